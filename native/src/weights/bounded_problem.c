/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A dual method. The bounds that matter hold on thin curves, so few of them have a multiplier: keep
 * a set C of vertices, solve with the bounds kept there only, add the vertices at which the result
 * dips furthest below zero or above one, and repeat. With S the signs of the bounds (1 for w >= 0,
 * -1 for w <= 1) and multipliers l >= 0 on C,
 *
 *     w = Q^-1 (load + S l),     slack of C = q + G l >= 0,   l . slack = 0,   G = S (Q^-1)_CC S,
 *
 * so a round costs one solve with a factor that all rounds and handles share, and a small dense
 * complementarity problem. Every round's Lagrangian
 *
 *     D = w^T Q w / 2 - l . slack
 *
 * is a lower bound of the optimum, since l >= 0 and w minimises it; w clamped to [0, 1] gives an
 * upper one. */
#include "weights/bounded_problem.h"

#include "memory.h"
#include "weights/complementarity.h"
#include "weights/inverse_block.h"

#include <math.h>
#include <string.h>

/* Of the dips, those of at least this part of the deepest join C; none less than the rounding. */
static const double worthwhile = 0.1, least_dip = 1e-13;

/* Give up after so many rounds in which the gap has not fallen by a tenth. */
enum { patience = 20 };

typedef struct bounded_state {
    const bounded_problem *problem;
    double *w;                       /* of the vertices, without the bounds outside of C */
    double *clamped, *bent, *forces; /* of the vertices: clamped w, M^-1 L w, Q w */
    double *best;                    /* the clamped w of least energy, */
    double upper;                    /* and that energy */
    double *rows;                    /* of the unknowns: work room */
    double *dip;                     /* of the vertices: how far outside of [0, 1]; 0 in C */
    int32_t *vertices;               /* C */
    double *previous;                /* multipliers of the round before */
    int32_t *candidates;
    complementarity bounds;
    inverse_block *block;
    sparse_solver *solver;
} bounded_state;

static void close_state(bounded_state *state)
{
    release(state->best);
    release(state->clamped);
    release(state->bent);
    release(state->forces);
    release(state->rows);
    release(state->dip);
    release(state->vertices);
    release(state->previous);
    release(state->candidates);
    complementarity_free(&state->bounds);
    inverse_block_destroy(state->block);
    sparse_solver_destroy(state->solver);
}

static tug_status open_state(bounded_state *state, const bounded_problem *problem, double *w)
{
    size_t size = (size_t)problem->L->size, unknowns = (size_t)problem->unknown_count;
    memset(state, 0, sizeof *state);
    state->problem = problem;
    state->w = w;
    state->best = allocate(size, sizeof(double));
    state->upper = INFINITY;
    state->clamped = allocate(size, sizeof(double));
    state->bent = allocate(size, sizeof(double));
    state->forces = allocate(size, sizeof(double));
    state->rows = allocate(unknowns, sizeof(double));
    state->dip = allocate(size, sizeof(double));
    state->vertices = allocate(unknowns, sizeof(int32_t));
    state->previous = allocate(unknowns, sizeof(double));
    state->candidates = allocate(unknowns, sizeof(int32_t));
    if (!state->best || !state->clamped || !state->bent || !state->forces || !state->rows ||
        !state->dip || !state->vertices || !state->previous || !state->candidates) {
        return fail_memory();
    }
    tug_status status =
        inverse_block_create(sparse_factor_supernodes(problem->factor), &state->block);
    if (status == TUG_OK) {
        status = sparse_solver_create(problem->factor, 1, &state->solver);
    }
    return status;
}

/* w += Q^-1 rows. Only changes of w are ever solved for: their rounding falls with them. */
static tug_status add_solution(bounded_state *state)
{
    const bounded_problem *problem = state->problem;
    tug_status status = sparse_solve(state->solver, state->rows, state->rows);
    for (int32_t i = 0; status == TUG_OK && i < problem->unknown_count; i++) {
        state->w[problem->unknowns[i]] += state->rows[i];
    }
    return status;
}

static tug_status solve_without_bounds(bounded_state *state)
{
    const bounded_problem *problem = state->problem;
    laplacian_bend(problem->L, state->w, state->bent);
    laplacian_apply(problem->L, state->bent, state->forces);
    for (int32_t i = 0; i < problem->unknown_count; i++) {
        state->rows[i] = -state->forces[problem->unknowns[i]];
    }
    return add_solution(state);
}

