/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The public calls from weights to models: argument checks, and nothing else. */
#include "api/arguments.h"
#include "dictionaries/dictionary_fit.h"
#include "dictionaries/medoids.h"
#include "dictionaries/skeleton/skeleton.h"
#include "mesh/pose_rotations.h"
#include "model/dictionary.h"
#include "model/groups.h"
#include "model/model.h"
#include "weights/bounded_biharmonic.h"
#include "weights/eigenfunctions.h"

#include <math.h>

static progress_range whole_range(tug_progress callback, void *user)
{
    return (progress_range){callback, user, 0.0, 1.0};
}

int32_t tug_abi(void)
{
    return TUG_ABI;
}

const char *tug_version(void)
{
    return TUG_VERSION;
}

void tug_default_weights_options(tug_weights_options *options)
{
    *options = (tug_weights_options){
        .struct_size = sizeof *options, .tolerance = 1e-6, .max_iterations = 200};
}

tug_status tug_compute_weights(const tug_mesh *mesh, const int32_t *handle_starts,
                               const int32_t *handle_vertices, int32_t handle_count,
                               const tug_weights_options *options, tug_progress progress,
                               void *user, double *weights, tug_weights_info *info)
{
    REQUIRE_POINTER("tug_compute_weights", mesh);
    REQUIRE_POINTER("tug_compute_weights", handle_starts);
    REQUIRE_POINTER("tug_compute_weights", handle_vertices);
    REQUIRE_POINTER("tug_compute_weights", options);
    REQUIRE_POINTER("tug_compute_weights", weights);
    REQUIRE_SIZE("tug_compute_weights", options);
    REQUIRE_INFO("tug_compute_weights", info);
    REQUIRE(handle_count > 0, "tug_compute_weights: there are no handles");
    REQUIRE(options->tolerance > 0.0, "tug_compute_weights: the tolerance must be above zero");
    REQUIRE(options->max_iterations > 0 && options->threads >= 0,
            "tug_compute_weights: max_iterations must be above zero and threads not negative");
    REQUIRE(handle_starts[0] == 0, "tug_compute_weights: handle_starts begins with %d, not 0",
            handle_starts[0]);
    for (int32_t h = 0; h < handle_count; h++) {
        REQUIRE(handle_starts[h + 1] > handle_starts[h],
                "tug_compute_weights: handle %d has no vertices", h);
        for (int32_t i = handle_starts[h]; i < handle_starts[h + 1]; i++) {
            REQUIRE(handle_vertices[i] >= 0 && handle_vertices[i] < mesh->vertex_count,
                    "tug_compute_weights: handle %d names vertex %d of %d", h, handle_vertices[i],
                    mesh->vertex_count);
        }
    }
    progress_range range = whole_range(progress, user);
    return bounded_biharmonic_weights(mesh, handle_starts, handle_vertices, handle_count, options,
                                      &range, weights, info);
}

tug_status tug_compute_eigenfunctions(const tug_mesh *mesh, int32_t count, tug_progress progress,
                                      void *user, double *values, double *functions,
                                      tug_eigenfunctions_info *info)
{
    REQUIRE_POINTER("tug_compute_eigenfunctions", mesh);
    REQUIRE_POINTER("tug_compute_eigenfunctions", values);
    REQUIRE_POINTER("tug_compute_eigenfunctions", functions);
    REQUIRE_INFO("tug_compute_eigenfunctions", info);
    REQUIRE(count > 0 && count <= mesh->vertex_count,
            "tug_compute_eigenfunctions: %d functions are wanted of %d vertices", count,
            mesh->vertex_count);
    progress_range range = whole_range(progress, user);
    return compute_eigenfunctions(mesh, count, &range, values, functions, info);
}

void tug_default_skeleton_options(tug_skeleton_options *options)
{
    *options = (tug_skeleton_options){
        .struct_size = sizeof *options, .smoothness = 1e-5, .tolerance = 1e-2, .max_rounds = 100};
}

