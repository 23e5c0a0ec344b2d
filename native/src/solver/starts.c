/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/starts.h"

#include "dense/rotation.h"

#include <math.h>
#include <string.h>

/* Of a start without costs. More change little; without any, another shape often seems closest. */
enum { STEPS = 6 };

static const double LEAST_SCALE = 1e-3;

/* The spread of points about their mean as one group sees them. */
static double find_spread(const tug_model *model, const holding *held, int32_t g,
                          const double *points)
{
    int32_t k = model->header.dimension, h = model->header.rows;
    const double *near = model->nearness + g * h;
    double mean[3] = {0}, total = 0.0, squares = 0.0;
    for (int32_t r = 0; r < h; r++) {
        double weight = near[r] * grip_of(held, r);
        total += weight;
        for (int32_t a = 0; a < k; a++) {
            mean[a] += weight * points[r * k + a];
        }
    }
    for (int32_t i = 0; i < h * k; i++) {
        double away = points[i] - mean[i % k] / total;
        squares += near[i / k] * grip_of(held, i / k) * away * away;
    }
    return squares;
}

void fit_scales(const tug_model *model, const holding *held, const double *Y, shape_costs *c)
{
    for (int32_t s = 0; s < model->header.shapes; s++) {
        double from = 0.0, to = 0.0;
        for (int32_t g = 0; g < model->header.groups; g++) {
            from += find_spread(model, held, g, model->shape[s].rows);
            to += find_spread(model, held, g, Y);
        }
        /* Handles that all coincide have no size. */
        c->scale[s] = from > 0.0 ? fmax(sqrt(to / from), LEAST_SCALE) : 1.0;
    }
}

rotation_energy energy_alone(const tug_model *model, const holding *held, int32_t s,
                             const double *Y, shape_costs *c)
{
    int32_t k = model->header.dimension;
    const reduction *reduced = held_energy(model, held, s);
    for (int32_t i = 0; i < model->header.rows * k; i++) {
        c->Y[i] = Y[i] / c->scale[s];
    }
    find_pull(reduced, c->Y, k, c->L);
    return (rotation_energy){model->header.groups, k, reduced->C, c->L};
}

/* The matrix whose closest rotation best carries the handles of a shape, seen from one group, to Y,
 * and agrees with the orientations there. */
static void fit_handles(const tug_model *model, const holding *held, const orientation *oriented,
                        int32_t s, const double *Y, int32_t g, double *turned)
{
    const shape_model *shape = model->shape + s;
    int32_t k = model->header.dimension, h = model->header.rows;
    const double *near = model->nearness + g * h;
    double from[3] = {0}, to[3] = {0}, M[9] = {0}, total = 0.0, size = 0.0;
    for (int32_t r = 0; r < h; r++) {
        double weight = near[r] * grip_of(held, r);
        total += weight;
        for (int32_t a = 0; a < k; a++) {
            from[a] += weight * shape->rows[r * k + a];
            to[a] += weight * Y[r * k + a];
        }
    }
    for (int32_t r = 0; r < h; r++) {
        for (int32_t i = 0; i < k * k; i++) {
            double x = shape->rows[r * k + i / k] - from[i / k] / total;
            M[i] += near[r] * grip_of(held, r) * x * (Y[r * k + i % k] - to[i % k] / total);
        }
    }
    for (int32_t i = 0; i < k * k; i++) {
        size += fabs(M[i]);
    }
    /* Two handles leave the turn about their line open: the least one is taken. */
    for (int32_t a = 0; a < k; a++) {
        M[a * k + a] += 1e-6 * size;
    }
    multiply(k, model->align + (g * model->header.shapes + s) * k * k, M, turned);
    add_orientation_pull(model, oriented, g, size > 0.0 ? size : 1.0, turned);
}

/* What the energy leaves open stays as it starts. */
static void add_least_prior(const tug_model *model, const double *start, double *L)
{
    int32_t k = model->header.dimension, kk = k * k;
    for (int32_t i = 0; i < model->header.groups * kk; i++) {
        double weight = LEAST_PRIOR * model->stiffness[i / kk];
        L[i] += weight * start[i / kk * kk + i % k * k + i / k % k];
    }
}

void start_alone(const tug_model *model, const holding *held, const orientation *oriented,
                 int32_t s, shape_costs *c)
{
    int32_t k = model->header.dimension;
    for (int32_t g = 0; g < model->header.groups; g++) {
        fit_handles(model, held, oriented, s, c->Y, g, c->R + g * k * k);
    }
    closest_rotations(k, model->header.groups, c->R, c->R);
    add_least_prior(model, c->R, c->L);
}

void keep_rotations(const tug_model *model, int32_t s, shape_costs *c)
{
    int32_t kk = model->header.dimension * model->header.dimension, S = model->header.shapes;
    for (int32_t g = 0; g < model->header.groups; g++) {
        memcpy(c->rotations + (g * S + s) * kk, c->R + g * kk, (size_t)kk * sizeof *c->R);
    }
}

/* A local and a global step: rotations become those closest to the moments of the transforms that
 * suit them best, K_g T = L_g - (C R^T)_g + H_gg R_g^T. */
static void step_alone(const tug_model *model, const rotation_energy *energy, int32_t s,
                       shape_costs *c)
{
    int32_t k = energy->k, kk = k * k, p = model->header.shapes * k;
    couple_rotations(energy, c->R, &c->workspace);
    for (int32_t g = 0; g < energy->groups; g++) {
        const double *H = model->H + (size_t)(g * p + s * k) * (size_t)p + (size_t)(s * k);
        double *moment = c->V + g * kk;
        multiply_strided(k, H, p, 1, c->R + g * kk, 1, k, moment);
        for (int32_t i = 0; i < kk; i++) {
            moment[i] += c->L[g * kk + i] - c->workspace.CR[g * kk + i];
        }
    }
    closest_rotations(k, energy->groups, c->V, c->R);
}

void find_starts(const tug_model *model, const holding *held, const double *Y, shape_costs *c)
{
    for (int32_t s = 0; s < model->header.shapes; s++) {
        rotation_energy energy = energy_alone(model, held, s, Y, c);
        start_alone(model, held, NULL, s, c);
        for (int step = 0; step < STEPS; step++) {
            step_alone(model, &energy, s, c);
        }
        keep_rotations(model, s, c);
    }
}
