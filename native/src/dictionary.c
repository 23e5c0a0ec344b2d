/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dictionary.h"

#include <stddef.h>

void add_dictionary_row(const dictionary *D, int32_t vertex, double factor, double *row)
{
    int32_t coordinates = D->shapes * D->dimension, columns = block_columns(D);
    size_t n = (size_t)D->vertices, v = (size_t)vertex;
    for (int32_t h = 0; h < D->weights; h++) {
        double weight = factor * D->weight_columns[(size_t)h * n + v];
        if (weight == 0.0) {
            continue;
        }
        double *block = row + (size_t)h * (size_t)columns;
        const double *middle = D->middles + (size_t)h * (size_t)coordinates;
        block[0] += weight;
        for (int32_t c = 0; c < coordinates; c++) {
            block[1 + c] += weight * (D->shape_columns[(size_t)c * n + v] - middle[c]);
        }
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
