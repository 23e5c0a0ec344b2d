/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A nonlinear shape space as in Schumacher, Thomaszewski, Coros, Martin, Sumner and Gross 2012,
 * "Efficient Simulation of Example-Based Materials": the examples are interpolated as features of
 * elements, which need not fit together, and the pose is the one nearest to the interpolation:
 *
 *     min over w in the simplex, R, T of  1/2 sum_g sum_(e in g) c_e | q_e - R_g M_e(w) p_0e |^2
 *
 * with q = D T, H q = Y, and M_e(w) the blend of the triangle's deformation gradients, each shape
 * turned to the rest shape group by group. T is eliminated as for (A 20), R found by Newton's
 * method, and w by Gauss-Newton within the simplex, with R giving way.
 *
 * Against the paper: posing without dynamics, as in Figure 2 e of AMRAP; triangles of a surface;
 * the distance is as rigid as possible within an edge group, in place of a strain's; the pose is in
 * Tug's reduced space. The start is the shape of least energy. */
#include "dense/dense.h"
#include "dense/rotation.h"
#include "elimination.h"
#include "feature_moments.h"
#include "gauss_newton.h"
#include "memory.h"
#include "model/energy.h"
#include "solver/costs.h"
#include "subspace.h"

#include <math.h>
#include <string.h>

enum { MAX_TURNS = 100 };

static const double TURN_TOLERANCE = 1e-9; /* radians, of the rotations for one w */

typedef struct shape_space {
    tug_model *model; /* of all shapes: dictionary, alignment, and the costs to start from */
    shape_costs costs;
    feature_moments moments;
    elimination form;
    double *placed; /* rank by k: the mapped unknowns that Y alone makes */
    double constant;
    double *V, *dV;     /* #G k by b, #S by the same: K and dK mapped, and then free */
    double *C, *L;      /* of the rotations' energy at w */
    double *dC, *dL;    /* its derivatives in one weight */
    double *KY, *dKY;   /* #G k by k, #S by the same: K F Y and its derivatives */
    double *N;          /* #S k by b: sum_g R_g dV_g */
    double *coupling;   /* tangent components by #S */
    double *relaxed;    /* the same: what the rotations give way */
    double *R, *kept_R; /* #G by k by k: at the last w, and at the best */
    double *pull;       /* #G by k by k: the least prior, to where the rotations started */
    double *t, *T;      /* k by b, b by k: the pose, mapped and not */
    rotation_workspace turning;
    weight_workspace weights;
} shape_space;

static void destroy(void *state)
{
    shape_space *p = state;
    if (p == NULL) {
        return;
    }
    double *const members[] = {p->placed, p->V,    p->dV, p->C,        p->L,       p->dC,
                               p->KY,     p->dKY,  p->N,  p->coupling, p->relaxed, p->R,
                               p->kept_R, p->pull, p->t,  p->T};
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        release(members[i]);
    }
    elimination_destroy(&p->form);
    model_destroy(p->model);
    costs_destroy(&p->costs);
    feature_moments_destroy(&p->moments);
    rotation_workspace_destroy(&p->turning);
    weight_workspace_destroy(&p->weights);
    release(p);
}

static int allocate_room(shape_space *p)
{
    const model_header *header = &p->model->header;
    size_t k = (size_t)header->dimension, S = (size_t)header->shapes;
    size_t G = (size_t)header->groups, b = (size_t)p->model->energy.unknowns;
    size_t turns = G * (size_t)tangent_size(header->dimension);
    p->placed = allocate(b * k, sizeof(double));
    p->V = allocate(G * k * b, sizeof(double));
    p->dV = allocate(S * G * k * b, sizeof(double));
    p->KY = allocate(G * k * k, sizeof(double));
    p->dKY = allocate(S * G * k * k, sizeof(double));
    p->C = allocate(G * k * G * k, sizeof(double));
    p->L = allocate(G * k * k, sizeof(double));
    p->dC = allocate(G * k * G * k, sizeof(double));
    p->N = allocate(S * k * b, sizeof(double));
    p->coupling = allocate(turns * S, sizeof(double));
    p->relaxed = allocate(turns * S, sizeof(double));
    p->R = allocate(G * k * k, sizeof(double));
    p->kept_R = allocate(G * k * k, sizeof(double));
    p->pull = allocate(G * k * k, sizeof(double));
    p->t = allocate(k * b, sizeof(double));
    p->T = allocate(b * k, sizeof(double));
    int room = rotation_workspace_create(header->groups, header->dimension, &p->turning);
    room &= weight_workspace_create(header->shapes, &p->weights);
    room &= costs_create(p->model, &p->costs);
    return room && p->placed && p->V && p->dV && p->KY && p->dKY && p->C && p->L && p->dC && p->N &&
           p->coupling && p->relaxed && p->R && p->kept_R && p->pull && p->t && p->T;
}

