/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/shape_couplings.h"

#include "dense/vector.h"
#include "memory.h"
#include "solver/own_block.h"

#include <string.h>

/* Vectors, or rows, whose sums are kept in registers: with three columns as many as there are. */
enum { TILE = 4 };

static size_t block_size(const shape_couplings *c)
{
    return (size_t)c->size * (size_t)c->stride;
}

/* The block of shapes s <= t. */
static double *block_of(const shape_couplings *c, int32_t s, int32_t t)
{
    int32_t number = c->all ? s * c->shapes - s * (s - 1) / 2 + t - s : s;
    return c->blocks + (size_t)number * block_size(c);
}

const double *own_coupling(const shape_couplings *c, int32_t s)
{
    return block_of(c, s, s);
}

int couplings_create(const tug_model *model, int all, shape_couplings *c)
{
    int32_t S = model->header.shapes, k = model->header.dimension;
    c->shapes = S;
    c->k = k;
    c->size = model->header.groups * k;
    c->stride = (c->size + LANES - 1) / LANES * LANES;
    c->all = all;
    size_t count = (size_t)(all ? S * (S + 1) / 2 : S);
    c->blocks = allocate(count * block_size(c), sizeof *c->blocks);
    return c->blocks != NULL;
}

void couplings_destroy(shape_couplings *c)
{
    release(c->blocks);
}

static void find_block(const tug_model *model, const reduction *energy, const shape_couplings *c,
                       int32_t s, int32_t t)
{
    int32_t k = c->k, S = c->shapes;
    double *row = block_of(c, s, t);
    for (int32_t g = 0; g < model->header.groups; g++, row += k * c->stride) {
        for (int32_t h = 0; h < model->header.groups; h++) {
            double own[9];
            find_own_block(model, energy, g * S + s, h * S + t, own);
            for (int32_t a = 0; a < k; a++) {
                memcpy(row + a * c->stride + h * k, own + a * k, (size_t)k * sizeof *own);
            }
        }
    }
}

void find_couplings(const tug_model *model, const reduction *energy, shape_couplings *c)
{
    for (int32_t s = 0; s < c->shapes; s++) {
        for (int32_t t = s; t < (c->all ? c->shapes : s + 1); t++) {
            find_block(model, energy, c, s, t);
        }
    }
}

/* Y += A^T X for one block: entries from i on, their sums in registers. k and width are constants
 * where these are called. */
PART void add_transposed_part(const shape_couplings *c, int32_t k, int width, int32_t i,
                              const double *A, const double *X, double *Y)
{
    packed sum[3][TILE] = {{{0.0}}};
    const double *row = A + i;
    for (int32_t j = 0; j < c->size; j++, row += c->stride) {
        for (int v = 0; v < width; v++) {
            packed x = *packed_at(row + LANES * v);
            for (int32_t a = 0; a < k; a++) {
                sum[a][v] += X[a * c->stride + j] * x;
            }
        }
    }
    for (int32_t a = 0; a < k; a++) {
        for (int v = 0; v < width; v++) {
            *writable_packed_at(Y + a * c->stride + i + LANES * v) += sum[a][v];
        }
    }
}

PART void add_transposed(const shape_couplings *c, int32_t k, const double *A, const double *X,
                         double *Y)
{
    int32_t i = 0;
    for (; i + TILE * LANES <= c->stride; i += TILE * LANES) {
        add_transposed_part(c, k, TILE, i, A, X, Y);
    }
    for (; i < c->stride; i += LANES) {
        add_transposed_part(c, k, 1, i, A, X, Y);
    }
}

/* Y += A X, `height` rows of A from i on. */
PART void add_straight_part(const shape_couplings *c, int32_t k, int height, int32_t i,
                            const double *A, const double *X, double *Y)
{
    packed sum[3][TILE] = {{{0.0}}};
    const double *row = A + (size_t)i * (size_t)c->stride;
    for (int32_t j = 0; j < c->stride; j += LANES) {
        for (int32_t a = 0; a < k; a++) {
            packed x = *packed_at(X + a * c->stride + j);
            for (int u = 0; u < height; u++) {
                sum[a][u] += x * *packed_at(row + u * c->stride + j);
            }
        }
    }
    for (int32_t a = 0; a < k; a++) {
        for (int u = 0; u < height; u++) {
            Y[a * c->stride + i + u] += sum_of_lanes(&sum[a][u]);
        }
    }
}

PART void add_straight(const shape_couplings *c, int32_t k, const double *A, const double *X,
                       double *Y)
{
    int32_t i = 0;
    for (; i + TILE <= c->size; i += TILE) {
        add_straight_part(c, k, TILE, i, A, X, Y);
    }
    for (; i < c->size; i++) {
        add_straight_part(c, k, 1, i, A, X, Y);
    }
}

PART void couple(const shape_couplings *c, int32_t k, int32_t first, int32_t count, const double *X,
                 double *AX)
{
    int32_t slice = slice_size(c);
    memset(AX + first * slice, 0, (size_t)(count * slice) * sizeof *AX);
    for (int32_t s = first; s < first + count; s++) {
        for (int32_t t = s; t < first + count; t++) {
            const double *A = block_of(c, s, t);
            add_transposed(c, k, A, X + s * slice, AX + t * slice);
            if (s != t) {
                add_straight(c, k, A, X + t * slice, AX + s * slice);
            }
        }
    }
}

DISPATCHED void couple_shapes(const shape_couplings *c, int32_t first, int32_t count,
                              const double *X, double *AX)
{
    if (c->k == 3) {
        couple(c, 3, first, count, X, AX);
    } else {
        couple(c, 2, first, count, X, AX);
    }
}

void scatter_blocks(const shape_couplings *c, const double *blocks, int32_t pitch, double *slice)
{
    int32_t k = c->k;
    for (int32_t i = 0; i < c->size; i++) {
        for (int32_t a = 0; a < k; a++) {
            slice[a * c->stride + i] = blocks[i / k * pitch + i % k * k + a];
        }
    }
}

/* A rotation is the transpose of its block. */
void gather_rotations(const shape_couplings *c, const double *slice, int32_t pitch, double *R)
{
    int32_t k = c->k;
    for (int32_t i = 0; i < c->size; i++) {
        for (int32_t a = 0; a < k; a++) {
            R[i / k * pitch + a * k + i % k] = slice[a * c->stride + i];
        }
    }
}

void scatter_rotations(const shape_couplings *c, const double *R, int32_t pitch, double *slice)
{
    int32_t k = c->k;
    for (int32_t i = 0; i < c->size; i++) {
        for (int32_t a = 0; a < k; a++) {
            slice[a * c->stride + i] = R[i / k * pitch + a * k + i % k];
        }
    }
}
