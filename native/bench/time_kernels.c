/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Print, for each of our own dense kernels: its name, its size, its microseconds and OpenBLAS's. */
#include "dense/dense.h"

#include <cblas.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { MOST = 60, REPEATS = 2000 };

typedef struct problem {
    int32_t n;
    double A[MOST * MOST], V[MOST * 3];
    double G[MOST * MOST], x[MOST * 3]; /* overwritten by every call */
} problem;

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info);

static void factor(problem *p)
{
    cholesky_factor(p->G, p->n);
}

static void factor_by_blas(problem *p)
{
    int info;
    dpotrf_("L", &p->n, p->G, &p->n, &info);
}

static void solve(problem *p)
{
    cholesky_solve(p->A, p->n, p->x, 1);
}

static void solve_by_blas(problem *p)
{
    cblas_dtrsv(CblasRowMajor, CblasUpper, CblasTrans, CblasNonUnit, p->n, p->A, p->n, p->x, 1);
    cblas_dtrsv(CblasRowMajor, CblasUpper, CblasNoTrans, CblasNonUnit, p->n, p->A, p->n, p->x, 1);
}

static void multiply(problem *p)
{
    add_thin_product_tn(p->n, p->n, 3, p->A, p->V, p->x);
}

static void multiply_by_blas(problem *p)
{
    add_product_tn(p->n, 3, p->n, 1.0, p->A, p->n, p->V, 3, p->x, 3);
}

/* The least of all repeats. */
static double microseconds(void (*kernel)(problem *), problem *p)
{
    double least = 1e9;
    for (int i = 0; i < REPEATS; i++) {
        struct timespec start, end;
        memcpy(p->G, p->A, sizeof p->G);
        memcpy(p->x, p->V, sizeof p->x);
        timespec_get(&start, TIME_UTC);
        kernel(p);
        timespec_get(&end, TIME_UTC);
        double elapsed = 1e6 * (double)(end.tv_sec - start.tv_sec) +
                         1e-3 * (double)(end.tv_nsec - start.tv_nsec);
        least = elapsed < least ? elapsed : least;
    }
    return least;
}

int main(void)
{
    static const struct {
        const char *name;
        void (*ours)(problem *), (*blas)(problem *);
    } kernels[] = {{"factor", factor, factor_by_blas},
                   {"solve", solve, solve_by_blas},
                   {"multiply", multiply, multiply_by_blas}};
    static problem p;
    use_one_blas_thread();
    for (p.n = 12; p.n <= MOST; p.n += 24) {
        for (int32_t i = 0; i < p.n * p.n; i++) {
            p.A[i] = i % (p.n + 1) == 0 ? 2.0 : 1.0 / MOST;
            p.V[i % (3 * MOST)] = 1.0;
        }
        for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) {
            printf("%s %d %.3f %.3f\n", kernels[i].name, p.n, microseconds(kernels[i].ours, &p),
                   microseconds(kernels[i].blas, &p));
        }
    }
    return 0;
}
