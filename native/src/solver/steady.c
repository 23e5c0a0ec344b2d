/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The steady form (docs/algorithm.md): one rotation R_g per group, and priors on rotations and
 * blend,
 *
 *     f(R, B) = sqrt(E_d(R, B) + eps/2 sum_g (w_g |R_g - R^_g|^2 + 3 |B_g - B^_g|^2_H)) + lambda
 * d^T B,    d_gs = sqrt(w_g D_gs / sum_h w_h),
 *
 * with the transforms eliminated. The blend is eliminated too: phi(R) = min over B of f is
 * minimised by Newton's method, downhill in every step. Second derivatives of phi are those of E_d
 * in R, less what the blend gives way on its face of the simplices. */
#include "solver/forms.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "solver/blend_terms.h"
#include "solver/contraction.h"

#include <math.h>
#include <string.h>

static size_t rotation_bytes(const tug_solver *solver)
{
    int32_t k = solver->model->header.dimension;
    return (size_t)(solver->model->header.groups * k * k) * sizeof(double);
}

/* What counts against a shape in a group: its energy there, and a little of the group's fair share
 * of its energy everywhere, for groups in which all shapes are equally good (an eye, a claw). */
static double mismatch(const tug_solver *solver, int32_t g, int32_t s)
{
    static const double elsewhere = 0.1;
    const tug_model *model = solver->model;
    int32_t S = model->header.shapes;
    double energy = 0.0;
    for (int32_t h = 0; h < model->header.groups; h++) {
        energy += solver->costs.D[h * S + s];
    }
    double share = elsewhere * stiffness_share(model, g);
    return solver->costs.D[g * S + s] + share * energy + 1e-12 * model->stiffness[g] + 1e-300;
}

/* R^_g: the mean of the single-shape optima, each weighted by the inverse square of its mismatch
 * (the cost is a root of it). Exact where the handles sit on an example, and smooth in the handles.
 */
static void find_rotation_prior(tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes;
    for (int32_t g = 0; g < G; g++) {
        double least = INFINITY, *mean = solver->prior_R + g * kk;
        memset(mean, 0, (size_t)kk * sizeof *mean);
        for (int32_t s = 0; s < S; s++) {
            least = fmin(least, mismatch(solver, g, s));
        }
        for (int32_t s = 0; s < S; s++) {
            double ratio = least / mismatch(solver, g, s);
            for (int32_t i = 0; i < kk; i++) {
                mean[i] +=
                    ratio * ratio * solver->costs.rotations[(g * S + s) * kk + (i % k) * k + i / k];
            }
        }
    }
    closest_rotations(k, G, solver->prior_R, solver->prior_R);
}

/* eps; never quite zero, so that rotations which the energy leaves open are decided. */
static double prior_weight(const tug_solver *solver)
{
    return fmax(solver->options.prior, LEAST_PRIOR);
}

/* eps sum_g w_g |R_g - R^_g|^2 and the orientations' own: twice the energy that pulls rotations. */
static double rotation_prior_energy(const tug_solver *solver)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    double prior = 0.0, orientations = 0.0;
    for (int32_t g = 0; g < solver->model->header.groups; g++) {
        for (int32_t i = g * kk; i < (g + 1) * kk; i++) {
            double difference = solver->group_R[i] - solver->prior_R[i];
            prior += solver->model->stiffness[g] * difference * difference;
        }
        orientations +=
            orientation_energy(solver->model, &solver->oriented, g, solver->group_R + g * kk);
    }
    return prior_weight(solver) * prior + orientations;
}

/* 3 eps tr(H_gst): the quadratic form of the blends' prior, which is the rigidity energy between
 * the blended shapes of B and B^. Shapes that agree in a group may be exchanged for nothing. */
static double blend_prior_entry(const tug_solver *solver, int32_t i, int32_t t)
{
    return 3.0 * solver->options.prior * solver->set.form[i * solver->set.width + t];
}

