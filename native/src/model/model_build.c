/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From mesh, shapes, weights, rows and groups to the constants of a model. */
#include "model/model_build.h"

#include "dense/dense.h"
#include "memory.h"
#include "model/smoothness.h"

/* The constant function as a combination of the weights, by least squares. */
static tug_status find_constant(tug_model *model)
{
    int32_t m = model->header.weights, n = model->header.vertices;
    double *products = allocate((size_t)m * (size_t)m, sizeof *products);
    if (products == NULL) {
        return fail_memory();
    }
    const double *W = model->weight_columns;
    add_product_nt(m, m, n, 1.0, W, n, W, n, products, m);
    for (int32_t h = 0; h < m; h++) {
        model->constant[h] = 0.0;
        for (int32_t i = 0; i < n; i++) {
            model->constant[h] += W[(size_t)h * (size_t)n + (size_t)i];
        }
    }
    int definite = cholesky_factor(products, m);
    if (definite) {
        cholesky_solve(products, m, model->constant, 1);
    }
    release(products);
    return definite ? TUG_OK
                    : fail(TUG_ERROR_ARGUMENT,
                           "tug_create_model: the weight functions depend on each other");
}

/* The groups' constants, and the factor of their sum; the sum is the largest thing beside C. */
static tug_status measure(tug_model *model, const tug_mesh *mesh, const int32_t *groups,
                          const tug_rows *rows, const double *stiffness,
                          const progress_range *range)
{
    size_t b = (size_t)model->energy.unknowns;
    progress_range first = progress_part(range, 0.0, 0.7), second = progress_part(range, 0.7, 1.0);
    double *L = allocate(b * b, sizeof *L);
    tug_status status = L != NULL ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        status = find_group_constants(model, mesh, groups, stiffness, &first, L);
    }
    if (status == TUG_OK) {
        add_smoothness(&model->dictionary, model->smoothness, 0,
                       model->header.shapes * model->header.dimension, L);
        place_stiffness(model);
        status = find_rows(model, rows);
    }
    if (status == TUG_OK) {
        status = report(&second, "solving for transforms", 0.0);
    }
    if (status == TUG_OK) {
        status = factor_transforms(L, &model->energy);
    }
    release(L);
    return status;
}

static tug_status build_model(tug_model *model, const tug_mesh *mesh, const int32_t *groups,
                              const tug_rows *rows, const double *stiffness, double smoothness,
                              const progress_range *range)
{
    const progress_range parts[] = {progress_part(range, 0.0, 0.5), progress_part(range, 0.5, 0.6),
                                    progress_part(range, 0.6, 1.0)};
    find_middles(&model->dictionary, mesh->mass, model->middles);
    tug_status status = find_constant(model);
    if (status == TUG_OK) {
        status = find_smoothness(mesh, &model->dictionary, smoothness, model->smoothness);
    }
    if (status == TUG_OK) {
        status = measure(model, mesh, groups, rows, stiffness, parts);
    }
    if (status == TUG_OK) {
        status = eliminate_shapes(model, parts + 1);
    }
    if (status == TUG_OK) {
        status = eliminate_joint(model, parts + 2);
    }
    return status == TUG_OK ? require_finite(model) : status;
}

/* A model with its support, all else zero. weights: #V by #W. */
static tug_status open_model(model_header *header, const tug_mesh *mesh, const double *shapes,
                             const double *weights, const int32_t *groups, tug_model **out)
{
    support seen;
    tug_status status =
        support_create(mesh, weights, header->weights, groups, header->groups, &seen);
    if (status != TUG_OK) {
        return status;
    }
    header->seen = seen.starts[header->groups];
    status = model_allocate(header, &seen, out);
    support_destroy(&seen);
    if (status == TUG_OK) {
        const dictionary *D = &(*out)->dictionary;
        store_shape_columns(D, shapes, header->unit, (*out)->shape_columns, NULL);
        store_weight_columns(D, weights, (*out)->weight_columns);
    }
    return status;
}

tug_status model_create(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                        const double *weights, int32_t weight_count, const tug_rows *rows,
                        const int32_t *groups, int32_t group_count, const double *stiffness,
                        double smoothness, const progress_range *range, tug_model **out)
{
    tug_status status = require_sound_mesh(mesh);
    if (status != TUG_OK) {
        return status;
    }
    use_one_blas_thread();
    model_header header = {
        .vertices = mesh->vertex_count,
        .dimension = mesh->dimension,
        .shapes = shape_count,
        .weights = weight_count,
        .rows = rows->count,
        .groups = group_count,
        .unit = bounding_diagonal(shapes, mesh->vertex_count, mesh->dimension),
    };
    if (!(header.unit > 0.0)) {
        return fail(TUG_ERROR_ARGUMENT,
                    "tug_create_model: all vertices of shape 0 are in one place");
    }
    tug_model *model = NULL;
    status = open_model(&header, mesh, shapes, weights, groups, &model);
    if (status == TUG_OK) {
        status = build_model(model, mesh, groups, rows, stiffness, smoothness, range);
    }
    if (status != TUG_OK) {
        model_destroy(model);
        return status;
    }
    *out = model;
    return TUG_OK;
}
