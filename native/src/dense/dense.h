/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dense linear algebra; with dense.c the only place that knows BLAS and LAPACK. All matrices are
 * row-major. */
#ifndef TUG_DENSE_H
#define TUG_DENSE_H

#include <stddef.h>
#include <stdint.h>

/* One BLAS thread: parallelism is over frames and handles, in our code. */
void use_one_blas_thread(void);

/* C += alpha A B; C m by n, A m by l, B l by n, rows lda, ldb, ldc apart. */
void add_product(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                 const double *B, int32_t ldb, double *C, int32_t ldc);

/* C += alpha A^T B; A l by m. */
void add_product_tn(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                    const double *B, int32_t ldb, double *C, int32_t ldc);

/* C += alpha A^T A, its upper triangle; A l by n. */
void add_gram(int32_t n, int32_t l, double alpha, const double *A, int32_t lda, double *C,
              int32_t ldc);

/* T += A^T V for k columns, two or three; A l by n, V l by k, T n by k. (thin_product.c) */
void add_thin_product_tn(int32_t l, int32_t n, int32_t k, const double *A, const double *V,
                         double *T);

/* C += alpha A B^T; B n by l. */
void add_product_nt(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                    const double *B, int32_t ldb, double *C, int32_t ldc);

/* The upper triangle of C, n by n, += alpha A^T A; A l by n. */
void add_upper_gram(int32_t n, int32_t l, double alpha, const double *A, double *C);

/* C += A B, B symmetric, n by n, of which the lower triangle is read; A and C m by n. */
void add_symmetric_product(int32_t m, int32_t n, const double *A, const double *B, double *C);

/* P^T A P = G^T G for the largest well-conditioned leading part. A, n by n and symmetric, is
 * overwritten by the upper triangular G (n apart, what is below stays as it was); pivots[i] is the
 * row of A that came i-th. Stops at the first pivot below `tolerance`. work: 2 n. Returns the rank.
 */
int32_t pivoted_cholesky(double *A, int32_t n, double tolerance, int32_t *pivots, double *work);

/* rows by r, in place: V <- V G^-1 with the upper triangular G, r by r, ldg apart. */
void solve_right_upper(double *V, int32_t rows, int32_t ldv, const double *G, int32_t r,
                       int32_t ldg);

/* The same with G^-T. */
void solve_right_upper_transposed(double *V, int32_t rows, int32_t ldv, const double *G, int32_t r,
                                  int32_t ldg);

/* A = G^T G in place, upper triangle. Returns 0 where A is not positive definite. (cholesky.c) */
int cholesky_factor(double *A, int32_t n);

/* B <- A^-1 B (B n by columns), from cholesky_factor's G. */
void cholesky_solve(const double *G, int32_t n, double *B, int32_t columns);

/* B <- G^-T B, half of it: B^T B is then B^T A^-1 B of the old B. */
void cholesky_solve_half(const double *G, int32_t n, double *B, int32_t columns);

/* A = sum_i values_i a_i a_i^T by rising values: a_i becomes row i of A, n by n and symmetric.
 * work: 34 n. Returns 0 where LAPACK gives up. */
int symmetric_eigenpairs(double *A, int32_t n, double *values, double *work);

/* (thin_product.c) */
double dot(const double *a, const double *b, size_t count);

#endif