/* Add the blends' prior to Q and c; returns what it adds to r. */
static double add_blend_prior(tug_solver *solver)
{
    working_set *set = &solver->set;
    int32_t w = set->width, count = solver->model->header.groups * w;
    double constant = 0.0;
    for (int32_t i = 0; i < count; i++) {
        double pull = 0.0;
        for (int32_t t = 0; t < w; t++) {
            double entry = blend_prior_entry(solver, i, t);
            int32_t j = i / w * w + t;
            solver->Q[(size_t)i * (size_t)count + (size_t)j] += entry;
            pull += entry * set->prior_B[j];
        }
        set->c[i] -= pull;
        constant += set->prior_B[i] * pull;
    }
    return constant;
}

/* Twice the energy of the blends' prior at the present blend. */
static double blend_prior_energy(const tug_solver *solver)
{
    const working_set *set = &solver->set;
    int32_t w = set->width;
    double sum = 0.0;
    for (int32_t i = 0; i < solver->model->header.groups * w; i++) {
        double difference = set->B[i] - set->prior_B[i];
        for (int32_t t = 0; t < w && difference != 0.0; t++) {
            int32_t j = i / w * w + t;
            sum += blend_prior_entry(solver, i, t) * difference * (set->B[j] - set->prior_B[j]);
        }
    }
    return sum;
}

/* Q and c of E_d at the present rotations. */
static void find_blend_energy(tug_solver *solver)
{
    working_set *set = &solver->set;
    int32_t k = solver->model->header.dimension, kk = k * k, w = set->width;
    contract_rotations(&set->coupling, solver->group_R, solver->Q);
    for (int32_t i = 0; i < solver->model->header.groups * w; i++) {
        set->c[i] = -trace_of_product(k, solver->group_R + (i / w) * kk, set->pull + i * kk);
    }
}

/* (A 20) as it stands, on the working set. */
static void minimise(tug_solver *solver, double constant)
{
    working_set *set = &solver->set;
    blend_terms terms = {set->width,           set->c, set->d, solver->folded_d,
                         solver->r + constant, set->B};
    solve_blend(solver, &terms);
}

/* phi at the present rotations; the blend follows. */
static double solve_blend_here(tug_solver *solver)
{
    find_blend_energy(solver);
    double constant = add_blend_prior(solver);
    minimise(solver, rotation_prior_energy(solver) + constant);
    return solver->blend.objective;
}

/* The energy of the rotations at the present blend: C, and L with the pull of prior and
 * orientations. */
static void find_rotation_energy(tug_solver *solver)
{
    const working_set *set = &solver->set;
    int32_t k = solver->model->header.dimension, kk = k * k, w = set->width;
    contract_blend(&set->coupling, set->B, solver->C);
    for (int32_t g = 0; g < solver->model->header.groups; g++) {
        double weight = prior_weight(solver) * solver->model->stiffness[g];
        for (int32_t i = 0; i < kk; i++) {
            double sum = weight * solver->prior_R[g * kk + (i % k) * k + i / k];
            for (int32_t s = 0; s < w; s++) {
                sum += set->B[g * w + s] * set->pull[(g * w + s) * kk + i];
            }
            solver->L[g * kk + i] = sum;
        }
        add_orientation_pull(solver->model, &solver->oriented, g, solver->model->stiffness[g],
                             solver->L + g * kk);
    }
}

/* Row `pair` of J: the derivative of the rotations' gradient in one blend weight. */
static void differentiate_gradient(tug_solver *solver, int32_t pair, double *row)
{
    const working_set *set = &solver->set;
    int32_t k = solver->model->header.dimension, kk = k * k, t = tangent_size(k);
    int32_t own = pair / set->width;
    double pull[9], half[9], turned[9], axis[3];
    contract_blend_row(&set->coupling, pair, set->B, solver->X);
    memcpy(pull, set->pull + pair * kk, (size_t)kk * sizeof *pull);
    for (int32_t h = 0; h < solver->model->header.groups; h++) {
        multiply_nt(k, solver->X + h * kk, solver->group_R + h * kk, half);
        multiply(k, solver->group_R + own * kk, half, turned);
        for (int32_t i = 0; i < kk; i++) {
            pull[i] -= half[i];
        }
        axial_vector(k, turned, axis); /* of R_own X_h R_h^T, the transpose of what is wanted */
        for (int32_t a = 0; a < t; a++) {
            row[h * t + a] = -axis[a];
        }
    }
    multiply(k, solver->group_R + own * kk, pull, turned);
    axial_vector(k, turned, axis);
    for (int32_t a = 0; a < t; a++) {
        row[own * t + a] -= axis[a];
    }
}

