/* SPDX-License-Identifier: GPL-3.0-or-later */
/* MeshIK: Sumner, Zwicker, Gotsman and Popovic 2005, "Mesh-Based Inverse Kinematics", with the
 * nonlinear feature space: vertices q, the handles' held, and weights w that sum to one minimise
 *
 *     1/2 sum_t sum_(e in t) c_e | q_e - M_t(w) p_0e |^2,
 *
 * M_t(w) being the blend of the triangle's deformation gradients. By Gauss-Newton on w: the
 * vertices are linear in M, and the matrix of their normal equations, the cotangent Laplacian, is
 * factored once. A triangle's fourth vertex, where the paper has one, would leave this energy as it
 * is: it makes the column of the normal exact.
 *
 * Against the paper: triangles count by their area; steps are damped where a full one does not lead
 * downhill. A part without a handle is tied to the nearest handle by one vertex, by the blend of
 * their distances. As in the paper, a turn of the whole is no different from any other. */
#include "dense/dense.h"
#include "dense/small_matrix.h"
#include "features.h"
#include "gauss_newton.h"
#include "memory.h"
#include "method.h"
#include "weights/laplacian.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A vertex that is tied to a handle. */
typedef struct tie {
    int32_t vertex, handle;
} tie;

typedef struct mesh_ik {
    const tug_baseline *baseline;
    feature_set features;
    laplacian L;
    int32_t *row_of; /* #V: the vertex' unknown, or -1 - its handle */
    int32_t unknowns;
    tie *ties;
    int32_t tie_count;
    sparse_factor *factor;
    sparse_solver *one, *all; /* of k and of #S k right sides */
    double *corner;           /* #F by 3 by k: the sum over a corner's edges of +- c_e p_0e */
    double *M, *dM, *dMC;     /* #F by k by k; #S by k by k of one triangle, and times its C */
    double *pull, *q;         /* #V by k: the sum over the edges of +- c_e M p_0e, and the pose */
    double *d_pull;           /* #V by #S by k: its derivatives */
    double *right, *d_right;  /* k and #S k vectors of the unknowns */
    double *d_q;
    weight_workspace weights;
} mesh_ik;

static void destroy(void *state)
{
    mesh_ik *m = state;
    if (m == NULL) {
        return;
    }
    features_destroy(&m->features);
    laplacian_free(&m->L);
    sparse_solver_destroy(m->one);
    sparse_solver_destroy(m->all);
    sparse_factor_destroy(m->factor);
    release(m->row_of);
    release(m->ties);
    release(m->M);
    release(m->dM);
    release(m->dMC);
    release(m->corner);
    release(m->pull);
    release(m->q);
    release(m->d_pull);
    release(m->right);
    release(m->d_right);
    release(m->d_q);
    weight_workspace_destroy(&m->weights);
    release(m);
}

static int allocate_room(mesh_ik *m, const tug_baseline_problem *problem)
{
    size_t k = (size_t)problem->dimension, S = (size_t)problem->shape_count;
    size_t n = (size_t)problem->vertex_count;
    m->row_of = allocate(n, sizeof *m->row_of);
    m->ties = allocate((size_t)m->baseline->mesh->component_count, sizeof *m->ties);
    m->M = allocate((size_t)problem->triangle_count * k * k, sizeof *m->M);
    m->dM = allocate(S * k * k, sizeof *m->dM);
    m->dMC = allocate(S * k * k, sizeof *m->dMC);
    m->corner = allocate(3 * (size_t)problem->triangle_count * k, sizeof *m->corner);
    m->pull = allocate(n * k, sizeof *m->pull);
    m->q = allocate(n * k, sizeof *m->q);
    m->d_pull = allocate(S * n * k, sizeof *m->d_pull);
    m->right = allocate(n * k, sizeof *m->right);
    m->d_right = allocate(S * n * k, sizeof *m->d_right);
    m->d_q = allocate(S * n * k, sizeof *m->d_q);
    int room = features_create(problem->dimension, problem->triangle_count, problem->shape_count,
                               &m->features);
    room &= weight_workspace_create(problem->shape_count, &m->weights);
    return room && m->row_of && m->ties && m->M && m->dM && m->pull && m->q && m->d_pull &&
           m->right && m->d_right && m->d_q && m->corner && m->dMC;
}

