/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tug's reduced model as the space that a comparison system moves in. */
#ifndef TUG_BASELINES_SUBSPACE_H
#define TUG_BASELINES_SUBSPACE_H

#include "method.h"
#include "model/model.h"

/* A model of shapes first to first + count - 1, one row for each handle. */
tug_status create_subspace(const tug_baseline *baseline, const tug_baseline_problem *problem,
                           int32_t first, int32_t count, tug_model **out);

/* positions = factor D T: #V by k. */
void find_pose(const dictionary *D, const double *T, double factor, double *positions);

#endif
