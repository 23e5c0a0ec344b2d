/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The forms of a solve, each from the costs to B and R: steady.c and alternation.c. */
#ifndef TUG_FORMS_H
#define TUG_FORMS_H

#include "solver_state.h"

void solve_steady(tug_solver *solver, tug_solve_info *info);
void solve_alternating(tug_solver *solver, tug_solve_info *info);
void solve_without_rotations(tug_solver *solver, tug_solve_info *info);

#endif
