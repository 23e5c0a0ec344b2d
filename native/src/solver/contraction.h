/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The joint energy's constant matrix with rotations, or a blend, put in. Pairs (g, s) are numbered
 * i = g S + s; C_ij is the k by k block of a pair of pairs. C: laid out as in tug_model. */
#ifndef TUG_CONTRACTION_H
#define TUG_CONTRACTION_H

#include "model/model.h"

/* The constant matrix of some shapes of each group: blocks of groups g <= h, one after the other,
 * k by k by #S by #S. */
typedef struct coupling {
    int32_t groups, k, shapes;
    const double *C;
} coupling;

/* That of all shapes of a joint problem. */
static inline coupling joint_coupling(const reduction *energy)
{
    return (coupling){energy->groups, energy->group_rows / energy->shapes, energy->shapes,
                      energy->C};
}

/* Doubles of it, and the part of `all` for `width` shapes of each group, #G by width. */
static inline size_t partial_coupling_size(size_t groups, size_t k, size_t width)
{
    return groups * (groups + 1) / 2 * k * k * width * width;
}
void gather_coupling(const coupling *all, const int32_t *shapes, int32_t width, double *out);

/* Q_ij = tr(R_g C_ij R_h^T), i = (g, s), j = (h, t): #G #S square. R: #G by k by k. */
void contract_rotations(const coupling *from, const double *R, double *Q);

/* The same with a rotation for each pair. R: #G by #S by k by k. */
void contract_pair_rotations(const coupling *from, const double *R, double *Q);

/* Q B, from the pairs of groups in which B is not zero. B, out: #G by #S. */
void apply_rotated_coupling(const coupling *from, const double *R, const double *B, double *out);

/* out_gh = sum_st B_gs B_ht C_(gs)(ht): #G k square. B: #G by #S. */
void contract_blend(const coupling *from, const double *B, double *out);

/* X_h = sum_t B_ht C_i(ht) for one pair i: #G by k by k. */
void contract_blend_row(const coupling *from, int32_t pair, const double *B, double *X);

#endif