static void number_unknowns(mesh_ik *m)
{
    for (int32_t h = 0; h < m->baseline->row_count; h++) {
        m->row_of[m->baseline->handles[h]] = -1 - h;
    }
    for (int32_t v = 0; v < m->baseline->mesh->vertex_count; v++) {
        if (m->row_of[v] == 0) {
            m->row_of[v] = m->unknowns++;
        }
    }
}

static int32_t nearest_handle(const tug_baseline *baseline, int32_t vertex)
{
    const double *p = baseline->mesh->vertices;
    int32_t k = baseline->mesh->dimension, best = 0;
    double least = INFINITY;
    for (int32_t h = 0; h < baseline->row_count; h++) {
        double squares = 0.0;
        for (int32_t a = 0; a < k; a++) {
            double difference = p[baseline->handles[h] * k + a] - p[vertex * k + a];
            squares += difference * difference;
        }
        best = squares < least ? h : best;
        least = fmin(least, squares);
    }
    return best;
}

static tug_status tie_components(mesh_ik *m)
{
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t *held = allocate((size_t)mesh->component_count, sizeof *held);
    if (held == NULL) {
        return fail_memory();
    }
    for (int32_t h = 0; h < m->baseline->row_count; h++) {
        held[mesh->component[m->baseline->handles[h]]] = 1;
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        if (!held[mesh->component[v]]) {
            held[mesh->component[v]] = 1;
            m->ties[m->tie_count++] = (tie){v, nearest_handle(m->baseline, v)};
        }
    }
    release(held);
    return TUG_OK;
}

/* The unknowns' part of L, its lower triangle, and the ties. */
static void fill_matrix(const mesh_ik *m, sparse_matrix *A)
{
    int32_t end = 0;
    for (int32_t v = 0; v < m->L.size; v++) {
        int32_t column = m->row_of[v];
        for (int32_t e = m->L.starts[v]; e < m->L.starts[v + 1] && column >= 0; e++) {
            int32_t row = m->row_of[m->L.columns[e]];
            if (row >= column) {
                A->rows[end] = row;
                A->values[end++] = m->L.values[e];
            }
        }
        if (column >= 0) {
            A->starts[column + 1] = end;
        }
    }
    for (int32_t i = 0; i < m->tie_count; i++) {
        int32_t row = m->row_of[m->ties[i].vertex];
        for (int32_t e = A->starts[row]; e < A->starts[row + 1]; e++) {
            A->values[e] += A->rows[e] == row ? 1.0 : 0.0;
        }
    }
}

static tug_status factor_matrix(mesh_ik *m)
{
    size_t entries = (size_t)m->L.starts[m->L.size];
    sparse_matrix A = {.size = m->unknowns};
    A.starts = allocate((size_t)m->unknowns + 1, sizeof *A.starts);
    A.rows = allocate(entries, sizeof *A.rows);
    A.values = allocate(entries, sizeof *A.values);
    tug_status status = A.starts && A.rows && A.values ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        fill_matrix(m, &A);
        status = sparse_factor_create(&A, &m->factor);
    }
    sparse_matrix_free(&A);
    int32_t k = m->baseline->mesh->dimension;
    if (status == TUG_OK) {
        status = sparse_solver_create(m->factor, k, &m->one);
    }
    return status == TUG_OK ? sparse_solver_create(m->factor, m->baseline->shape_count * k, &m->all)
                            : status;
}

static void find_corners(mesh_ik *m)
{
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t k = mesh->dimension;
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) { /* the edge opposite of corner i */
        int32_t first = i / 3 * 3, a = first + (i + 1) % 3, b = first + (i + 2) % 3;
        const double *from = mesh->vertices + mesh->triangles[a] * k;
        const double *to = mesh->vertices + mesh->triangles[b] * k;
        for (int32_t c = 0; c < k; c++) {
            double part = mesh->half_cotangent[i] * (to[c] - from[c]);
            m->corner[a * k + c] -= part;
            m->corner[b * k + c] += part;
        }
    }
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    mesh_ik *m = *state = allocate(1, sizeof *m);
    if (m == NULL) {
        return fail_memory();
    }
    m->baseline = baseline;
    if (!allocate_room(m, problem)) {
        return fail_memory();
    }
    for (int32_t i = 0; i < problem->shape_count * problem->triangle_count; i++) {
        int32_t s = i / problem->triangle_count, t = i % problem->triangle_count;
        double F[9];
        find_gradient(baseline->mesh, shape_of_baseline(baseline, s), t, F);
        set_feature(&m->features, t, s, F);
    }
    find_corners(m);
    number_unknowns(m);
    tug_status status = laplacian_create(baseline->mesh, DBL_MAX, &m->L);
    if (status == TUG_OK) {
        status = tie_components(m);
    }
    return status == TUG_OK ? factor_matrix(m) : status;
}

