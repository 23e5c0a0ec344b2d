/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "reduction.h"

#include "dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* Columns of the scaled dictionary whose squared distance from the span of the others is below this
 * are left out: two shapes that are affine images of each other near a handle, a flat mesh in
 * space. */
static const double RANK_TOLERANCE = 1e-12;

/* Rows whose squared distance from the span of the others is relatively below this are dependent.
 */
static const double ROW_TOLERANCE = 1e-12;

typedef struct elimination {
    double *M;       /* b by b: L + rho X^T X, scaled to a diagonal of one; then its factor G */
    double *scale;   /* b */
    int32_t *pivots; /* b */
    double *work;    /* 2 b */
    double *X, *SX;  /* rows by rank: X G^-1, and S^-1 of it */
    double *S;       /* rows by rows: X M^-1 X^T, then its factor */
    double *K;       /* turned by rank: K G^-1, then projected */
    double *FL;      /* rows by b */
} elimination;

static void free_elimination(elimination *e)
{
    release(e->M);
    release(e->scale);
    release(e->pivots);
    release(e->work);
    release(e->X);
    release(e->SX);
    release(e->S);
    release(e->K);
    release(e->FL);
}

static int allocate_elimination(elimination *e, const reduction *r)
{
    size_t b = (size_t)r->unknowns, h = (size_t)r->rows, t = (size_t)r->turned;
    e->M = allocate(b * b, sizeof *e->M);
    e->scale = allocate(b, sizeof *e->scale);
    e->pivots = allocate(b, sizeof *e->pivots);
    e->work = allocate(2 * b, sizeof *e->work);
    e->X = allocate(h * b, sizeof *e->X);
    e->SX = allocate(h * b, sizeof *e->SX);
    e->S = allocate(h * h, sizeof *e->S);
    e->K = allocate(t * b, sizeof *e->K);
    e->FL = allocate(h * b, sizeof *e->FL);
    return e->M && e->scale && e->pivots && e->work && e->X && e->SX && e->S && e->K && e->FL;
}

static double trace(const double *A, int32_t n)
{
    double sum = 0.0;
    for (int32_t i = 0; i < n; i++) {
        sum += A[(size_t)i * (size_t)n + (size_t)i];
    }
    return sum;
}

/* L alone does not see translations; X^T X does, and adding it changes nothing under X T = Y. */
static void make_definite(elimination *e, const double *L, const double *X, const reduction *r)
{
    int32_t b = r->unknowns, h = r->rows;
    double squares = dot(X, X, (size_t)h * (size_t)b);
    double rho = squares > 0.0 ? trace(L, b) / squares : 0.0;
    memcpy(e->M, L, (size_t)b * (size_t)b * sizeof *L);
    add_product_tn(b, b, h, rho, X, b, X, b, e->M, b);
    for (int32_t i = 0; i < b; i++) {
        double diagonal = e->M[(size_t)i * (size_t)b + (size_t)i];
        e->scale[i] = diagonal > 0.0 ? 1.0 / sqrt(diagonal) : 0.0;
    }
    for (int32_t i = 0; i < b; i++) {
        for (int32_t j = 0; j < b; j++) {
            e->M[(size_t)i * (size_t)b + (size_t)j] *= e->scale[i] * e->scale[j];
        }
    }
}

/* out = V restricted to the independent columns, scaled, times G^-1. */
static void map_rows(const elimination *e, const double *V, int32_t rows, int32_t b, int32_t rank,
                     double *out)
{
    for (int32_t i = 0; i < rows; i++) {
        for (int32_t j = 0; j < rank; j++) {
            int32_t column = e->pivots[j];
            out[(size_t)i * (size_t)rank + (size_t)j] =
                V[(size_t)i * (size_t)b + (size_t)column] * e->scale[column];
        }
    }
    solve_right_upper(out, rows, rank, e->M, rank, b);
}

/* out = V G^-T back in all columns; V is overwritten. */
static void unmap_rows(const elimination *e, double *V, int32_t rows, int32_t b, int32_t rank,
                       double *out)
{
    solve_right_upper_transposed(V, rows, rank, e->M, rank, b);
    memset(out, 0, (size_t)rows * (size_t)b * sizeof *out);
    for (int32_t i = 0; i < rows; i++) {
        for (int32_t j = 0; j < rank; j++) {
            int32_t column = e->pivots[j];
            out[(size_t)i * (size_t)b + (size_t)column] =
                V[(size_t)i * (size_t)rank + (size_t)j] * e->scale[column];
        }
    }
}

