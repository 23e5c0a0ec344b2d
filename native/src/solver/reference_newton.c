/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/reference_newton.h"

#include "dense/dense.h"
#include "dense/rotation.h"

#include <math.h>

enum { HALVINGS = 40 };

/* The least of what is left of a direction's curvature that alpha may leave. */
static const double LEAST_CURVATURE = 1e-3;

/* C of a shape alone in the whole dictionary: H - A. */
static void find_form(tug_solver *solver, int32_t s)
{
    const shape_couplings *c = &solver->references.couplings;
    const double *A = own_coupling(c, s);
    int32_t k = c->k, p = solver->model->header.shapes * k;
    for (int32_t i = 0; i < c->size; i++) {
        double *row = solver->C + (size_t)i * (size_t)c->size;
        for (int32_t j = 0; j < c->size; j++) {
            row[j] = -A[(size_t)i * (size_t)c->stride + (size_t)j];
        }
        const double *H = solver->model->H + (size_t)(i / k * p + s * k + i % k) * (size_t)p;
        for (int32_t a = 0; a < k; a++) {
            row[i / k * k + a] += H[s * k + a];
        }
    }
}

/* What pulls on the rotations where E is divided by alpha^2. */
static void find_scaled_pull(tug_solver *solver, const reference_set *set)
{
    int32_t S = solver->model->header.shapes, k = solver->model->header.dimension, kk = k * k;
    for (int32_t i = 0; i < solver->model->header.groups * kk; i++) {
        int32_t pair = i / kk * S + set->first, transposed = i % k * k + i % kk / k;
        double prior = LEAST_PRIOR * solver->model->stiffness[i / kk] / set->scale;
        solver->L[i] = (solver->pull[pair * kk + i % kk] +
                        prior * solver->costs.rotations[pair * kk + transposed]) /
                       set->scale;
    }
}

/* The step of Newton's method without alpha's part of the Hessian becomes that with it, where what
 * is left is still positive: (H - u u^T)^-1 g = x + y u^T x / (1 - u^T y), H x = g, H y = u. */
static void follow_scale(tug_solver *solver, const rotation_energy *energy,
                         const reference_set *set)
{
    rotation_workspace *w = &solver->turning;
    int32_t k = energy->k, kk = k * k, t = tangent_size(k), size = energy->groups * t;
    int32_t S = solver->model->header.shapes;
    double *u = w->columns, *y = w->trial;
    double curvature = LEAST_PRIOR * solver->references.stiffness[set->first];
    for (int32_t g = 0; g < energy->groups; g++) {
        const double *R = solver->group_R + g * kk, *CR = w->CR + g * kk;
        double change[9], turned[9];
        for (int32_t i = 0; i < kk; i++) {
            change[i] = 2.0 * CR[i] - solver->pull[(g * S + set->first) * kk + i] / set->scale;
        }
        multiply(k, R, change, turned);
        axial_vector(k, turned, u + g * t);
        curvature += trace_of_product(k, R, CR);
    }
    for (int32_t i = 0; i < size; i++) {
        u[i] /= sqrt(curvature);
        y[i] = u[i];
    }
    cholesky_solve(w->factor, size, y, 1);
    double left = 1.0 - dot(u, y, (size_t)size);
    double share = left > LEAST_CURVATURE ? dot(u, w->step, (size_t)size) / left : 0.0;
    for (int32_t i = 0; i < size; i++) {
        w->step[i] += share * y[i];
    }
}

/* To the rotations turned by t times the step. */
static void go_to_trial(tug_solver *solver, const reference_question *question,
                        const rotation_energy *energy, double t, reference_set *set)
{
    reference_room *room = &solver->references;
    turn_all(energy, solver->group_R, t, &solver->turning);
    scatter_rotations(&room->couplings, solver->turning.trial, energy->k * energy->k,
                      room->X + set->first * slice_size(&room->couplings));
    settle_references(question, set, room);
}

static void take_step(tug_solver *solver, const reference_question *question, reference_set *set)
{
    const shape_couplings *c = &solver->references.couplings;
    rotation_energy energy = {solver->model->header.groups, c->k, solver->C, solver->L};
    rotation_workspace *w = &solver->turning;
    int32_t size = energy.groups * tangent_size(c->k);
    double before = value_of(set), rounding = 1e-15 * set->magnitude;
    find_scaled_pull(solver, set);
    gather_rotations(c, solver->references.X + set->first * slice_size(c), c->k * c->k,
                     solver->group_R);
    differentiate_rotations(&energy, solver->group_R, w);
    find_newton_step(size, w);
    if (question->scaled) {
        follow_scale(solver, &energy, set);
    }
    double slope = set->scale * set->scale * dot(w->gradient, w->step, (size_t)size);
    double full = largest_turn(&energy, w), t = longest_part(full);
    int seen = -slope > rounding; /* else the decrease drowns, but the gradient does not */
    set->residual = seen ? full : 0.0;
    for (int halvings = 0; halvings < HALVINGS; halvings++, t *= 0.5) {
        go_to_trial(solver, question, &energy, t, set);
        if (!seen || value_of(set) <= before + 1e-4 * t * slope + rounding) {
            return;
        }
    }
    set->residual = 0.0; /* rounding is all that is left */
    go_to_trial(solver, question, &energy, 0.0, set);
}

int32_t descend_reference(tug_solver *solver, const reference_question *question,
                          int32_t max_rounds, reference_set *set)
{
    int32_t rounds = 0;
    find_form(solver, set->first);
    /* Shapes of no size have no rotations to find. */
    while (rounds < max_rounds && set->scale > 0.0) {
        take_step(solver, question, set);
        rounds++;
        if (set->residual <= solver->options.tolerance) {
            break;
        }
    }
    return rounds;
}
