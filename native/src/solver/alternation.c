/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The paper's own form (section 5.5): a rotation per group and shape, (A 20) and (A 22-23) by
 * turns; and the form without rotations, which is one (A 20). */
#include "solver/forms.h"

#include "dense/rotation.h"
#include "solver/blend_terms.h"
#include "solver/contraction.h"
#include "solver/moments.h"

#include <math.h>
#include <string.h>

/* Twice what the orientations cost a pair of blend weight one. */
static double pair_orientation(const tug_solver *solver, int32_t i)
{
    int32_t kk = solver->model->header.dimension * solver->model->header.dimension;
    return orientation_energy(solver->model, &solver->oriented, i / solver->model->header.shapes,
                              solver->R + i * kk);
}

static void solve_blend_here(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    coupling all = joint_coupling(joint_energy(solver));
    contract_pair_rotations(&all, solver->R, solver->Q);
    for (int32_t i = 0; i < n; i++) {
        solver->c[i] = 0.5 * pair_orientation(solver, i) -
                       trace_of_product(k, solver->R + i * kk, solver->pull + i * kk);
    }
    blend_terms terms = all_terms(solver);
    solve_blend(solver, &terms);
}

/* (A 22), all for the transforms of the old rotations. Returns the largest angle. */
static double update_rotations(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t S = solver->model->header.shapes, n = solver->model->header.groups * S;
    double largest = 0.0, *R = solver->M;
    stack_rotations(solver, solver->V);
    find_pose_moments(solver, solver->V, solver->M);
    for (int32_t i = 0; i < n; i++) {
        add_orientation_pull(solver->model, &solver->oriented, i / S,
                             solver->model->stiffness[i / S], solver->M + i * kk);
    }
    closest_rotations(k, n, solver->M, R);
    for (int32_t i = 0; i < n; i++) {
        largest = fmax(largest, angle_between(k, solver->R + i * kk, R + i * kk));
    }
    memcpy(solver->R, R, (size_t)(n * kk) * sizeof *R);
    return largest;
}

static void start_rotations(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension;
    size_t pairs = (size_t)(solver->model->header.groups * solver->model->header.shapes);
    memcpy(solver->R, solver->costs.rotations, pairs * (size_t)(k * k) * sizeof *solver->R);
}

void start_alternation(tug_solver *solver)
{
    if (!solver->options.warm_start || !solver->solved) {
        start_rotations(solver);
    }
    solve_blend_here(solver);
}

void solve_alternating(tug_solver *solver, tug_solve_info *info)
{
    start_alternation(solver);
    info->residual = INFINITY;
    while (info->rounds < solver->options.max_rounds && !info->converged) {
        double before = solver->blend.objective;
        info->residual = update_rotations(solver);
        solve_blend_here(solver);
        info->rounds++;
        info->increase = fmax(info->increase, solver->blend.objective - before);
        info->converged = info->residual <= solver->options.tolerance;
    }
    info->energy = solver->blend.u;
    for (int32_t i = 0; i < solver->model->header.groups * solver->model->header.shapes; i++) {
        info->energy -= 0.5 * solver->B[i] * pair_orientation(solver, i);
    }
}

void solve_without_rotations(tug_solver *solver, tug_solve_info *info)
{
    start_rotations(solver);
    solve_blend_here(solver);
    info->rounds = 1;
    info->converged = 1;
    info->energy = solver->blend.u;
}
