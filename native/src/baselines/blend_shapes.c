/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear blend shapes by direct manipulation, as in Lewis and Anjyo 2010: the weights b of the
 * simplex that minimise |H sum_s b_s p_s - Y|^2 / 2 plus a regulariser too small to be seen; what
 * is left of the handles' distances is then spread over the mesh by the weight functions.
 *
 * Against the paper: weights are bounded, in place of a penalty on their change from the last
 * frame, so that the pose has no history. */
#include "dense/dense.h"
#include "memory.h"
#include "method.h"
#include "solver/blend.h"

#include <string.h>

/* Of |b|^2, relative to the mean of the quadratic form's diagonal. */
static const double REGULARISER = 1e-9;

typedef struct blend_shapes {
    double *rows;     /* #S by #H k: the handle positions of every shape, about their mean */
    double *mean;     /* #H k */
    double *Q;        /* #S by #S */
    double *c, *none; /* #S */
    double *spread;   /* #V by #H: moves every handle by one and keeps the others */
    double *left;     /* #H k: what the blend misses */
    int32_t length;   /* #H k */
    blend_workspace work;
} blend_shapes;

static void destroy(void *state)
{
    blend_shapes *b = state;
    if (b == NULL) {
        return;
    }
    release(b->rows);
    release(b->mean);
    release(b->Q);
    release(b->c);
    release(b->none);
    release(b->spread);
    release(b->left);
    blend_workspace_destroy(&b->work);
    release(b);
}

static int allocate_room(blend_shapes *b, const tug_baseline_problem *problem)
{
    size_t S = (size_t)problem->shape_count, h = (size_t)problem->handle_count;
    size_t length = h * (size_t)problem->dimension;
    b->length = (int32_t)length;
    b->rows = allocate(S * length, sizeof *b->rows);
    b->mean = allocate(length, sizeof *b->mean);
    b->Q = allocate(S * S, sizeof *b->Q);
    b->c = allocate(S, sizeof *b->c);
    b->none = allocate(S, sizeof *b->none);
    b->spread = allocate((size_t)problem->vertex_count * h, sizeof *b->spread);
    b->left = allocate(length, sizeof *b->left);
    int room = blend_workspace_create(1, (int32_t)S, &b->work);
    return room && b->rows && b->mean && b->Q && b->c && b->none && b->spread && b->left;
}

static void find_form(const tug_baseline *baseline, blend_shapes *b)
{
    int32_t S = baseline->shape_count, k = baseline->mesh->dimension;
    for (int32_t i = 0; i < S * b->length; i++) {
        int32_t s = i / b->length, e = i % b->length;
        int32_t v = baseline->handles[e / k];
        b->rows[i] = shape_of_baseline(baseline, s)[(size_t)v * (size_t)k + (size_t)(e % k)];
        b->mean[e] += b->rows[i] / S;
    }
    for (int32_t i = 0; i < S * b->length; i++) {
        b->rows[i] -= b->mean[i % b->length];
    }
    add_product_nt(S, S, b->length, 1.0, b->rows, b->length, b->rows, b->length, b->Q, S);
    double trace = 0.0;
    for (int32_t s = 0; s < S; s++) {
        trace += b->Q[s * S + s] / S;
    }
    for (int32_t s = 0; s < S; s++) {
        b->Q[s * S + s] += REGULARISER * trace;
    }
}

/* W X^T (X X^T)^-1, X being the weights at the handles: the least combination of the weight
 * functions that moves one handle and no other. */
static tug_status find_spread(const tug_baseline_problem *problem, blend_shapes *b)
{
    int32_t h = problem->handle_count, m = problem->weight_count, n = problem->vertex_count;
    double *X = allocate((size_t)h * (size_t)m, sizeof *X);
    double *G = allocate((size_t)h * (size_t)h, sizeof *G);
    tug_status status = X != NULL && G != NULL ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        for (int32_t i = 0; i < h; i++) {
            memcpy(X + (size_t)i * (size_t)m,
                   problem->weights + (size_t)problem->handles[i] * (size_t)m,
                   (size_t)m * sizeof *X);
        }
        add_product_nt(h, h, m, 1.0, X, m, X, m, G, h);
        if (cholesky_factor(G, h)) {
            cholesky_solve(G, h, X, m);
            add_product_nt(n, h, m, 1.0, problem->weights, m, X, m, b->spread, h);
        } else {
            status = fail(TUG_ERROR_HANDLES, "the weights do not tell the handles apart");
        }
    }
    release(X);
    release(G);
    return status;
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    blend_shapes *b = *state = allocate(1, sizeof *b);
    if (b == NULL || !allocate_room(b, problem)) {
        return fail_memory();
    }
    find_form(baseline, b);
    return find_spread(problem, b);
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    blend_shapes *b = baseline->state;
    int32_t S = baseline->shape_count;
    for (int32_t i = 0; i < b->length; i++) {
        b->left[i] = baseline->Y[i] - b->mean[i];
    }
    double r = dot(b->left, b->left, (size_t)b->length);
    for (int32_t s = 0; s < S; s++) {
        b->c[s] = -dot(b->rows + s * b->length, b->left, (size_t)b->length);
        baseline->blend[s] = 1.0 / S;
    }
    blend_problem problem = {1, S, b->Q, b->c, r, b->none, 1};
    blend_result result = minimise_blend(&problem, &b->work, baseline->blend);
    for (int32_t i = 0; i < S * b->length; i++) {
        b->left[i % b->length] -= baseline->blend[i / b->length] * b->rows[i];
    }
    info->rounds = result.pivots;
    info->objective = result.objective;
    info->residual = result.gap;
    info->converged = result.gap <= baseline->options.tolerance;
    return TUG_OK;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    const blend_shapes *b = baseline->state;
    int32_t n = baseline->mesh->vertex_count, k = baseline->mesh->dimension;
    memset(positions, 0, (size_t)n * (size_t)k * sizeof *positions);
    for (int32_t s = 0; s < baseline->shape_count; s++) {
        const double *shape = shape_of_baseline(baseline, s);
        for (size_t i = 0; i < (size_t)n * (size_t)k; i++) {
            positions[i] += baseline->blend[s] * shape[i];
        }
    }
    add_product(n, k, baseline->row_count, 1.0, b->spread, baseline->row_count, b->left, k,
                positions, k);
}

const baseline_method blend_shapes_method = {create, destroy, solve, find_positions, NULL};
