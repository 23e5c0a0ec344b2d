/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dense/extrapolation.h"

#include "dense/dense.h"
#include "dense/vector.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { DEPTH = EXTRAPOLATION_DEPTH };

int extrapolation_create(int32_t size, int32_t measured, extrapolation *e)
{
    e->size = size;
    e->measured = measured;
    e->end = allocate((size_t)DEPTH * (size_t)size, sizeof *e->end);
    e->step = allocate((size_t)DEPTH * (size_t)size, sizeof *e->step);
    return e->end && e->step;
}

void extrapolation_destroy(extrapolation *e)
{
    release(e->end);
    release(e->step);
}

void forget_steps(extrapolation *e)
{
    e->count = 0;
    e->next = 0;
}

void record_step(extrapolation *e, const double *from, const double *to)
{
    size_t size = (size_t)e->size;
    double *step = e->step + (size_t)e->next * size;
    memcpy(e->end + (size_t)e->next * size, to, size * sizeof *to);
    for (size_t i = 0; i < size; i++) {
        step[i] = to[i] - from[i];
    }
    e->count = e->count < DEPTH ? e->count + 1 : DEPTH;
    for (int32_t i = 0; i < e->count; i++) {
        const double *other = e->step + (size_t)i * size;
        e->products[i][e->next] = dot(other, step + e->measured, (size_t)e->measured);
        e->products[e->next][i] = e->products[i][e->next];
    }
    e->next = (e->next + 1) % DEPTH;
}

/* The weights a minimise |sum_i a_i step_i|, sum_i a_i = 1: (steps^T steps) a is constant. Steps
 * are scaled to length one first, since the late ones are far shorter. */
static int find_weights(const extrapolation *e, double *weights)
{
    static const double ridge = 1e-12; /* steps that depend on each other share a weight */
    double products[DEPTH * DEPTH], length[DEPTH], sum = 0.0;
    for (int32_t i = 0; i < e->count; i++) {
        length[i] = sqrt(fmax(e->products[i][i], 0.0));
        if (!(length[i] > 0.0)) {
            return 0;
        }
        weights[i] = 1.0 / length[i];
        for (int32_t j = 0; j <= i; j++) {
            products[j * e->count + i] = e->products[i][j] / (length[i] * length[j]);
        }
        products[i * e->count + i] = 1.0 + ridge;
    }
    if (!cholesky_factor(products, e->count)) {
        return 0;
    }
    cholesky_solve(products, e->count, weights, 1);
    for (int32_t i = 0; i < e->count; i++) {
        weights[i] /= length[i];
        sum += weights[i];
    }
    for (int32_t i = 0; i < e->count; i++) {
        weights[i] /= sum;
    }
    return sum > 0.0;
}

/* ahead <- sum_i weights_i end_i, four at a time. */
DISPATCHED static void mix_ends(const extrapolation *e, const double *weights, double *ahead)
{
    size_t size = (size_t)e->size, j = 0;
    for (; j + LANES <= size; j += LANES) {
        packed sum = {0.0};
        for (int32_t i = 0; i < e->count; i++) {
            sum += weights[i] * *packed_at(e->end + (size_t)i * size + j);
        }
        *writable_packed_at(ahead + j) = sum;
    }
    for (; j < size; j++) {
        ahead[j] = 0.0;
        for (int32_t i = 0; i < e->count; i++) {
            ahead[j] += weights[i] * e->end[(size_t)i * size + j];
        }
    }
}

int extrapolate(const extrapolation *e, double *ahead)
{
    double weights[DEPTH];
    if (e->count < 2 || !find_weights(e, weights)) {
        return 0;
    }
    mix_ends(e, weights, ahead);
    return 1;
}
