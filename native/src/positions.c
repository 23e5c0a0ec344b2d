/* SPDX-License-Identifier: GPL-3.0-or-later */
/* q = D T: the only part of a frame whose cost grows with the mesh. */
#include "dispatch.h"
#include "solver.h"

#include <string.h>

enum { LANES = 8 }; /* vertices at a time: their sums stay in registers */

/* Positions of `lanes` vertices from `start` on. Called with constants for k and lanes, so that the
 * compiler unrolls over both. */
static inline __attribute__((always_inline)) void
find_lanes(const tug_solver *solver, int32_t k, int32_t lanes, size_t start, double *positions)
{
    const dictionary *D = &solver->model->dictionary;
    size_t n = (size_t)D->vertices;
    int32_t coordinates = D->shapes * k;
    const double *T = solver->placed_T;
    double total[3][LANES];
    memset(total, 0, sizeof total);
    for (int32_t h = 0; h < D->weights; h++, T += (1 + coordinates) * k) {
        const double *column = D->shape_columns + start, *factor = T + k;
        double sum[3][LANES];
        for (int32_t axis = 0; axis < k; axis++) {
            for (int32_t i = 0; i < lanes; i++) {
                sum[axis][i] = T[axis];
            }
        }
        for (int32_t c = 0; c < coordinates; c++, column += n, factor += k) {
            for (int32_t axis = 0; axis < k; axis++) {
                for (int32_t i = 0; i < lanes; i++) {
                    sum[axis][i] += factor[axis] * column[i];
                }
            }
        }
        const double *W = D->weight_columns + (size_t)h * n + start;
        for (int32_t axis = 0; axis < k; axis++) {
            for (int32_t i = 0; i < lanes; i++) {
                total[axis][i] += W[i] * sum[axis][i];
            }
        }
    }
    for (int32_t i = 0; i < lanes; i++) {
        for (int32_t axis = 0; axis < k; axis++) {
            positions[i * k + axis] =
                solver->middle[axis] + solver->model->header.unit * total[axis][i];
        }
    }
}

void place_transforms(const dictionary *D, const double *T, double *placed)
{
    int32_t k = D->dimension, coordinates = D->shapes * k, block = (1 + coordinates) * k;
    memcpy(placed, T, (size_t)(D->weights * block) * sizeof *T);
    for (int32_t h = 0; h < D->weights; h++, placed += block) {
        for (int32_t c = 0; c < coordinates; c++) {
            double middle = D->middles[h * coordinates + c];
            for (int32_t axis = 0; axis < k; axis++) {
                placed[axis] -= middle * placed[(1 + c) * k + axis];
            }
        }
    }
}

DISPATCHED void find_positions(const tug_solver *solver, double *positions)
{
    size_t n = (size_t)solver->model->header.vertices, start = 0;
    int32_t k = solver->model->header.dimension;
    for (; start + LANES <= n; start += LANES) {
        if (k == 3) {
            find_lanes(solver, 3, LANES, start, positions + 3 * start);
        } else {
            find_lanes(solver, 2, LANES, start, positions + 2 * start);
        }
    }
    find_lanes(solver, k, (int32_t)(n - start), start, positions + (size_t)k * start);
}
