/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "gauss_newton.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { MAX_ATTEMPTS = 30 };

/* Of the Hessian's mean diagonal: the first damping, how it grows, and where it is given up. */
static const double FIRST_DAMPING = 1e-4, GROWTH = 3.0, LAST_DAMPING = 1e9;

/* Of |w|^2 / 2, the energy being in units of the diagonal squared: it decides
 * between shapes that are the same, and moves no other weight visibly. */
static const double REGULARISER = 1e-8;

int weight_workspace_create(int32_t shapes, weight_workspace *w)
{
    size_t S = (size_t)shapes;
    w->gradient = allocate(S, sizeof *w->gradient);
    w->hessian = allocate(S * S, sizeof *w->hessian);
    w->correction = allocate(S * S, sizeof *w->correction);
    w->last_gradient = allocate(S, sizeof *w->last_gradient);
    w->moved = allocate(S, sizeof *w->moved);
    w->damped = allocate(S * S, sizeof *w->damped);
    w->linear = allocate(S, sizeof *w->linear);
    w->step = allocate(S, sizeof *w->step);
    w->trial = allocate(S, sizeof *w->trial);
    int room = blend_workspace_create(1, shapes, &w->blending);
    return room && w->gradient && w->hessian && w->correction && w->last_gradient && w->moved &&
           w->damped && w->linear && w->step && w->trial;
}

void weight_workspace_destroy(weight_workspace *w)
{
    release(w->gradient);
    release(w->hessian);
    release(w->correction);
    release(w->last_gradient);
    release(w->moved);
    release(w->damped);
    release(w->linear);
    release(w->step);
    release(w->trial);
    blend_workspace_destroy(&w->blending);
}

/* A symmetric rank-one update (SR1) by which Gauss-Newton Hessian and
 * correction agree with how the gradient has changed along the last step. What
 * is along (1, ..., 1) no step can see. */
static void update_correction(int32_t S, weight_workspace *w)
{
    double lengths = 0.0, along = 0.0, mean = 0.0;
    for (int32_t i = 0; i < S; i++) {
        double *lack = w->linear + i;
        *lack = w->gradient[i] - w->last_gradient[i] -
                dot(w->hessian + i * S, w->moved, (size_t)S) -
                dot(w->correction + i * S, w->moved, (size_t)S);
        mean += *lack / S;
    }
    for (int32_t i = 0; i < S; i++) {
        w->linear[i] -= mean;
        along += w->linear[i] * w->moved[i];
    }
    lengths = sqrt(dot(w->linear, w->linear, (size_t)S) * dot(w->moved, w->moved, (size_t)S));
    if (fabs(along) <= 1e-6 * lengths) {
        return;
    }
    for (int32_t i = 0; i < S * S; i++) {
        w->correction[i] += w->linear[i / S] * w->linear[i % S] / along;
    }
}

/* damped <- hessian + damping I, at least so much that the Cholesky factorisation keeps its pivots,
 * and the correction where it is wanted. */
static void damp(int32_t S, int corrected, double damping, weight_workspace *w)
{
    double trace = 0.0;
    for (int32_t i = 0; i < S; i++) {
        trace += w->hessian[i * S + i] / S;
    }
    for (int32_t i = 0; i < S * S; i++) {
        w->damped[i] = w->hessian[i] + (corrected ? w->correction[i] : 0.0);
    }
    for (int32_t i = 0; i < S; i++) {
        w->damped[i * S + i] += (damping + 1e-12) * trace + 1e-300;
    }
}

/* trial <- the minimiser of the quadratic model on the simplex. Its constant keeps it from falling
 * below zero there: its linear part is at its least for one weight alone. */
static void step_in_simplex(int32_t S, const double *at, weight_workspace *w)
{
    double r = 0.0, least = INFINITY;
    memset(w->step, 0, (size_t)S * sizeof *w->step);
    for (int32_t i = 0; i < S; i++) {
        double product = dot(w->damped + i * S, at, (size_t)S);
        w->linear[i] = w->gradient[i] - product;
        r += at[i] * product;
        least = fmin(least, w->gradient[i]);
    }
    memcpy(w->trial, at, (size_t)S * sizeof *at);
    blend_problem model = {1, S, w->damped, w->linear, r - 2.0 * least, w->step, 1};
    minimise_blend(&model, &w->blending, w->trial);
}

/* The same with no bounds: the multiplier of the sum follows from two solves.
 * Returns 0 where the model is not convex. */