tug_status tug_find_skeleton(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                             int32_t wanted, const tug_skeleton_options *options,
                             tug_progress progress, void *user, double *weights,
                             int32_t *bone_count, tug_skeleton_info *info)
{
    REQUIRE_POINTER("tug_find_skeleton", mesh);
    REQUIRE_POINTER("tug_find_skeleton", shapes);
    REQUIRE_POINTER("tug_find_skeleton", options);
    REQUIRE_POINTER("tug_find_skeleton", weights);
    REQUIRE_POINTER("tug_find_skeleton", bone_count);
    REQUIRE_SIZE("tug_find_skeleton", options);
    REQUIRE_INFO("tug_find_skeleton", info);
    REQUIRE(shape_count > 0, "tug_find_skeleton: there are no shapes");
    REQUIRE(wanted > 0, "tug_find_skeleton: %d bones are wanted", wanted);
    REQUIRE(options->smoothness >= 0.0 && isfinite(options->smoothness),
            "tug_find_skeleton: the smoothness is %g: it cannot be negative", options->smoothness);
    REQUIRE(options->tolerance >= 0.0, "tug_find_skeleton: the tolerance cannot be negative");
    REQUIRE(options->max_rounds > 0, "tug_find_skeleton: max_rounds must be above zero");
    size_t n = (size_t)mesh->vertex_count, k = (size_t)mesh->dimension;
    ptrdiff_t bad = find_not_finite(shapes, (size_t)shape_count * n * k);
    REQUIRE(bad < 0,
            "tug_find_skeleton: vertex %zu of shape %zu has a coordinate that is not finite",
            (size_t)bad / k % n, (size_t)bad / k / n);
    progress_range range = whole_range(progress, user);
    return find_skeleton(mesh, shapes, shape_count, wanted, options, &range, weights, bone_count,
                         info);
}

tug_status tug_cluster_triangles(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                                 int32_t wanted, tug_progress progress, void *user, int32_t *groups,
                                 int32_t *group_count)
{
    REQUIRE_POINTER("tug_cluster_triangles", mesh);
    REQUIRE_POINTER("tug_cluster_triangles", weights);
    REQUIRE_POINTER("tug_cluster_triangles", groups);
    REQUIRE_POINTER("tug_cluster_triangles", group_count);
    REQUIRE(weight_count > 0, "tug_cluster_triangles: there are no weight functions");
    REQUIRE(wanted > 0, "tug_cluster_triangles: %d groups are wanted", wanted);
    ptrdiff_t bad = find_not_finite(weights, (size_t)mesh->vertex_count * (size_t)weight_count);
    REQUIRE(bad < 0, "tug_cluster_triangles: a weight of vertex %td is not finite",
            bad / weight_count);
    progress_range range = whole_range(progress, user);
    return cluster_triangles(mesh, weights, weight_count, wanted, &range, groups, group_count);
}

static tug_status check_dictionary(const tug_dictionary *D, const char *call)
{
    REQUIRE(D->shapes != NULL, "%s: shapes is NULL", call);
    REQUIRE(D->weights != NULL, "%s: weights is NULL", call);
    REQUIRE(D->vertex_count > 0, "%s: there are no vertices", call);
    REQUIRE(D->dimension == 2 || D->dimension == 3, "%s: the dimension is %d, not 2 or 3", call,
            D->dimension);
    REQUIRE(D->shape_count > 0, "%s: there are no shapes", call);
    REQUIRE(D->weight_count > 0, "%s: there are no weight functions", call);
    REQUIRE((int64_t)D->weight_count * (1 + (int64_t)D->shape_count * D->dimension) <= INT16_MAX,
            "%s: more than %d atoms", call, INT16_MAX);
    size_t n = (size_t)D->vertex_count, k = (size_t)D->dimension;
    ptrdiff_t bad = find_not_finite(D->shapes, (size_t)D->shape_count * n * k);
    REQUIRE(bad < 0, "%s: vertex %zu of shape %zu has a coordinate that is not finite", call,
            (size_t)bad / k % n, (size_t)bad / k / n);
    REQUIRE(bounding_diagonal(D->shapes, D->vertex_count, D->dimension) > 0.0,
            "%s: all vertices of shape 0 are in one place", call);
    bad = find_not_finite(D->weights, n * (size_t)D->weight_count);
    REQUIRE(bad < 0, "%s: a weight of vertex %td is not finite", call, bad / D->weight_count);
    return TUG_OK;
}

