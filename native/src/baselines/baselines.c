/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The public calls: argument checks, units, and which method it is. */
#include "baselines.h"

#include "api/arguments.h"
#include "dense/dense.h"
#include "memory.h"
#include "method.h"

#include <math.h>
#include <string.h>

static const baseline_method *const methods[] = {
    [TUG_BASELINE_FAST] = &fast_method,
    [TUG_BASELINE_ENERGY_INTERPOLATION] = &energy_interpolation_method,
    [TUG_BASELINE_NONLINEAR_SHAPE_SPACE] = &nonlinear_shape_space_method,
    [TUG_BASELINE_MESH_IK] = &mesh_ik_method,
    [TUG_BASELINE_REDUCED_DEFORMABLE] = &reduced_deformable_method,
    [TUG_BASELINE_BLEND_SHAPES] = &blend_shapes_method,
};

enum { METHODS = sizeof methods / sizeof *methods };

void tug_baseline_default_options(tug_baseline_options *options)
{
    *options = (tug_baseline_options){
        .struct_size = sizeof *options,
        .max_rounds = 200,
        .tolerance = 1e-6,
    };
}

static tug_status check_handles(const tug_baseline_problem *problem)
{
    for (int32_t h = 0; h < problem->handle_count; h++) {
        int32_t v = problem->handles[h];
        REQUIRE(v >= 0 && v < problem->vertex_count,
                "tug_baseline_create: handle %d is vertex %d of %d", h, v, problem->vertex_count);
        for (int32_t other = 0; other < h; other++) {
            if (problem->handles[other] == v) {
                return fail(TUG_ERROR_HANDLES, "handles %d and %d are the same vertex", other, h);
            }
        }
    }
    return TUG_OK;
}

static tug_status check_groups(const tug_baseline_problem *problem)
{
    for (int32_t g = 0; g < problem->group_count; g++) {
        int32_t t = 0;
        while (t < problem->triangle_count && problem->groups[t] != g) {
            t++;
        }
        REQUIRE(t < problem->triangle_count, "tug_baseline_create: no triangle is in group %d", g);
    }
    for (int32_t t = 0; t < problem->triangle_count; t++) {
        int32_t g = problem->groups[t];
        REQUIRE(g >= 0 && g < problem->group_count,
                "tug_baseline_create: triangle %d is in group %d of %d", t, g,
                problem->group_count);
    }
    return TUG_OK;
}

static tug_status check_problem(const tug_baseline_problem *problem)
{
    REQUIRE_POINTER("tug_baseline_create", problem->shapes);
    REQUIRE_POINTER("tug_baseline_create", problem->triangles);
    REQUIRE_POINTER("tug_baseline_create", problem->handles);
    REQUIRE_POINTER("tug_baseline_create", problem->weights);
    REQUIRE_POINTER("tug_baseline_create", problem->groups);
    REQUIRE(problem->dimension == 2 || problem->dimension == 3,
            "tug_baseline_create: the dimension is %d, not 2 or 3", problem->dimension);
    REQUIRE(problem->shape_count > 0 && problem->vertex_count > 0 && problem->triangle_count > 0 &&
                problem->handle_count > 0 && problem->weight_count > 0 && problem->group_count > 0,
            "tug_baseline_create: a count is not above zero");
    size_t n = (size_t)problem->vertex_count;
    size_t coordinates = n * (size_t)(problem->shape_count * problem->dimension);
    REQUIRE(find_not_finite(problem->shapes, coordinates) < 0 &&
                find_not_finite(problem->weights, n * (size_t)problem->weight_count) < 0,
            "tug_baseline_create: a coordinate or a weight is not finite");
    tug_status status = check_handles(problem);
    return status == TUG_OK ? check_groups(problem) : status;
}

static tug_status check_options(const tug_baseline_options *options)
{
    REQUIRE_SIZE("tug_baseline_create", options);
    REQUIRE(options->max_rounds > 0, "tug_baseline_create: max_rounds must be above zero");
    REQUIRE(options->tolerance > 0.0, "tug_baseline_create: the tolerance must be above zero");
    return TUG_OK;
}

static tug_status create_mesh(tug_baseline *baseline, const tug_baseline_problem *problem)
{
    tug_status status = mesh_create(baseline->shapes, problem->vertex_count, problem->dimension,
                                    problem->triangles, problem->triangle_count, &baseline->mesh);
    return status == TUG_OK ? require_sound_mesh(baseline->mesh) : status;
}

/* From the caller's units to those of the library. */
static tug_status rescale_shapes(tug_baseline *baseline, const tug_baseline_problem *problem)
{
    size_t n = (size_t)problem->vertex_count, k = (size_t)problem->dimension;
    double squares = 0.0;
    for (size_t a = 0; a < k; a++) {
        double low = problem->shapes[a], high = low, sum = 0.0;
        for (size_t i = a; i < n * k; i += k) {
            low = fmin(low, problem->shapes[i]);
            high = fmax(high, problem->shapes[i]);
            sum += problem->shapes[i];
        }
        squares += (high - low) * (high - low);
        baseline->middle[a] = sum / (double)n;
    }
    baseline->unit = sqrt(squares);
    REQUIRE(baseline->unit > 0.0, "tug_baseline_create: all vertices of shape 0 are in one place");
    for (size_t i = 0; i < (size_t)problem->shape_count * n * k; i++) {
        baseline->shapes[i] = (problem->shapes[i] - baseline->middle[i % k]) / baseline->unit;
    }
    return TUG_OK;
}

