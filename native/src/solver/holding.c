/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/holding.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* From here on springs are as good as pins: what they give way is below a target's rounding. */
static const double FIRMEST = 1e12;

/* A stays definite while its scaled pivots are above this. */
static const double HELD_TOLERANCE = 1e-9;

/* One problem with rows that give way. */
typedef struct yielding {
    reduction energy;
    double *own;  /* the C, KF and FLF of `energy` */
    double *give; /* count by turned + rows: u = give (V, Y) */
} yielding;

struct holding {
    int32_t problems; /* #S + 1, the joint one first */
    int32_t count;    /* rows that give way */
    int32_t *rows;    /* count */
    double *grip;     /* #H */
    double *spring;   /* #H: w s, zero for pinned rows */
    yielding *problem;
};

void release_holding(holding *held)
{
    if (held == NULL) {
        return;
    }
    for (int32_t i = 0; held->problem != NULL && i < held->problems; i++) {
        release(held->problem[i].own);
        release(held->problem[i].give);
    }
    release(held->rows);
    release(held->grip);
    release(held->spring);
    release(held->problem);
    release(held);
}

/* What one elimination needs; f rows give way of h, t rows of V. */
typedef struct downdate {
    double *A;     /* f by f, scaled to a diagonal of one; then its factor G */
    double *scale; /* f */
    int32_t *pivots;
    double *work;  /* 2 f */
    double *X;     /* t + h by f: M_f G^-1, columns in the order of the pivots */
    double *block; /* the largest block of C that is laid out as one */
} downdate;

static void free_downdate(downdate *d)
{
    release(d->A);
    release(d->scale);
    release(d->pivots);
    release(d->work);
    release(d->X);
    release(d->block);
}

static int allocate_downdate(const tug_model *model, size_t f, downdate *d)
{
    size_t p = (size_t)(model->header.shapes * model->header.dimension);
    d->A = allocate(f * f, sizeof *d->A);
    d->scale = allocate(f, sizeof *d->scale);
    d->pivots = allocate(f, sizeof *d->pivots);
    d->work = allocate(2 * f, sizeof *d->work);
    d->X = allocate((size_t)(model->energy.turned + model->header.rows) * f, sizeof *d->X);
    d->block = allocate(p * p, sizeof *d->block);
    return d->A && d->scale && d->pivots && d->work && d->X && d->block;
}

/* The null vector of A that its first missing pivot tells is one on the rows of a part that nothing
 * holds. */
static tug_status name_loose_rows(const holding *held, downdate *d, int32_t rank)
{
    int32_t f = held->count, last = d->pivots[rank];
    double *null = d->work, *share = d->work + f;
    for (int32_t j = 0; j < rank; j++) {
        null[j] = d->A[(size_t)j * (size_t)f + (size_t)rank];
    }
    solve_right_upper_transposed(null, 1, f, d->A, rank, f);
    memset(share, 0, (size_t)f * sizeof *share);
    share[last] = 1.0;
    for (int32_t j = 0; j < rank; j++) {
        share[d->pivots[j]] = fabs(null[j]) * d->scale[d->pivots[j]] / d->scale[last];
    }
    char text[256] = "";
    size_t length = 0;
    for (int32_t i = 0; i < f && length < sizeof text - 16; i++) {
        if (share[i] > 1e-3) {
            length += (size_t)snprintf(text + length, sizeof text - length, "%s%d",
                                       length > 0 ? ", " : "", held->rows[i]);
        }
    }
    return fail(TUG_ERROR_HANDLES,
                "nothing holds the part of the mesh that has the rows %s: at least one of them "
                "must be pinned or firm",
                text);
}

static tug_status factor_springs(const holding *held, const reduction *from, downdate *d)
{
    int32_t f = held->count, h = from->rows;
    for (int32_t i = 0; i < f; i++) {
        double diagonal = from->FLF[held->rows[i] * (h + 1)] + held->spring[held->rows[i]];
        d->scale[i] = diagonal > 0.0 ? 1.0 / sqrt(diagonal) : 0.0;
    }
    for (int32_t i = 0; i < f; i++) {
        for (int32_t j = 0; j < f; j++) {
            double entry = from->FLF[held->rows[i] * h + held->rows[j]] +
                           (i == j ? held->spring[held->rows[i]] : 0.0);
            d->A[i * f + j] = d->scale[i] * d->scale[j] * entry;
        }
    }
    int32_t rank = pivoted_cholesky(d->A, f, HELD_TOLERANCE, d->pivots, d->work);
    return rank == f ? TUG_OK : name_loose_rows(held, d, rank);
}