static int step_freely(int32_t S, const double *at, weight_workspace *w)
{
    double along = 0.0, across = 0.0;
    for (int32_t i = 0; i < S; i++) {
        w->step[i] = -w->gradient[i];
        w->linear[i] = 1.0;
    }
    if (!cholesky_factor(w->damped, S)) {
        return 0;
    }
    cholesky_solve(w->damped, S, w->step, 1);
    cholesky_solve(w->damped, S, w->linear, 1);
    for (int32_t i = 0; i < S; i++) {
        along += w->step[i];
        across += w->linear[i];
    }
    for (int32_t i = 0; i < S; i++) {
        w->trial[i] = at[i] + w->step[i] - along / across * w->linear[i];
    }
    return 1;
}

/* trial <- the step of the model, damped until it is convex. Returns how far it
 * moves a weight. */
static double find_step(const weight_problem *problem, int corrected, double *damping,
                        const double *at, weight_workspace *w)
{
    int32_t S = problem->shapes;
    damp(S, corrected, *damping, w);
    while (!step_freely(S, at, w) && *damping < LAST_DAMPING) {
        *damping = fmax(FIRST_DAMPING, GROWTH * *damping);
        damp(S, corrected, *damping, w);
    }
    if (problem->simplex) {
        damp(S, corrected, *damping, w);
        step_in_simplex(S, at, w);
    }
    double moved = 0.0;
    for (int32_t i = 0; i < S; i++) {
        moved = fmax(moved, fabs(w->trial[i] - at[i]));
    }
    return moved;
}

static tug_status evaluate(const weight_problem *problem, const double *w, double *energy)
{
    tug_status status = problem->evaluate(problem->state, w, energy);
    *energy += 0.5 * REGULARISER * dot(w, w, (size_t)problem->shapes);
    return status;
}

static tug_status differentiate(const weight_problem *problem, const double *w,
                                weight_workspace *workspace)
{
    int32_t S = problem->shapes;
    tug_status status =
        problem->differentiate(problem->state, w, workspace->gradient, workspace->hessian);
    for (int32_t i = 0; i < S; i++) {
        workspace->gradient[i] += REGULARISER * w[i];
        workspace->hessian[i * S + i] += REGULARISER;
    }
    return status;
}

/* w <- trial */
static void take_step(int32_t S, double *w, weight_workspace *workspace)
{
    for (int32_t i = 0; i < S; i++) {
        workspace->moved[i] = workspace->trial[i] - w[i];
    }
    memcpy(w, workspace->trial, (size_t)S * sizeof *w);
    memcpy(workspace->last_gradient, workspace->gradient, (size_t)S * sizeof *w);
}

/* One step downhill from w, whose energy is *energy. Where the model leads uphill, it goes without
 * its correction, and is damped more and more then. *damping: of the last step, and of this one.
 * *length: how far it goes. */
static tug_status descend(const weight_problem *problem, weight_workspace *workspace,
                          double tolerance, double *damping, double *w, double *energy,
                          double *length)
{
    double start = *damping > FIRST_DAMPING ? *damping / GROWTH : 0.0, after;
    *damping = start;
    for (int attempt = 0; attempt < MAX_ATTEMPTS; attempt++) {
        *length = find_step(problem, attempt == 0, damping, w, workspace);
        tug_status status = evaluate(problem, workspace->trial, &after);
        if (status != TUG_OK) {
            return status;
        }
        /* Below the tolerance the decrease may drown in the rounding of the energy. */
        if (after <= *energy || *length <= tolerance) {
            take_step(problem->shapes, w, workspace);
            *energy = after;
            return TUG_OK;
        }
        *damping = attempt == 0 ? start : fmax(FIRST_DAMPING, GROWTH * *damping);
    }
    *length = INFINITY;
    return TUG_OK;
}

tug_status minimise_weights(const weight_problem *problem, const tug_baseline_options *options,
                            weight_workspace *workspace, double *w, tug_baseline_info *info)
{
    double damping = 0.0;
    size_t square = (size_t)problem->shapes * (size_t)problem->shapes;
    memset(workspace->correction, 0, square * sizeof *workspace->correction);
    tug_status status = evaluate(problem, w, &info->objective);
    while (status == TUG_OK && info->rounds < options->max_rounds && !info->converged) {
        double before = info->objective;
        status = differentiate(problem, w, workspace);
        if (info->rounds > 0) {
            update_correction(problem->shapes, workspace);
        }
        if (status == TUG_OK) {
            status = descend(problem, workspace, options->tolerance, &damping, w, &info->objective,
                             &info->residual);
        }
        info->rounds++;
        info->increase = fmax(info->increase, info->objective - before);
        /* A damped step is short for its damping too. */
        double needed = damping == 0.0 ? options->tolerance : 1e-3 * options->tolerance;
        info->converged = info->residual <= needed;
    }
    return status;
}