static double slack_at(const bounded_state *state, int32_t c)
{
    double w = state->w[state->vertices[c]];
    return state->bounds.sign[c] > 0.0 ? w : 1.0 - w;
}

/* D, with M^-1 L w left in `bent`. */
static double lower_bound(bounded_state *state)
{
    double energy = laplacian_bend(state->problem->L, state->w, state->bent);
    for (int32_t c = 0; c < state->bounds.count; c++) {
        energy -= state->bounds.l[c] * slack_at(state, c);
    }
    return energy;
}

static void update_best(bounded_state *state)
{
    for (int32_t v = 0; v < state->problem->L->size; v++) {
        state->clamped[v] = fmin(fmax(state->w[v], 0.0), 1.0);
    }
    double energy = laplacian_bend(state->problem->L, state->clamped, state->bent);
    if (energy < state->upper) {
        double *worse = state->best;
        state->upper = energy;
        state->best = state->clamped;
        state->clamped = worse;
    }
}

static double relative_gap(const bounded_state *state, double lower)
{
    return state->upper > 0.0 ? fmax(state->upper - lower, 0.0) / state->upper : 0.0;
}

static double largest_dip(const bounded_state *state)
{
    double dip = 0.0;
    for (int32_t v = 0; v < state->problem->L->size; v++) {
        dip = fmax(dip, fmax(-state->w[v], state->w[v] - 1.0));
    }
    return dip;
}

/* The residual r = load + S l - Q w into `rows`, given M^-1 L w in `bent`. Returns its largest
 * entry relative to that of Q w. */
static double find_residual(bounded_state *state)
{
    const bounded_problem *problem = state->problem;
    double largest = 0.0, residual = 0.0;
    laplacian_apply(problem->L, state->bent, state->forces);
    for (int32_t v = 0; v < problem->L->size; v++) {
        largest = fmax(largest, fabs(state->forces[v]));
    }
    for (int32_t c = 0; c < state->bounds.count; c++) {
        state->forces[state->vertices[c]] -= state->bounds.sign[c] * state->bounds.l[c];
    }
    for (int32_t i = 0; i < problem->unknown_count; i++) {
        state->rows[i] = -state->forces[problem->unknowns[i]];
        residual = fmax(residual, fabs(state->rows[i]));
    }
    return largest > 0.0 ? residual / largest : 0.0;
}

/* What rounding left of the stationarity lowers the Lagrangian's minimum to D - r^T Q^-1 r / 2, and
 * w + Q^-1 r attains it. */
static tug_status certify(bounded_state *state, bounded_result *result)
{
    double lower = lower_bound(state);
    result->kkt_residual = find_residual(state);
    tug_status status = add_solution(state);
    for (int32_t i = 0; i < state->problem->unknown_count; i++) {
        lower += 0.5 * state->forces[state->problem->unknowns[i]] * state->rows[i];
    }
    update_best(state);
    result->gap = relative_gap(state, lower);
    result->violation = largest_dip(state);
    result->converged = result->gap <= state->problem->tolerance;
    return status;
}

static void find_dips(bounded_state *state)
{
    memset(state->dip, 0, (size_t)state->problem->L->size * sizeof(double));
    for (int32_t i = 0; i < state->problem->unknown_count; i++) {
        int32_t v = state->problem->unknowns[i];
        state->dip[v] = fmax(fmax(-state->w[v], state->w[v] - 1.0), 0.0);
    }
    for (int32_t c = 0; c < state->bounds.count; c++) {
        state->dip[state->vertices[c]] = 0.0;
    }
}

/* Whether no neighbour dips further; of equals the first. */
static int is_deepest(const bounded_state *state, int32_t vertex)
{
    const laplacian *L = state->problem->L;
    for (int32_t k = L->starts[vertex]; k < L->starts[vertex + 1]; k++) {
        int32_t other = L->columns[k];
        if (state->dip[other] > state->dip[vertex] ||
            (state->dip[other] == state->dip[vertex] && other < vertex)) {
            return 0;
        }
    }
    return 1;
}