/* The features of all triangles, each shape turned to the rest shape by its group. */
static void set_features(const tug_baseline *baseline, shape_space *p)
{
    const tug_mesh *mesh = baseline->mesh;
    int32_t k = mesh->dimension, S = baseline->shape_count;
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        for (int32_t s = 0; s < S; s++) {
            double F[9], turned[9];
            const double *Q = p->model->align + (p->moments.groups[t] * S + s) * k * k;
            find_gradient(mesh, shape_of_baseline(baseline, s), t, F);
            multiply(k, Q, F, turned);
            set_feature(&p->moments.features, t, s, turned);
        }
    }
}

/* D^T L D of the whole mesh. */
static tug_status find_stiffness(const tug_mesh *mesh, const dictionary *D, double *stiffness)
{
    size_t b = (size_t)dictionary_columns(D), p = (size_t)(block_columns(D) - 1);
    int32_t *one_group = allocate((size_t)mesh->triangle_count, sizeof *one_group);
    int32_t *functions = allocate((size_t)D->weights, sizeof *functions); /* all of them */
    group_energy energy = {.L = stiffness};
    energy.K = allocate(p * b, sizeof *energy.K);
    energy.H = allocate(p * p, sizeof *energy.H);
    energy_workspace *workspace = NULL;
    tug_status status = one_group && functions && energy.K && energy.H ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        status = energy_workspace_create(mesh, D, one_group, 1, NULL, &workspace);
    }
    if (status == TUG_OK) {
        for (int32_t h = 0; h < D->weights; h++) {
            functions[h] = h;
        }
        find_group_energy(workspace, 0, functions, D->weights, &energy);
    }
    energy_workspace_destroy(workspace);
    release(one_group);
    release(functions);
    release(energy.K);
    release(energy.H);
    return status;
}

static tug_status eliminate(const tug_baseline *baseline, shape_space *p)
{
    const dictionary *D = &p->model->dictionary;
    int32_t b = dictionary_columns(D), h = baseline->row_count;
    size_t size = (size_t)b;
    double *L = allocate(size * size, sizeof *L), *X = allocate((size_t)h * size, sizeof *X);
    tug_status status = L != NULL && X != NULL ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        status = find_stiffness(baseline->mesh, D, L);
    }
    if (status == TUG_OK) {
        for (int32_t i = 0; i < h; i++) {
            add_dictionary_row(D, baseline->handles[i], 1.0, X + (size_t)i * size);
        }
        status = elimination_create(L, X, b, h, &p->form);
    }
    release(L);
    release(X);
    return status;
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    shape_space *p = *state = allocate(1, sizeof *p);
    if (p == NULL) {
        return fail_memory();
    }
    tug_status status = create_subspace(baseline, problem, 0, problem->shape_count, &p->model);
    if (status != TUG_OK) {
        return status;
    }
    if (!feature_moments_create(baseline->mesh, &p->model->dictionary, problem->groups,
                                problem->group_count, problem->shape_count, &p->moments) ||
        !allocate_room(p)) {
        return fail_memory();
    }
    set_features(baseline, p);
    return eliminate(baseline, p);
}

/* Rows of K: V what T can do for them, KY what Y does. */
static void map_moments(shape_space *p, const double *K, double *V, double *KY)
{
    int32_t k = p->moments.mesh->dimension, turned = p->moments.group_count * k;
    map_rows(&p->form, K, turned, V);
    memset(KY, 0, (size_t)(turned * k) * sizeof *KY);
    add_product(turned, k, p->form.rank, 1.0, V, p->form.rank, p->placed, k, KY, k);
    free_rows(&p->form, turned, V);
}

