/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From handle positions to a pose. */
#ifndef TUG_SOLVER_H
#define TUG_SOLVER_H

#include "solver/solver_state.h"

/* firmness: #H, not negative. Where it fails everything is as before. */
tug_status solver_set_firmness(tug_solver *solver, const double *firmness);

/* targets: #H by k, finite. rotations: #G by #S by k by k to start from in place of the shapes' own
 * optima, or NULL. */
void solver_solve(tug_solver *solver, const double *targets, const double *rotations,
                  tug_solve_info *info);

/* The pose of least energy for a blend, #G by #S, and rotations as copy_rotations gives them. */
void solver_pose(tug_solver *solver, const double *targets, const double *blend,
                 const double *rotations);

/* T with its translations taken from the middles of the dictionary to the shapes' own origins: what
 * positions are made with. Both unknowns by k. */
void place_transforms(const dictionary *D, const double *T, double *placed);

/* positions: #V by k, from placed_T. */
void find_positions(const tug_solver *solver, double *positions);

/* What tug_get_blend, tug_get_costs and tug_get_rotations give. */
void copy_blend(const tug_solver *solver, double *blend);
void copy_costs(const tug_solver *solver, double *costs);
void copy_rotations(const tug_solver *solver, double *rotations);

#endif
