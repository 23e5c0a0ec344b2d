/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Products of k by k matrices, k two or three, row-major. Here in whole so that the compiler sees
 * k. */
#ifndef TUG_SMALL_MATRIX_H
#define TUG_SMALL_MATRIX_H

#include <stdint.h>

static inline void identity_matrix(int32_t k, double *I)
{
    for (int32_t i = 0; i < k * k; i++) {
        I[i] = i % (k + 1) == 0 ? 1.0 : 0.0;
    }
}

/* C_ij = sum_l A_(i row + l step) B_(l row' + j step'): every product below, k being a constant in
 * each of the two calls. */
static inline void multiply_strided(int32_t k, const double *A, int32_t A_row, int32_t A_step,
                                    const double *B, int32_t B_row, int32_t B_step, double *C)
{
    for (int32_t i = 0; i < k; i++) {
        for (int32_t j = 0; j < k; j++) {
            double sum = 0.0;
            for (int32_t l = 0; l < k; l++) {
                sum += A[i * A_row + l * A_step] * B[l * B_row + j * B_step];
            }
            C[i * k + j] = sum;
        }
    }
}

/* C = A B */
static inline void multiply(int32_t k, const double *A, const double *B, double *C)
{
    if (k == 3) {
        multiply_strided(3, A, 3, 1, B, 3, 1, C);
    } else {
        multiply_strided(2, A, 2, 1, B, 2, 1, C);
    }
}

/* C = A B^T */
static inline void multiply_nt(int32_t k, const double *A, const double *B, double *C)
{
    if (k == 3) {
        multiply_strided(3, A, 3, 1, B, 1, 3, C);
    } else {
        multiply_strided(2, A, 2, 1, B, 1, 2, C);
    }
}

/* C = A^T B */
static inline void multiply_tn(int32_t k, const double *A, const double *B, double *C)
{
    if (k == 3) {
        multiply_strided(3, A, 1, 3, B, 3, 1, C);
    } else {
        multiply_strided(2, A, 1, 2, B, 2, 1, C);
    }
}

/* tr(A B) */
static inline double trace_of_product(int32_t k, const double *A, const double *B)
{
    double sum = 0.0;
    for (int32_t i = 0; i < k; i++) {
        for (int32_t j = 0; j < k; j++) {
            sum += A[i * k + j] * B[j * k + i];
        }
    }
    return sum;
}

#endif