static int32_t count_atoms(const tug_dictionary *D)
{
    return D->weight_count * (1 + D->shape_count * D->dimension);
}

tug_status tug_reduce_dictionary(const tug_dictionary *D, int32_t wanted, tug_progress progress,
                                 void *user, int32_t *atoms)
{
    REQUIRE(D != NULL, "tug_reduce_dictionary: dictionary is NULL");
    REQUIRE_POINTER("tug_reduce_dictionary", atoms);
    tug_status status = check_dictionary(D, "tug_reduce_dictionary");
    if (status != TUG_OK) {
        return status;
    }
    int32_t least = D->weight_count, all = count_atoms(D);
    REQUIRE(wanted >= least && wanted <= all,
            "tug_reduce_dictionary: %d atoms are wanted of %d, and the %d weight functions stay",
            wanted, all, least);
    progress_range range = whole_range(progress, user);
    return reduce_dictionary(D, wanted, &range, atoms);
}

static tug_status check_atoms(const tug_dictionary *D, const int32_t *atoms, int32_t count)
{
    int32_t weights = 0, block = 1 + D->shape_count * D->dimension;
    for (int32_t i = 0; i < count; i++) {
        REQUIRE(atoms[i] >= 0 && atoms[i] < count_atoms(D),
                "tug_fit_dictionary: there is no atom %d", atoms[i]);
        REQUIRE(i == 0 || atoms[i] > atoms[i - 1],
                "tug_fit_dictionary: the atoms do not rise: %d comes after %d", atoms[i],
                atoms[i - 1]);
        weights += atoms[i] % block == 0;
    }
    REQUIRE(weights == D->weight_count,
            "tug_fit_dictionary: %d of the %d weight functions are not among the atoms",
            D->weight_count - weights, D->weight_count);
    return TUG_OK;
}

tug_status tug_fit_dictionary(const tug_dictionary *D, const int32_t *atoms, int32_t atom_count,
                              const double *positions, tug_progress progress, void *user,
                              double *transforms, double *fitted)
{
    REQUIRE(D != NULL, "tug_fit_dictionary: dictionary is NULL");
    REQUIRE_POINTER("tug_fit_dictionary", positions);
    REQUIRE(atoms != NULL || atom_count == 0, "tug_fit_dictionary: atoms is NULL");
    tug_status status = check_dictionary(D, "tug_fit_dictionary");
    if (status == TUG_OK && atoms != NULL) {
        status = check_atoms(D, atoms, atom_count);
    }
    if (status != TUG_OK) {
        return status;
    }
    size_t k = (size_t)D->dimension;
    ptrdiff_t bad = find_not_finite(positions, (size_t)D->vertex_count * k);
    REQUIRE(bad < 0, "tug_fit_dictionary: position %zu is not finite", (size_t)bad / k);
    progress_range range = whole_range(progress, user);
    return fit_dictionary(D, atoms, atom_count, positions, &range, transforms, fitted);
}

