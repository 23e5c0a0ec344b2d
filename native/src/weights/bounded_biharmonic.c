/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "weights/bounded_biharmonic.h"

#include "dense/dense.h"
#include "memory.h"
#include "mesh/mesh.h"
#include "weights/bounded_problem.h"
#include "weights/handles.h"
#include "weights/workers.h"

#include <math.h>
#include <string.h>

/* The part of the progress bar up to the factor. */
static const double factor_share = 0.3;

/* Where the first leaves the energy too ill conditioned for a factor, the second. */
static const double steepest_half_cotangent[] = {1e3, 30.0};

typedef struct weights_job {
    const tug_mesh *mesh;
    handle_map map;
    laplacian L;
    sparse_factor *factor; /* NULL where every weight is given */
    bounded_problem problem;
    int32_t handle_count;
    double *columns; /* #W by #V: the functions before they are divided by their sum */
    bounded_result *results;
} weights_job;

static void close_job(weights_job *job)
{
    handle_map_free(&job->map);
    laplacian_free(&job->L);
    sparse_factor_destroy(job->factor);
    release(job->columns);
    release(job->results);
}

/* One for its own vertices and components, zero elsewhere. */
static void give_values(const weights_job *job, int32_t handle, double *column)
{
    for (int32_t v = 0; v < job->mesh->vertex_count; v++) {
        int32_t follows = job->map.follows[job->mesh->component[v]];
        column[v] = follows == handle || job->map.owner[v] == handle ? 1.0 : 0.0;
    }
}

static tug_status factorise(weights_job *job, double steepest)
{
    sparse_matrix Q;
    laplacian_free(&job->L);
    tug_status status = laplacian_create(job->mesh, steepest, &job->L);
    if (status == TUG_OK) {
        status = bilaplacian_part(&job->L, job->map.unknowns, job->map.unknown_count,
                                  job->map.row_of, &Q);
    }
    if (status == TUG_OK) {
        status = sparse_factor_create(&Q, &job->factor);
        sparse_matrix_free(&Q);
    }
    return status;
}

static tug_status prepare(void *context, int32_t worker, int32_t item, const atomic_int *stop)
{
    weights_job *job = context;
    tug_status status = TUG_ERROR_NUMERIC;
    (void)worker, (void)item, (void)stop;
    if (job->map.unknown_count == 0) {
        return TUG_OK;
    }
    for (int i = 0; i < 2 && status == TUG_ERROR_NUMERIC; i++) {
        status = factorise(job, steepest_half_cotangent[i]);
    }
    if (status == TUG_ERROR_NUMERIC) {
        return fail(status, "tug_compute_weights: triangles too thin or too different in size: "
                            "merge vertices by distance");
    }
    return status;
}

static tug_status solve_handle(void *context, int32_t worker, int32_t item, const atomic_int *stop)
{
    const weights_job *job = context;
    (void)worker;
    double *column = job->columns + (size_t)item * (size_t)job->mesh->vertex_count;
    give_values(job, item, column);
    if (job->factor == NULL) {
        job->results[item].converged = 1;
        return TUG_OK;
    }
    return bounded_solve(&job->problem, column, stop, &job->results[item]);
}

/* What the optimum has as zeros is left with ripples of a few times the tolerance; as zeros they
 * keep a handle's reach, and with it the size of a model, local. */
static const double RIPPLE = 10.0;

static void clear_ripples(const weights_job *job, double tolerance)
{
    size_t count = (size_t)job->mesh->vertex_count * (size_t)job->handle_count;
    for (size_t i = 0; i < count; i++) {
        job->columns[i] = job->columns[i] < RIPPLE * tolerance ? 0.0 : job->columns[i];
    }
}

/* Rows divided by their sum, into the caller's array only when all of them are good. */
static tug_status normalise(const weights_job *job, double *weights)
{
    size_t size = (size_t)job->mesh->vertex_count, count = (size_t)job->handle_count;
    for (size_t v = 0; v < size; v++) {
        double sum = 0.0;
        for (size_t h = 0; h < count; h++) {
            sum += job->columns[h * size + v];
        }
        if (!(sum > 0.0) || !isfinite(sum)) {
            return fail(TUG_ERROR_NUMERIC, "tug_compute_weights: no weights at vertex %zu", v);
        }
        for (size_t h = 0; h < count; h++) {
            job->columns[h * size + v] /= sum;
        }
    }
    for (size_t v = 0; v < size; v++) {
        for (size_t h = 0; h < count; h++) {
            weights[v * count + h] = job->columns[h * size + v];
        }
    }
    return TUG_OK;
}

static void summarise(const weights_job *job, tug_weights_info *info)
{
    if (info == NULL) {
        return;
    }
    size_t struct_size = info->struct_size;
    *info = (tug_weights_info){.struct_size = struct_size, .converged = 1};
    for (int32_t h = 0; h < job->handle_count; h++) {
        const bounded_result *result = job->results + h;
        info->converged &= result->converged;
        info->iterations =
            result->iterations > info->iterations ? result->iterations : info->iterations;
        info->gap = fmax(info->gap, result->gap);
        info->kkt_residual = fmax(info->kkt_residual, result->kkt_residual);
        info->bound_violation = fmax(info->bound_violation, result->violation);
    }
}

static tug_status open_job(weights_job *job, const int32_t *handle_starts,
                           const int32_t *handle_vertices, int follow_nearest)
{
    tug_status status = require_sound_mesh(job->mesh);
    if (status == TUG_OK) {
        status = handle_map_create(job->mesh, handle_starts, handle_vertices, job->handle_count,
                                   follow_nearest, &job->map);
    }
    if (status != TUG_OK) {
        return status;
    }
    size_t size = (size_t)job->mesh->vertex_count, count = (size_t)job->handle_count;
    job->columns = allocate(size * count, sizeof(double));
    job->results = allocate(count, sizeof *job->results);
    return job->columns != NULL && job->results != NULL ? TUG_OK : fail_memory();
}

static tug_status run_job(weights_job *job, const tug_weights_options *options,
                          const progress_range *range)
{
    progress_range first = progress_part(range, 0.0, factor_share);
    tug_status status = run_workers(1, 1, prepare, job, &first, "factoring the energy");
    if (status != TUG_OK) {
        return status;
    }
    job->problem = (bounded_problem){.L = &job->L,
                                     .unknowns = job->map.unknowns,
                                     .row_of = job->map.row_of,
                                     .unknown_count = job->map.unknown_count,
                                     .factor = job->factor,
                                     .tolerance = options->tolerance,
                                     .max_iterations = options->max_iterations};
    int32_t threads = options->threads > 0 ? options->threads : processor_count();
    progress_range second = progress_part(range, factor_share, 1.0);
    return run_workers(threads, job->handle_count, solve_handle, job, &second,
                       "solving for the weights");
}

tug_status bounded_biharmonic_weights(const tug_mesh *mesh, const int32_t *handle_starts,
                                      const int32_t *handle_vertices, int32_t handle_count,
                                      const tug_weights_options *options,
                                      const progress_range *range, double *weights,
                                      tug_weights_info *info)
{
    use_one_blas_thread();
    weights_job job = {.mesh = mesh, .handle_count = handle_count};
    tug_status status =
        open_job(&job, handle_starts, handle_vertices, options->follow_nearest != 0);
    if (status == TUG_OK) {
        status = run_job(&job, options, range);
    }
    if (status == TUG_OK) {
        clear_ripples(&job, options->tolerance);
        status = normalise(&job, weights);
    }
    if (status == TUG_OK) {
        summarise(&job, info);
    }
    close_job(&job);
    return status;
}