/* C += the blocks of H on its diagonal. */
static void add_blocks(int32_t turned, int32_t k, const double *H, double *C)
{
    for (int32_t i = 0; i < turned * k; i++) {
        int32_t row = i / k, column = row / k * k + i % k;
        C[row * turned + column] += H[i];
    }
}

/* The energy of the rotations with T eliminated: C = H - V V^T and L = K F Y, and the prior. */
static rotation_energy find_energy(shape_space *p)
{
    int32_t k = p->moments.mesh->dimension, r = p->form.rank, G = p->moments.group_count;
    int32_t turned = G * k;
    map_moments(p, p->moments.K, p->V, p->KY);
    memset(p->C, 0, (size_t)turned * (size_t)turned * sizeof *p->C);
    add_product_nt(turned, turned, r, -1.0, p->V, r, p->V, r, p->C, turned);
    add_blocks(turned, k, p->moments.H, p->C);
    for (int32_t i = 0; i < turned * k; i++) {
        p->L[i] = p->KY[i] + p->pull[i];
    }
    return (rotation_energy){G, k, p->C, p->L};
}

/* The derivative of find_energy in weight s. */
static rotation_energy differentiate_energy(shape_space *p, int32_t s)
{
    int32_t k = p->moments.mesh->dimension, r = p->form.rank, G = p->moments.group_count;
    int32_t turned = G * k;
    double *dV = p->dV + (size_t)s * (size_t)turned * (size_t)r, *dKY = p->dKY + s * turned * k;
    map_moments(p, p->moments.dK + (size_t)s * (size_t)turned * (size_t)p->form.unknowns, dV, dKY);
    memset(p->dC, 0, (size_t)turned * (size_t)turned * sizeof *p->dC);
    add_product_nt(turned, turned, r, -1.0, dV, r, p->V, r, p->dC, turned);
    add_product_nt(turned, turned, r, -1.0, p->V, r, dV, r, p->dC, turned);
    add_blocks(turned, k, p->moments.dH + s * turned * k, p->dC);
    return (rotation_energy){G, k, p->dC, dKY};
}

/* phi(w) = min over R; rotations start from those of the best w so far. */
static tug_status evaluate(void *state, const double *w, double *energy)
{
    shape_space *p = state;
    int32_t k = p->moments.mesh->dimension, converged;
    find_feature_moments(&p->moments, w, 0);
    rotation_energy form = find_energy(p);
    memcpy(p->R, p->kept_R, (size_t)(form.groups * k * k) * sizeof *p->R);
    fit_rotations(&form, TURN_TOLERANCE, MAX_TURNS, &p->turning, p->R, &converged);
    *energy = evaluate_rotations(&form, p->R, &p->turning) + p->constant;
    return TUG_OK;
}

/* The Gauss-Newton Hessian for fixed rotations: what the derivatives have in common, less what the
 * transforms give way. */
static void find_hessian(shape_space *p, double *hessian)
{
    int32_t k = p->moments.mesh->dimension, kk = k * k, r = p->form.rank;
    int32_t G = p->moments.group_count, S = p->moments.features.shapes;
    size_t size = (size_t)k * (size_t)r;
    memset(p->N, 0, (size_t)S * size * sizeof *p->N);
    for (int32_t i = 0; i < S * G; i++) {
        add_product(k, r, k, 1.0, p->R + i % G * kk, k, p->dV + (size_t)i * size, r,
                    p->N + (size_t)(i / G) * size, r);
    }
    for (int32_t i = 0; i < S * S; i++) {
        hessian[i] = p->moments.gram[i] -
                     dot(p->N + (size_t)(i / S) * size, p->N + (size_t)(i % S) * size, size);
    }
}

