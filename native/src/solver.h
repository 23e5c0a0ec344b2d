/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From handle positions to a pose. */
#ifndef TUG_SOLVER_H
#define TUG_SOLVER_H

#include "solver_state.h"

/* targets: #H by k, finite. */
void solver_solve(tug_solver *solver, const double *targets, tug_solve_info *info);

/* positions: #V by k. */
void find_positions(const tug_solver *solver, double *positions);

/* What tug_get_blend, tug_get_costs and tug_get_rotations give. */
void copy_blend(const tug_solver *solver, double *blend);
void copy_costs(const tug_solver *solver, double *costs);
void copy_rotations(const tug_solver *solver, double *rotations);

#endif
