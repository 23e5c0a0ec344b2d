/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The paper's form made convergent (appendix A; docs/algorithm.md, "The trust region"):
 *
 *     E(T, B) = sqrt(E_d(T, B, R(T))) + lambda d^T B,    R(T) by (A 22),
 *
 * lowered in every round. A round minimises over T and B the convex model
 *
 *     sqrt(E_d(T, B, R_0) + mu/2 |T - T_0|^2) + d_R E (T - T_0) + lambda d^T B
 *
 * of (A 24), which keeps near T_0 by its damping mu. With T eliminated, it is an (A 20). */
#include "solver/forms.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "solver/blend_terms.h"
#include "solver/contraction.h"
#include "solver/moments.h"

#include <math.h>
#include <string.h>

/* The point that a round's model is made at. Sizes are those of the energy: |V|^2 = tr(V^T A V). */
typedef struct linearisation {
    blend_result here;
    double own_energy;  /* |V_0|^2 */
    double slope_size;  /* |slope|^2 */
    double slope_there; /* slope . V_0 */
} linearisation;

static size_t pair_count(const tug_solver *solver)
{
    return (size_t)(solver->model->header.groups * solver->model->header.shapes);
}

static size_t block_count(const tug_solver *solver)
{
    size_t k = (size_t)solver->model->header.dimension;
    return pair_count(solver) * k * k;
}

static double find_tau(const tug_solver *solver, double u)
{
    return solver->options.squared ? 1.0 : 2.0 * sqrt(u);
}

static double price_of_blend(const tug_solver *solver)
{
    return solver->options.single_blend
               ? dot(solver->folded_d, solver->folded_B, (size_t)solver->model->header.shapes)
               : dot(solver->d, solver->B, pair_count(solver));
}

static double find_own_energy(const tug_solver *solver)
{
    size_t count = block_count(solver);
    return dot(solver->V, solver->M, count) - dot(solver->V, solver->pull, count);
}

/* R, the blended moments and the objective, from V, M and B. */
static void measure(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    follow_moments(solver, solver->M);
    find_blended_moments(solver, solver->trust.N);
    double sum = solver->r + find_own_energy(solver);
    for (int32_t i = 0; i < (int32_t)pair_count(solver); i++) {
        const double *R = solver->R + i * kk;
        sum += solver->B[i] * (trace_of_product(k, R, solver->trust.N + i * kk) -
                               2.0 * trace_of_product(k, R, solver->M + i * kk));
    }
    double u = raise_to_rounding(0.5 * sum, solver->r);
    solver->blend.u = u;
    solver->blend.objective = (solver->options.squared ? u : sqrt(u)) + price_of_blend(solver);
}

/* V, M, B and folded_B as one vector. */
static void keep_point(const tug_solver *solver, double *point)
{
    size_t blocks = block_count(solver), n = pair_count(solver);
    memcpy(point, solver->V, blocks * sizeof *point);
    memcpy(point + blocks, solver->M, blocks * sizeof *point);
    memcpy(point + 2 * blocks, solver->B, n * sizeof *point);
    memcpy(point + 2 * blocks + n, solver->folded_B,
           (size_t)solver->model->header.shapes * sizeof *point);
}

static void go_to_point(tug_solver *solver, const double *point)
{
    size_t blocks = block_count(solver), n = pair_count(solver);
    memcpy(solver->V, point, blocks * sizeof *point);
    memcpy(solver->M, point + blocks, blocks * sizeof *point);
    memcpy(solver->B, point + 2 * blocks, n * sizeof *point);
    memcpy(solver->folded_B, point + 2 * blocks + n,
           (size_t)solver->model->header.shapes * sizeof *point);
}

static linearisation linearise(tug_solver *solver)
{
    size_t count = block_count(solver);
    double tau = find_tau(solver, solver->blend.u);
    find_rotation_slope(solver, solver->M, solver->trust.N, solver->trust.slope);
    for (size_t i = 0; i < count; i++) {
        solver->trust.slope[i] /= tau;
    }
    find_own_moments(solver, solver->trust.slope, solver->trust.slope_moments);
    coupling all = joint_coupling(joint_energy(solver));
    contract_pair_rotations(&all, solver->R, solver->trust.Q);
    keep_point(solver, solver->trust.kept);
    memcpy(solver->trust.R, solver->R, count * sizeof *solver->R);
    return (linearisation){
        .here = solver->blend,
        .own_energy = find_own_energy(solver),
        .slope_size = dot(solver->trust.slope, solver->trust.slope_moments, count),
        .slope_there = dot(solver->V, solver->trust.slope_moments, count),
    };
}

/* What a linear term leaves of the root of a quadratic: sqrt(x^2 + a^2) - g x has the minimum
 * a sqrt(1 - g^2) over x, none where g > 1. */
static double find_shrink(const tug_solver *solver, const linearisation *at, double damping)
{
    return solver->options.squared ? 1.0 : 1.0 - 2.0 * at->slope_size / (1.0 + damping);
}