static tug_status factor_rows(elimination *e, int32_t h, int32_t rank)
{
    add_product_nt(h, h, rank, 1.0, e->X, rank, e->X, rank, e->S, h);
    double largest = 0.0;
    for (int32_t i = 0; i < h; i++) {
        double diagonal = e->S[i * h + i];
        largest = diagonal > largest ? diagonal : largest;
    }
    int definite = cholesky_factor(e->S, h);
    for (int32_t i = 0; i < h && definite; i++) {
        double pivot = e->S[i * h + i];
        definite = pivot * pivot > ROW_TOLERANCE * largest;
    }
    if (!definite) {
        return fail(TUG_ERROR_HANDLES, "the handles' constraints depend on each other: "
                                       "no two may hold the same place of the mesh");
    }
    memcpy(e->SX, e->X, (size_t)h * (size_t)rank * sizeof *e->X);
    cholesky_solve(e->S, h, e->SX, rank);
    return TUG_OK;
}

static tug_status eliminate(elimination *e, const double *L, const double *X, const double *K,
                            reduction *r, int32_t *rank_out)
{
    int32_t b = r->unknowns, h = r->rows, t = r->turned;
    make_definite(e, L, X, r);
    int32_t rank = pivoted_cholesky(e->M, b, RANK_TOLERANCE, e->pivots, e->work);
    map_rows(e, X, h, b, rank, e->X);
    map_rows(e, K, t, b, rank, e->K);
    tug_status status = factor_rows(e, h, rank);
    if (status != TUG_OK) {
        return status;
    }
    memset(r->KF, 0, (size_t)t * (size_t)h * sizeof *r->KF);
    add_product_nt(t, h, rank, 1.0, e->K, rank, e->SX, rank, r->KF, h);
    add_product(t, rank, h, -1.0, r->KF, h, e->X, rank, e->K, rank);
    add_product_nt(t, t, rank, -1.0, e->K, rank, e->K, rank, r->C, t);
    unmap_rows(e, e->K, t, b, rank, r->ZK);
    unmap_rows(e, e->SX, h, b, rank, r->F);
    memset(r->FLF, 0, (size_t)h * (size_t)h * sizeof *r->FLF);
    add_product(h, b, b, 1.0, r->F, b, L, b, e->FL, b);
    add_product_nt(h, h, b, 1.0, e->FL, b, r->F, b, r->FLF, h);
    *rank_out = rank;
    return TUG_OK;
}

tug_status eliminate_transforms(const double *L, const double *X, const double *K, reduction *out,
                                int32_t *rank)
{
    elimination e = {0};
    tug_status status =
        allocate_elimination(&e, out) ? eliminate(&e, L, X, K, out, rank) : fail_memory();
    free_elimination(&e);
    return status;
}

void find_pull(const reduction *energy, const double *Y, int32_t k, double *pull)
{
    memset(pull, 0, (size_t)(energy->turned * k) * sizeof *pull);
    for (int32_t i = 0; i < energy->turned; i++) {
        for (int32_t r = 0; r < energy->rows; r++) {
            double factor = energy->KF[(size_t)i * (size_t)energy->rows + (size_t)r];
            for (int32_t a = 0; a < k; a++) {
                pull[i * k + a] += factor * Y[r * k + a];
            }
        }
    }
}

double energy_of_rows(const reduction *energy, const double *Y, int32_t k)
{
    double sum = 0.0;
    for (int32_t i = 0; i < energy->rows; i++) {
        for (int32_t j = 0; j < energy->rows; j++) {
            sum += energy->FLF[(size_t)i * (size_t)energy->rows + (size_t)j] *
                   dot(Y + i * k, Y + j * k, (size_t)k);
        }
    }
    return sum;
}

void recover_transforms(const reduction *energy, const double *V, const double *Y, int32_t k,
                        double *T)
{
    memset(T, 0, (size_t)energy->unknowns * (size_t)k * sizeof *T);
    add_thin_product_tn(energy->turned, energy->unknowns, k, energy->ZK, V, T);
    add_thin_product_tn(energy->rows, energy->unknowns, k, energy->F, Y, T);
}