/* tr(A B^T) */
static inline double inner(int32_t k, const double *A, const double *B)
{
    double sum = 0.0;
    for (int32_t i = 0; i < k * k; i++) {
        sum += A[i] * B[i];
    }
    return sum;
}

/* y += A x */
static inline void add_transformed(int32_t k, const double *A, const double *x, double *y)
{
    for (int32_t i = 0; i < k; i++) {
        for (int32_t c = 0; c < k; c++) {
            y[i] += A[i * k + c] * x[c];
        }
    }
}

/* What a tie wants of its vertex beyond the handle's place: the shapes' own distance, blended. */
static double tie_offset(const mesh_ik *m, int32_t i, int32_t s, int32_t axis)
{
    int32_t k = m->features.k;
    const double *p = shape_of_baseline(m->baseline, s);
    int32_t handle = m->baseline->handles[m->ties[i].handle];
    return p[m->ties[i].vertex * k + axis] - p[handle * k + axis];
}

static void add_ties(mesh_ik *m, const double *w)
{
    int32_t k = m->features.k;
    for (int32_t i = 0; i < m->tie_count * k; i++) {
        const tie *at = m->ties + i / k;
        double wanted = m->baseline->Y[at->handle * k + i % k];
        for (int32_t s = 0; s < m->features.shapes; s++) {
            wanted += w[s] * tie_offset(m, i / k, s, i % k);
        }
        m->pull[at->vertex * k + i % k] += wanted;
    }
}

/* The pose of least energy for the M at hand. */
static tug_status find_vertices(mesh_ik *m)
{
    const double *Y = m->baseline->Y;
    int32_t k = m->features.k, n = m->L.size;
    for (int32_t i = 0; i < n * k; i++) {
        int32_t v = i / k, axis = i % k, row = m->row_of[v];
        double sum = m->pull[i];
        for (int32_t e = m->L.starts[v]; e < m->L.starts[v + 1]; e++) {
            int32_t other = m->row_of[m->L.columns[e]];
            sum -= other < 0 ? m->L.values[e] * Y[(-1 - other) * k + axis] : 0.0;
        }
        if (row >= 0) {
            m->right[axis * m->unknowns + row] = sum;
        }
    }
    tug_status status = sparse_solve(m->one, m->right, m->right);
    for (int32_t i = 0; i < n * k && status == TUG_OK; i++) {
        int32_t row = m->row_of[i / k];
        m->q[i] = row < 0 ? Y[(-1 - row) * k + i % k] : m->right[i % k * m->unknowns + row];
    }
    return status;
}

static double measure(const mesh_ik *m)
{
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t k = mesh->dimension;
    double sum = 0.0;
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        int32_t first = i / 3 * 3;
        int32_t a = mesh->triangles[first + (i + 1) % 3] * k;
        int32_t b = mesh->triangles[first + (i + 2) % 3] * k;
        double edge[3], misfit[3];
        for (int32_t c = 0; c < k; c++) {
            edge[c] = mesh->vertices[a + c] - mesh->vertices[b + c];
            misfit[c] = m->q[b + c] - m->q[a + c];
        }
        add_transformed(k, m->M + first / 3 * k * k, edge, misfit);
        sum += 0.5 * mesh->half_cotangent[i] * dot(misfit, misfit, (size_t)k);
    }
    return sum;
}

static tug_status evaluate(void *state, const double *w, double *energy)
{
    mesh_ik *m = state;
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t k = mesh->dimension;
    memset(m->pull, 0, (size_t)(mesh->vertex_count * k) * sizeof *m->pull);
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        double *M = m->M + t * k * k;
        blend_features(&m->features, t, w, M);
        for (int32_t i = 3 * t; i < 3 * t + 3; i++) {
            add_transformed(k, M, m->corner + i * k, m->pull + mesh->triangles[i] * k);
        }
    }
    add_ties(m, w);
    tug_status status = find_vertices(m);
    *energy = status == TUG_OK ? measure(m) : 0.0;
    return status;
}