/* X = M_f G^-1 with M = [C, -K F; -(K F)^T, F^T L F]. */
static void map_form(const holding *held, const reduction *from, downdate *d)
{
    int32_t f = held->count, t = from->turned, h = from->rows;
    for (int32_t i = 0; i < t + h; i++) {
        const double *row = i < t ? from->KF + (size_t)i * (size_t)h : from->FLF + (i - t) * h;
        for (int32_t j = 0; j < f; j++) {
            double scale = d->scale[d->pivots[j]];
            d->X[(size_t)i * (size_t)f + (size_t)j] =
                (i < t ? -scale : scale) * row[held->rows[d->pivots[j]]];
        }
    }
    solve_right_upper(d->X, t + h, f, d->A, f, f);
}

/* C -= X X^T in the joint problem's blocks (see reduction). */
static void reduce_blocks(const tug_model *model, int32_t f, const downdate *d, double *C)
{
    int32_t k = model->header.dimension, S = model->header.shapes, G = model->header.groups;
    int32_t p = S * k;
    size_t size = (size_t)p * (size_t)p;
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++, C += size) {
            memset(d->block, 0, size * sizeof *d->block);
            add_product_nt(p, p, f, 1.0, d->X + (size_t)(g * p) * (size_t)f, f,
                           d->X + (size_t)(h * p) * (size_t)f, f, d->block, p);
            for (int32_t i = 0; i < p; i++) {
                for (int32_t j = 0; j < p; j++) {
                    C[((i % k * k + j % k) * S + i / k) * S + j / k] -= d->block[i * p + j];
                }
            }
        }
    }
}

/* give = -A^-1 M_f^T, its rows in the order of held->rows. */
static void store_give(const holding *held, int32_t size, downdate *d, double *give)
{
    int32_t f = held->count;
    solve_right_upper_transposed(d->X, size, f, d->A, f, f);
    for (int32_t j = 0; j < f; j++) {
        for (int32_t i = 0; i < size; i++) {
            give[(size_t)d->pivots[j] * (size_t)size + (size_t)i] =
                -d->scale[d->pivots[j]] * d->X[(size_t)i * (size_t)f + (size_t)j];
        }
    }
}

static tug_status allocate_yielding(const reduction *from, int32_t count, yielding *y)
{
    size_t t = (size_t)from->turned, h = (size_t)from->rows, size = coupling_size(from);
    y->energy = *from;
    y->own = allocate(size + t * h + h * h, sizeof *y->own);
    y->give = allocate((size_t)count * (t + h), sizeof *y->give);
    if (y->own == NULL || y->give == NULL) {
        return fail_memory();
    }
    y->energy.C = y->own;
    y->energy.KF = y->energy.C + size;
    y->energy.FLF = y->energy.KF + t * h;
    memcpy(y->energy.C, from->C, size * sizeof(double));
    memcpy(y->energy.KF, from->KF, t * h * sizeof(double));
    memcpy(y->energy.FLF, from->FLF, h * h * sizeof(double));
    return TUG_OK;
}

static tug_status yield_rows(const tug_model *model, holding *held, int32_t problem, downdate *d)
{
    const reduction *from = held_energy(model, NULL, problem);
    yielding *y = held->problem + problem + 1;
    int32_t f = held->count, t = from->turned, h = from->rows;
    tug_status status = allocate_yielding(from, f, y);
    if (status == TUG_OK) {
        status = factor_springs(held, from, d);
    }
    if (status != TUG_OK) {
        return status;
    }
    map_form(held, from, d);
    const double *X_Y = d->X + (size_t)t * (size_t)f;
    if (problem == JOINT) {
        reduce_blocks(model, f, d, y->energy.C);
    } else {
        add_product_nt(t, t, f, -1.0, d->X, f, d->X, f, y->energy.C, t);
    }
    add_product_nt(t, h, f, 1.0, d->X, f, X_Y, f, y->energy.KF, h);
    add_product_nt(h, h, f, -1.0, X_Y, f, X_Y, f, y->energy.FLF, h);
    store_give(held, t + h, d, y->give);
    return TUG_OK;
}

