/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reduced deformable models: Der, Sumner and Popovic 2006, "Inverse Kinematics for Reduced
 * Deformable Models": MeshIK with the vertices bound to a skinned model and one feature for each
 * cluster of triangles. The pose x = D T of the rest shape's skinning subspace and the weights w
 * minimise
 *
 *     1/2 sum_g sum_(e in g) c_e | x_e - M_g(w) p_0e |^2,    H x = Y,
 *
 * M_g(w) being the blend of the groups' mean deformation gradients. With T eliminated it is a
 * function of w alone: the rotations of the single-shape problem are these matrices here.
 *
 * Against the paper: the controls are the handles' affine transforms with their weight functions,
 * or bones where the caller gives their weights; a cluster's gradient is held against all of its
 * triangles rather than one. Handles hold exactly, or rows softly:
 *
 *     + 1/2 sum_r beta_r |(H x - Y)_r|^2    in place of    H x = Y. */
#include "dense/dense.h"
#include "dense/rotation.h"
#include "features.h"
#include "gauss_newton.h"
#include "memory.h"
#include "subspace.h"

#include <math.h>
#include <string.h>

/* Weight of a group's rotation in its deformation gradient, relative to its edges. */
static const double TURNED = 1e-6;

typedef struct reduced {
    tug_model *model; /* of the rest shape */
    feature_set features;
    double *pull, *V; /* #G k by k: K F Y, and the transposes of M_g */
    double *CV;       /* #G k by k */
    double *dM;       /* #S by k by k */
    double *dV, *CdV; /* #S by #G k by k */
    double *T;        /* unknowns by k */
    double *recovery; /* recover_transforms' work */
    double constant;  /* of the energy: what Y alone says */
    weight_workspace weights;
} reduced;

static void destroy(void *state)
{
    reduced *r = state;
    if (r == NULL) {
        return;
    }
    model_destroy(r->model);
    features_destroy(&r->features);
    release(r->pull);
    release(r->V);
    release(r->CV);
    release(r->dM);
    release(r->dV);
    release(r->CdV);
    release(r->T);
    release(r->recovery);
    weight_workspace_destroy(&r->weights);
    release(r);
}

static int allocate_room(reduced *r, const tug_baseline_problem *problem)
{
    size_t k = (size_t)problem->dimension, S = (size_t)problem->shape_count;
    size_t block = (size_t)problem->group_count * k * k;
    r->pull = allocate(block, sizeof *r->pull);
    r->V = allocate(block, sizeof *r->V);
    r->CV = allocate(block, sizeof *r->CV);
    r->dM = allocate(S * k * k, sizeof *r->dM);
    r->dV = allocate(S * block, sizeof *r->dV);
    r->CdV = allocate(S * block, sizeof *r->CdV);
    size_t unknowns = (size_t)problem->weight_count * (1 + k);
    r->T = allocate(unknowns * k, sizeof *r->T);
    int room = features_create(problem->dimension, problem->group_count, problem->shape_count,
                               &r->features);
    room &= weight_workspace_create(problem->shape_count, &r->weights);
    return room && r->pull && r->V && r->CV && r->dM && r->dV && r->CdV && r->T;
}

static void store_transposed(int32_t k, const double *M, double *transposed)
{
    for (int32_t i = 0; i < k * k; i++) {
        transposed[i] = M[i % k * k + i / k];
    }
}

/* moments: #G by k by k, the sum over the edges of c p_se p_0e^T. */
static void find_moments(const tug_baseline *baseline, const int32_t *groups, int32_t s,
                         double *moments)
{
    const tug_mesh *mesh = baseline->mesh;
    const double *p = shape_of_baseline(baseline, s);
    int32_t k = mesh->dimension, kk = k * k;
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const int32_t *corners = mesh->triangles + i / 3 * 3;
        int32_t a = corners[(i + 1) % 3] * k, b = corners[(i + 2) % 3] * k;
        for (int32_t e = 0; e < kk; e++) {
            moments[groups[i / 3] * kk + e] +=
                mesh->half_cotangent[i] * (p[b + e / k] - p[a + e / k]) *
                (mesh->vertices[b + e % k] - mesh->vertices[a + e % k]);
        }
    }
}

/* The F that best carries the rest shape's edges to the shape's and turns what they say little of,
 * the normal of a group that is nearly flat: (N + m R) (A + m I)^-1 with the moments N of the shape
 * and A of the rest shape, and their rotation R. */
static void fit_gradient(int32_t k, const double *rest, const double *moment, double *F)
{
    double A[9], N[9], R[9], trace = 0.0;
    for (int32_t a = 0; a < k; a++) {
        trace += rest[a * k + a];
    }
    store_transposed(k, moment, N);
    closest_rotation(k, N, R);
    for (int32_t i = 0; i < k * k; i++) {
        A[i] = rest[i] + (i % (k + 1) == 0 ? TURNED * trace : 0.0);
        N[i] += TURNED * trace * R[i % k * k + i / k];
    }
    cholesky_factor(A, k);
    cholesky_solve(A, k, N, k);
    store_transposed(k, N, F);
}

