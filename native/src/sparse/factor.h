/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An upper triangular factor G without its lower half: panels of a few rows, one after the other,
 * each from its first row's diagonal to the last column. Half the room of a square, and every panel
 * still a matrix that BLAS takes. */
#ifndef TUG_FACTOR_H
#define TUG_FACTOR_H

#include <stddef.h>
#include <stdint.h>

/* Doubles that a factor with n rows takes. */
size_t factor_size(int32_t n);

/* From the upper triangle of a square, rows ld apart. */
void pack_factor(const double *square, int32_t ld, int32_t n, double *factor);

/* G square, zero below its diagonal. */
void unpack_factor(const double *factor, int32_t n, double *square);

/* x <- x G^-1 and x <- x G^-T for the `count` rows of x, count by n. */
void solve_factor(const double *factor, int32_t n, int32_t count, double *x);
void solve_factor_transposed(const double *factor, int32_t n, int32_t count, double *x);

/* x <- (G^T G)^-1 x, n by `columns`. work: n columns. */
void solve_factored(const double *factor, int32_t n, int32_t columns, double *work, double *x);

#endif
