/* SPDX-License-Identifier: GPL-3.0-or-later */
/* By Newton's method from the library's own start, or by the local and global steps of Jacobson et
 * al. 2012 from one rotation for the whole shape, the one that best carries its handles to Y. */
#include "single_shape.h"

#include "dense/rotation.h"
#include "memory.h"
#include "subspace.h"

#include <math.h>
#include <string.h>

tug_status single_shape_create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                               int32_t s, single_shape *out)
{
    size_t k = (size_t)problem->dimension;
    tug_status status = create_subspace(baseline, problem, s, 1, &out->model);
    if (status != TUG_OK) {
        return status;
    }
    out->Y = allocate((size_t)problem->handle_count * k, sizeof *out->Y);
    out->pull = allocate((size_t)problem->group_count * k * k, sizeof *out->pull);
    int room = costs_create(out->model, &out->fit);
    return room && out->Y != NULL && out->pull != NULL ? TUG_OK : fail_memory();
}

void single_shape_destroy(single_shape *shape)
{
    model_destroy(shape->model);
    costs_destroy(&shape->fit);
    release(shape->Y);
    release(shape->pull);
}

/* The rotation that best carries the shape's handles to Y, for every group. */
static void start_rotations(const single_shape *shape, double *R)
{
    const double *rows = shape->model->shape[0].rows;
    int32_t k = shape->model->header.dimension, h = shape->model->header.rows;
    double from[3] = {0}, to[3] = {0}, M[9] = {0}, size = 0.0;
    for (int32_t i = 0; i < h * k; i++) {
        from[i % k] += rows[i] / h;
        to[i % k] += shape->Y[i] / h;
    }
    for (int32_t i = 0; i < h * k * k; i++) {
        int32_t row = i / (k * k), a = i / k % k, c = i % k;
        double part = (rows[row * k + a] - from[a]) * (shape->Y[row * k + c] - to[c]);
        M[a * k + c] += part;
        size += fabs(part);
    }
    for (int32_t a = 0; a < k; a++) {
        M[a * k + a] += 1e-6 * size; /* handles on a line leave a turn open: the least is taken */
    }
    for (int32_t g = 0; g < shape->model->header.groups; g++) {
        closest_rotation(k, M, R + g * k * k);
    }
}

/* The local step: R_g maximises tr(R_g K_g T), and K T = H R^T - C R^T + K F Y for the T of the
 * global step. Returns the largest turn. The global step is in C, and C R^T is the workspace's. */
static double turn_locally(single_shape *shape, const rotation_energy *energy, double *R)
{
    int32_t k = energy->k, kk = k * k;
    double largest = 0.0, *next = shape->fit.V;
    for (int32_t g = 0; g < energy->groups; g++) {
        double *M = next + g * kk;
        multiply_nt(k, shape->model->H + g * kk, R + g * kk, M);
        for (int32_t i = 0; i < kk; i++) {
            M[i] += energy->L[g * kk + i] - shape->fit.workspace.CR[g * kk + i];
        }
    }
    closest_rotations(k, energy->groups, next, next);
    for (int32_t g = 0; g < energy->groups; g++) {
        largest = fmax(largest, angle_between(k, next + g * kk, R + g * kk));
    }
    memcpy(R, next, (size_t)(energy->groups * kk) * sizeof *R);
    return largest;
}

static void alternate(const tug_baseline *baseline, single_shape *shape, tug_baseline_info *info)
{
    const reduction *reduced = &shape->model->shape[0].energy;
    int32_t k = shape->model->header.dimension;
    rotation_energy energy = {shape->model->header.groups, k, reduced->C, shape->pull};
    double *R = shape->fit.R;
    find_pull(reduced, shape->Y, k, shape->pull);
    start_rotations(shape, R);
    double before = evaluate_rotations(&energy, R, &shape->fit.workspace);
    while (info->rounds < baseline->options.max_rounds && !info->converged) {
        info->residual = turn_locally(shape, &energy, R);
        double after = evaluate_rotations(&energy, R, &shape->fit.workspace);
        info->increase = fmax(info->increase, after - before);
        before = after;
        info->rounds++;
        info->converged = info->residual <= baseline->options.tolerance;
    }
    shape->energy = fmax(before + 0.5 * energy_of_rows(reduced, shape->Y, k), 0.0);
    for (int32_t i = 0; i < reduced->turned * k; i++) {
        shape->fit.V[i] = R[i / (k * k) * k * k + i % k * k + i / k % k];
    }
    recover_transforms(reduced, shape->fit.V, shape->Y, k, shape->fit.recovery, shape->fit.T);
}

static void fit_by_newton(single_shape *shape, tug_baseline_info *info)
{
    find_costs(shape->model, NULL, NULL, shape->Y, 1, &shape->fit);
    info->converged = shape->fit.converged;
    info->rounds = shape->fit.steps;
    shape->energy = 0.0;
    for (int32_t g = 0; g < shape->model->header.groups; g++) {
        shape->energy += 0.5 * shape->fit.D[g];
    }
}

void single_shape_solve(const tug_baseline *baseline, single_shape *shape, tug_baseline_info *info)
{
    double unit = shape->model->header.unit;
    for (int32_t i = 0; i < shape->model->header.rows * shape->model->header.dimension; i++) {
        shape->Y[i] = baseline->Y[i] / unit;
    }
    if (baseline->options.local_global) {
        alternate(baseline, shape, info);
    } else {
        fit_by_newton(shape, info);
    }
    shape->energy *= unit * unit;
    info->increase *= unit * unit;
    info->objective = shape->energy;
}

void single_shape_positions(const single_shape *shape, double *positions)
{
    find_pose(&shape->model->dictionary, shape->fit.T, shape->model->header.unit, positions);
}