static tug_status find_features(const tug_baseline *baseline, const tug_baseline_problem *problem,
                                reduced *r)
{
    int32_t G = problem->group_count, k = problem->dimension, kk = k * k;
    size_t size = (size_t)(G * kk);
    double *moments = allocate(2 * size, sizeof *moments);
    if (moments == NULL) {
        return fail_memory();
    }
    find_moments(baseline, problem->groups, 0, moments);
    for (int32_t s = 0; s < problem->shape_count; s++) {
        memset(moments + size, 0, size * sizeof *moments);
        find_moments(baseline, problem->groups, s, moments + size);
        for (int32_t g = 0; g < G; g++) {
            double F[9];
            fit_gradient(k, moments + g * kk, moments + size + g * kk, F);
            set_feature(&r->features, g, s, F);
        }
    }
    release(moments);
    return TUG_OK;
}

/* Takes the model, also where it fails. */
static tug_status take_model(reduced *r, tug_model *model)
{
    size_t size = recovery_size(&model->shape->energy, r->features.k);
    double *recovery = allocate(size, sizeof *recovery);
    if (recovery == NULL) {
        model_destroy(model);
        return fail_memory();
    }
    model_destroy(r->model);
    release(r->recovery);
    r->model = model;
    r->recovery = recovery;
    return TUG_OK;
}

static tug_status change_rows(void *state, const tug_rows *rows, const double *firmness)
{
    reduced *r = state;
    tug_model *model;
    tug_status status = tug_change_rows(r->model, rows, firmness, &model);
    return status == TUG_OK ? take_model(r, model) : status;
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    reduced *r = *state = allocate(1, sizeof *r);
    if (r == NULL || !allocate_room(r, problem)) {
        return fail_memory();
    }
    tug_model *model;
    tug_status status = create_subspace(baseline, problem, 0, 1, &model);
    if (status == TUG_OK) {
        status = take_model(r, model);
    }
    return status == TUG_OK ? find_features(baseline, problem, r) : status;
}

/* 1/2 tr(V^T C V) - tr(V^T K F Y) + constant. */
static tug_status evaluate(void *state, const double *w, double *energy)
{
    reduced *r = state;
    const reduction *form = &r->model->shape[0].energy;
    int32_t k = r->features.k, kk = k * k, turned = form->turned;
    for (int32_t g = 0; g < r->features.elements; g++) {
        double M[9];
        blend_features(&r->features, g, w, M);
        store_transposed(k, M, r->V + g * kk);
    }
    size_t size = (size_t)(turned * k);
    memset(r->CV, 0, size * sizeof *r->CV);
    add_product(turned, k, turned, 1.0, form->C, turned, r->V, k, r->CV, k);
    *energy = 0.5 * dot(r->V, r->CV, size) - dot(r->V, r->pull, size) + r->constant;
    return TUG_OK;
}

static tug_status differentiate(void *state, const double *w, double *gradient, double *hessian)
{
    reduced *r = state;
    const reduction *form = &r->model->shape[0].energy;
    int32_t k = r->features.k, kk = k * k, S = r->features.shapes, turned = form->turned;
    size_t size = (size_t)(turned * k);
    double energy;
    evaluate(r, w, &energy);
    for (int32_t g = 0; g < r->features.elements; g++) {
        differentiate_features(&r->features, g, w, r->dM);
        for (int32_t s = 0; s < S; s++) {
            store_transposed(k, r->dM + s * kk, r->dV + (size_t)s * size + (size_t)(g * kk));
        }
    }
    memset(r->CdV, 0, (size_t)S * size * sizeof *r->CdV);
    for (int32_t s = 0; s < S; s++) {
        double *dV = r->dV + (size_t)s * size, *CdV = r->CdV + (size_t)s * size;
        add_product(turned, k, turned, 1.0, form->C, turned, dV, k, CdV, k);
        gradient[s] = dot(dV, r->CV, size) - dot(dV, r->pull, size);
        for (int32_t other = 0; other <= s; other++) {
            hessian[s * S + other] = hessian[other * S + s] =
                dot(CdV, r->dV + (size_t)other * size, size);
        }
    }
    return TUG_OK;
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    reduced *r = baseline->state;
    const reduction *form = &r->model->shape[0].energy;
    int32_t k = r->features.k, S = baseline->shape_count;
    find_pull(form, baseline->Y, k, r->pull);
    r->constant = 0.5 * energy_of_rows(form, baseline->Y, k);
    for (int32_t s = 0; s < S; s++) {
        baseline->blend[s] = 1.0 / S;
    }
    weight_problem problem = {S, 0, r, evaluate, differentiate};
    tug_status status =
        minimise_weights(&problem, &baseline->options, &r->weights, baseline->blend, info);
    if (status == TUG_OK) {
        status = evaluate(r, baseline->blend, &info->objective);
        info->objective = fmax(info->objective, 0.0);
        recover_transforms(form, r->V, baseline->Y, k, r->recovery, r->T);
    }
    return status;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    const reduced *r = baseline->state;
    find_pose(&r->model->dictionary, r->T, r->model->header.unit, positions);
}

const baseline_method reduced_deformable_method = {create, destroy, solve, find_positions,
                                                   change_rows};