/* Minimise the model over B, T eliminated; returns the model's value. */
static double minimise_model(tug_solver *solver, const linearisation *at, double damping)
{
    int32_t k = solver->model->header.dimension, kk = k * k, S = solver->model->header.shapes;
    size_t n = pair_count(solver);
    double part = 1.0 / (1.0 + damping), shrink = find_shrink(solver, at, damping);
    for (size_t i = 0; i < n * n; i++) {
        solver->Q[i] = shrink * part * solver->trust.Q[i];
    }
    add_blend_stiffness(solver, shrink * part * damping, solver->Q);
    memcpy(solver->trust.folded_d, solver->folded_d, (size_t)S * sizeof(double));
    for (int32_t i = 0; i < (int32_t)n; i++) {
        const double *R = solver->R + i * kk;
        double pull = trace_of_product(k, R, solver->pull + i * kk);
        double moment = trace_of_product(k, R, solver->M + i * kk);
        double tilt = part * trace_of_product(k, R, solver->trust.slope_moments + i * kk);
        solver->c[i] = -shrink * part * (pull + damping * moment);
        solver->trust.d[i] = solver->d[i] + tilt;
        solver->trust.folded_d[i % S] += tilt;
    }
    blend_terms terms = all_terms(solver);
    terms.d = solver->trust.d;
    terms.folded_d = solver->trust.folded_d;
    terms.r = shrink * (solver->r + part * damping * at->own_energy);
    solve_blend(solver, &terms);
    double rest = solver->options.squared ? 0.5 * part * at->slope_size : 0.0;
    return solver->blend.objective - part * at->slope_there - rest;
}

/* Go to the model's minimum. Returns how far the model is lower there than here. */
static double take_step(tug_solver *solver, const linearisation *at, double damping)
{
    double gain = at->here.objective - minimise_model(solver, at, damping);
    double tau = find_tau(solver, solver->blend.u) / find_shrink(solver, at, damping);
    stack_rotations(solver, solver->V);
    for (size_t i = 0; i < block_count(solver); i++) {
        double kept = solver->trust.kept[i]; /* V comes first in a point */
        solver->V[i] =
            (solver->V[i] + damping * kept - tau * solver->trust.slope[i]) / (1.0 + damping);
    }
    find_pose_moments(solver, solver->V, solver->M);
    measure(solver);
    return gain;
}

static void step_back(tug_solver *solver, const linearisation *at)
{
    double gap = solver->blend.gap;
    go_to_point(solver, solver->trust.kept);
    memcpy(solver->R, solver->trust.R, block_count(solver) * sizeof *solver->R);
    solver->blend = at->here;
    solver->blend.gap = gap;
}

static double find_largest_turn(const tug_solver *solver)
{
    int32_t k = solver->model->header.dimension;
    double largest = 0.0;
    for (size_t i = 0; i < block_count(solver); i += (size_t)(k * k)) {
        largest = fmax(largest, angle_between(k, solver->R + i, solver->trust.R + i));
    }
    return largest;
}

/* Beyond a step's end B may leave the simplices: negative weights become zero. blend: #G + 1 rows
 * of #S, the last of them folded_B. */
static void restore_simplices(const tug_solver *solver, double *blend)
{
    int32_t S = solver->model->header.shapes;
    for (int32_t row = 0; row <= solver->model->header.groups; row++, blend += S) {
        double sum = 0.0;
        for (int32_t s = 0; s < S; s++) {
            blend[s] = fmax(blend[s], 0.0);
            sum += blend[s];
        }
        for (int32_t s = 0; s < S; s++) {
            blend[s] /= sum;
        }
    }
}

/* Go from the point reached to the one ahead, if that is lower. */
static int try_ahead(tug_solver *solver)
{
    blend_result reached = solver->blend;
    restore_simplices(solver, solver->trust.ahead + 2 * block_count(solver));
    go_to_point(solver, solver->trust.ahead);
    measure(solver);
    if (solver->blend.objective < reached.objective) {
        return 1;
    }
    go_to_point(solver, solver->trust.reached);
    measure(solver);
    return 0;
}

/* The model is far stiffer than the energy where a part bends, so that its steps are short: go on
 * to where the last few are heading or, where that is uphill, further the same way, twice as far
 * each time that it helped. */
static void look_ahead(tug_solver *solver, double *stretch)
{
    keep_point(solver, solver->trust.reached);
    record_step(&solver->trust.path, solver->trust.kept, solver->trust.reached);
    if (extrapolate(&solver->trust.path, solver->trust.ahead) && try_ahead(solver)) {
        return;
    }
    for (int32_t i = 0; i < solver->trust.path.size; i++) {
        solver->trust.ahead[i] = solver->trust.reached[i] +
                                 *stretch * (solver->trust.reached[i] - solver->trust.kept[i]);
    }
    *stretch = try_ahead(solver) ? 2.0 * *stretch : 1.0;
}

static void start(tug_solver *solver)
{
    if (!solver->options.warm_start || !solver->solved) {
        start_alternation(solver);
        stack_rotations(solver, solver->V);
    }
    find_pose_moments(solver, solver->V, solver->M);
    measure(solver);
    forget_steps(&solver->trust.path);
}

void solve_trust_region(tug_solver *solver, tug_solve_info *info)
{
    double damping = 0.0, stretch = 1.0;
    start(solver);
    linearisation at = linearise(solver);
    while (info->rounds < solver->options.max_rounds && !info->converged) {
        damping = fmax(damping, 4.0 * at.slope_size - 1.0); /* shrink is one half or more */
        double gain = take_step(solver, &at, damping);
        double fall = at.here.objective - solver->blend.objective;
        double rounding = 1e-15 * fabs(solver->r) / find_tau(solver, at.here.u);
        info->rounds++;
        info->residual = (1.0 + damping) * find_largest_turn(solver);
        info->converged = info->residual <= solver->options.tolerance || gain <= rounding;
        if (fall < 0.1 * gain || fall < 0.0) {
            step_back(solver, &at);
            damping = fmax(4.0 * damping, 0.5);
        } else if (!info->converged) {
            look_ahead(solver, &stretch);
            at = linearise(solver);
            damping *= 0.25;
        }
    }
    info->energy = solver->blend.u;
}
