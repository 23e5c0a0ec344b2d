/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The steps from mesh, shapes, weights, rows and groups to the constants of a model. */
#ifndef TUG_MODEL_BUILD_H
#define TUG_MODEL_BUILD_H

#include "model/model.h"

/* Every group's constants, in the columns that it sees: K and H of the joint problem and of every
 * single shape, each shape's forms, alignment, stiffness and mean weights. L: unknowns square, the
 * lower triangle of D^T L D, added to. */
tug_status find_group_constants(tug_model *model, const tug_mesh *mesh, const int32_t *groups,
                                const double *stiffness, const progress_range *range, double *L);

/* X = rows of D at the constraints, and the constrained values of each shape: added to zeros. And
 * how much each row says about each group. */
tug_status find_rows(tug_model *model, const tug_rows *rows);

/* H where the groups meet themselves in C, before the eliminations. */
void place_stiffness(tug_model *model);

/* The transforms of every shape alone, from its groups' constants and the joint X. */
tug_status eliminate_shapes(tug_model *model, const progress_range *range);

/* The transforms of the joint problem, once L has been used up by factor_transforms. */
tug_status eliminate_joint(tug_model *model, const progress_range *range);

#endif
