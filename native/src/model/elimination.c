/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The constants of a reduction, once: a Cholesky factorisation with pivoting of M = L + rho X^T X,
 * and the products of its inverse. */
#include "dense/dense.h"
#include "memory.h"
#include "model/reduction.h"
#include "sparse/factor.h"

#include <math.h>
#include <string.h>

/* Columns of the scaled dictionary whose squared distance from the span of the others is below this
 * are left out: two shapes that are affine images of each other near a handle, a flat mesh in
 * space. */
static const double RANK_TOLERANCE = 1e-12;

/* Rows whose squared distance from the span of the others is relatively below this are dependent.
 */
static const double ROW_TOLERANCE = 1e-12;

/* X^T B X, or rho X^T X with which it is as large as L, is the result times out^T out. trace: of L.
 * out: rows by unknowns. */
static double weigh_rows(const reduction *r, double trace, double *out)
{
    size_t b = (size_t)r->unknowns, h = (size_t)r->rows;
    memcpy(out, r->X, h * b * sizeof *out);
    if (r->firmness == NULL) {
        double squares = dot(r->X, r->X, h * b);
        return squares > 0.0 ? trace / squares : 0.0;
    }
    for (size_t i = 0; i < h * b; i++) {
        out[i] *= sqrt(r->firmness[i / b]);
    }
    return 1.0;
}

/* L alone does not see translations; X^T X does, and adding it changes nothing under X T = Y. The
 * upper triangle becomes M, scaled to a diagonal of one. L stays below it, and its diagonal is
 * kept. X: room for rows by unknowns. */
static void make_definite(double *M, const reduction *r, double *diagonal, double *X)
{
    size_t b = (size_t)r->unknowns;
    double trace = 0.0;
    for (size_t i = 0; i < b; i++) {
        diagonal[i] = M[i * b + i];
        trace += diagonal[i];
        for (size_t j = i + 1; j < b; j++) {
            M[i * b + j] = M[j * b + i];
        }
    }
    double weight = weigh_rows(r, trace, X);
    add_upper_gram(r->unknowns, r->rows, weight, X, M);
    for (size_t i = 0; i < b; i++) {
        double own = M[i * b + i];
        r->scale[i] = own > 0.0 ? 1.0 / sqrt(own) : 0.0;
    }
    for (size_t i = 0; i < b; i++) {
        for (size_t j = i; j < b; j++) {
            M[i * b + j] *= r->scale[i] * r->scale[j];
        }
    }
}

/* M's own lower triangle from its factor, of rank square; G and P: room for the same. */
static void multiply_factor(const reduction *r, double *G, double *P, double *L)
{
    size_t b = (size_t)r->unknowns, rank = (size_t)*r->rank;
    unpack_factor(r->factor, *r->rank, G);
    memset(P, 0, rank * rank * sizeof *P);
    add_upper_gram(*r->rank, *r->rank, 1.0, G, P);
    memset(L, 0, b * b * sizeof *L);
    for (size_t i = 0; i < rank; i++) {
        for (size_t j = i; j < rank; j++) {
            size_t row = (size_t)r->pivots[i], column = (size_t)r->pivots[j];
            size_t low = row > column ? row * b + column : column * b + row;
            L[low] = P[i * rank + j] / (r->scale[row] * r->scale[column]);
        }
    }
}

/* L <- L - weight X^T X in the lower triangle. product: unknowns square. */
static void take_rows(const reduction *r, double weight, const double *X, double *product,
                      double *L)
{
    size_t b = (size_t)r->unknowns;
    memset(product, 0, b * b * sizeof *product);
    add_upper_gram(r->unknowns, r->rows, weight, X, product);
    for (size_t i = 0; i < b; i++) {
        for (size_t j = 0; j <= i; j++) {
            L[i * b + j] -= product[j * b + i];
        }
    }
}

tug_status restore_form(const reduction *r, double *L)
{
    size_t b = (size_t)r->unknowns, h = (size_t)r->rows, rank = (size_t)*r->rank;
    double *G = allocate(b * b, sizeof *G), *P = allocate(b * b, sizeof *P);
    double *X = allocate(h * b, sizeof *X);
    int room = G && P && X;
    if (room) {
        double trace = 0.0; /* of L: with rho it is half of M's */
        for (size_t i = 0; i < b; i++) {
            trace += r->scale[i] > 0.0 ? 0.5 / (r->scale[i] * r->scale[i]) : 0.0;
        }
        multiply_factor(r, G, P, L);
        double weight = weigh_rows(r, trace, X);
        for (size_t i = rank; i < b; i++) {
            for (size_t row = 0; row < h; row++) {
                X[row * b + (size_t)r->pivots[i]] = 0.0;
            }
        }
        take_rows(r, weight, X, P, L);
    }
    release(G);
    release(P);
    release(X);
    return room ? TUG_OK : fail_memory();
}