static tug_status build(tug_baseline *baseline, const tug_baseline_problem *problem)
{
    size_t k = (size_t)problem->dimension, S = (size_t)problem->shape_count;
    size_t h = (size_t)problem->handle_count;
    baseline->shapes = allocate(S * (size_t)problem->vertex_count * k, sizeof *baseline->shapes);
    baseline->handles = allocate(h, sizeof *baseline->handles);
    baseline->Y = allocate(h * k, sizeof *baseline->Y);
    baseline->blend = allocate(S, sizeof *baseline->blend);
    if (!(baseline->shapes && baseline->handles && baseline->Y && baseline->blend)) {
        return fail_memory();
    }
    memcpy(baseline->handles, problem->handles, h * sizeof *baseline->handles);
    tug_status status = rescale_shapes(baseline, problem);
    if (status == TUG_OK) {
        status = create_mesh(baseline, problem);
    }
    return status == TUG_OK ? baseline->method->create(baseline, problem, &baseline->state)
                            : status;
}

tug_status tug_baseline_create(int32_t method, const tug_baseline_problem *problem,
                               const tug_baseline_options *options, tug_baseline **out)
{
    REQUIRE_POINTER("tug_baseline_create", out);
    *out = NULL;
    REQUIRE_POINTER("tug_baseline_create", problem);
    REQUIRE_POINTER("tug_baseline_create", options);
    REQUIRE(method >= 0 && method < METHODS, "tug_baseline_create: there is no method %d", method);
    tug_status status = check_options(options);
    if (status == TUG_OK) {
        status = check_problem(problem);
    }
    if (status != TUG_OK) {
        return status;
    }
    use_one_blas_thread();
    tug_baseline *baseline = allocate(1, sizeof *baseline);
    if (baseline == NULL) {
        return fail_memory();
    }
    baseline->method = methods[method];
    baseline->options = *options;
    baseline->shape_count = problem->shape_count;
    baseline->row_count = problem->handle_count;
    status = build(baseline, problem);
    if (status != TUG_OK) {
        tug_baseline_destroy(baseline);
        return status;
    }
    *out = baseline;
    return TUG_OK;
}

tug_status tug_baseline_change_rows(tug_baseline *baseline, const tug_rows *rows,
                                    const double *firmness)
{
    REQUIRE_POINTER("tug_baseline_change_rows", baseline);
    REQUIRE_POINTER("tug_baseline_change_rows", rows);
    REQUIRE_POINTER("tug_baseline_change_rows", firmness);
    REQUIRE(baseline->method->change_rows != NULL,
            "tug_baseline_change_rows: this method knows handles alone");
    REQUIRE(rows->count > 0, "tug_baseline_change_rows: there are no rows");
    double *Y = allocate((size_t)(rows->count * baseline->mesh->dimension), sizeof *Y);
    if (Y == NULL) {
        return fail_memory();
    }
    tug_status status = baseline->method->change_rows(baseline->state, rows, firmness);
    if (status != TUG_OK) {
        release(Y);
        return status;
    }
    release(baseline->Y);
    baseline->Y = Y;
    baseline->row_count = rows->count;
    return TUG_OK;
}

void tug_baseline_destroy(tug_baseline *baseline)
{
    if (baseline == NULL) {
        return;
    }
    baseline->method->destroy(baseline->state);
    mesh_destroy(baseline->mesh);
    release(baseline->shapes);
    release(baseline->handles);
    release(baseline->Y);
    release(baseline->blend);
    release(baseline);
}

tug_status tug_baseline_solve(tug_baseline *baseline, const double *targets,
                              tug_baseline_info *info)
{
    REQUIRE_POINTER("tug_baseline_solve", baseline);
    REQUIRE_POINTER("tug_baseline_solve", targets);
    tug_baseline_info own = {.struct_size = sizeof own}, *to = info != NULL ? info : &own;
    REQUIRE_SIZE("tug_baseline_solve", to);
    int32_t k = baseline->mesh->dimension;
    size_t count = (size_t)(baseline->row_count * k);
    REQUIRE(find_not_finite(targets, count) < 0, "tug_baseline_solve: a target is not finite");
    for (size_t i = 0; i < count; i++) {
        baseline->Y[i] = (targets[i] - baseline->middle[i % (size_t)k]) / baseline->unit;
    }
    tug_baseline_info found = {.struct_size = sizeof found};
    tug_status status = baseline->method->solve(baseline, &found);
    baseline->solved = status == TUG_OK;
    if (status == TUG_OK) {
        double scale = baseline->unit * baseline->unit;
        found.objective *= scale;
        found.increase *= scale;
        *to = found;
    }
    return status;
}

tug_status tug_baseline_get_positions(const tug_baseline *baseline, double *positions)
{
    REQUIRE_POINTER("tug_baseline_get_positions", baseline);
    REQUIRE_POINTER("tug_baseline_get_positions", positions);
    REQUIRE(baseline->solved, "tug_baseline_get_positions: nothing has been solved yet");
    baseline->method->find_positions(baseline, positions);
    size_t k = (size_t)baseline->mesh->dimension;
    for (size_t i = 0; i < (size_t)baseline->mesh->vertex_count * k; i++) {
        positions[i] = baseline->middle[i % k] + baseline->unit * positions[i];
    }
    return TUG_OK;
}

tug_status tug_baseline_get_blend(const tug_baseline *baseline, double *blend)
{
    REQUIRE_POINTER("tug_baseline_get_blend", baseline);
    REQUIRE_POINTER("tug_baseline_get_blend", blend);
    REQUIRE(baseline->solved, "tug_baseline_get_blend: nothing has been solved yet");
    memcpy(blend, baseline->blend, (size_t)baseline->shape_count * sizeof *blend);
    return TUG_OK;
}
