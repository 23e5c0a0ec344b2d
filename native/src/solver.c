/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver.h"

#include "memory.h"
#include "rotation.h"

#include <math.h>
#include <string.h>

void solver_destroy(tug_solver *solver)
{
    if (solver == NULL) {
        return;
    }
    double *arrays[] = {solver->Y,        solver->pull,     solver->B,        solver->R,
                        solver->T,        solver->Q,        solver->c,        solver->d,
                        solver->folded_Q, solver->folded_c, solver->folded_d, solver->folded_B,
                        solver->group_R,  solver->prior_R,  solver->kept_R,   solver->C,
                        solver->L,        solver->X,        solver->J,        solver->face_J,
                        solver->face_X,   solver->face_H,   solver->V};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        release(arrays[i]);
    }
    costs_destroy(&solver->costs);
    blend_workspace_destroy(&solver->blending);
    rotation_workspace_destroy(&solver->turning);
    release(solver);
}

typedef struct array_request {
    double **array;
    size_t count;
} array_request;

static int allocate_arrays(const array_request *requests, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        *requests[i].array = allocate(requests[i].count, sizeof(double));
        if (*requests[i].array == NULL) {
            return 0;
        }
    }
    return 1;
}

static int allocate_solver(tug_solver *s)
{
    const model_header *header = &s->model->header;
    size_t k = (size_t)header->dimension, kk = k * k, S = (size_t)header->shapes;
    size_t G = (size_t)header->groups, h = (size_t)header->rows, n = G * S;
    size_t size = G * (size_t)tangent_size(header->dimension);
    /* The rows of J beyond the first S serve as scratch for a single blend. */
    const array_request requests[] = {
        {&s->Y, h * k},
        {&s->pull, n * kk},
        {&s->B, n},
        {&s->R, n * kk},
        {&s->T, (size_t)s->model->energy.unknowns * k},
        {&s->Q, n * n},
        {&s->c, n},
        {&s->d, n},
        {&s->folded_Q, S * S},
        {&s->folded_c, S},
        {&s->folded_d, S},
        {&s->folded_B, S},
        {&s->group_R, G * kk},
        {&s->prior_R, G * kk},
        {&s->kept_R, G * kk},
        {&s->C, G * k * G * k},
        {&s->L, G * kk},
        {&s->X, G * kk},
        {&s->J, (n + 1) * size},
        {&s->face_J, n * size},
        {&s->face_X, n * size},
        {&s->face_H, n * n},
        {&s->V, n * kk},
    };
    return allocate_arrays(requests, sizeof requests / sizeof *requests);
}

tug_status solver_create(const tug_model *model, const tug_solver_options *options,
                         tug_solver **out)
{
    tug_solver *solver = allocate(1, sizeof *solver);
    if (solver == NULL) {
        return fail_memory();
    }
    solver->model = model;
    solver->options = *options;
    int32_t groups = model->header.groups, shapes = model->header.shapes;
    int room =
        allocate_solver(solver) && costs_create(model, &solver->costs) &&
        blend_workspace_create(options->single_blend ? 1 : groups, shapes, &solver->blending) &&
        rotation_workspace_create(groups, model->header.dimension, &solver->turning);
    if (!room) {
        solver_destroy(solver);
        return fail_memory();
    }
    *out = solver;
    return TUG_OK;
}

/* Y about its mean: no energy sees where the pose is, and the digits are kept for its form. */
static void take_targets(tug_solver *solver, const double *targets)
{
    int32_t k = solver->model->header.dimension, h = solver->model->header.rows;
    double unit = solver->model->header.unit;
    for (int32_t a = 0; a < k; a++) {
        double sum = 0.0;
        for (int32_t r = 0; r < h; r++) {
            sum += targets[r * k + a];
        }
        solver->middle[a] = sum / h;
        for (int32_t r = 0; r < h; r++) {
            solver->Y[r * k + a] = (targets[r * k + a] - solver->middle[a]) / unit;
        }
    }
    find_pull(&solver->model->energy, solver->Y, k, solver->pull);
    solver->r = energy_of_rows(&solver->model->energy, solver->Y, k);
}

/* One simplex for all groups: sums over them. */
static void fold(const tug_solver *solver)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes, n = G * S;
    memset(solver->folded_Q, 0, (size_t)(S * S) * sizeof(double));
    memset(solver->folded_c, 0, (size_t)S * sizeof(double));
    for (int32_t i = 0; i < n; i++) {
        solver->folded_c[i % S] += solver->c[i];
        for (int32_t j = 0; j < n; j++) {
            solver->folded_Q[(i % S) * S + j % S] += solver->Q[(size_t)i * (size_t)n + (size_t)j];
        }
    }
}

