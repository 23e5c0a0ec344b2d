/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The costs D of (A 10): for each shape alone, the as-rigid-as-possible pose for the handle
 * positions, and what every edge group contributes to its energy. Each shape's rotations start from
 * a fit of its own handle positions to the wanted ones, so D is a function of the handles, and
 * turns with them. */
#ifndef TUG_COSTS_H
#define TUG_COSTS_H

#include "solver/holding.h"
#include "solver/orientation.h"
#include "solver/rotation_fit.h"

typedef struct shape_costs {
    double *D;         /* #G by #S, energies */
    double *rotations; /* #G by #S by k by k: each shape's own optimum */
    double *scale;     /* #S: what each shape is taken to be larger by; ones at first */
    int32_t converged; /* all shapes */
    int32_t steps;     /* Newton's, largest over the shapes */
    rotation_workspace workspace;
    double *R, *L, *V;                /* of one shape: #G by k by k */
    double *T, *difference, *product; /* of one shape: #W (k + 1) by k */
    double *placed;                   /* of one shape: #H by k */
    double *recovery;                 /* recover_transforms' work */
    double *Y;                        /* of one shape: #H by k, in its own size */
} shape_costs;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int costs_create(const tug_model *model, shape_costs *costs);
void costs_destroy(shape_costs *costs);

/* Y: #H by k. turning: 0 holds every group of every shape as it stands in its shape. What the
 * spring of a row that gives way takes, or an orientation, counts in the group nearest to the row.
 */
void find_costs(const tug_model *model, const holding *held, const orientation *oriented,
                const double *Y, int turning, shape_costs *costs);

#endif
