/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/moments.h"

#include "dense/rotation.h"

#include <string.h>

static int32_t pair_count(const tug_solver *solver)
{
    return solver->model->header.groups * solver->model->header.shapes;
}

void stack_rotations(const tug_solver *solver, double *V)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    for (int32_t i = 0; i < pair_count(solver) * kk; i++) {
        int32_t pair = i / kk, row = i / k % k, column = i % k;
        V[i] = solver->scale * solver->B[pair] * solver->R[pair * kk + column * k + row];
    }
}

/* H_ij of two pairs of one group. */
static void find_stiffness(const tug_model *model, int32_t i, int32_t j, double *block)
{
    int32_t k = model->header.dimension, S = model->header.shapes;
    size_t p = (size_t)(S * k), g = (size_t)(i / S);
    for (int32_t ab = 0; ab < k * k; ab++) {
        size_t row = (size_t)(i % S * k + ab / k), column = (size_t)(j % S * k + ab % k);
        block[ab] = model->H[(g * p + row) * p + column];
    }
}

/* Component (a, b) of C_ij; of two groups the block of the earlier one first is stored. */
static double joint_entry(const reduction *energy, int32_t i, int32_t j, int32_t ab)
{
    int32_t S = energy->shapes, k = energy->group_rows / S;
    if (i / S > j / S) {
        return joint_entry(energy, j, i, ab % k * k + ab / k);
    }
    size_t block = coupling_offset(energy, i / S, j / S);
    return energy->C[block + (size_t)((ab * S + i % S) * S + j % S)];
}

void find_own_block(const tug_model *model, const reduction *energy, int32_t i, int32_t j,
                    double *block)
{
    int32_t kk = model->header.dimension * model->header.dimension, S = model->header.shapes;
    memset(block, 0, (size_t)kk * sizeof *block);
    if (i / S == j / S) {
        find_stiffness(model, i, j, block);
    }
    for (int32_t ab = 0; ab < kk; ab++) {
        block[ab] -= joint_entry(energy, i, j, ab);
    }
}

static int is_zero(const double *block, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        if (block[i] != 0.0) {
            return 0;
        }
    }
    return 1;
}

void find_own_moments(const tug_solver *solver, const double *V, double *AV)
{
    int32_t k = solver->model->header.dimension, kk = k * k, n = pair_count(solver);
    double block[9], product[9];
    memset(AV, 0, (size_t)(n * kk) * sizeof *AV);
    for (int32_t j = 0; j < n; j++) {
        if (is_zero(V + j * kk, kk)) {
            continue; /* most shapes count in no group */
        }
        for (int32_t i = 0; i < n; i++) {
            find_own_block(solver->model, joint_energy(solver), i, j, block);
            multiply(k, block, V + j * kk, product);
            for (int32_t ab = 0; ab < kk; ab++) {
                AV[i * kk + ab] += product[ab];
            }
        }
    }
}

void find_pose_moments(const tug_solver *solver, const double *V, double *M)
{
    int32_t k = solver->model->header.dimension;
    find_own_moments(solver, V, M);
    for (int32_t i = 0; i < pair_count(solver) * k * k; i++) {
        M[i] += solver->pull[i];
    }
}

/* M_i with the least prior. */
static void hold_moment(const tug_solver *solver, int32_t i, const double *M, double *held)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    double weight = LEAST_PRIOR * solver->model->stiffness[i / solver->model->header.shapes];
    const double *start = solver->costs.rotations + i * kk;
    for (int32_t ab = 0; ab < kk; ab++) {
        held[ab] = M[i * kk + ab] + weight * start[ab % k * k + ab / k];
    }
}

void follow_moments(tug_solver *solver, const double *M)
{
    int32_t k = solver->model->header.dimension;
    for (int32_t i = 0; i < pair_count(solver); i++) {
        hold_moment(solver, i, M, solver->R + i * k * k);
    }
    closest_rotations(k, pair_count(solver), solver->R, solver->R);
}

void find_blended_moments(const tug_solver *solver, double *N)
{
    int32_t k = solver->model->header.dimension, kk = k * k, S = solver->model->header.shapes;
    double block[9], product[9];
    memset(N, 0, (size_t)(pair_count(solver) * kk) * sizeof *N);
    for (int32_t i = 0; i < pair_count(solver); i++) {
        for (int32_t j = i / S * S; j < (i / S + 1) * S; j++) {
            if (solver->B[j] == 0.0) {
                continue;
            }
            find_stiffness(solver->model, i, j, block);
            multiply_nt(k, block, solver->R + j * kk, product);
            for (int32_t ab = 0; ab < kk; ab++) {
                N[i * kk + ab] += solver->B[j] * product[ab];
            }
        }
    }
}

void add_blend_stiffness(const tug_solver *solver, double weight, double *Q)
{
    int32_t k = solver->model->header.dimension, kk = k * k, S = solver->model->header.shapes;
    size_t n = (size_t)pair_count(solver);
    for (int32_t i = 0; i < pair_count(solver); i++) {
        for (int32_t j = i / S * S; j < (i / S + 1) * S; j++) {
            double block[9], product[9];
            find_stiffness(solver->model, i, j, block);
            multiply_nt(k, block, solver->R + j * kk, product);
            Q[(size_t)i * n + (size_t)j] +=
                weight * trace_of_product(k, solver->R + i * kk, product);
        }
    }
}

void find_rotation_slope(const tug_solver *solver, const double *M, const double *N, double *slope)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    memset(slope, 0, (size_t)(pair_count(solver) * kk) * sizeof *slope);
    for (int32_t i = 0; i < pair_count(solver); i++) {
        double difference[9], held[9], product[9], axis[3], w[3], W[9];
        if (solver->B[i] == 0.0) {
            continue;
        }
        for (int32_t ab = 0; ab < kk; ab++) {
            difference[ab] = solver->B[i] * (N[i * kk + ab] - M[i * kk + ab]);
        }
        multiply(k, solver->R + i * kk, difference, product);
        axial_vector(k, product, axis);
        hold_moment(solver, i, M, held);
        solve_for_turn(k, solver->R + i * kk, held, axis, w);
        skew_matrix(k, w, W);
        multiply(k, W, solver->R + i * kk, product);
        for (int32_t ab = 0; ab < kk; ab++) {
            slope[i * kk + ab] = product[ab % k * k + ab / k];
        }
    }
}
