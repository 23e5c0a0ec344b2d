/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Minimise E = sum_vs m_v |q_vs - sum_j w_vj (R_js p_v + t_js)|^2 + smoothness tr(W^T L W), by
 * turns over the motions of the bones and over the weights of the vertices. Every step lowers it.
 */
#include "dictionaries/skeleton/skeleton.h"

#include "dense/dense.h"
#include "dictionaries/skeleton/influences.h"
#include "dictionaries/skeleton/motions.h"
#include "dictionaries/skeleton/seeds.h"
#include "memory.h"

#include <math.h>
#include <string.h>

static const double steepest_half_cotangent = 1e3;

/* The part of the progress bar before the rounds. */
static const double seeds_share = 0.2;

/* Of the objective, where the bones explain everything. */
static const double rounding = 1e-15;

enum { vertices_a_report = 1024 };

typedef struct skeleton_job {
    skinning s;
    int32_t wanted;
    double unit;
    influence_room room;
    motion_sums *sums; /* poses */
    double *places;    /* poses by k */
    double misfit;     /* the first part of E */
    double objective;
    int32_t rounds, converged;
} skeleton_job;

static void close_job(skeleton_job *job)
{
    release(job->s.rest);
    release(job->s.posed);
    release(job->s.miss);
    release(job->s.motion);
    release(job->s.bone);
    release(job->s.weight);
    laplacian_free(&job->s.L);
    influence_room_destroy(&job->room);
    release(job->sums);
    release(job->places);
}

static int allocate_job(skeleton_job *job)
{
    skinning *s = &job->s;
    size_t n = (size_t)s->vertices, k = (size_t)s->dimension, poses = (size_t)s->poses;
    s->rest = allocate(n * k, sizeof(double));
    s->posed = allocate(n * poses * k, sizeof(double));
    s->miss = allocate(n * poses * k, sizeof(double));
    s->motion = allocate((size_t)job->wanted * poses * (k + 1) * k, sizeof(double));
    s->bone = allocate(n * most_influences, sizeof(int32_t));
    s->weight = allocate(n * most_influences, sizeof(double));
    job->sums = allocate(poses, sizeof *job->sums);
    job->places = allocate(poses * k, sizeof(double));
    return s->rest && s->posed && s->miss && s->motion && s->bone && s->weight && job->sums &&
           job->places;
}

/* Each shape about its own mean: a bone's translation is then no larger than the shape. */
static void store_shape(skinning *s, const double *shape, double unit, double *to, size_t stride)
{
    size_t n = (size_t)s->vertices, k = (size_t)s->dimension;
    for (size_t c = 0; c < k; c++) {
        double mean = 0.0;
        for (size_t v = 0; v < n; v++) {
            mean += shape[v * k + c] / (double)n;
        }
        for (size_t v = 0; v < n; v++) {
            to[v * stride + c] = (shape[v * k + c] - mean) / unit;
        }
    }
}

static tug_status open_job(skeleton_job *job, const tug_mesh *mesh, const double *shapes)
{
    skinning *s = &job->s;
    size_t entries = (size_t)s->vertices * (size_t)s->dimension;
    tug_status status = require_sound_mesh(mesh);
    if (status == TUG_OK) {
        status = laplacian_create(mesh, steepest_half_cotangent, &s->L);
    }
    if (status == TUG_OK && !allocate_job(job)) {
        status = fail_memory();
    }
    if (status != TUG_OK) {
        return status;
    }
    job->unit = mesh->diagonal;
    store_shape(s, shapes, job->unit, s->rest, (size_t)s->dimension);
    for (int32_t i = 0; i < s->poses; i++) {
        store_shape(s, shapes + (size_t)(i + 1) * entries, job->unit, s->posed + i * s->dimension,
                    (size_t)(s->poses * s->dimension));
    }
    return TUG_OK;
}

/* Of rigid clusters: what their bones do not explain. */
static void find_misses(skeleton_job *job)
{
    skinning *s = &job->s;
    int32_t width = s->poses * s->dimension;
    for (int32_t v = 0; v < s->vertices; v++) {
        double *miss = s->miss + (size_t)v * (size_t)width;
        const double *posed = s->posed + (size_t)v * (size_t)width;
        carry_vertex(s, s->bone[(size_t)v * most_influences], v, miss);
        for (int32_t i = 0; i < width; i++) {
            miss[i] = posed[i] - miss[i];
        }
    }
}

/* w_u . w_v */
static double common_weight(const skinning *s, int32_t u, int32_t v)
{
    double sum = 0.0;
    for (int32_t i = u * most_influences; i < (u + 1) * most_influences; i++) {
        for (int32_t j = v * most_influences; j < (v + 1) * most_influences; j++) {
            sum += s->bone[i] == s->bone[j] ? s->weight[i] * s->weight[j] : 0.0;
        }
    }
    return sum;
}

