/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows that give way. A row of firmness w is held to its target by a spring instead of exactly:
 *
 *     min over Y' of  E(V, Y') + 1/2 sum_r w_r s_r |Y'_r - Y_r|^2,
 *
 * s_r being the surface's own stiffness at the row. E is a quadratic form M in (V, Y'), so with
 * u = Y' - Y of the rows f that give way the minimum is the form M - M_f A^-1 M_f^T in (V, Y), with
 * A = M_ff + diag(w s), and u = -A^-1 M_f^T (V, Y). What M does not see, an example or a
 * translation, the new form does not see either; for w -> infinity it is M, and for w = 0 the
 * target does not count. Everything that works on a reduction works on it. */
#ifndef TUG_HOLDING_H
#define TUG_HOLDING_H

#include "model/model.h"

/* NULL stands for rows that are all pinned, everywhere below. */
typedef struct holding holding;

/* firmness: #H, not negative; from about 1e12 on a row counts as pinned. *out is NULL where all
 * do. TUG_ERROR_HANDLES where a part of the mesh is held by nothing firmer than about 1e-8.
 * O(rows that give way times the model's constants). */
tug_status hold_rows(const tug_model *model, const double *firmness, holding **out);

/* NULL is allowed. */
void release_holding(holding *held);

/* The problem of a shape alone has the shape's number, the joint one this. */
enum { JOINT = -1 };

/* The reduction of a problem in terms of the targets. Only its C, KF and FLF may be other than the
 * model's: transforms are recovered from where the rows come to be. */
const reduction *held_energy(const tug_model *model, const holding *held, int32_t problem);

/* Where the rows come to be, Y': #H by k. V: turned by k, as for recover_transforms. */
void settle_rows(const tug_model *model, const holding *held, int32_t problem, const double *V,
                 const double *Y, double *placed);

/* w_r s_r |Y'_r - Y_r|^2, twice the energy of a row's spring. Both #H by k. */
double spring_energy(const holding *held, int32_t row, const double *placed, const double *Y,
                     int32_t k);

/* w / (1 + w): one for a pinned row, zero for a free one. */
double grip_of(const holding *held, int32_t row);

#endif
