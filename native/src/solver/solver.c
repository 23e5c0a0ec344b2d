/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/solver.h"

#include "dense/small_matrix.h"
#include "solver/forms.h"
#include "solver/moments.h"
#include "solver/starts.h"

#include <math.h>
#include <string.h>

/* Y about its mean: no energy sees where the pose is, and the digits are kept for its form. What
 * holds nothing does not count, however far away. */
static void take_targets(tug_solver *solver, const double *targets)
{
    int32_t k = solver->model->header.dimension, h = solver->model->header.rows;
    double unit = solver->model->header.unit;
    for (int32_t a = 0; a < k; a++) {
        double sum = 0.0, total = 0.0;
        for (int32_t r = 0; r < h; r++) {
            sum += grip_of(solver->held, r) * targets[r * k + a];
            total += grip_of(solver->held, r);
        }
        solver->middle[a] = sum / total;
        for (int32_t r = 0; r < h; r++) {
            int holds = grip_of(solver->held, r) > 0.0;
            solver->Y[r * k + a] = holds ? (targets[r * k + a] - solver->middle[a]) / unit : 0.0;
        }
    }
    find_pull(joint_energy(solver), solver->Y, k, solver->pull);
    solver->r = energy_of_rows(joint_energy(solver), solver->Y, k);
}

/* What a shape of energy D costs in the objective. */
static double cost_of(const tug_solver *solver, double D)
{
    return solver->options.lambda * (solver->options.squared ? D : sqrt(D));
}

/* The costs: of each group and shape (A 10), or of each shape as a whole (A 5) for a single blend.
 * sum_g sqrt(D_gs) grows with the number of groups that a shape's energy is cut into. The steady
 * form weighs its terms by the groups' shares w_g of the stiffness: sum_g sqrt(w_g D_gs) is at most
 * the root of the whole energy, and is that where the energy is spread like the stiffness. */
static void price_shapes(tug_solver *solver)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes;
    const double *D = solver->costs.D;
    find_costs(solver->model, solver->held, &solver->oriented, solver->Y,
               solver->options.form != TUG_FORM_NO_ROTATIONS, &solver->costs);
    int shared = solver->options.form == TUG_FORM_STEADY && !solver->options.squared;
    for (int32_t i = 0; i < G * S; i++) {
        double share = shared ? stiffness_share(solver->model, i / S) : 1.0;
        solver->d[i] = cost_of(solver, share * D[i]);
    }
    for (int32_t s = 0; s < S; s++) {
        double sum = 0.0;
        for (int32_t g = 0; g < G; g++) {
            sum += D[g * S + s];
        }
        solver->folded_d[s] = cost_of(solver, sum);
    }
}

/* Where the forms without costs start. */
static void start_shapes(tug_solver *solver, int given)
{
    if (solver->options.scale) {
        fit_scales(solver->model, solver->held, solver->Y, &solver->costs);
    }
    if (!given) {
        find_starts(solver->model, solver->held, solver->Y, &solver->costs);
    }
    solver->costs.converged = 1;
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

/* T from V. Returns the energy of springs and soft rows. */
static double find_transforms(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension;
    settle_rows(solver->model, solver->held, JOINT, solver->V, solver->Y, solver->placed);
    recover_transforms(joint_energy(solver), solver->V, solver->placed, k, solver->recovery,
                       solver->T);
    place_transforms(&solver->model->dictionary, solver->T, solver->placed_T);
    double springs = 0.0;
    for (int32_t r = 0; r < solver->model->header.rows; r++) {
        springs += 0.5 * spring_energy(solver->held, r, solver->placed, solver->Y, k);
        springs += 0.5 * soft_row_energy(joint_energy(solver), r, solver->T, solver->placed, k);
    }
    return springs;
}

tug_status solver_set_firmness(tug_solver *solver, const double *firmness)
{
    holding *held;
    tug_status status = hold_rows(solver->model, firmness, &held);
    if (status == TUG_OK) {
        release_holding(solver->held);
        solver->held = held;
        if (compares_with_references(solver->options.form)) {
            find_couplings(solver->model, joint_energy(solver), &solver->references.couplings);
        }
    }
    return status;
}

/* Relative to the alignment, from the papers' R_gs. */
static void align_rotations(const tug_model *model, const double *given, double *R)
{
    int32_t k = model->header.dimension, kk = k * k;
    for (int32_t i = 0; i < model->header.groups * model->header.shapes; i++) {
        multiply_nt(k, given + i * kk, model->align + i * kk, R + i * kk);
    }
}

void solver_solve(tug_solver *solver, const double *targets, const double *rotations,
                  tug_solve_info *info)
{
    take_targets(solver, targets);
    if (compares_with_references(solver->options.form)) {
        start_shapes(solver, rotations != NULL);
    } else {
        price_shapes(solver);
        start_blend(solver);
    }
    if (rotations != NULL) {
        align_rotations(solver->model, rotations, solver->costs.rotations);
    }
    solver->scale = 1.0;
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
    case TUG_FORM_TRUST_REGION:
        solve_trust_region(solver, info);
        break;
    case TUG_FORM_AVERAGE:
        solve_average(solver, info);
        break;
    case TUG_FORM_MINIMAL:
        solve_minimal(solver, info);
        break;
    case TUG_FORM_CLOSEST:
        solve_closest(solver, info);
        break;
    }
    if (solver->options.form != TUG_FORM_TRUST_REGION) {
        stack_rotations(solver, solver->V);
    }
    info->energy = fmax(info->energy - find_transforms(solver), 0.0);
    double unit = solver->model->header.unit, scale = solver->options.squared ? unit * unit : unit;
    info->converged &= solver->costs.converged;
    info->objective = scale * solver->blend.objective;
    info->energy *= unit * unit;
    info->gap = scale * solver->blend.gap;
    info->increase *= scale;
    solver->solved = solver->posed = 1;
}

void solver_pose(tug_solver *solver, const double *targets, const double *blend,
                 const double *rotations)
{
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    take_targets(solver, targets);
    solver->scale = 1.0;
    memcpy(solver->B, blend, (size_t)n * sizeof *blend);
    align_rotations(solver->model, rotations, solver->R);
    stack_rotations(solver, solver->V);
    find_transforms(solver);
    solver->solved = 0;
    solver->posed = 1;
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
