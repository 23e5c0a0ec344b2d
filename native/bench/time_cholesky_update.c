/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Print, for rows added to a Cholesky factor and dropped from it: what was done, the size, its
 * microseconds, and those of making the factor anew, by us and by LAPACK. */
#include "dense/cholesky_update.h"
#include "dense/dense.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

enum { ROWS = 10, MOST = 500, REPEATS = 50 };

static double A[MOST * MOST], X[ROWS * MOST];          /* the matrix without the rows, the rows */
static double G[MOST * MOST], lost[ROWS * MOST];       /* overwritten by every call */
static double with[MOST * MOST], without[MOST * MOST]; /* factors */

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info);

static void add(int32_t n)
{
    cholesky_add_rows(G, n, lost, ROWS);
}

static void drop(int32_t n)
{
    double work[ROWS * ROWS];
    cholesky_drop_rows(G, n, lost, ROWS, work);
}

static void factor(int32_t n)
{
    cholesky_factor(G, n);
}

static void factor_by_lapack(int32_t n)
{
    int info;
    dpotrf_("L", &n, G, &n, &info);
}

/* The least of all repeats. */
static double microseconds(void (*kernel)(int32_t n), int32_t n, const double *start_from)
{
    double least = 1e9;
    for (int i = 0; i < REPEATS; i++) {
        struct timespec start, end;
        memcpy(G, start_from, sizeof G);
        memcpy(lost, X, sizeof lost);
        timespec_get(&start, TIME_UTC);
        kernel(n);
        timespec_get(&end, TIME_UTC);
        double elapsed = 1e6 * (double)(end.tv_sec - start.tv_sec) +
                         1e-3 * (double)(end.tv_nsec - start.tv_nsec);
        least = elapsed < least ? elapsed : least;
    }
    return least;
}

static void prepare(int32_t n)
{
    for (int32_t i = 0; i < n * n; i++) {
        A[i] = i % (n + 1) == 0 ? 2.0 : 1.0 / MOST;
    }
    for (int32_t i = 0; i < ROWS * n; i++) {
        X[i] = (i * 37 % 101 - 50) / 50.0;
    }
    memcpy(without, A, sizeof without);
    cholesky_factor(without, n);
    memcpy(with, without, sizeof with);
    memcpy(lost, X, sizeof lost);
    cholesky_add_rows(with, n, lost, ROWS);
}

int main(void)
{
    static const int32_t sizes[] = {100, 200, MOST};
    use_one_blas_thread();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        int32_t n = sizes[i];
        prepare(n);
        double anew = microseconds(factor, n, A), lapack = microseconds(factor_by_lapack, n, A);
        printf("added %d %.3f %.3f %.3f\n", n, microseconds(add, n, without), anew, lapack);
        printf("dropped %d %.3f %.3f %.3f\n", n, microseconds(drop, n, with), anew, lapack);
    }
    return 0;
}