static int32_t list_candidates(bounded_state *state)
{
    int32_t found = 0, kept = 0;
    double deepest = 0.0;
    find_dips(state);
    for (int32_t i = 0; i < state->problem->unknown_count; i++) {
        int32_t v = state->problem->unknowns[i];
        if (state->dip[v] > least_dip && is_deepest(state, v)) {
            state->candidates[found++] = v;
            deepest = fmax(deepest, state->dip[v]);
        }
    }
    for (int32_t i = 0; i < found; i++) {
        if (state->dip[state->candidates[i]] >= worthwhile * deepest) {
            state->candidates[kept++] = state->candidates[i];
        }
    }
    return kept;
}

/* The candidates join C. */
static tug_status add_bounds(bounded_state *state, int32_t count)
{
    complementarity *bounds = &state->bounds;
    tug_status status = complementarity_reserve(bounds, bounds->count + count);
    if (status != TUG_OK) {
        return status;
    }
    for (int32_t i = 0; i < count; i++) {
        int32_t v = state->candidates[i], c = bounds->count++;
        state->vertices[c] = v;
        bounds->sign[c] = state->w[v] < 0.0 ? 1.0 : -1.0;
        bounds->l[c] = 0.0;
        bounds->support[c] = 1;
        state->candidates[i] = state->problem->row_of[v];
    }
    return inverse_block_extend(state->block, state->candidates, count);
}

/* q = slack - G l at the present w, so that the rounding of earlier rounds is made good. */
static void find_offsets(bounded_state *state, const double *G, int32_t stride)
{
    complementarity *bounds = &state->bounds;
    for (int32_t c = 0; c < bounds->count; c++) {
        const double *row = G + (size_t)c * (size_t)stride;
        double sum = 0.0;
        for (int32_t b = 0; b < bounds->count; b++) {
            sum += row[b] * bounds->sign[b] * bounds->l[b];
        }
        bounds->q[c] = slack_at(state, c) - bounds->sign[c] * sum;
    }
}

static tug_status apply_multipliers(bounded_state *state)
{
    memset(state->rows, 0, (size_t)state->problem->unknown_count * sizeof(double));
    for (int32_t c = 0; c < state->bounds.count; c++) {
        state->rows[state->problem->row_of[state->vertices[c]]] =
            state->bounds.sign[c] * (state->bounds.l[c] - state->previous[c]);
    }
    return add_solution(state);
}

/* One round. *more: in, whether the last one left its complementarity problem unsolved; out,
 * whether there was anything to do. */
static tug_status improve(bounded_state *state, int *unsolved, int *more)
{
    int32_t count = list_candidates(state), stride;
    *more = count > 0 || *unsolved;
    if (!*more) {
        return TUG_OK;
    }
    tug_status status = add_bounds(state, count);
    if (status != TUG_OK) {
        return status;
    }
    const double *G = inverse_block_entries(state->block, &stride);
    find_offsets(state, G, stride);
    memcpy(state->previous, state->bounds.l, (size_t)state->bounds.count * sizeof(double));
    int solved;
    status = complementarity_solve(&state->bounds, G, stride, &solved);
    *unsolved = !solved;
    return status == TUG_OK ? apply_multipliers(state) : status;
}

static tug_status iterate(bounded_state *state, const atomic_int *stop, bounded_result *result)
{
    int unsolved = 0, more = 1;
    int32_t tries = patience;
    double least = INFINITY;
    tug_status status = solve_without_bounds(state);
    while (status == TUG_OK) {
        double lower = lower_bound(state);
        update_best(state);
        double gap = relative_gap(state, lower);
        tries = gap < 0.9 * least ? patience : tries - 1;
        least = fmin(least, gap);
        int last = !more || tries == 0 || result->iterations == state->problem->max_iterations;
        if (last || gap <= state->problem->tolerance) {
            status = certify(state, result);
            if (status != TUG_OK || last || result->converged) {
                break;
            }
        }
        if (atomic_load(stop)) {
            return fail(TUG_ERROR_CANCELLED, "cancelled");
        }
        status = improve(state, &unsolved, &more);
        result->iterations += more;
    }
    return status;
}

tug_status bounded_solve(const bounded_problem *problem, double *w, const atomic_int *stop,
                         bounded_result *result)
{
    bounded_state state;
    memset(result, 0, sizeof *result);
    tug_status status = open_state(&state, problem, w);
    if (status == TUG_OK) {
        status = iterate(&state, stop, result);
    }
    if (status == TUG_OK) {
        memcpy(w, state.best, (size_t)problem->L->size * sizeof(double));
    }
    close_state(&state);
    return status;
}
