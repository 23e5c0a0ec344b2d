/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dictionaries/dictionary_gram.h"

#include "dense/dense.h"
#include "memory.h"

#include <string.h>

enum { rows_at_a_time = 128 };

void own_dictionary_free(own_dictionary *own)
{
    release(own->shape_columns);
    release(own->weight_columns);
    release(own->middles);
    release(own->means);
    *own = (own_dictionary){0};
}

static int allocate_own(own_dictionary *own)
{
    const dictionary *D = &own->D;
    size_t n = (size_t)D->vertices, coordinates = (size_t)(D->shapes * D->dimension);
    size_t m = (size_t)D->weights;
    own->shape_columns = allocate(coordinates * n, sizeof(double));
    own->weight_columns = allocate(m * n, sizeof(double));
    own->middles = allocate(m * coordinates, sizeof(double));
    own->means = allocate(coordinates, sizeof(double));
    return own->shape_columns && own->weight_columns && own->middles && own->means;
}

tug_status own_dictionary_create(const tug_dictionary *given, own_dictionary *out)
{
    *out = (own_dictionary){.D = {.vertices = given->vertex_count,
                                  .dimension = given->dimension,
                                  .shapes = given->shape_count,
                                  .weights = given->weight_count}};
    out->unit = bounding_diagonal(given->shapes, given->vertex_count, given->dimension);
    double *ones = allocate((size_t)given->vertex_count, sizeof *ones);
    if (ones == NULL || !allocate_own(out)) {
        release(ones);
        own_dictionary_free(out);
        return fail_memory();
    }
    for (int32_t v = 0; v < given->vertex_count; v++) {
        ones[v] = 1.0;
    }
    store_shape_columns(&out->D, given->shapes, out->unit, out->shape_columns, out->means);
    store_weight_columns(&out->D, given->weights, out->weight_columns);
    out->D.shape_columns = out->shape_columns;
    out->D.weight_columns = out->weight_columns;
    find_middles(&out->D, ones, out->middles);
    out->D.middles = out->middles;
    release(ones);
    return TUG_OK;
}

tug_status visit_rows(const dictionary *D, row_visitor visit, void *context,
                      const progress_range *range, const char *stage)
{
    size_t b = (size_t)dictionary_columns(D);
    double *rows = allocate(rows_at_a_time * b, sizeof *rows);
    tug_status status = rows != NULL ? TUG_OK : fail_memory();
    for (int32_t first = 0; first < D->vertices && status == TUG_OK; first += rows_at_a_time) {
        int32_t left = D->vertices - first, count = left < rows_at_a_time ? left : rows_at_a_time;
        status = report(range, stage, (double)first / D->vertices);
        if (status == TUG_OK) {
            memset(rows, 0, rows_at_a_time * b * sizeof *rows);
            for (int32_t i = 0; i < count; i++) {
                add_dictionary_row(D, first + i, 1.0, rows + (size_t)i * b);
            }
            visit(context, first, count, rows);
        }
    }
    release(rows);
    return status;
}

typedef struct gram_sum {
    int32_t columns;
    double *gram;
} gram_sum;

static void add_to_gram(void *context, int32_t first, int32_t count, const double *rows)
{
    const gram_sum *sum = context;
    int32_t b = sum->columns;
    (void)first;
    add_product_tn(b, b, count, 1.0, rows, b, rows, b, sum->gram, b);
}

tug_status find_gram(const dictionary *D, const progress_range *range, double *gram)
{
    gram_sum sum = {dictionary_columns(D), gram};
    memset(gram, 0, (size_t)sum.columns * (size_t)sum.columns * sizeof *gram);
    use_one_blas_thread();
    return visit_rows(D, add_to_gram, &sum, range, "measuring the dictionary");
}
