/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dense/dense.h"

#include <cblas.h>

void dpstrf_(const char *uplo, const int *n, double *a, const int *lda, int *piv, int *rank,
             const double *tol, double *work, int *info);

void dsyev_(const char *jobz, const char *uplo, const int *n, double *a, const int *lda, double *w,
            double *work, const int *lwork, int *info);

void use_one_blas_thread(void)
{
    openblas_set_num_threads(1);
}

void add_product(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                 const double *B, int32_t ldb, double *C, int32_t ldc)
{
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, m, n, l, alpha, A, lda, B, ldb, 1.0, C,
                ldc);
}

void add_product_tn(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                    const double *B, int32_t ldb, double *C, int32_t ldc)
{
    cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, m, n, l, alpha, A, lda, B, ldb, 1.0, C,
                ldc);
}

void add_gram(int32_t n, int32_t l, double alpha, const double *A, int32_t lda, double *C,
              int32_t ldc)
{
    cblas_dsyrk(CblasRowMajor, CblasUpper, CblasTrans, n, l, alpha, A, lda, 1.0, C, ldc);
}

void add_product_nt(int32_t m, int32_t n, int32_t l, double alpha, const double *A, int32_t lda,
                    const double *B, int32_t ldb, double *C, int32_t ldc)
{
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, m, n, l, alpha, A, lda, B, ldb, 1.0, C,
                ldc);
}

void add_upper_gram(int32_t n, int32_t l, double alpha, const double *A, double *C)
{
    cblas_dsyrk(CblasRowMajor, CblasUpper, CblasTrans, n, l, alpha, A, n, 1.0, C, n);
}

void add_symmetric_product(int32_t m, int32_t n, const double *A, const double *B, double *C)
{
    cblas_dsymm(CblasRowMajor, CblasRight, CblasLower, m, n, 1.0, B, n, A, n, 1.0, C, n);
}

int32_t pivoted_cholesky(double *A, int32_t n, double tolerance, int32_t *pivots, double *work)
{
    /* A row-major upper triangle is a column-major lower one: A = L L^T there is G^T G here. */
    int rank = 0, info = 0;
    dpstrf_("L", &n, A, &n, pivots, &rank, &tolerance, work, &info);
    for (int32_t i = 0; i < n; i++) {
        pivots[i]--;
    }
    return rank;
}

void solve_right_upper(double *V, int32_t rows, int32_t ldv, const double *G, int32_t r,
                       int32_t ldg)
{
    cblas_dtrsm(CblasRowMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, rows, r, 1.0, G,
                ldg, V, ldv);
}

void solve_right_upper_transposed(double *V, int32_t rows, int32_t ldv, const double *G, int32_t r,
                                  int32_t ldg)
{
    cblas_dtrsm(CblasRowMajor, CblasRight, CblasUpper, CblasTrans, CblasNonUnit, rows, r, 1.0, G,
                ldg, V, ldv);
}

int symmetric_eigenpairs(double *A, int32_t n, double *values, double *work)
{
    int room = 34 * n, info = 0;
    dsyev_("V", "L", &n, A, &n, values, work, &room, &info);
    return info == 0;
}
