/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/moments.h"

#include "dense/rotation.h"
#include "solver/own_block.h"

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
            find_pair_stiffness(solver->model, i, j, block);
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
            find_pair_stiffness(solver->model, i, j, block);
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
