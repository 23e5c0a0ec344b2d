/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The transforms of a model eliminated: of every shape alone, and of all together. */
#include "model/model_build.h"

#include "memory.h"
#include "model/null_space.h"
#include "model/smoothness.h"

#include <string.h>

/* Columns of shape s in (V, Y): the example itself, V_gs = Q_gs and Y its own rows. */
static void store_example(const tug_model *model, int32_t s, int32_t block, int32_t first,
                          double *N, int32_t columns, int32_t column)
{
    int32_t k = model->header.dimension, S = model->header.shapes, G = model->header.groups;
    for (int32_t g = 0; g < G; g++) {
        const double *Q = model->align + (g * S + s) * k * k;
        for (int32_t i = 0; i < k * k; i++) {
            int32_t row = g * block + first + i / k;
            N[(size_t)row * (size_t)columns + (size_t)(column + i % k)] = Q[i];
        }
    }
    for (int32_t i = 0; i < model->header.rows * k; i++) {
        size_t row = (size_t)(G * block + i / k);
        N[row * (size_t)columns + (size_t)(column + i % k)] = model->shape[s].rows[i];
    }
}

static void store_translation(const reduction *energy, double *N, int32_t columns)
{
    for (int32_t r = 0; r < energy->rows; r++) {
        N[(size_t)(energy->turned + r + 1) * (size_t)columns - 1] = 1.0;
    }
}

/* Shapes first to last of the joint energy, or one shape of its own. */
static tug_status restore_examples(const tug_model *model, reduction *energy, int32_t first,
                                   int32_t last)
{
    int32_t k = model->header.dimension, block = (last - first + 1) * k, columns = block + 1;
    double *N = allocate((size_t)(energy->turned + energy->rows) * (size_t)columns, sizeof *N);
    if (N == NULL) {
        return fail_memory();
    }
    for (int32_t s = first; s <= last; s++) {
        store_example(model, s, block, (s - first) * k, N, columns, (s - first) * k);
    }
    store_translation(energy, N, columns);
    tug_status status = restore_null_space(energy, N, columns);
    release(N);
    return status;
}

/* The groups' forms together, the lower triangle. */
static void sum_forms(const tug_model *model, const shape_model *shape, double *L)
{
    size_t b = (size_t)shape->energy.unknowns, block = (size_t)shape->energy.block;
    memset(L, 0, b * b * sizeof *L);
    for (int32_t g = 0; g < model->header.groups; g++) {
        const double *form = group_form(model, shape, g);
        const int32_t *functions = support_of(&model->support, g);
        size_t columns = (size_t)group_columns(&shape->energy, g);
        for (size_t i = 0; i < columns; i++) {
            size_t column = (size_t)functions[i / block] * block + i % block;
            for (size_t j = 0; j <= i; j++) {
                L[column * b + (size_t)functions[j / block] * block + j % block] +=
                    form[i * columns + j];
            }
        }
    }
}

static tug_status eliminate_shape(tug_model *model, int32_t s, double *L)
{
    const model_header *header = &model->header;
    reduction *energy = &model->shape[s].energy;
    progress_range silent = {NULL, NULL, 0.0, 1.0};
    sum_forms(model, model->shape + s, L);
    add_smoothness(&model->dictionary, model->smoothness, s * header->dimension, header->dimension,
                   L);
    for (int32_t r = 0; r < header->rows; r++) {
        const double *row = model->energy.X + (size_t)r * (size_t)model->energy.unknowns;
        for (int32_t j = 0; j < energy->unknowns; j++) {
            energy->X[r * energy->unknowns + j] = row[joint_column(header, s, j)];
        }
    }
    tug_status status = factor_transforms(L, energy);
    if (status == TUG_OK) {
        status = eliminate_transforms(energy, &silent);
    }
    return status == TUG_OK ? restore_examples(model, energy, s, s) : status;
}

tug_status eliminate_shapes(tug_model *model, const progress_range *range)
{
    size_t b = (size_t)model->shape->energy.unknowns;
    double *L = allocate(b * b, sizeof *L);
    tug_status status = L != NULL ? TUG_OK : fail_memory();
    for (int32_t s = 0; s < model->header.shapes && status == TUG_OK; s++) {
        status = report(range, "solving for transforms", (double)s / model->header.shapes);
        if (status == TUG_OK) {
            status = eliminate_shape(model, s, L);
        }
    }
    release(L);
    return status;
}

tug_status eliminate_joint(tug_model *model, const progress_range *range)
{
    tug_status status = eliminate_transforms(&model->energy, range);
    return status == TUG_OK ? restore_examples(model, &model->energy, 0, model->header.shapes - 1)
                            : status;
}