/* X G^-1 in the independent unknowns, scaled: rows by rank. */
static void map_constraints(const reduction *r, double *out)
{
    size_t b = (size_t)r->unknowns, rank = (size_t)*r->rank;
    for (size_t i = 0; i < (size_t)r->rows; i++) {
        for (size_t j = 0; j < rank; j++) {
            size_t column = (size_t)r->pivots[j];
            out[i * rank + j] = r->X[i * b + column] * r->scale[column];
        }
    }
    solve_factor(r->factor, *r->rank, r->rows, out);
}

/* out = V G^-T back in all unknowns; V, count by rank, is overwritten. */
static void unmap_rows(const reduction *r, double *V, int32_t count, double *out)
{
    size_t b = (size_t)r->unknowns, rank = (size_t)*r->rank;
    solve_factor_transposed(r->factor, *r->rank, count, V);
    memset(out, 0, (size_t)count * b * sizeof *out);
    for (size_t i = 0; i < (size_t)count; i++) {
        for (size_t j = 0; j < rank; j++) {
            size_t column = (size_t)r->pivots[j];
            out[i * b + column] = V[i * rank + j] * r->scale[column];
        }
    }
}

/* x <- S^-1 x, S = x x^T: rows by rank. S: rows by rows. */
static tug_status solve_constraints(int32_t h, int32_t rank, double *S, double *x)
{
    add_product_nt(h, h, rank, 1.0, x, rank, x, rank, S, h);
    double largest = 0.0;
    for (int32_t i = 0; i < h; i++) {
        largest = fmax(largest, S[i * h + i]);
    }
    int definite = cholesky_factor(S, h);
    for (int32_t i = 0; i < h && definite; i++) {
        double pivot = S[i * h + i];
        definite = pivot * pivot > ROW_TOLERANCE * largest;
    }
    if (!definite) {
        return fail(TUG_ERROR_HANDLES, "the handles' constraints depend on each other: "
                                       "no two may hold the same place of the mesh");
    }
    cholesky_solve(S, h, x, rank);
    return TUG_OK;
}

static void make_symmetric(double *A, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j < i; j++) {
            A[i * n + j] = A[j * n + i] = 0.5 * (A[i * n + j] + A[j * n + i]);
        }
    }
}

/* x <- B x, x rows by rank. */
static void scale_rows(const reduction *r, double *x)
{
    size_t rank = (size_t)*r->rank;
    for (size_t i = 0; i < (size_t)r->rows * rank; i++) {
        x[i] *= r->firmness[i / rank];
    }
}

/* F and B - B X F. X: mapped, overwritten. */
static void find_soft_maps(reduction *r, double *X)
{
    int32_t h = r->rows, rank = *r->rank;
    scale_rows(r, X);
    memset(r->FLF, 0, (size_t)h * (size_t)h * sizeof *r->FLF);
    for (int32_t i = 0; i < h; i++) {
        r->FLF[i * (h + 1)] = r->firmness[i];
    }
    add_product_nt(h, h, rank, -1.0, X, rank, X, rank, r->FLF, h);
    make_symmetric(r->FLF, h);
    unmap_rows(r, X, h, r->F);
}

/* F, and F^T L F. L: its lower triangle below the diagonal, which is put back. X: mapped. */
static tug_status find_row_maps(double *L, const double *diagonal, reduction *r, double *X,
                                double *S)
{
    size_t b = (size_t)r->unknowns;
    tug_status status = solve_constraints(r->rows, *r->rank, S, X);
    if (status != TUG_OK) {
        return status;
    }
    unmap_rows(r, X, r->rows, r->F);
    for (size_t i = 0; i < b; i++) {
        L[i * b + i] = diagonal[i];
    }
    double *FL = X; /* rank is b at most */
    memset(FL, 0, (size_t)r->rows * b * sizeof *FL);
    add_symmetric_product(r->rows, r->unknowns, r->F, L, FL);
    memset(r->FLF, 0, (size_t)r->rows * (size_t)r->rows * sizeof *r->FLF);
    add_product_nt(r->rows, r->rows, r->unknowns, 1.0, FL, r->unknowns, r->F, r->unknowns, r->FLF,
                   r->rows);
    make_symmetric(r->FLF, r->rows); /* but for its own rounding it is */
    return TUG_OK;
}

tug_status factor_transforms(double *L, reduction *r)
{
    size_t b = (size_t)r->unknowns, h = (size_t)r->rows;
    double *diagonal = allocate(b, sizeof *diagonal), *work = allocate(2 * b, sizeof *work);
    double *X = allocate(h * b, sizeof *X), *S = allocate(h * h, sizeof *S);
    tug_status status = diagonal && work && X && S ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        make_definite(L, r, diagonal, X);
        *r->rank = pivoted_cholesky(L, r->unknowns, RANK_TOLERANCE, r->pivots, work);
        pack_factor(L, r->unknowns, *r->rank, r->factor);
        map_constraints(r, X);
        if (r->firmness != NULL) {
            find_soft_maps(r, X);
        } else {
            status = find_row_maps(L, diagonal, r, X, S);
        }
    }
    release(diagonal);
    release(work);
    release(X);
    release(S);
    return status;
}

