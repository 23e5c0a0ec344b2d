/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/own_block.h"

#include <string.h>

void find_pair_stiffness(const tug_model *model, int32_t i, int32_t j, double *block)
{
    int32_t k = model->header.dimension, S = model->header.shapes;
    size_t p = (size_t)(S * k), g = (size_t)(i / S);
    for (int32_t ab = 0; ab < k * k; ab++) {
        size_t row = (size_t)(i % S * k + ab / k), column = (size_t)(j % S * k + ab % k);
        block[ab] = model->H[(g * p + row) * p + column];
    }
}

/* Component (a, b) of C_ij; of two groups the block of the earlier one first is stored. */
static double joint_entry(const reduction *energy, int32_t i, int32_t j, int32_t ab)
{
    int32_t S = energy->shapes, k = energy->group_rows / S;
    if (i / S > j / S) {
        return joint_entry(energy, j, i, ab % k * k + ab / k);
    }
    size_t block = coupling_offset(energy, i / S, j / S);
    return energy->C[block + (size_t)((ab * S + i % S) * S + j % S)];
}

void find_own_block(const tug_model *model, const reduction *energy, int32_t i, int32_t j,
                    double *block)
{
    int32_t kk = model->header.dimension * model->header.dimension, S = model->header.shapes;
    memset(block, 0, (size_t)kk * sizeof *block);
    if (i / S == j / S) {
        find_pair_stiffness(model, i, j, block);
    }
    for (int32_t ab = 0; ab < kk; ab++) {
        block[ab] -= joint_entry(energy, i, j, ab);
    }
}
