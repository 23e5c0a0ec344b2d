/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/model.h"

#include "memory.h"
#include "sparse/factor.h"

#include <math.h>
#include <string.h>

/* Hands out consecutive parts of the blocks, or only counts them where there are none yet. */
typedef struct cursor {
    double *data;
    int32_t *indices;
    size_t used, indices_used;
} cursor;

static double *take(cursor *at, size_t count)
{
    double *part = at->data != NULL ? at->data + at->used : NULL;
    at->used += count;
    return part;
}

static int32_t *take_indices(cursor *at, size_t count)
{
    int32_t *part = at->indices != NULL ? at->indices + at->indices_used : NULL;
    at->indices_used += count;
    return part;
}

/* shapes: of the blocks of C, or 0 for the square one of a single shape. */
static void lay_out_reduction(cursor *at, const tug_model *model, int32_t shapes, reduction *r)
{
    const model_header *header = &model->header;
    int32_t k = header->dimension, together = shapes > 0 ? shapes : 1;
    *r = (reduction){
        .support = &model->support,
        .groups = header->groups,
        .group_rows = together * k,
        .turned = header->groups * together * k,
        .rows = header->rows,
        .unknowns = header->weights * (1 + together * k),
        .block = 1 + together * k,
        .shapes = shapes,
    };
    size_t h = (size_t)r->rows, b = (size_t)r->unknowns, turned = (size_t)r->turned;
    r->rank = take_indices(at, 1);
    r->pivots = take_indices(at, b);
    r->scale = take(at, b);
    r->factor = take(at, factor_size(r->unknowns));
    r->K = take(at, (size_t)header->seen * (size_t)(r->block * r->group_rows));
    r->X = take(at, h * b);
    r->firmness = header->soft ? model->firmness : NULL;
    r->C = take(at, coupling_size(r));
    r->KF = take(at, turned * h);
    r->FLF = take(at, h * h);
    r->F = take(at, h * b);
}

/* Doubles of the forms of one shape, and where each group's begins. */
static size_t lay_out_forms(tug_model *model)
{
    size_t used = 0;
    for (int32_t g = 0; g < model->header.groups; g++) {
        size_t columns =
            (size_t)(support_count(&model->support, g) * (1 + model->header.dimension));
        model->form_offsets[g] = used;
        used += columns * columns;
    }
    return used;
}

static cursor lay_out(tug_model *model, double *data, int32_t *indices)
{
    const model_header *header = &model->header;
    size_t n = (size_t)header->vertices, k = (size_t)header->dimension;
    size_t S = (size_t)header->shapes, m = (size_t)header->weights;
    size_t h = (size_t)header->rows, G = (size_t)header->groups, forms = lay_out_forms(model);
    cursor at = {data, indices, 0, 0};
    take_indices(&at, G + 1 + (size_t)header->seen); /* the support */
    model->shape_columns = take(&at, S * k * n);
    model->weight_columns = take(&at, m * n);
    model->middles = take(&at, m * S * k);
    model->constant = take(&at, m);
    model->smoothness = take(&at, m * m);
    model->firmness = take(&at, h);
    lay_out_reduction(&at, model, header->shapes, &model->energy);
    model->align = take(&at, G * S * k * k);
    model->H = take(&at, G * S * k * S * k);
    model->stiffness = take(&at, G);
    model->nearness = take(&at, G * h);
    model->group_weights = take(&at, G * m);
    for (size_t s = 0; s < S; s++) {
        shape_model *shape = model->shape + s;
        lay_out_reduction(&at, model, 0, &shape->energy);
        shape->L = take(&at, forms);
        shape->rows = take(&at, h * k);
    }
    model->dictionary = (dictionary){
        .vertices = header->vertices,
        .dimension = header->dimension,
        .shapes = header->shapes,
        .weights = header->weights,
        .shape_columns = model->shape_columns,
        .weight_columns = model->weight_columns,
        .middles = model->middles,
    };
    at.indices_used += at.indices_used % 2; /* keeps what follows aligned to doubles */
    return at;
}

void model_destroy(tug_model *model)
{
    if (model != NULL) {
        release(model->data);
        release(model->indices);
        release(model->form_offsets);
        release(model->shape);
        release(model);
    }
}

static void copy_support(tug_model *model, const support *seen)
{
    size_t starts = (size_t)model->header.groups + 1;
    model->support = (support){model->indices, model->indices + starts};
    memcpy(model->support.starts, seen->starts, starts * sizeof *seen->starts);
    memcpy(model->support.functions, seen->functions,
           (size_t)model->header.seen * sizeof *seen->functions);
}

tug_status model_allocate(const model_header *header, const support *seen, tug_model **out)
{
    tug_model *model = allocate(1, sizeof *model);
    if (model == NULL) {
        return fail_memory();
    }
    model->header = *header;
    model->support = *seen;
    model->shape = allocate((size_t)header->shapes, sizeof *model->shape);
    model->form_offsets = allocate((size_t)header->groups, sizeof *model->form_offsets);
    if (model->shape != NULL && model->form_offsets != NULL) {
        cursor end = lay_out(model, NULL, NULL);
        model->index_count = end.indices_used;
        model->data_count = end.used;
        model->indices = allocate(end.indices_used, sizeof *model->indices);
        model->data = allocate(end.used, sizeof *model->data);
    }
    if (model->data == NULL || model->indices == NULL) {
        model_destroy(model);
        return fail_memory();
    }
    copy_support(model, seen);
    lay_out(model, model->data, model->indices);
    *out = model;
    return TUG_OK;
}

int32_t nearest_group(const tug_model *model, int32_t row)
{
    const double *near = model->nearness + row;
    int32_t rows = model->header.rows, nearest = 0;
    for (int32_t g = 1; g < model->header.groups; g++) {
        nearest = near[g * rows] > near[nearest * rows] ? g : nearest;
    }
    return nearest;
}

double stiffness_share(const tug_model *model, int32_t group)
{
    double sum = 0.0;
    for (int32_t g = 0; g < model->header.groups; g++) {
        sum += model->stiffness[g];
    }
    return model->stiffness[group] / sum;
}

tug_status require_finite(const tug_model *model)
{
    for (size_t i = 0; i < model->data_count; i++) {
        if (!isfinite(model->data[i])) {
            return fail(TUG_ERROR_NUMERIC, "the model is not finite: look for coordinates or "
                                           "weights that are not numbers");
        }
    }
    return TUG_OK;
}
