/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The as-rigid-as-possible pose of one shape alone in its own skinning subspace. */
#ifndef TUG_BASELINES_SINGLE_SHAPE_H
#define TUG_BASELINES_SINGLE_SHAPE_H

#include "method.h"
#include "solver/costs.h"

typedef struct single_shape {
    tug_model *model; /* of this shape and no other; its unit is this shape's diagonal */
    shape_costs fit;
    double *Y, *pull; /* #H by k; #G by k by k */
    double energy;    /* of the last pose, as 1/2 the sum over edges */
} single_shape;

tug_status single_shape_create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                               int32_t s, single_shape *out);

/* Frees the members; they may be NULL. */
void single_shape_destroy(single_shape *shape);

/* Pose the shape for the baseline's Y; info: as of this shape alone. */
void single_shape_solve(const tug_baseline *baseline, single_shape *shape, tug_baseline_info *info);

void single_shape_positions(const single_shape *shape, double *positions);

#endif
