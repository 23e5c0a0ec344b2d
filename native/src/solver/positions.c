/* SPDX-License-Identifier: GPL-3.0-or-later */
/* q = D T: the only part of a frame whose cost grows with the mesh. */
#include "dense/vector.h"
#include "solver/solver.h"

#include <string.h>

enum { WIDTH = 4, TILE = WIDTH * LANES }; /* vertices at a time */

/* total += W_h times what T_h, one weight function's block of T, makes of a tile's vertices. */
PART void add_weighted(const double *column, const double *W, size_t n, int32_t coordinates,
                       int32_t k, const double *T, packed total[3][WIDTH])
{
    packed sum[3][WIDTH] = {{{0.0}}};
    const double *factor = T + k;
    for (int32_t c = 0; c < coordinates; c++, column += n, factor += k) {
        for (int32_t v = 0; v < WIDTH; v++) {
            packed x = *packed_at(column + LANES * v);
            for (int32_t axis = 0; axis < k; axis++) {
                sum[axis][v] += factor[axis] * x;
            }
        }
    }
    for (int32_t axis = 0; axis < k; axis++) {
        for (int32_t v = 0; v < WIDTH; v++) {
            total[axis][v] += *packed_at(W + LANES * v) * (T[axis] + sum[axis][v]);
        }
    }
}

/* Positions of the tile of vertices from `start` on. */
PART void find_tile(const tug_solver *solver, int32_t k, size_t start, double *positions)
{
    const dictionary *D = &solver->model->dictionary;
    size_t n = (size_t)D->vertices;
    int32_t coordinates = D->shapes * k;
    const double *T = solver->placed_T, *W = D->weight_columns + start;
    packed total[3][WIDTH] = {{{0.0}}};
    for (int32_t h = 0; h < D->weights; h++, T += (1 + coordinates) * k, W += n) {
        add_weighted(D->shape_columns + start, W, n, coordinates, k, T, total);
    }
    double place[3][TILE];
    for (int32_t axis = 0; axis < k; axis++) {
        for (int32_t v = 0; v < WIDTH; v++) {
            *writable_packed_at(place[axis] + LANES * v) =
                solver->middle[axis] + solver->model->header.unit * total[axis][v];
        }
    }
    for (int32_t i = 0; i < TILE; i++) {
        for (int32_t axis = 0; axis < k; axis++) {
            positions[i * k + axis] = place[axis][i];
        }
    }
}

/* The same for a mesh smaller than a tile. */
static void find_few(const tug_solver *solver, double *positions)
{
    const dictionary *D = &solver->model->dictionary;
    int32_t n = D->vertices, k = D->dimension, coordinates = D->shapes * k;
    for (int32_t i = 0; i < n * k; i++) {
        const double *T = solver->placed_T + i % k;
        double total = 0.0;
        for (int32_t h = 0; h < D->weights; h++) {
            double sum = *T;
            T += k;
            for (int32_t c = 0; c < coordinates; c++, T += k) {
                sum += *T * D->shape_columns[c * n + i / k];
            }
            total += D->weight_columns[h * n + i / k] * sum;
        }
        positions[i] = solver->middle[i % k] + solver->model->header.unit * total;
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

/* The last tile does some for a second time, with the same result. */
PART void find_tiles(const tug_solver *solver, int32_t k, double *positions)
{
    size_t n = (size_t)solver->model->header.vertices;
    for (size_t start = 0; start < n; start += TILE) {
        size_t first = start + TILE <= n ? start : n - TILE;
        find_tile(solver, k, first, positions + first * (size_t)k);
    }
}

DISPATCHED void find_positions(const tug_solver *solver, double *positions)
{
    int32_t k = solver->model->header.dimension;
    if (solver->model->header.vertices < TILE) {
        find_few(solver, positions);
    } else if (k == 3) {
        find_tiles(solver, 3, positions);
    } else {
        find_tiles(solver, 2, positions);
    }
}