/* J for every simplex entry in use; a single blend moves all its groups' entries at once. */
static void find_entry_derivatives(tug_solver *solver)
{
    int32_t S = solver->set.width, G = solver->model->header.groups;
    size_t size = (size_t)(G * tangent_size(solver->model->header.dimension));
    if (!solver->options.single_blend) {
        for (int32_t i = 0; i < G * S; i++) {
            if (solver->blending.free[i]) {
                differentiate_gradient(solver, i, solver->J + (size_t)i * size);
            }
        }
        return;
    }
    double *row = solver->J + (size_t)S * size; /* rows from S on are free for use */
    for (int32_t s = 0; s < S; s++) {
        memset(solver->J + (size_t)s * size, 0, size * sizeof *row);
        for (int32_t g = 0; g < G && solver->blending.free[s]; g++) {
            differentiate_gradient(solver, g * S + s, row);
            for (size_t a = 0; a < size; a++) {
                solver->J[(size_t)s * size + a] += row[a];
            }
        }
    }
}

/* The Hessian of f in the blend on its face, times 2 sqrt(u): that of u less 2 d d^T for the root.
 */
static void find_face_hessian(tug_solver *solver)
{
    const blend_workspace *face = &solver->blending;
    int32_t S = solver->set.width;
    int single = solver->options.single_blend;
    const double *Q = single ? solver->folded_Q : solver->Q,
                 *d = single ? solver->folded_d : solver->set.d;
    size_t n = (size_t)(single ? S : S * solver->model->header.groups), q = (size_t)face->face;
    for (size_t a = 0; a < q; a++) {
        size_t i = (size_t)face->list[a], pi = (size_t)face->pivot[face->list[a] / S];
        for (size_t b = 0; b < q; b++) {
            size_t j = (size_t)face->list[b], pj = (size_t)face->pivot[face->list[b] / S];
            double root = solver->options.squared ? 0.0 : 2.0 * (d[i] - d[pi]) * (d[j] - d[pj]);
            solver->face_H[a * q + b] =
                Q[i * n + j] - Q[i * n + pj] - Q[pi * n + j] + Q[pi * n + pj] - root;
        }
        solver->face_H[a * q + a] *= 1.0 + 1e-10;
    }
}

/* Take from the rotations' Hessian what the blend gives way: J^T H_face^-1 J. */
static void let_blend_follow(tug_solver *solver)
{
    const blend_workspace *face = &solver->blending;
    int32_t S = solver->set.width, q = face->face;
    int32_t size = solver->model->header.groups * tangent_size(solver->model->header.dimension);
    if (q == 0) {
        return;
    }
    find_entry_derivatives(solver);
    find_face_hessian(solver);
    if (!cholesky_factor(solver->face_H, q)) {
        return; /* a face without a strict minimum: the rotations alone then set the step */
    }
    for (int32_t a = 0; a < q; a++) {
        const double *entry = solver->J + (size_t)face->list[a] * (size_t)size;
        const double *pivot = solver->J + (size_t)face->pivot[face->list[a] / S] * (size_t)size;
        for (int32_t i = 0; i < size; i++) {
            solver->face_J[a * size + i] = entry[i] - pivot[i];
        }
    }
    cholesky_solve_half(solver->face_H, q, solver->face_J, size);
    add_gram(size, q, -1.0, solver->face_J, size, solver->turning.hessian, size);
}

