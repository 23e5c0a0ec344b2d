/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rigid motions of bones, by weighted Procrustes fits. */
#ifndef TUG_MOTIONS_H
#define TUG_MOTIONS_H

#include "dictionaries/skeleton/skinning.h"

/* Sums over vertices p, wanted at q with weight w and mass m, of the fit of one pose. */
typedef struct motion_sums {
    double weight;      /* m w^2 */
    double from[3];     /* m w^2 p */
    double to[3];       /* m w q */
    double products[9]; /* m w p q^T */
} motion_sums;

void add_to_motion(motion_sums *sums, int32_t k, double mass, double weight, const double *p,
                   const double *q);

/* The rigid motion that minimises sum m |q - w (R p + t)|^2, as a row of skinning's motion. */
void fit_motion(const motion_sums *sums, int32_t k, double *motion);

/* Every bone in turn gets the motion that is best while the others and the weights stay. The
 * objective never rises. room: poses. places: poses by k. */
void improve_motions(skinning *s, motion_sums *room, double *places);

#endif
