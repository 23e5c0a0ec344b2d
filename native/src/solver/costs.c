/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/costs.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { MAX_STEPS = 100 };

static const double TOLERANCE = 1e-7; /* radians; Newton's error after such a step is its square */
static const double LEAST_SCALE = 1e-3;

int costs_create(const tug_model *model, shape_costs *c)
{
    size_t k = (size_t)model->header.dimension, S = (size_t)model->header.shapes;
    size_t G = (size_t)model->header.groups, b = (size_t)model->header.weights * (1 + k);
    c->D = allocate(G * S, sizeof *c->D);
    c->rotations = allocate(G * S * k * k, sizeof *c->rotations);
    c->R = allocate(G * k * k, sizeof *c->R);
    c->L = allocate(G * k * k, sizeof *c->L);
    c->V = allocate(G * k * k, sizeof *c->V);
    c->T = allocate(b * k, sizeof *c->T);
    c->difference = allocate(b * k, sizeof *c->difference);
    c->product = allocate(b * k, sizeof *c->product);
    c->placed = allocate((size_t)model->header.rows * k, sizeof *c->placed);
    c->recovery = allocate(recovery_size(&model->shape->energy, (int32_t)k), sizeof *c->recovery);
    c->scale = allocate(S, sizeof *c->scale);
    c->Y = allocate((size_t)model->header.rows * k, sizeof *c->Y);
    for (size_t s = 0; s < S && c->scale != NULL; s++) {
        c->scale[s] = 1.0;
    }
    int room = rotation_workspace_create((int32_t)G, (int32_t)k, &c->workspace);
    return room && c->D && c->rotations && c->R && c->L && c->V && c->T && c->difference &&
           c->product && c->placed && c->recovery && c->scale && c->Y;
}

void costs_destroy(shape_costs *c)
{
    release(c->D);
    release(c->rotations);
    release(c->R);
    release(c->L);
    release(c->V);
    release(c->T);
    release(c->difference);
    release(c->product);
    release(c->placed);
    release(c->recovery);
    release(c->scale);
    release(c->Y);
    rotation_workspace_destroy(&c->workspace);
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

/* tr(T^T L T) of one group. */
static double quadratic_part(const double *L, int32_t b, int32_t k, const double *T, double *LT)
{
    memset(LT, 0, (size_t)(b * k) * sizeof *LT);
    add_thin_product_tn(b, b, k, L, T, LT);
    return dot(T, LT, (size_t)(b * k));
}

/* difference = T - T_s R^T in the columns that group g sees. T_s has, for each weight function, the
 * shape's middle and the identity. */
static void subtract_turned_shape(const tug_model *model, int32_t s, int32_t g, const double *R,
                                  const double *T, double *difference)
{
    int32_t k = model->header.dimension, coordinates = model->header.shapes * k;
    const int32_t *functions = support_of(&model->support, g);
    for (int32_t f = 0; f < support_count(&model->support, g); f++) {
        int32_t h = functions[f];
        const double *middle = model->middles + h * coordinates + s * k;
        const double *from = T + h * (1 + k) * k;
        double *to = difference + f * (1 + k) * k;
        for (int32_t a = 0; a < k; a++) {
            to[a] = from[a] - model->constant[h] * dot(R + a * k, middle, (size_t)k);
            for (int32_t c = 0; c < k; c++) {
                to[(1 + c) * k + a] = from[(1 + c) * k + a] - model->constant[h] * R[a * k + c];
            }
        }
    }
}

/* E_g of (A 7), twice the group's part of the energy, for every group of one shape. It is the form
 * L_g of T - T_s R_g^T, where T_s makes the shape itself: no cancellation near the example. */
static void find_group_costs(const tug_model *model, const holding *held,
                             const orientation *oriented, int32_t s, const double *Y,
                             shape_costs *c)
{
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes;
    const shape_model *shape = model->shape + s;
    for (int32_t i = 0; i < shape->energy.turned * k; i++) {
        c->V[i] = c->R[(i / kk) * kk + (i % k) * k + i / k % k];
    }
    settle_rows(model, held, s, c->V, Y, c->placed);
    recover_transforms(&shape->energy, c->V, c->placed, k, c->recovery, c->T);
    for (int32_t g = 0; g < model->header.groups; g++) {
        double R[9];
        multiply(k, c->R + g * kk, model->align + (g * S + s) * kk, R);
        subtract_turned_shape(model, s, g, R, c->T, c->difference);
        double energy =
            quadratic_part(group_form(model, shape, g), group_columns(&shape->energy, g), k,
                           c->difference, c->product);
        c->D[g * S + s] = fmax(energy, 0.0);
        c->D[g * S + s] += orientation_energy(model, oriented, g, c->R + g * kk);
    }
    for (int32_t r = 0; r < model->header.rows; r++) {
        c->D[nearest_group(model, r) * S + s] +=
            spring_energy(held, r, c->placed, Y, k) +
            soft_row_energy(&shape->energy, r, c->T, c->placed, k);
    }
}

static void start_rotations(const tug_model *model, const holding *held,
                            const orientation *oriented, int32_t s, const double *Y, int turning,
                            double *R)
{
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes;
    for (int32_t g = 0; g < model->header.groups; g++) {
        if (turning) {
            fit_handles(model, held, oriented, s, Y, g, R + g * kk);
        } else {
            const double *Q = model->align + (g * S + s) * kk;
            for (int32_t i = 0; i < kk; i++) {
                R[g * kk + i] = Q[(i % k) * k + i / k];
            }
        }
    }
    if (turning) {
        closest_rotations(k, model->header.groups, R, R);
    }
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

void find_costs(const tug_model *model, const holding *held, const orientation *oriented,
                const double *Y, int turning, shape_costs *c)
{
    int32_t k = model->header.dimension, kk = k * k;
    int32_t S = model->header.shapes, G = model->header.groups;
    c->converged = 1;
    c->steps = 0;
    for (int32_t s = 0; s < S; s++) {
        const reduction *reduced = held_energy(model, held, s);
        rotation_energy energy = {G, k, reduced->C, c->L};
        for (int32_t i = 0; i < model->header.rows * k; i++) {
            c->Y[i] = Y[i] / c->scale[s];
        }
        find_pull(reduced, c->Y, k, c->L);
        start_rotations(model, held, oriented, s, c->Y, turning, c->R);
        if (turning) {
            add_least_prior(model, c->R, c->L);
            for (int32_t g = 0; g < G; g++) {
                add_orientation_pull(model, oriented, g, model->stiffness[g], c->L + g * kk);
            }
            int converged;
            int32_t steps =
                fit_rotations(&energy, TOLERANCE, MAX_STEPS, &c->workspace, c->R, &converged);
            c->converged &= converged;
            c->steps = steps > c->steps ? steps : c->steps;
        }
        find_group_costs(model, held, oriented, s, c->Y, c);
        for (int32_t g = 0; g < G; g++) {
            c->D[g * S + s] *= c->scale[s] * c->scale[s];
            memcpy(c->rotations + (g * S + s) * kk, c->R + g * kk, (size_t)kk * sizeof *c->R);
        }
    }
}
