/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "subspace.h"

#include "memory.h"

#include <string.h>

tug_status create_subspace(const tug_baseline *baseline, const tug_baseline_problem *problem,
                           int32_t first, int32_t count, tug_model **out)
{
    int32_t h = problem->handle_count;
    int32_t *starts = allocate((size_t)h + 1, sizeof *starts);
    double *ones = allocate((size_t)h, sizeof *ones);
    tug_status status = starts != NULL && ones != NULL ? TUG_OK : fail_memory();
    for (int32_t i = 0; i < h && status == TUG_OK; i++) {
        starts[i + 1] = i + 1;
        ones[i] = 1.0;
    }
    if (status == TUG_OK) {
        tug_rows rows = {starts, baseline->handles, ones, h};
        progress_range silent = {NULL, NULL, 0.0, 1.0};
        status = model_create(baseline->mesh, shape_of_baseline(baseline, first), count,
                              problem->weights, problem->weight_count, &rows, problem->groups,
                              problem->group_count, NULL, 0.0, &silent, out);
    }
    release(starts);
    release(ones);
    return status;
}

/* What one weight function's transforms make of a vertex. */
static void transform_vertex(const dictionary *D, const double *T, int32_t h, size_t v, double *x)
{
    int32_t k = D->dimension, coordinates = block_columns(D) - 1;
    const double *middle = D->middles + (size_t)h * (size_t)coordinates;
    memcpy(x, T, (size_t)k * sizeof *x);
    for (int32_t c = 0; c < coordinates; c++) {
        double offset = D->shape_columns[(size_t)c * (size_t)D->vertices + v] - middle[c];
        for (int32_t a = 0; a < k; a++) {
            x[a] += offset * T[(1 + c) * k + a];
        }
    }
}

void find_pose(const dictionary *D, const double *T, double factor, double *positions)
{
    size_t n = (size_t)D->vertices, k = (size_t)D->dimension;
    memset(positions, 0, n * k * sizeof *positions);
    for (size_t i = 0; i < n * (size_t)D->weights; i++) {
        size_t v = i / (size_t)D->weights, h = i % (size_t)D->weights;
        double weight = factor * D->weight_columns[h * n + v], x[3];
        if (weight != 0.0) {
            transform_vertex(D, T + h * (size_t)block_columns(D) * k, (int32_t)h, v, x);
            for (size_t a = 0; a < k; a++) {
                positions[v * k + a] += weight * x[a];
            }
        }
    }
}