static tug_status check_rows(const char *call, const tug_rows *rows, int32_t vertex_count)
{
    REQUIRE(rows->starts != NULL, "%s: rows->starts is NULL", call);
    REQUIRE(rows->vertices != NULL, "%s: rows->vertices is NULL", call);
    REQUIRE(rows->values != NULL, "%s: rows->values is NULL", call);
    REQUIRE(rows->count > 0, "%s: there are no constraint rows", call);
    REQUIRE(rows->starts[0] == 0, "%s: the rows' starts begin with %d, not 0", call,
            rows->starts[0]);
    for (int32_t r = 0; r < rows->count; r++) {
        REQUIRE(rows->starts[r + 1] > rows->starts[r], "%s: row %d is empty", call, r);
        for (int32_t i = rows->starts[r]; i < rows->starts[r + 1]; i++) {
            REQUIRE(rows->vertices[i] >= 0 && rows->vertices[i] < vertex_count,
                    "%s: row %d names vertex %d of %d", call, r, rows->vertices[i], vertex_count);
            REQUIRE(isfinite(rows->values[i]), "%s: row %d has a value that is not finite", call,
                    r);
        }
    }
    return TUG_OK;
}

static tug_status check_groups(const int32_t *groups, int32_t triangle_count, int32_t group_count)
{
    int32_t next = 0; /* groups are checked one by one: every number has to be used */
    for (int32_t g = 0; g < group_count; g++, next = 0) {
        while (next < triangle_count && groups[next] != g) {
            next++;
        }
        REQUIRE(next < triangle_count, "tug_create_model: no triangle is in group %d of %d", g,
                group_count);
    }
    for (int32_t t = 0; t < triangle_count; t++) {
        REQUIRE(groups[t] >= 0 && groups[t] < group_count,
                "tug_create_model: triangle %d is in group %d of %d", t, groups[t], group_count);
    }
    return TUG_OK;
}

static tug_status check_values(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                               const double *weights, int32_t weight_count)
{
    size_t n = (size_t)mesh->vertex_count, k = (size_t)mesh->dimension;
    ptrdiff_t bad = find_not_finite(shapes, (size_t)shape_count * n * k);
    REQUIRE(bad < 0,
            "tug_create_model: vertex %zu of shape %zu has a coordinate that is not finite",
            (size_t)bad / k % n, (size_t)bad / k / n);
    bad = find_not_finite(weights, n * (size_t)weight_count);
    REQUIRE(bad < 0, "tug_create_model: a weight of vertex %td is not finite", bad / weight_count);
    return TUG_OK;
}

static tug_status check_stiffness(const double *stiffness, int32_t triangle_count)
{
    for (int32_t t = 0; t < triangle_count; t++) {
        REQUIRE(stiffness[t] > 0.0 && isfinite(stiffness[t]),
                "tug_create_model: the stiffness of triangle %d is %g: it must be above zero", t,
                stiffness[t]);
    }
    return TUG_OK;
}

tug_status tug_find_rotations(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                              const int32_t *groups, int32_t group_count, const double *positions,
                              double *rotations)
{
    REQUIRE_POINTER("tug_find_rotations", mesh);
    REQUIRE_POINTER("tug_find_rotations", shapes);
    REQUIRE_POINTER("tug_find_rotations", groups);
    REQUIRE_POINTER("tug_find_rotations", positions);
    REQUIRE_POINTER("tug_find_rotations", rotations);
    REQUIRE(shape_count > 0, "tug_find_rotations: there are no shapes");
    REQUIRE(group_count > 0, "tug_find_rotations: there are no edge groups");
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        REQUIRE(groups[t] >= 0 && groups[t] < group_count,
                "tug_find_rotations: triangle %d is in group %d of %d", t, groups[t], group_count);
    }
    size_t count = (size_t)mesh->vertex_count * (size_t)mesh->dimension;
    ptrdiff_t bad = find_not_finite(shapes, (size_t)shape_count * count);
    REQUIRE(bad < 0, "tug_find_rotations: coordinate %td of the shapes is not finite", bad);
    bad = find_not_finite(positions, count);
    REQUIRE(bad < 0, "tug_find_rotations: coordinate %td of the positions is not finite", bad);
    find_pose_rotations(mesh, shapes, shape_count, groups, group_count, positions, rotations);
    return TUG_OK;
}