static void measure(skeleton_job *job)
{
    const skinning *s = &job->s;
    size_t width = (size_t)(s->poses * s->dimension);
    double roughness = 0.0;
    job->misfit = 0.0;
    for (int32_t v = 0; v < s->vertices; v++) {
        const double *miss = s->miss + (size_t)v * width;
        job->misfit += s->L.mass[v] * dot(miss, miss, width);
        for (int32_t e = s->L.starts[v]; e < s->L.starts[v + 1]; e++) {
            roughness += s->L.values[e] * common_weight(s, v, s->L.columns[e]);
        }
    }
    job->objective = job->misfit + s->smoothness * roughness;
}

static tug_status improve_weights(skeleton_job *job, const progress_range *range)
{
    skinning *s = &job->s;
    for (int32_t v = 0; v < s->vertices; v++) {
        if (v % vertices_a_report == 0) {
            tug_status status =
                report(range, "finding the bones' weights", (double)v / s->vertices);
            if (status != TUG_OK) {
                return status;
            }
        }
        improve_vertex(s, v, &job->room);
    }
    return TUG_OK;
}

static tug_status run_rounds(skeleton_job *job, const tug_skeleton_options *options,
                             const progress_range *range)
{
    find_misses(job);
    measure(job);
    for (; job->rounds < options->max_rounds && !job->converged; job->rounds++) {
        double before = job->objective, step = 1.0 / options->max_rounds;
        progress_range part = progress_part(range, job->rounds * step, (job->rounds + 1) * step);
        tug_status status = improve_weights(job, &part);
        if (status != TUG_OK) {
            return status;
        }
        improve_motions(&job->s, job->sums, job->places);
        measure(job);
        job->converged = before - job->objective <= options->tolerance * before + rounding;
    }
    return TUG_OK;
}

static tug_status decompose(skeleton_job *job, const tug_skeleton_options *options,
                            const progress_range *range)
{
    progress_range first = progress_part(range, 0.0, seeds_share);
    tug_status status = plant_bones(&job->s, job->wanted, &first);
    if (status == TUG_OK && !influence_room_create(&job->s, &job->room)) {
        status = fail_memory();
    }
    if (status == TUG_OK) {
        progress_range second = progress_part(range, seeds_share, 1.0);
        status = run_rounds(job, options, &second);
    }
    return status;
}

/* Number the bones that have weight. number: of a bone, or no_bone. */
static int32_t number_bones(const skinning *s, int32_t *number)
{
    int32_t count = 0;
    for (int32_t j = 0; j < s->bones; j++) {
        number[j] = no_bone;
    }
    for (int32_t i = 0; i < most_influences * s->vertices; i++) {
        if (s->weight[i] > 0.0) {
            number[s->bone[i]] = 0;
        }
    }
    for (int32_t j = 0; j < s->bones; j++) {
        number[j] = number[j] == 0 ? count++ : no_bone;
    }
    return count;
}

static tug_status hand_over(const skeleton_job *job, double *weights, int32_t *bone_count)
{
    const skinning *s = &job->s;
    int32_t *number = allocate((size_t)s->bones, sizeof *number);
    if (number == NULL) {
        return fail_memory();
    }
    int32_t count = number_bones(s, number);
    memset(weights, 0, (size_t)s->vertices * (size_t)count * sizeof *weights);
    for (int32_t i = 0; i < most_influences * s->vertices; i++) {
        if (s->weight[i] > 0.0) {
            size_t row = (size_t)(i / most_influences) * (size_t)count;
            weights[row + (size_t)number[s->bone[i]]] = s->weight[i];
        }
    }
    *bone_count = count;
    release(number);
    return TUG_OK;
}

static void summarise(const skeleton_job *job, tug_skeleton_info *info)
{
    if (info != NULL) {
        info->converged = job->converged;
        info->rounds = job->rounds;
        info->error = job->unit * sqrt(job->misfit / fmax(1.0, job->s.poses));
        info->objective = job->objective;
    }
}

tug_status find_skeleton(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                         int32_t wanted, const tug_skeleton_options *options,
                         const progress_range *range, double *weights, int32_t *bone_count,
                         tug_skeleton_info *info)
{
    skeleton_job job = {.s = {.vertices = mesh->vertex_count,
                              .dimension = mesh->dimension,
                              .poses = shape_count - 1,
                              .smoothness = options->smoothness},
                        .wanted = wanted < mesh->vertex_count ? wanted : mesh->vertex_count};
    tug_status status = open_job(&job, mesh, shapes);
    if (status == TUG_OK) {
        status = decompose(&job, options, range);
    }
    if (status == TUG_OK) {
        status = hand_over(&job, weights, bone_count);
    }
    if (status == TUG_OK) {
        summarise(&job, info);
    }
    close_job(&job);
    return status;
}