typedef struct coupling_work {
    double *X, *SX; /* rows by rank: X G^-1, and S^-1 or B of it */
    double *S;      /* rows by rows */
    double *A;      /* group_rows by rank: K_g G^-1, projected */
    double *ZK;     /* group_rows by unknowns */
    double *block;  /* group_rows square */
    int32_t *place; /* weight functions: their block of a group's columns, or -1 */
} coupling_work;

static int allocate_coupling(coupling_work *w, const reduction *r)
{
    size_t b = (size_t)r->unknowns, h = (size_t)r->rows, p = (size_t)r->group_rows;
    w->X = allocate(h * b, sizeof *w->X);
    w->SX = allocate(h * b, sizeof *w->SX);
    w->S = allocate(h * h, sizeof *w->S);
    w->A = allocate(p * b, sizeof *w->A);
    w->ZK = allocate(p * b, sizeof *w->ZK);
    w->block = allocate(p * p, sizeof *w->block);
    w->place = allocate(b / (size_t)r->block, sizeof *w->place);
    return w->X && w->SX && w->S && w->A && w->ZK && w->block && w->place;
}

static void free_coupling(coupling_work *w)
{
    release(w->X);
    release(w->SX);
    release(w->S);
    release(w->A);
    release(w->ZK);
    release(w->block);
    release(w->place);
}

/* A = K_g G^-1, in the independent unknowns and scaled. */
static void map_group(const reduction *r, int32_t g, coupling_work *w)
{
    size_t rank = (size_t)*r->rank, columns = (size_t)group_columns(r, g);
    const int32_t *functions = support_of(r->support, g);
    const double *K = group_rows_of_K(r, g);
    for (int32_t h = 0; h < r->unknowns / r->block; h++) {
        w->place[h] = -1;
    }
    for (int32_t f = 0; f < support_count(r->support, g); f++) {
        w->place[functions[f]] = f;
    }
    for (size_t j = 0; j < rank; j++) {
        int32_t column = r->pivots[j], f = w->place[column / r->block];
        for (size_t i = 0; i < (size_t)r->group_rows; i++) {
            size_t at = i * columns + (size_t)(f * r->block + column % r->block);
            w->A[i * rank + j] = f < 0 ? 0.0 : r->scale[column] * K[at];
        }
    }
    solve_factor(r->factor, *r->rank, r->group_rows, w->A);
}

/* Take K_g Z K_h^T from the block of g and h. */
static void couple_groups(reduction *r, int32_t g, int32_t h, coupling_work *w)
{
    int32_t p = r->group_rows, columns = group_columns(r, h);
    const int32_t *functions = support_of(r->support, h);
    const double *K = group_rows_of_K(r, h);
    read_block(r, g, h, w->block);
    for (int32_t f = 0; f < support_count(r->support, h); f++) {
        add_product_nt(p, p, r->block, -1.0, w->ZK + functions[f] * r->block, r->unknowns,
                       K + f * r->block, columns, w->block, p);
    }
    if (g == h) {
        make_symmetric(w->block, p);
    }
    write_block(r, g, h, w->block);
}

static tug_status couple_all(reduction *r, const progress_range *range, coupling_work *w)
{
    int32_t rank = *r->rank, h = r->rows, p = r->group_rows;
    map_constraints(r, w->X);
    memcpy(w->SX, w->X, (size_t)h * (size_t)rank * sizeof *w->X);
    tug_status status = TUG_OK;
    if (r->firmness != NULL) {
        scale_rows(r, w->SX);
    } else {
        status = solve_constraints(h, rank, w->S, w->SX);
    }
    for (int32_t g = 0; g < r->groups && status == TUG_OK; g++) {
        status = report(range, "solving for transforms", (double)g / r->groups);
        double *KF = r->KF + (size_t)(g * p) * (size_t)h;
        memset(KF, 0, (size_t)p * (size_t)h * sizeof *KF);
        map_group(r, g, w);
        add_product_nt(p, h, rank, 1.0, w->A, rank, w->SX, rank, KF, h);
        if (r->firmness == NULL) { /* K Z K^T has nothing of what the rows determine */
            add_product(p, rank, h, -1.0, KF, h, w->X, rank, w->A, rank);
        }
        unmap_rows(r, w->A, p, w->ZK);
        for (int32_t other = g; other < r->groups; other++) {
            couple_groups(r, g, other, w);
        }
    }
    return status;
}

tug_status eliminate_transforms(reduction *r, const progress_range *range)
{
    coupling_work w = {0};
    tug_status status = allocate_coupling(&w, r) ? couple_all(r, range, &w) : fail_memory();
    free_coupling(&w);
    return status;
}
