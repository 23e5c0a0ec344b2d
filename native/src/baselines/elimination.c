/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "elimination.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* As in reduction.c: squared distances from the span of the others. */
static const double RANK_TOLERANCE = 1e-12;

void elimination_destroy(elimination *e)
{
    release(e->G);
    release(e->scale);
    release(e->pivots);
    release(e->X);
    release(e->F);
    release(e->along);
}

/* G <- S (L + rho X^T X) S with a diagonal of ones. */
static void scale_form(elimination *e, const double *L, const double *X)
{
    int32_t b = e->unknowns;
    double trace = 0.0, squares = dot(X, X, (size_t)e->rows * (size_t)b);
    for (int32_t i = 0; i < b; i++) {
        trace += L[(size_t)i * (size_t)b + (size_t)i];
    }
    e->rho = squares > 0.0 ? trace / squares : 0.0;
    memcpy(e->G, L, (size_t)b * (size_t)b * sizeof *L);
    add_product_tn(b, b, e->rows, e->rho, X, b, X, b, e->G, b);
    for (int32_t i = 0; i < b; i++) {
        double diagonal = e->G[(size_t)i * (size_t)b + (size_t)i];
        e->scale[i] = diagonal > 0.0 ? 1.0 / sqrt(diagonal) : 0.0;
    }
    for (size_t i = 0; i < (size_t)b * (size_t)b; i++) {
        e->G[i] *= e->scale[i / (size_t)b] * e->scale[i % (size_t)b];
    }
}

/* F = (X X^T)^-1 X. */
static tug_status invert_rows(elimination *e)
{
    int32_t h = e->rows, r = e->rank;
    double *products = allocate((size_t)h * (size_t)h, sizeof *products);
    if (products == NULL) {
        return fail_memory();
    }
    add_product_nt(h, h, r, 1.0, e->X, r, e->X, r, products, h);
    int definite = cholesky_factor(products, h);
    if (definite) {
        memcpy(e->F, e->X, (size_t)h * (size_t)r * sizeof *e->X);
        cholesky_solve(products, h, e->F, r);
    }
    release(products);
    return definite ? TUG_OK
                    : fail(TUG_ERROR_HANDLES, "the handles' constraints depend on each other");
}

tug_status elimination_create(const double *L, const double *X, int32_t unknowns, int32_t rows,
                              elimination *e)
{
    size_t b = (size_t)unknowns, h = (size_t)rows;
    *e = (elimination){.unknowns = unknowns, .rows = rows};
    e->G = allocate(b * b, sizeof *e->G);
    e->scale = allocate(b, sizeof *e->scale);
    e->pivots = allocate(b, sizeof *e->pivots);
    e->X = allocate(h * b, sizeof *e->X);
    e->F = allocate(h * b, sizeof *e->F);
    e->along = allocate(h, sizeof *e->along);
    double *work = allocate(2 * b, sizeof *work);
    tug_status status =
        e->G && e->scale && e->pivots && e->X && e->F && e->along && work ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        scale_form(e, L, X);
        e->rank = pivoted_cholesky(e->G, unknowns, RANK_TOLERANCE, e->pivots, work);
        map_rows(e, X, rows, e->X);
        status = invert_rows(e);
    }
    release(work);
    return status;
}

void map_rows(const elimination *e, const double *K, int32_t count, double *V)
{
    size_t b = (size_t)e->unknowns, r = (size_t)e->rank;
    for (size_t i = 0; i < (size_t)count; i++) {
        for (size_t j = 0; j < r; j++) {
            size_t column = (size_t)e->pivots[j];
            V[i * r + j] = K[i * b + column] * e->scale[column];
        }
    }
    solve_right_upper(V, count, e->rank, e->G, e->rank, e->unknowns);
}

void free_rows(elimination *e, int32_t count, double *V)
{
    int32_t h = e->rows, r = e->rank;
    for (int32_t i = 0; i < count; i++) {
        double *row = V + (size_t)i * (size_t)r;
        memset(e->along, 0, (size_t)h * sizeof *e->along);
        add_product_nt(1, h, r, 1.0, row, r, e->F, r, e->along, h);
        add_product(1, r, h, -1.0, e->along, h, e->X, r, row, r);
    }
}

double place_rows(const elimination *e, const double *Y, int32_t k, double *t)
{
    size_t held = (size_t)e->rows * (size_t)k, size = (size_t)e->rank * (size_t)k;
    memset(t, 0, size * sizeof *t);
    add_product_tn(e->rank, k, e->rows, 1.0, e->F, e->rank, Y, k, t, k);
    return dot(t, t, size) - e->rho * dot(Y, Y, held);
}

void unmap_columns(const elimination *e, double *V, int32_t count, double *T)
{
    size_t b = (size_t)e->unknowns, r = (size_t)e->rank;
    memset(T, 0, b * (size_t)count * sizeof *T);
    solve_right_upper_transposed(V, count, e->rank, e->G, e->rank, e->unknowns);
    for (size_t i = 0; i < (size_t)count; i++) {
        for (size_t j = 0; j < r; j++) {
            size_t row = (size_t)e->pivots[j];
            T[row * (size_t)count + i] = V[i * r + j] * e->scale[row];
        }
    }
}