/* C = sum_e c p_0e p_0e^T and misfit = sum_e c (M p_0e - q_e) p_0e^T of one triangle. */
static void find_moments(const mesh_ik *m, int32_t t, double *C, double *misfit)
{
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t k = mesh->dimension;
    memset(C, 0, (size_t)(k * k) * sizeof *C);
    for (int32_t i = 3 * t; i < 3 * t + 3; i++) {
        for (int32_t e = 0; e < k * k; e++) {
            C[e] += mesh->vertices[mesh->triangles[i] * k + e / k] * m->corner[i * k + e % k];
        }
    }
    multiply(k, m->M + t * k * k, C, misfit);
    for (int32_t i = 3 * t; i < 3 * t + 3; i++) {
        for (int32_t e = 0; e < k * k; e++) {
            misfit[e] -= m->q[mesh->triangles[i] * k + e / k] * m->corner[i * k + e % k];
        }
    }
}

/* One triangle's part in gradient and Hessian, where the vertices do not give way, and in d_pull,
 * with which they do. */
static void add_triangle(mesh_ik *m, int32_t t, double *gradient, double *hessian)
{
    int32_t k = m->features.k, kk = k * k, S = m->features.shapes;
    double C[9], misfit[9];
    find_moments(m, t, C, misfit);
    for (int32_t s = 0; s < S; s++) {
        multiply(k, m->dM + s * kk, C, m->dMC + s * kk);
        gradient[s] += inner(k, m->dM + s * kk, misfit);
        for (int32_t other = 0; other <= s; other++) {
            hessian[s * S + other] += inner(k, m->dMC + s * kk, m->dM + other * kk);
        }
    }
    for (int32_t i = 3 * t; i < 3 * t + 3; i++) {
        double *pull = m->d_pull + (size_t)(m->baseline->mesh->triangles[i] * S * k);
        for (int32_t s = 0; s < S; s++) {
            add_transformed(k, m->dM + s * kk, m->corner + i * k, pull + s * k);
        }
    }
}

/* d_q = A^-1 d_pull; the Hessian loses d_pull^T d_q. */
static tug_status give_way(mesh_ik *m, double *hessian)
{
    int32_t k = m->features.k, S = m->features.shapes, columns = S * k;
    size_t unknowns = (size_t)m->unknowns, size = unknowns * (size_t)k;
    for (int32_t v = 0; v < m->L.size; v++) {
        for (int32_t c = 0; c < columns && m->row_of[v] >= 0; c++) {
            m->d_right[(size_t)c * unknowns + (size_t)m->row_of[v]] =
                m->d_pull[(size_t)v * (size_t)columns + (size_t)c];
        }
    }
    tug_status status = sparse_solve(m->all, m->d_right, m->d_q);
    for (int32_t s = 0; s < S && status == TUG_OK; s++) {
        for (int32_t other = 0; other <= s; other++) {
            hessian[s * S + other] -=
                dot(m->d_right + (size_t)s * size, m->d_q + (size_t)other * size, size);
            hessian[other * S + s] = hessian[s * S + other];
        }
    }
    return status;
}

/* The ties are left out: they hold exactly in every pose of least energy, and move whole parts. */
static tug_status differentiate(void *state, const double *w, double *gradient, double *hessian)
{
    mesh_ik *m = state;
    const tug_mesh *mesh = m->baseline->mesh;
    int32_t S = m->features.shapes;
    size_t size = (size_t)mesh->vertex_count * (size_t)(S * mesh->dimension);
    double energy;
    tug_status status = evaluate(m, w, &energy);
    if (status != TUG_OK) {
        return status;
    }
    memset(gradient, 0, (size_t)S * sizeof *gradient);
    memset(hessian, 0, (size_t)(S * S) * sizeof *hessian);
    memset(m->d_pull, 0, size * sizeof *m->d_pull);
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        differentiate_features(&m->features, t, w, m->dM);
        add_triangle(m, t, gradient, hessian);
    }
    return give_way(m, hessian);
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    mesh_ik *m = baseline->state;
    for (int32_t s = 0; s < baseline->shape_count; s++) {
        baseline->blend[s] = 1.0 / baseline->shape_count;
    }
    weight_problem problem = {baseline->shape_count, 0, m, evaluate, differentiate};
    tug_status status =
        minimise_weights(&problem, &baseline->options, &m->weights, baseline->blend, info);
    return status == TUG_OK ? evaluate(m, baseline->blend, &info->objective) : status;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    const mesh_ik *m = baseline->state;
    memcpy(positions, m->q, (size_t)(m->L.size * m->features.k) * sizeof *positions);
}

const baseline_method mesh_ik_method = {create, destroy, solve, find_positions, NULL};
