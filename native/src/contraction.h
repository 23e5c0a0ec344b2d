/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The joint energy's constant matrix with rotations, or a blend, put in. Pairs (g, s) are numbered
 * i = g S + s; C_ij is the k by k block of a pair of pairs. C: laid out as in tug_model. */
#ifndef TUG_CONTRACTION_H
#define TUG_CONTRACTION_H

#include "model.h"

/* Q_ij = tr(R_g C_ij R_h^T), i = (g, s), j = (h, t): #G #S square. R: #G by k by k. */
void contract_rotations(const tug_model *model, const double *C, const double *R, double *Q);

/* The same with a rotation for each pair. R: #G by #S by k by k. */
void contract_pair_rotations(const tug_model *model, const double *C, const double *R, double *Q);

/* out_gh = sum_st B_gs B_ht C_(gs)(ht): #G k square. B: #G by #S. */
void contract_blend(const tug_model *model, const double *C, const double *B, double *out);

/* X_h = sum_t B_ht C_i(ht) for one pair i: #G by k by k. */
void contract_blend_row(const tug_model *model, const double *C, int32_t pair, const double *B,
                        double *X);

#endif
