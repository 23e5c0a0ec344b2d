/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Handles that also say how the surface around them is turned: for each row an orientation O and
 * its firmness o, a term of
 *
 *     1/2 o w_g |R_g - O|^2,    w_g: the group's stiffness,
 *
 * on the rotation R_g of the group nearest to the row, relative to the rest shape. Linear in R_g
 * but for a constant, like a prior. The terms of a group add up to one on their mean. */
#ifndef TUG_ORIENTATION_H
#define TUG_ORIENTATION_H

#include "model/model.h"

/* NULL stands for no orientations in all calls that only read. */
typedef struct orientation {
    double *firmness; /* #G: sum of o over the rows nearest to the group */
    double *mean;     /* #G by k by k: sum of o O over sum of o; not a rotation where they differ */
    double *spread;   /* #G: sum of o |O - mean|^2 */
} orientation;

/* All firmness zero. Returns 0 where memory is short; it can then be destroyed all the same. */
int orientation_create(const tug_model *model, orientation *oriented);
void orientation_destroy(orientation *oriented);

/* O: #H by k by k, rotations up to the rounding of single precision where the firmness, #H, is
 * above zero. */
void orient_groups(const tug_model *model, const double *O, const double *firmness,
                   orientation *oriented);

/* sum o w_g |R - O|^2, twice the energy of a group turned by R. */
double orientation_energy(const tug_model *model, const orientation *oriented, int32_t g,
                          const double *R);

/* L += scale sum o O^T: for scale = w_g what the terms add to a group's L in sum_g tr(R_g L_g). */
void add_orientation_pull(const tug_model *model, const orientation *oriented, int32_t g,
                          double scale, double *L);

#endif
