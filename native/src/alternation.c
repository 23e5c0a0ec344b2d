/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The paper's own form (section 5.5): a rotation per group and shape, (A 20) and (A 22-23) by
 * turns; and the form without rotations, which is one (A 20). */
#include "forms.h"

#include "contraction.h"
#include "rotation.h"

#include <math.h>
#include <string.h>

static void solve_blend_here(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    contract_pair_rotations(solver->model, solver->R, solver->Q);
    for (int32_t i = 0; i < n; i++) {
        solver->c[i] = -trace_of_product(k, solver->R + i * kk, solver->pull + i * kk);
    }
    solve_blend(solver, 0.0);
}

/* Component (a, b) of C_ij. */
static double joint_entry(const tug_model *model, int32_t i, int32_t j, int32_t ab)
{
    size_t G = (size_t)model->header.groups, S = (size_t)model->header.shapes;
    size_t kk = (size_t)(model->header.dimension * model->header.dimension);
    size_t g = (size_t)i / S, h = (size_t)j / S, s = (size_t)i % S, t = (size_t)j % S;
    return model->energy.C[(((g * G + h) * kk + (size_t)ab) * S + s) * S + t];
}

/* K_i T of (A 23), from the constants: pull_i + sum_j B_j (H - C)_ij R_j^T. */
static void find_moment(const tug_solver *solver, int32_t i, double *KT)
{
    const tug_model *model = solver->model;
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes, p = S * k;
    memcpy(KT, solver->pull + i * kk, (size_t)kk * sizeof *KT);
    for (int32_t j = 0; j < model->header.groups * S; j++) {
        if (solver->B[j] == 0.0) {
            continue;
        }
        double block[9], product[9];
        for (int32_t ab = 0; ab < kk; ab++) {
            block[ab] = -joint_entry(model, i, j, ab);
            if (i / S == j / S) {
                int32_t row = (i % S) * k + ab / k, column = (j % S) * k + ab % k;
                block[ab] += model->H[(size_t)(i / S * p + row) * (size_t)p + (size_t)column];
            }
        }
        multiply_nt(k, block, solver->R + j * kk, product);
        for (int32_t ab = 0; ab < kk; ab++) {
            KT[ab] += solver->B[j] * product[ab];
        }
    }
}

/* (A 22). All moments belong to the T of the old rotations, so the new ones wait in V. Returns the
 * largest angle. */
static double update_rotations(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t n = solver->model->header.groups * solver->model->header.shapes;
    double largest = 0.0, KT[9];
    for (int32_t i = 0; i < n; i++) {
        find_moment(solver, i, KT);
        closest_rotation(k, KT, solver->V + i * kk);
        largest = fmax(largest, angle_between(k, solver->R + i * kk, solver->V + i * kk));
    }
    memcpy(solver->R, solver->V, (size_t)(n * kk) * sizeof *solver->R);
    return largest;
}

static void start_rotations(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension;
    size_t pairs = (size_t)(solver->model->header.groups * solver->model->header.shapes);
    memcpy(solver->R, solver->costs.rotations, pairs * (size_t)(k * k) * sizeof *solver->R);
}

void solve_alternating(tug_solver *solver, tug_solve_info *info)
{
    if (!solver->options.warm_start || !solver->solved) {
        start_rotations(solver);
    }
    solve_blend_here(solver);
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
