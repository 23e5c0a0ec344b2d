/* SPDX-License-Identifier: GPL-3.0-or-later */
/* L f = mu M f with y = M^1/2 f is an ordinary problem, and the smallest mu are the largest
 * eigenvalues 1 / (mu + shift) of A = M^1/2 (L + shift M)^-1 M^1/2. Its null space is known: what
 * is constant on each component. */
#include "weights/eigenfunctions.h"

#include "dense/dense.h"
#include "memory.h"
#include "mesh/mesh.h"
#include "weights/krylov.h"
#include "weights/laplacian.h"
#include "weights/workers.h"

#include <math.h>
#include <string.h>

/* The whole area being one, mu is of the order of 10 times the function's number. */
static const double shift = 1.0;

static const double steepest_half_cotangent = 1e3;

/* Of a pair of A: its residual relative to the eigenvalue. */
static const double tolerance = 1e-11;

/* The part of the progress bar up to the factor. */
static const double factor_share = 0.3;

typedef struct eigen_job {
    const tug_mesh *mesh;
    int32_t count, constants; /* functions; those of them that are constant on every component */
    laplacian L;
    double *root; /* #V: M^1/2 */
    sparse_factor *factor;
    sparse_solver *solver;
    double *scaled;  /* krylov_block by #V */
    double *vectors; /* count by #V, y and then f; room for one block more */
    double *values;  /* count */
    double residual;
    int32_t applications;
} eigen_job;

static void close_job(eigen_job *job)
{
    laplacian_free(&job->L);
    sparse_solver_destroy(job->solver);
    sparse_factor_destroy(job->factor);
    release(job->root);
    release(job->scaled);
    release(job->vectors);
    release(job->values);
}

static tug_status open_job(eigen_job *job)
{
    size_t size = (size_t)job->mesh->vertex_count;
    tug_status status = require_sound_mesh(job->mesh);
    if (status == TUG_OK) {
        status = laplacian_create(job->mesh, steepest_half_cotangent, &job->L);
    }
    if (status != TUG_OK) {
        return status;
    }
    job->root = allocate(size, sizeof(double));
    job->scaled = allocate(krylov_block * size, sizeof(double));
    job->vectors = allocate(((size_t)job->count + krylov_block) * size, sizeof(double));
    job->values = allocate((size_t)job->count, sizeof(double));
    if (!job->root || !job->scaled || !job->vectors || !job->values) {
        return fail_memory();
    }
    for (size_t v = 0; v < size; v++) {
        job->root[v] = sqrt(job->L.mass[v]);
    }
    return TUG_OK;
}

static tug_status factorise(void *context, int32_t worker, int32_t item, const atomic_int *stop)
{
    eigen_job *job = context;
    sparse_matrix shifted;
    (void)worker, (void)item, (void)stop;
    tug_status status = shifted_laplacian(&job->L, shift, &shifted);
    if (status == TUG_OK) {
        status = sparse_factor_create(&shifted, &job->factor);
        sparse_matrix_free(&shifted);
    }
    return status;
}

static tug_status apply_inverse(void *context, const double *vectors, double *images)
{
    eigen_job *job = context;
    size_t size = (size_t)job->mesh->vertex_count, entries = krylov_block * size;
    for (size_t i = 0; i < entries; i++) {
        job->scaled[i] = job->root[i % size] * vectors[i];
    }
    tug_status status = sparse_solve(job->solver, job->scaled, images);
    for (size_t i = 0; i < entries; i++) {
        images[i] *= job->root[i % size];
    }
    return status;
}

/* The largest component that `taken` has not marked, the first of equal ones. */
static int32_t take_largest(const double *mass, int32_t count, int32_t *taken)
{
    int32_t largest = -1;
    for (int32_t c = 0; c < count; c++) {
        if (!taken[c] && (largest < 0 || mass[c] > mass[largest])) {
            largest = c;
        }
    }
    taken[largest] = 1;
    return largest;
}

/* y of the functions that are constant on every component: 1, and then, component after component
 * from the second largest on, what it differs by from the larger ones. Orthonormal. */
static void fill_constants(eigen_job *job, double *mass, int32_t *rank)
{
    const tug_mesh *mesh = job->mesh;
    size_t size = (size_t)mesh->vertex_count;
    for (size_t v = 0; v < size; v++) {
        mass[mesh->component[v]] += job->L.mass[v];
        job->vectors[v] = job->root[v];
    }
    double before = mass[take_largest(mass, mesh->component_count, rank)];
    for (int32_t j = 1; j < job->constants; j++) {
        int32_t next = take_largest(mass, mesh->component_count, rank);
        double here = mass[next], both = before + here;
        double inside = sqrt(before / (here * both)), outside = -sqrt(here / (before * both));
        rank[next] = j + 1;
        for (size_t v = 0; v < size; v++) {
            int32_t place = rank[mesh->component[v]];
            double value = place == j + 1 ? inside : place > 0 ? outside : 0.0;
            job->vectors[(size_t)j * size + v] = job->root[v] * value;
        }
        before = both;
    }
}