/* s_r: what moving the row alone takes, and a trifle of the whole where nothing resists. */
static double stiffness_at(const tug_model *model, int32_t row)
{
    double whole = 0.0;
    for (int32_t g = 0; g < model->header.groups; g++) {
        whole += model->stiffness[g];
    }
    return model->energy.FLF[row * (model->header.rows + 1)] + 1e-6 * whole;
}

static int all_are_pinned(const tug_model *model, const double *firmness)
{
    int32_t r = 0;
    while (r < model->header.rows && firmness[r] >= FIRMEST) {
        r++;
    }
    return r == model->header.rows;
}

static int allocate_holding(const tug_model *model, holding *held)
{
    size_t h = (size_t)model->header.rows;
    held->problems = model->header.shapes + 1;
    held->rows = allocate(h, sizeof *held->rows);
    held->grip = allocate(h, sizeof *held->grip);
    held->spring = allocate(h, sizeof *held->spring);
    held->problem = allocate((size_t)held->problems, sizeof *held->problem);
    return held->rows && held->grip && held->spring && held->problem;
}

static void take_firmness(const tug_model *model, const double *firmness, holding *held)
{
    for (int32_t r = 0; r < model->header.rows; r++) {
        if (firmness[r] >= FIRMEST) {
            held->grip[r] = 1.0;
            continue;
        }
        held->grip[r] = firmness[r] / (1.0 + firmness[r]);
        held->spring[r] = firmness[r] * stiffness_at(model, r);
        held->rows[held->count++] = r;
    }
}

static tug_status fill_holding(const tug_model *model, holding *held)
{
    downdate d = {0};
    tug_status status = allocate_downdate(model, (size_t)held->count, &d) ? TUG_OK : fail_memory();
    for (int32_t problem = JOINT; problem < model->header.shapes && status == TUG_OK; problem++) {
        status = yield_rows(model, held, problem, &d);
    }
    free_downdate(&d);
    return status;
}

tug_status hold_rows(const tug_model *model, const double *firmness, holding **out)
{
    use_one_blas_thread();
    *out = NULL;
    if (all_are_pinned(model, firmness)) {
        return TUG_OK;
    }
    holding *held = allocate(1, sizeof *held);
    if (held == NULL || !allocate_holding(model, held)) {
        release_holding(held);
        return fail_memory();
    }
    take_firmness(model, firmness, held);
    tug_status status = fill_holding(model, held);
    if (status != TUG_OK) {
        release_holding(held);
        return status;
    }
    *out = held;
    return TUG_OK;
}

const reduction *held_energy(const tug_model *model, const holding *held, int32_t problem)
{
    if (held != NULL) {
        return &held->problem[problem + 1].energy;
    }
    return problem == JOINT ? &model->energy : &model->shape[problem].energy;
}

/* to += factors V; V: count by k. */
static void add_combination(const double *factors, int32_t count, const double *V, int32_t k,
                            double *to)
{
    for (int32_t i = 0; i < count; i++) {
        for (int32_t a = 0; a < k; a++) {
            to[a] += factors[i] * V[i * k + a];
        }
    }
}

void settle_rows(const tug_model *model, const holding *held, int32_t problem, const double *V,
                 const double *Y, double *placed)
{
    int32_t k = model->header.dimension, h = model->header.rows;
    memcpy(placed, Y, (size_t)(h * k) * sizeof *placed);
    for (int32_t i = 0; held != NULL && i < held->count; i++) {
        const yielding *y = held->problem + problem + 1;
        int32_t t = y->energy.turned;
        const double *give = y->give + (size_t)i * (size_t)(t + h);
        double *row = placed + held->rows[i] * k;
        add_combination(give, t, V, k, row);
        add_combination(give + t, h, Y, k, row);
    }
}

double spring_energy(const holding *held, int32_t row, const double *placed, const double *Y,
                     int32_t k)
{
    double squares = 0.0;
    for (int32_t i = row * k; i < (row + 1) * k; i++) {
        squares += (placed[i] - Y[i]) * (placed[i] - Y[i]);
    }
    return held != NULL ? held->spring[row] * squares : 0.0;
}

double grip_of(const holding *held, int32_t row)
{
    return held != NULL ? held->grip[row] : 1.0;
}
