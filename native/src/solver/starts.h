/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where the rotations of a shape alone start, as functions of the targets: from a fit of its own
 * handle positions to them, in its own part of the dictionary. */
#ifndef TUG_STARTS_H
#define TUG_STARTS_H

#include "solver/costs.h"

/* scale <- how much wider the targets are spread than the handles of each shape, as its groups see
 * them. Y: #H by k. */
void fit_scales(const tug_model *model, const holding *held, const double *Y, shape_costs *costs);

/* The energy of a shape's rotations, from targets in its own size; both in `costs` as well. */
rotation_energy energy_alone(const tug_model *model, const holding *held, int32_t s,
                             const double *Y, shape_costs *costs);

/* costs->R <- the fit of the handles as each group sees them, where a least prior then holds what
 * the energy leaves open: it is added to costs->L. */
void start_alone(const tug_model *model, const holding *held, const orientation *oriented,
                 int32_t s, shape_costs *costs);

/* costs->R as the rotations of shape s. */
void keep_rotations(const tug_model *model, int32_t s, shape_costs *costs);

/* The rotations of all shapes where only these are asked for: the fit, and a few local and global
 * steps from it. Steps are cheap, and a form that goes on with rounds in the whole dictionary has
 * no use for the shapes' own optima. */
void find_starts(const tug_model *model, const holding *held, const double *Y, shape_costs *costs);

#endif