static tug_status find_constants(eigen_job *job)
{
    size_t components = (size_t)job->mesh->component_count;
    double *mass = allocate(components, sizeof *mass);
    int32_t *rank = allocate(components, sizeof *rank);
    int room = mass != NULL && rank != NULL;
    if (room) {
        fill_constants(job, mass, rank);
    }
    release(mass);
    release(rank);
    return room ? TUG_OK : fail_memory();
}

/* One more application takes out what the search has left of high frequencies, which L would
 * magnify; lengths become one again. */
static tug_status polish(eigen_job *job)
{
    size_t size = (size_t)job->mesh->vertex_count;
    for (int32_t i = job->constants; i < job->count; i += krylov_block) {
        double *first = job->vectors + (size_t)i * size;
        int32_t others = job->count - i < krylov_block ? job->count - i : krylov_block;
        tug_status status = apply_inverse(job, first, first);
        if (status != TUG_OK) {
            return status;
        }
        for (double *y = first; y < first + (size_t)others * size; y += size) {
            double length = sqrt(dot(y, y, size));
            for (size_t v = 0; v < size; v++) {
                y[v] /= length;
            }
        }
    }
    return TUG_OK;
}

/* |L f - mu M f| in the norm of M^-1, in parts of mu. */
static double residual_of(eigen_job *job, const double *f, double mu)
{
    double squares = 0.0;
    laplacian_apply(&job->L, f, job->scaled);
    for (int32_t v = 0; v < job->L.size; v++) {
        double rest = job->scaled[v] - mu * job->L.mass[v] * f[v];
        squares += rest * rest / job->L.mass[v];
    }
    return sqrt(squares) / mu;
}

/* The first vertex with half the largest magnitude is positive: unlike the largest itself, which a
 * symmetric mesh has on both sides, it does not hang on rounding. */
static double sign_of(const double *f, size_t size)
{
    double largest = 0.0;
    for (size_t v = 0; v < size; v++) {
        largest = fmax(largest, fabs(f[v]));
    }
    size_t first = 0;
    while (fabs(f[first]) < 0.5 * largest) {
        first++;
    }
    return f[first] < 0.0 ? -1.0 : 1.0;
}

/* f = M^-1/2 y, mu from A's eigenvalue. */
static void finish_pairs(eigen_job *job)
{
    size_t size = (size_t)job->mesh->vertex_count;
    for (int32_t i = 0; i < job->count; i++) {
        double *f = job->vectors + (size_t)i * size;
        for (size_t v = 0; v < size; v++) {
            f[v] /= job->root[v];
        }
        if (i < job->constants) {
            continue;
        }
        double sign = sign_of(f, size);
        for (size_t v = 0; v < size; v++) {
            f[v] *= sign;
        }
        job->values[i] = 1.0 / job->values[i] - shift;
        job->residual = fmax(job->residual, residual_of(job, f, job->values[i]));
    }
}

static tug_status search(eigen_job *job, const progress_range *range)
{
    krylov_problem problem = {.size = job->mesh->vertex_count,
                              .apply = apply_inverse,
                              .context = job,
                              .tolerance = tolerance,
                              .range = range,
                              .stage = "solving for the eigenfunctions"};
    tug_status status = sparse_solver_create(job->factor, krylov_block, &job->solver);
    if (status == TUG_OK) {
        status = krylov_largest(&problem, job->constants, job->count - job->constants, job->vectors,
                                job->values + job->constants, &job->applications);
    }
    return status == TUG_OK ? polish(job) : status;
}

static tug_status run_job(eigen_job *job, const progress_range *range)
{
    tug_status status = find_constants(job);
    if (status != TUG_OK || job->count == job->constants) {
        return status;
    }
    progress_range first = progress_part(range, 0.0, factor_share);
    status = run_workers(1, 1, factorise, job, &first, "factoring the Laplacian");
    if (status == TUG_OK) {
        progress_range second = progress_part(range, factor_share, 1.0);
        status = search(job, &second);
    }
    if (status == TUG_ERROR_NUMERIC) {
        return fail(status, "tug_compute_eigenfunctions: triangles too thin or too different in "
                            "size: merge vertices by distance");
    }
    return status;
}

static void hand_over(const eigen_job *job, double *values, double *functions,
                      tug_eigenfunctions_info *info)
{
    size_t size = (size_t)job->mesh->vertex_count, count = (size_t)job->count;
    memcpy(values, job->values, count * sizeof(double));
    for (size_t v = 0; v < size; v++) {
        for (size_t i = 0; i < count; i++) {
            functions[v * count + i] = job->vectors[i * size + v];
        }
    }
    if (info != NULL) {
        info->constants = job->constants;
        info->solves = job->applications * krylov_block;
        info->residual = job->residual;
    }
}

tug_status compute_eigenfunctions(const tug_mesh *mesh, int32_t count, const progress_range *range,
                                  double *values, double *functions, tug_eigenfunctions_info *info)
{
    use_one_blas_thread();
    int32_t components = mesh->component_count;
    eigen_job job = {
        .mesh = mesh, .count = count, .constants = components < count ? components : count};
    tug_status status = open_job(&job);
    if (status == TUG_OK) {
        status = run_job(&job, range);
    }
    if (status == TUG_OK) {
        finish_pairs(&job);
        hand_over(&job, values, functions, info);
    }
    close_job(&job);
    return status;
}
