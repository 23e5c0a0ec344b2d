/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model.h"

#include "memory.h"

/* Hands out consecutive parts of a block, or only counts them where there is no block yet. */
typedef struct cursor {
    double *data;
    size_t used;
} cursor;

static double *take(cursor *at, size_t count)
{
    double *part = at->data != NULL ? at->data + at->used : NULL;
    at->used += count;
    return part;
}

static void lay_out_reduction(cursor *at, reduction *r, size_t turned, size_t rows, size_t unknowns)
{
    r->turned = (int32_t)turned;
    r->rows = (int32_t)rows;
    r->unknowns = (int32_t)unknowns;
    r->C = take(at, turned * turned);
    r->KF = take(at, turned * rows);
    r->FLF = take(at, rows * rows);
    r->ZK = take(at, turned * unknowns);
    r->F = take(at, rows * unknowns);
}

static size_t lay_out(tug_model *model, double *data)
{
    const model_header *header = &model->header;
    size_t n = (size_t)header->vertices, k = (size_t)header->dimension;
    size_t S = (size_t)header->shapes, m = (size_t)header->weights;
    size_t h = (size_t)header->rows, G = (size_t)header->groups;
    cursor at = {data, 0};
    model->shape_columns = take(&at, S * k * n);
    model->weight_columns = take(&at, m * n);
    model->middles = take(&at, m * S * k);
    model->constant = take(&at, m);
    lay_out_reduction(&at, &model->energy, G * S * k, h, m * (1 + S * k));
    model->align = take(&at, G * S * k * k);
    model->H = take(&at, G * S * k * S * k);
    model->stiffness = take(&at, G);
    model->nearness = take(&at, G * h);
    for (size_t s = 0; s < S; s++) {
        shape_model *shape = model->shape + s;
        size_t b = m * (1 + k);
        lay_out_reduction(&at, &shape->energy, G * k, h, b);
        shape->L = take(&at, G * b * b);
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
    return at.used;
}

void model_destroy(tug_model *model)
{
    if (model != NULL) {
        release(model->data);
        release(model->shape);
        release(model);
    }
}

tug_status model_allocate(const model_header *header, tug_model **out)
{
    tug_model *model = allocate(1, sizeof *model);
    if (model == NULL) {
        return fail_memory();
    }
    model->header = *header;
    model->shape = allocate((size_t)header->shapes, sizeof *model->shape);
    if (model->shape != NULL) {
        model->data_count = lay_out(model, NULL);
        model->data = allocate(model->data_count, sizeof *model->data);
    }
    if (model->data == NULL) {
        model_destroy(model);
        return fail_memory();
    }
    lay_out(model, model->data);
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