/* Less what the rotations give way, where their own Hessian is definite. */
static void relax_rotations(shape_space *p, const rotation_energy *energy, double *hessian)
{
    int32_t S = p->moments.features.shapes, turns = energy->groups * tangent_size(energy->k);
    differentiate_rotations(energy, p->R, &p->turning);
    if (!cholesky_factor(p->turning.hessian, turns)) {
        return;
    }
    memcpy(p->relaxed, p->coupling, (size_t)(turns * S) * sizeof *p->relaxed);
    cholesky_solve(p->turning.hessian, turns, p->relaxed, S);
    add_product_tn(S, S, turns, -1.0, p->coupling, S, p->relaxed, S, hessian, S);
}

static tug_status differentiate(void *state, const double *w, double *gradient, double *hessian)
{
    shape_space *p = state;
    int32_t k = p->moments.mesh->dimension, S = p->moments.features.shapes;
    double energy;
    evaluate(p, w, &energy);
    memcpy(p->kept_R, p->R, (size_t)(p->moments.group_count * k * k) * sizeof *p->R);
    find_feature_moments(&p->moments, w, 1);
    rotation_energy form = find_energy(p);
    for (int32_t s = 0; s < S; s++) {
        rotation_energy change = differentiate_energy(p, s);
        gradient[s] = evaluate_rotations(&change, p->R, &p->turning);
        differentiate_rotations(&change, p->R, &p->turning);
        for (int32_t i = 0; i < form.groups * tangent_size(k); i++) {
            p->coupling[i * S + s] = p->turning.gradient[i];
        }
    }
    find_hessian(p, hessian);
    relax_rotations(p, &form, hessian);
    return TUG_OK;
}

/* The shape of least energy, and its rotations with the least prior that holds them. */
static void start(const tug_baseline *baseline, shape_space *p)
{
    int32_t G = p->moments.group_count, S = baseline->shape_count, best = 0;
    int32_t k = p->moments.mesh->dimension, kk = k * k;
    double least = 0.0;
    find_costs(p->model, NULL, NULL, baseline->Y, 1, &p->costs);
    for (int32_t s = 0; s < S; s++) {
        double sum = 0.0;
        for (int32_t g = 0; g < G; g++) {
            sum += p->costs.D[g * S + s];
        }
        best = s == 0 || sum < least ? s : best;
        least = s == best ? sum : least;
        baseline->blend[s] = 0.0;
    }
    baseline->blend[best] = 1.0;
    for (int32_t g = 0; g < G; g++) {
        p->constant += k * LEAST_PRIOR * p->model->stiffness[g];
    }
    for (int32_t i = 0; i < G * kk; i++) {
        const double *R = p->costs.rotations + (i / kk * S + best) * kk;
        p->kept_R[i] = R[i % kk];
        p->pull[i] = LEAST_PRIOR * p->model->stiffness[i / kk] * R[i % k * k + i / k % k];
    }
}

/* T from w and R: mapped, its transpose is sum_g R_g V_g and what Y makes. */
static void find_transforms(shape_space *p)
{
    int32_t k = p->moments.mesh->dimension, r = p->form.rank;
    for (int32_t i = 0; i < k * r; i++) {
        p->t[i] = p->placed[i % r * k + i / r];
    }
    for (int32_t g = 0; g < p->moments.group_count; g++) {
        add_product(k, r, k, 1.0, p->R + g * k * k, k, p->V + (size_t)(g * k) * (size_t)r, r, p->t,
                    r);
    }
    unmap_columns(&p->form, p->t, k, p->T);
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    shape_space *p = baseline->state;
    int32_t k = p->moments.mesh->dimension;
    p->constant = 0.5 * place_rows(&p->form, baseline->Y, k, p->placed);
    start(baseline, p);
    weight_problem problem = {baseline->shape_count, 1, p, evaluate, differentiate};
    tug_status status =
        minimise_weights(&problem, &baseline->options, &p->weights, baseline->blend, info);
    evaluate(p, baseline->blend, &info->objective);
    info->objective = fmax(info->objective, 0.0);
    find_transforms(p);
    return status;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    const shape_space *p = baseline->state;
    find_pose(&p->model->dictionary, p->T, p->model->header.unit, positions);
}

const baseline_method nonlinear_shape_space_method = {create, destroy, solve, find_positions, NULL};
