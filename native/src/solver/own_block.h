/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How the moments of one pair i = (g, s) depend on the rotation of another: A = K Z K^T, a block.
 */
#ifndef TUG_OWN_BLOCK_H
#define TUG_OWN_BLOCK_H

#include "model/model.h"

/* H_ij, k by k, of two pairs of one group. */
void find_pair_stiffness(const tug_model *model, int32_t i, int32_t j, double *block);

/* A_ij = H_ij - C_ij, k by k, pairs of different groups having no H_ij. */
void find_own_block(const tug_model *model, const reduction *energy, int32_t i, int32_t j,
                    double *block);

#endif