void solve_blend(tug_solver *solver, double constant)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes;
    int32_t squared = solver->options.squared;
    double r = solver->r + constant;
    if (!solver->options.single_blend) {
        blend_problem problem = {G, S, solver->Q, solver->c, r, solver->d, squared};
        solver->blend = minimise_blend(&problem, &solver->blending, solver->B);
        return;
    }
    fold(solver);
    blend_problem problem = {1,      S, solver->folded_Q, solver->folded_c, r, solver->folded_d,
                             squared};
    solver->blend = minimise_blend(&problem, &solver->blending, solver->folded_B);
    for (int32_t i = 0; i < G * S; i++) {
        solver->B[i] = solver->folded_B[i % S];
    }
}

/* What a shape of energy D costs in the objective. */
static double cost_of(const tug_solver *solver, double D)
{
    return solver->options.lambda * (solver->options.squared ? D : sqrt(D));
}

/* The costs: of each group and shape (A 10), or of each shape as a whole (A 5) for a single blend.
 */
static void price_shapes(tug_solver *solver)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes;
    const double *D = solver->costs.D;
    for (int32_t i = 0; i < G * S; i++) {
        solver->d[i] = cost_of(solver, D[i]);
    }
    for (int32_t s = 0; s < S; s++) {
        double sum = 0.0;
        for (int32_t g = 0; g < G; g++) {
            sum += D[g * S + s];
        }
        solver->folded_d[s] = cost_of(solver, sum);
    }
}

/* A cold start: each group's cheapest shape. */
static void start_blend(tug_solver *solver)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes;
    const double *D = solver->costs.D;
    if (solver->options.warm_start && solver->solved) {
        return;
    }
    memset(solver->B, 0, (size_t)(G * S) * sizeof *solver->B);
    memset(solver->folded_B, 0, (size_t)S * sizeof *solver->folded_B);
    for (int32_t g = 0; g < G; g++) {
        int32_t best = 0;
        for (int32_t s = 1; s < S; s++) {
            best = D[g * S + s] < D[g * S + best] ? s : best;
        }
        solver->B[g * S + best] = 1.0;
        solver->folded_B[best] += 1.0 / G;
    }
}

/* T from blend and rotations. */
static void find_transforms(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    for (int32_t i = 0; i < n * kk; i++) {
        int32_t pair = i / kk, row = i / k % k, column = i % k;
        solver->V[i] = solver->B[pair] * solver->R[pair * kk + column * k + row];
    }
    recover_transforms(&solver->model->energy, solver->V, solver->Y, k, solver->T);
}

void solver_solve(tug_solver *solver, const double *targets, tug_solve_info *info)
{
    take_targets(solver, targets);
    find_costs(solver->model, solver->Y, solver->options.form != TUG_FORM_NO_ROTATIONS,
               &solver->costs);
    price_shapes(solver);
    start_blend(solver);
    size_t size = info->struct_size;
    *info = (tug_solve_info){.struct_size = size};
    switch ((tug_form)solver->options.form) {
    case TUG_FORM_STEADY:
        solve_steady(solver, info);
        break;
    case TUG_FORM_PAPER:
        solve_alternating(solver, info);
        break;
    case TUG_FORM_NO_ROTATIONS:
        solve_without_rotations(solver, info);
        break;
    }
    find_transforms(solver);
    double unit = solver->model->header.unit, scale = solver->options.squared ? unit * unit : unit;
    info->converged &= solver->costs.converged;
    info->objective = scale * solver->blend.objective;
    info->energy *= unit * unit;
    info->gap = scale * solver->blend.gap;
    info->increase *= scale;
    solver->solved = 1;
}

void copy_blend(const tug_solver *solver, double *blend)
{
    size_t n = (size_t)(solver->model->header.groups * solver->model->header.shapes);
    memcpy(blend, solver->B, n * sizeof *blend);
}

void copy_costs(const tug_solver *solver, double *costs)
{
    double unit = solver->model->header.unit;
    for (int32_t i = 0; i < solver->model->header.groups * solver->model->header.shapes; i++) {
        double D = solver->costs.D[i];
        costs[i] = solver->options.squared ? unit * unit * D : unit * sqrt(D);
    }
}

/* The papers' R_gs: from the shape as it is given, so the alignment counts. */
void copy_rotations(const tug_solver *solver, double *rotations)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    for (int32_t i = 0; i < solver->model->header.groups * solver->model->header.shapes; i++) {
        multiply(k, solver->R + i * kk, solver->model->align + i * kk, rotations + i * kk);
    }
}