tug_status tug_create_model(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                            const double *weights, int32_t weight_count, const tug_rows *rows,
                            const int32_t *groups, int32_t group_count, const double *stiffness,
                            double smoothness, tug_progress progress, void *user, tug_model **out)
{
    REQUIRE_POINTER("tug_create_model", out);
    *out = NULL;
    REQUIRE_POINTER("tug_create_model", mesh);
    REQUIRE_POINTER("tug_create_model", shapes);
    REQUIRE_POINTER("tug_create_model", weights);
    REQUIRE_POINTER("tug_create_model", rows);
    REQUIRE_POINTER("tug_create_model", groups);
    REQUIRE(shape_count > 0, "tug_create_model: there are no shapes");
    REQUIRE(weight_count > 0, "tug_create_model: there are no weight functions");
    REQUIRE(group_count > 0, "tug_create_model: there are no edge groups");
    REQUIRE(smoothness >= 0.0 && isfinite(smoothness),
            "tug_create_model: the smoothness is %g: it cannot be negative", smoothness);
    tug_status status = check_rows("tug_create_model", rows, mesh->vertex_count);
    if (status == TUG_OK) {
        status = check_groups(groups, mesh->triangle_count, group_count);
    }
    if (status == TUG_OK) {
        status = check_values(mesh, shapes, shape_count, weights, weight_count);
    }
    if (status == TUG_OK && stiffness != NULL) {
        status = check_stiffness(stiffness, mesh->triangle_count);
    }
    if (status != TUG_OK) {
        return status;
    }
    progress_range range = whole_range(progress, user);
    return model_create(mesh, shapes, shape_count, weights, weight_count, rows, groups, group_count,
                        stiffness, smoothness, &range, out);
}

/* Beyond these a factor would lose the rows, or the surface. */
static const double SOFTEST_ROW = 1e-6, FIRMEST_ROW = 1e3;

tug_status tug_change_rows(const tug_model *model, const tug_rows *rows, const double *firmness,
                           tug_model **out)
{
    REQUIRE_POINTER("tug_change_rows", out);
    *out = NULL;
    REQUIRE_POINTER("tug_change_rows", model);
    REQUIRE_POINTER("tug_change_rows", rows);
    tug_status status = check_rows("tug_change_rows", rows, model->header.vertices);
    if (status != TUG_OK) {
        return status;
    }
    for (int32_t r = 0; r < rows->count && firmness != NULL; r++) {
        REQUIRE(firmness[r] >= SOFTEST_ROW && firmness[r] <= FIRMEST_ROW,
                "tug_change_rows: the firmness of row %d is %g: it must be from %g to %g", r,
                firmness[r], SOFTEST_ROW, FIRMEST_ROW);
    }
    return model_change_rows(model, rows, firmness, out);
}

void tug_destroy_model(tug_model *model)
{
    model_destroy(model);
}

tug_status tug_get_model_sizes(const tug_model *model, tug_model_sizes *sizes)
{
    REQUIRE_POINTER("tug_get_model_sizes", model);
    REQUIRE_POINTER("tug_get_model_sizes", sizes);
    REQUIRE_SIZE("tug_get_model_sizes", sizes);
    const model_header *header = &model->header;
    *sizes = (tug_model_sizes){
        .struct_size = sizeof *sizes,
        .vertices = header->vertices,
        .dimension = header->dimension,
        .shapes = header->shapes,
        .weights = header->weights,
        .rows = header->rows,
        .groups = header->groups,
        .unknowns = model->energy.unknowns,
        .rank = *model->energy.rank,
    };
    return TUG_OK;
}

size_t tug_model_blob_size(const tug_model *model)
{
    return model != NULL ? model_blob_size(model) : 0;
}

tug_status tug_save_model(const tug_model *model, void *blob, size_t size)
{
    REQUIRE_POINTER("tug_save_model", model);
    REQUIRE_POINTER("tug_save_model", blob);
    return model_save(model, blob, size);
}

tug_status tug_load_model(const void *blob, size_t size, tug_model **out)
{
    REQUIRE_POINTER("tug_load_model", out);
    *out = NULL;
    REQUIRE_POINTER("tug_load_model", blob);
    return model_load(blob, size, out);
}
