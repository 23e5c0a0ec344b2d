/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Products with one, two or three columns, declared in dense.h: too thin for BLAS. */
#include "dense/dense.h"
#include "dense/vector.h"

#include <string.h>

enum { WIDEST = 4 };

/* Rows j to j + 4 `width` of T, their sums in registers. */
PART void add_rows(int32_t l, size_t n, int32_t k, const double *A, const double *V, size_t j,
                   int width, double *T)
{
    packed sum[3][WIDEST] = {{{0.0}}};
    for (int32_t i = 0; i < l; i++, V += k) {
        const double *row = A + (size_t)i * n + j;
        for (int v = 0; v < width; v++) {
            packed x = *packed_at(row + LANES * v);
            for (int32_t a = 0; a < k; a++) {
                sum[a][v] += V[a] * x;
            }
        }
    }
    double total[3][LANES * WIDEST];
    memcpy(total, sum, sizeof sum);
    for (int x = 0; x < LANES * width; x++) {
        for (int32_t a = 0; a < k; a++) {
            T[((int32_t)j + x) * k + a] += total[a][x];
        }
    }
}

PART void add_row(int32_t l, size_t n, int32_t k, const double *A, const double *V, size_t j,
                  double *T)
{
    for (int32_t i = 0; i < l; i++) {
        for (int32_t a = 0; a < k; a++) {
            T[(int32_t)j * k + a] += A[(size_t)i * n + j] * V[i * k + a];
        }
    }
}

PART void add_all_rows(int32_t l, size_t n, int32_t k, const double *A, const double *V, double *T)
{
    size_t j = 0;
    for (; j + LANES * WIDEST <= n; j += LANES * WIDEST) {
        add_rows(l, n, k, A, V, j, WIDEST, T);
    }
    for (; j + LANES <= n; j += LANES) {
        add_rows(l, n, k, A, V, j, 1, T);
    }
    for (; j < n; j++) {
        add_row(l, n, k, A, V, j, T);
    }
}

DISPATCHED void add_thin_product_tn(int32_t l, int32_t n, int32_t k, const double *A,
                                    const double *V, double *T)
{
    if (k == 3) {
        add_all_rows(l, (size_t)n, 3, A, V, T);
    } else {
        add_all_rows(l, (size_t)n, 2, A, V, T);
    }
}

DISPATCHED double dot(const double *a, const double *b, size_t count)
{
    packed sums[WIDEST] = {{0.0}};
    double sum = 0.0;
    size_t i = 0;
    for (; i + LANES * WIDEST <= count; i += LANES * WIDEST) {
        for (size_t v = 0; v < WIDEST; v++) {
            sums[v] += *packed_at(a + i + LANES * v) * *packed_at(b + i + LANES * v);
        }
    }
    for (; i < count; i++) {
        sum += a[i] * b[i];
    }
    for (int v = 0; v < WIDEST; v++) {
        sum += sum_of_lanes(&sums[v]);
    }
    return sum;
}
