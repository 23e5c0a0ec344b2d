/* SPDX-License-Identifier: GPL-3.0-or-later */
/* q = D T: the only part of a frame whose cost grows with the mesh. */
#include "solver.h"

#include <string.h>

enum { BLOCK = 64 }; /* vertices at a time: a block's columns stay in the first cache */

/* sum over c of column_c times T_c, for one weight function's block of columns, in one coordinate.
 */
static void blend_columns(const dictionary *D, const double *T, int32_t k, int32_t axis,
                          size_t start, int32_t count, const double *middle, double *sum)
{
    int32_t coordinates = D->shapes * k;
    size_t n = (size_t)D->vertices;
    double constant = T[axis];
    for (int32_t c = 0; c < coordinates; c++) {
        constant -= middle[c] * T[(1 + c) * k + axis];
    }
    for (int32_t i = 0; i < count; i++) {
        sum[i] = constant;
    }
    for (int32_t c = 0; c < coordinates; c++) {
        const double *column = D->shape_columns + (size_t)c * n + start;
        double factor = T[(1 + c) * k + axis];
        for (int32_t i = 0; i < count; i++) {
            sum[i] += factor * column[i];
        }
    }
}

static void find_block(const tug_solver *solver, size_t start, int32_t count, double *positions)
{
    const dictionary *D = &solver->model->dictionary;
    int32_t k = D->dimension, columns = block_columns(D);
    double unit = solver->model->header.unit;
    for (int32_t axis = 0; axis < k; axis++) {
        double total[BLOCK] = {0.0}, sum[BLOCK];
        for (int32_t h = 0; h < D->weights; h++) {
            const double *W = D->weight_columns + (size_t)h * (size_t)D->vertices + start;
            blend_columns(D, solver->T + (size_t)(h * columns * k), k, axis, start, count,
                          D->middles + (size_t)h * (size_t)(columns - 1), sum);
            for (int32_t i = 0; i < count; i++) {
                total[i] += W[i] * sum[i];
            }
        }
        for (int32_t i = 0; i < count; i++) {
            positions[i * k + axis] = solver->middle[axis] + unit * total[i];
        }
    }
}

void find_positions(const tug_solver *solver, double *positions)
{
    int32_t n = solver->model->header.vertices, k = solver->model->header.dimension;
    for (int32_t start = 0; start < n; start += BLOCK) {
        int32_t count = n - start < BLOCK ? n - start : BLOCK;
        find_block(solver, (size_t)start, count, positions + (size_t)start * (size_t)k);
    }
}
