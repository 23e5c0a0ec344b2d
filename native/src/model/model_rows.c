/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a model has of its constraint rows, and models that differ in them alone. */
#include "model/model_build.h"

#include "memory.h"

#include <math.h>
#include <string.h>

/* A row's values of the weight functions, and of the columns and the shapes. */
static void find_row(tug_model *model, const tug_rows *rows, int32_t r, double *weights)
{
    const dictionary *D = &model->dictionary;
    size_t b = (size_t)model->energy.unknowns, k = (size_t)D->dimension, n = (size_t)D->vertices;
    memset(weights, 0, (size_t)D->weights * sizeof *weights);
    for (int32_t e = rows->starts[r]; e < rows->starts[r + 1]; e++) {
        int32_t v = rows->vertices[e];
        add_dictionary_row(D, v, rows->values[e], model->energy.X + (size_t)r * b);
        for (size_t h = 0; h < (size_t)D->weights; h++) {
            weights[h] += rows->values[e] * D->weight_columns[h * n + (size_t)v];
        }
        for (size_t c = 0; c < (size_t)D->shapes * k; c++) {
            model->shape[c / k].rows[(size_t)r * k + c % k] +=
                rows->values[e] * D->shape_columns[c * n + (size_t)v];
        }
    }
}

/* How much a row says about a group: inverse to their squared distance as the weights measure it,
 * floored so that no single row decides. */
static double find_nearness(const tug_model *model, int32_t g, const double *weights)
{
    const double *mean = model->group_weights + g * model->header.weights;
    double distance = 0.0, scale = 0.0;
    for (int32_t h = 0; h < model->header.weights; h++) {
        distance += (weights[h] - mean[h]) * (weights[h] - mean[h]);
        scale += weights[h] * weights[h];
    }
    return 1.0 / (distance + 0.1 * scale + 1e-12);
}

tug_status find_rows(tug_model *model, const tug_rows *rows)
{
    double *weights = allocate((size_t)model->header.weights, sizeof *weights);
    if (weights == NULL) {
        return fail_memory();
    }
    for (int32_t r = 0; r < rows->count; r++) {
        find_row(model, rows, r, weights);
        for (int32_t g = 0; g < model->header.groups; g++) {
            model->nearness[g * rows->count + r] = find_nearness(model, g, weights);
        }
    }
    release(weights);
    return TUG_OK;
}

void place_stiffness(tug_model *model)
{
    int32_t k = model->header.dimension, S = model->header.shapes, p = S * k;
    for (int32_t g = 0; g < model->header.groups; g++) {
        const double *H = model->H + (size_t)g * (size_t)(p * p);
        write_block(&model->energy, g, g, H);
        for (int32_t s = 0; s < S; s++) {
            double own[9];
            for (int32_t i = 0; i < k * k; i++) {
                own[i] = H[(s * k + i / k) * p + s * k + i % k];
            }
            write_block(&model->shape[s].energy, g, g, own);
        }
    }
}

static void copy(const double *from, size_t count, double *to)
{
    memcpy(to, from, count * sizeof *to);
}

/* All that does not depend on the rows. */
static void copy_surface(const tug_model *from, tug_model *to)
{
    size_t n = (size_t)from->header.vertices, k = (size_t)from->header.dimension;
    size_t S = (size_t)from->header.shapes, m = (size_t)from->header.weights;
    size_t G = (size_t)from->header.groups, seen = (size_t)from->header.seen, forms = 0;
    for (int32_t g = 0; g < from->header.groups; g++) {
        size_t columns = (size_t)group_columns(&from->shape->energy, g);
        forms += columns * columns;
    }
    copy(from->shape_columns, S * k * n, to->shape_columns);
    copy(from->weight_columns, m * n, to->weight_columns);
    copy(from->middles, m * S * k, to->middles);
    copy(from->constant, m, to->constant);
    copy(from->smoothness, m * m, to->smoothness);
    copy(from->energy.K, seen * (1 + S * k) * S * k, to->energy.K);
    copy(from->align, G * S * k * k, to->align);
    copy(from->H, G * S * k * S * k, to->H);
    copy(from->stiffness, G, to->stiffness);
    copy(from->group_weights, G * m, to->group_weights);
    for (size_t s = 0; s < S; s++) {
        copy(from->shape[s].energy.K, seen * (1 + k) * k, to->shape[s].energy.K);
        copy(from->shape[s].L, forms, to->shape[s].L);
    }
}

/* Unknowns that depended on others are not in the form that is restored: they leave the rows too.
 */
static void leave_out_dependent(const reduction *from, reduction *to)
{
    for (int32_t i = *from->rank; i < from->unknowns; i++) {
        for (int32_t r = 0; r < to->rows; r++) {
            to->X[(size_t)r * (size_t)to->unknowns + (size_t)from->pivots[i]] = 0.0;
        }
    }
}

static tug_status eliminate_anew(const tug_model *from, tug_model *to)
{
    size_t b = (size_t)to->energy.unknowns;
    const progress_range silent = {NULL, NULL, 0.0, 1.0};
    double *L = allocate(b * b, sizeof *L);
    tug_status status = L != NULL ? eliminate_shapes(to, &silent) : fail_memory();
    if (status == TUG_OK) {
        status = restore_form(&from->energy, L);
    }
    if (status == TUG_OK) {
        leave_out_dependent(&from->energy, &to->energy);
        status = factor_transforms(L, &to->energy);
    }
    release(L);
    if (status == TUG_OK) {
        status = eliminate_joint(to, &silent);
    }
    return status == TUG_OK ? require_finite(to) : status;
}

tug_status model_change_rows(const tug_model *from, const tug_rows *rows, const double *firmness,
                             tug_model **out)
{
    model_header header = from->header;
    header.rows = rows->count;
    header.soft = firmness != NULL;
    tug_model *model;
    tug_status status = model_allocate(&header, &from->support, &model);
    if (status != TUG_OK) {
        return status;
    }
    copy_surface(from, model);
    if (firmness != NULL) {
        copy(firmness, (size_t)rows->count, model->firmness);
    }
    place_stiffness(model);
    status = find_rows(model, rows);
    if (status == TUG_OK) {
        status = eliminate_anew(from, model);
    }
    if (status != TUG_OK) {
        model_destroy(model);
        return status;
    }
    *out = model;
    return TUG_OK;
}
