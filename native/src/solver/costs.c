/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/costs.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "memory.h"
#include "solver/starts.h"

#include <math.h>
#include <string.h>

enum { MAX_STEPS = 100 };

static const double TOLERANCE = 1e-7; /* radians; Newton's error after such a step is its square */

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

/* As the shape stands. */
static void stand_still(const tug_model *model, int32_t s, double *R)
{
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes;
    for (int32_t g = 0; g < model->header.groups; g++) {
        const double *Q = model->align + (g * S + s) * kk;
        for (int32_t i = 0; i < kk; i++) {
            R[g * kk + i] = Q[(i % k) * k + i / k];
        }
    }
}

static void turn_to_optimum(const tug_model *model, const orientation *oriented,
                            const rotation_energy *energy, shape_costs *c)
{
    int32_t kk = energy->k * energy->k, converged;
    for (int32_t g = 0; g < energy->groups; g++) {
        add_orientation_pull(model, oriented, g, model->stiffness[g], c->L + g * kk);
    }
    int32_t steps = fit_rotations(energy, TOLERANCE, MAX_STEPS, &c->workspace, c->R, &converged);
    c->converged &= converged;
    c->steps = steps > c->steps ? steps : c->steps;
}

void find_costs(const tug_model *model, const holding *held, const orientation *oriented,
                const double *Y, int turning, shape_costs *c)
{
    int32_t S = model->header.shapes;
    c->converged = 1;
    c->steps = 0;
    for (int32_t s = 0; s < S; s++) {
        rotation_energy energy = energy_alone(model, held, s, Y, c);
        if (turning) {
            start_alone(model, held, oriented, s, c);
            turn_to_optimum(model, oriented, &energy, c);
        } else {
            stand_still(model, s, c->R);
        }
        find_group_costs(model, held, oriented, s, c->Y, c);
        for (int32_t g = 0; g < model->header.groups; g++) {
            c->D[g * S + s] *= c->scale[s] * c->scale[s];
        }
        keep_rotations(model, s, c);
    }
}
