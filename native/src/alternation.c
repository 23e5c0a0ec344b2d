/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The paper's own form (section 5.5): a rotation per group and shape, (A 20) and (A 22-23) by
 * turns; and the form without rotations, which is one (A 20). */
#include "forms.h"

#include "contraction.h"
#include "moments.h"
#include "rotation.h"

#include <math.h>
#include <string.h>

static void solve_blend_here(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    contract_pair_rotations(solver->model, joint_energy(solver)->C, solver->R, solver->Q);
    for (int32_t i = 0; i < n; i++) {
        solver->c[i] = -trace_of_product(k, solver->R + i * kk, solver->pull + i * kk);
    }
    solve_blend(solver, 0.0);
}

/* (A 22), all for the transforms of the old rotations. Returns the largest angle. */
static double update_rotations(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    double largest = 0.0, R[9];
    stack_rotations(solver, solver->V);
    find_pose_moments(solver, solver->V, solver->M);
    for (int32_t i = 0; i < n; i++) {
        closest_rotation(k, solver->M + i * kk, R);
        largest = fmax(largest, angle_between(k, solver->R + i * kk, R));
        memcpy(solver->R + i * kk, R, (size_t)kk * sizeof *R);
    }
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
}

void solve_without_rotations(tug_solver *solver, tug_solve_info *info)
{
    start_rotations(solver);
    solve_blend_here(solver);
    info->rounds = 1;
    info->converged = 1;
    info->energy = solver->blend.u;
}