/* One step of Newton's method on phi. Returns the angle of the full step, or 0 where rounding
 * leaves none to take. */
static double descend(tug_solver *solver)
{
    static const double longest = 0.8; /* radians */
    rotation_workspace *turning = &solver->turning;
    int32_t k = solver->model->header.dimension, G = solver->model->header.groups;
    int32_t size = G * tangent_size(k);
    rotation_energy energy = {G, k, solver->C, solver->L};
    double before = solver->blend.objective;
    double tau = solver->options.squared ? 1.0 : 2.0 * sqrt(solver->blend.u);
    find_rotation_energy(solver);
    differentiate_rotations(&energy, solver->group_R, turning);
    let_blend_follow(solver);
    find_newton_step(size, turning);
    double slope = dot(turning->gradient, turning->step, (size_t)size) / tau;
    double rounding = 1e-15 * fabs(solver->r) / tau; /* of u, as f shows it */
    memcpy(solver->kept_R, solver->group_R, rotation_bytes(solver));
    double full = largest_turn(&energy, turning);
    if (full <= solver->options.tolerance) {
        return full;
    }
    double t = full > longest ? longest / full : 1.0;
    for (int halvings = 0; halvings < 40; halvings++, t *= 0.5) {
        turn_all(&energy, solver->kept_R, t, turning);
        memcpy(solver->group_R, turning->trial, rotation_bytes(solver));
        if (solve_blend_here(solver) <= before + 1e-4 * t * slope + rounding) {
            return full;
        }
    }
    memcpy(solver->group_R, solver->kept_R, rotation_bytes(solver));
    solve_blend_here(solver);
    return 0.0;
}

/* Every shape of a group turns with it. */
static void spread_rotations(tug_solver *solver)
{
    int32_t kk = solver->model->header.dimension * solver->model->header.dimension;
    int32_t S = solver->model->header.shapes;
    for (int32_t i = 0; i < solver->model->header.groups * S; i++) {
        memcpy(solver->R + i * kk, solver->group_R + (i / S) * kk, (size_t)kk * sizeof(double));
    }
}

/* The entries chosen, what of the question and of the blend belongs to them. */
static void open_entries(tug_solver *solver, const double *slopes, int32_t wanted)
{
    const tug_model *model = solver->model;
    working_set *set = &solver->set;
    int32_t kk = model->header.dimension * model->header.dimension;
    coupling all = joint_coupling(joint_energy(solver));
    choose_entries(model, &all, solver->B, slopes, wanted, set);
    gather_entries(model, set, 1, solver->B, set->B);
    gather_entries(model, set, 1, solver->d, set->d);
    gather_entries(model, set, 1, solver->prior_B, set->prior_B);
    gather_entries(model, set, kk, solver->pull, set->pull);
}

/* The gradient of u in every entry, those outside of the working set too. */
static void find_slopes(tug_solver *solver, double prior)
{
    const tug_model *model = solver->model;
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes, p = S * k;
    coupling all = joint_coupling(joint_energy(solver));
    double *slopes = solver->set.slopes;
    apply_rotated_coupling(&all, solver->group_R, solver->B, slopes);
    for (int32_t i = 0; i < model->header.groups * S; i++) {
        slopes[i] -= trace_of_product(k, solver->group_R + i / S * kk, solver->pull + i * kk);
        for (int32_t t = 0; t < S; t++) {
            int32_t j = i / S * S + t;
            double difference = solver->B[j] - solver->prior_B[j];
            for (int32_t a = 0; a < k && difference != 0.0 && prior > 0.0; a++) {
                size_t row = (size_t)(i / S * p + i % S * k + a);
                slopes[i] +=
                    3.0 * prior * difference * model->H[row * (size_t)p + (size_t)(t * k + a)];
            }
        }
    }
}

/* Of one group, at an optimum over the working set. */
typedef struct price {
    double excess;  /* what f could fall along the group's steepest entry at most, times tau */
    int32_t wanted; /* entries in use, and those along which f falls */
} price;

