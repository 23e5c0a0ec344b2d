/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/trust_room.h"

#include "memory.h"

int trust_room_create(const tug_model *model, trust_room *trust)
{
    size_t k = (size_t)model->header.dimension, S = (size_t)model->header.shapes;
    size_t n = (size_t)model->header.groups * S, blocks = n * k * k, point = 2 * blocks + n + S;
    trust->kept = allocate(point, sizeof *trust->kept);
    trust->reached = allocate(point, sizeof *trust->reached);
    trust->ahead = allocate(point, sizeof *trust->ahead);
    trust->R = allocate(blocks, sizeof *trust->R);
    trust->Q = allocate(n * n, sizeof *trust->Q);
    trust->N = allocate(blocks, sizeof *trust->N);
    trust->slope = allocate(blocks, sizeof *trust->slope);
    trust->slope_moments = allocate(blocks, sizeof *trust->slope_moments);
    trust->d = allocate(n, sizeof *trust->d);
    trust->folded_d = allocate(S, sizeof *trust->folded_d);
    int room = extrapolation_create((int32_t)point, (int32_t)blocks, &trust->path);
    return room && trust->kept && trust->reached && trust->ahead && trust->R && trust->Q &&
           trust->N && trust->slope && trust->slope_moments && trust->d && trust->folded_d;
}

void trust_room_destroy(trust_room *trust)
{
    release(trust->kept);
    release(trust->reached);
    release(trust->ahead);
    release(trust->R);
    release(trust->Q);
    release(trust->N);
    release(trust->slope);
    release(trust->slope_moments);
    release(trust->d);
    release(trust->folded_d);
    extrapolation_destroy(&trust->path);
}
