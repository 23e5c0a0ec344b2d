/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/dictionary.h"

#include <math.h>
#include <stddef.h>

double bounding_diagonal(const double *points, int32_t count, int32_t k)
{
    double squares = 0.0;
    for (int32_t c = 0; c < k; c++) {
        double low = points[c], high = points[c];
        for (int32_t i = 1; i < count; i++) {
            low = fmin(low, points[(size_t)i * (size_t)k + (size_t)c]);
            high = fmax(high, points[(size_t)i * (size_t)k + (size_t)c]);
        }
        squares += (high - low) * (high - low);
    }
    return sqrt(squares);
}

void store_shape_columns(const dictionary *D, const double *shapes, double unit, double *columns,
                         double *means)
{
    size_t n = (size_t)D->vertices, k = (size_t)D->dimension;
    for (size_t c = 0; c < (size_t)D->shapes * k; c++) {
        const double *values = shapes + (c / k) * n * k + c % k;
        double mean = 0.0;
        for (size_t i = 0; i < n; i++) {
            mean += values[i * k] / (double)n;
        }
        for (size_t i = 0; i < n; i++) {
            columns[c * n + i] = (values[i * k] - mean) / unit;
        }
        if (means != NULL) {
            means[c] = mean;
        }
    }
}

void store_weight_columns(const dictionary *D, const double *weights, double *columns)
{
    size_t n = (size_t)D->vertices, m = (size_t)D->weights;
    for (size_t i = 0; i < n; i++) {
        for (size_t h = 0; h < m; h++) {
            columns[h * n + i] = weights[i * m + h];
        }
    }
}

/* The columns of weight function h. */
static void add_function(const dictionary *D, int32_t h, int32_t vertex, double factor,
                         double *block)
{
    int32_t coordinates = D->shapes * D->dimension;
    size_t n = (size_t)D->vertices, v = (size_t)vertex;
    double weight = factor * D->weight_columns[(size_t)h * n + v];
    if (weight == 0.0) {
        return;
    }
    const double *middle = D->middles + (size_t)h * (size_t)coordinates;
    block[0] += weight;
    for (int32_t c = 0; c < coordinates; c++) {
        block[1 + c] += weight * (D->shape_columns[(size_t)c * n + v] - middle[c]);
    }
}

void add_dictionary_row(const dictionary *D, int32_t vertex, double factor, double *row)
{
    for (int32_t h = 0; h < D->weights; h++) {
        add_function(D, h, vertex, factor, row + (size_t)h * (size_t)block_columns(D));
    }
}

void add_partial_row(const dictionary *D, const int32_t *functions, int32_t count, int32_t vertex,
                     double factor, double *row)
{
    for (int32_t i = 0; i < count; i++) {
        add_function(D, functions[i], vertex, factor, row + (size_t)i * (size_t)block_columns(D));
    }
}

static double weighted_mean(const double *values, const double *mass, const double *W,
                            int32_t count)
{
    double sum = 0.0, total = 0.0;
    for (int32_t i = 0; i < count; i++) {
        double share = mass[i] * W[i] * W[i];
        sum += share * values[i];
        total += share;
    }
    return total > 0.0 ? sum / total : 0.0;
}

void find_middles(const dictionary *D, const double *mass, double *middles)
{
    int32_t coordinates = D->shapes * D->dimension;
    size_t n = (size_t)D->vertices;
    for (int32_t h = 0; h < D->weights; h++) {
        const double *W = D->weight_columns + (size_t)h * n;
        for (int32_t c = 0; c < coordinates; c++) {
            middles[h * coordinates + c] =
                weighted_mean(D->shape_columns + (size_t)c * n, mass, W, D->vertices);
        }
    }
}