static price price_group(const tug_solver *solver, int32_t g, double tau, double noise)
{
    int32_t S = solver->model->header.shapes;
    const double *B = solver->B + g * S, *d = solver->d + g * S, *u = solver->set.slopes + g * S;
    double level = 0.0;
    price result = {0.0, 0};
    for (int32_t s = 0; s < S; s++) {
        level += B[s] * (u[s] + tau * d[s]);
    }
    for (int32_t s = 0; s < S; s++) {
        double excess = level - (u[s] + tau * d[s]);
        result.excess = fmax(result.excess, excess);
        result.wanted += B[s] > 0.0 || excess > noise;
    }
    return result;
}

/* At an optimum over the working set: take in the entries along which f still falls. prior: weight
 * of the blends' prior in it. Returns 0 where there are none: it is the optimum over all, with the
 * gap that is then put into the result. */
static int extend_entries(tug_solver *solver, double prior)
{
    const tug_model *model = solver->model;
    working_set *set = &solver->set;
    int32_t S = model->header.shapes, wanted = 0, missing = 0;
    scatter_entries(model, set, set->B, solver->B);
    if (has_all_entries(model, set)) {
        return 0;
    }
    double tau = solver->options.squared ? 1.0 : 2.0 * sqrt(solver->blend.u), gap = 0.0;
    double noise = 1e-12 * tau * solver->blend.objective + 1e-15 * fabs(solver->r);
    find_slopes(solver, prior);
    for (int32_t g = 0; g < model->header.groups; g++) {
        price one = price_group(solver, g, tau, noise);
        missing |= one.excess > noise;
        wanted = one.wanted > wanted ? one.wanted : wanted;
        gap += one.excess / tau;
    }
    if (!missing) {
        solver->blend.gap = gap;
        return 0;
    }
    for (int32_t i = 0; i < model->header.groups * S; i++) {
        set->slopes[i] += tau * solver->d[i];
    }
    /* Wider each time, so that it ends. */
    open_entries(solver, set->slopes, wanted > set->width ? wanted : set->width + 1);
    return 1;
}

/* B^: the blend that suits the rotations' prior, a convex problem. */
static void find_blend_prior(tug_solver *solver)
{
    do {
        find_blend_energy(solver);
        minimise(solver, rotation_prior_energy(solver));
    } while (extend_entries(solver, 0.0));
    size_t n = (size_t)(solver->model->header.groups * solver->model->header.shapes);
    memcpy(solver->prior_B, solver->B, n * sizeof *solver->B);
    gather_entries(solver->model, &solver->set, 1, solver->prior_B, solver->set.prior_B);
}

/* Newton's method on phi over the working set. */
static void turn_to_optimum(tug_solver *solver, tug_solve_info *info)
{
    solve_blend_here(solver);
    info->converged = 0;
    info->residual = INFINITY;
    while (info->rounds < solver->options.max_rounds && !info->converged) {
        double before = solver->blend.objective;
        info->residual = descend(solver);
        info->rounds++;
        info->increase = fmax(info->increase, solver->blend.objective - before);
        info->converged = info->residual <= solver->options.tolerance;
    }
}

void solve_steady(tug_solver *solver, tug_solve_info *info)
{
    find_rotation_prior(solver);
    int cold = !solver->options.warm_start || !solver->solved;
    memcpy(solver->kept_R, solver->group_R, rotation_bytes(solver));
    memcpy(solver->group_R, solver->prior_R, rotation_bytes(solver));
    open_entries(solver, solver->d, 0);
    find_blend_prior(solver);
    if (!cold) {
        memcpy(solver->group_R, solver->kept_R, rotation_bytes(solver));
    }
    do {
        turn_to_optimum(solver, info);
    } while (extend_entries(solver, solver->options.prior));
    spread_rotations(solver);
    double priors = rotation_prior_energy(solver) + blend_prior_energy(solver);
    info->energy = fmax(solver->blend.u - 0.5 * priors, 0.0);
}
