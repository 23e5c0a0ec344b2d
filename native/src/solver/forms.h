/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The forms of a solve, each from the costs to B and R: steady.c, alternation.c,
 * trust_region.c and reference_forms.c. */
#ifndef TUG_FORMS_H
#define TUG_FORMS_H

#include "solver/solver_state.h"

void solve_steady(tug_solver *solver, tug_solve_info *info);
void solve_alternating(tug_solver *solver, tug_solve_info *info);

/* The shapes' own rotations, and (A 20) at these. */
void start_alternation(tug_solver *solver);

void solve_without_rotations(tug_solver *solver, tug_solve_info *info);

/* Leaves V too: its transforms are not those that suit B and R best. */
void solve_trust_region(tug_solver *solver, tug_solve_info *info);

/* These find a scale beside B and R, where it is free. */
void solve_average(tug_solver *solver, tug_solve_info *info);
void solve_minimal(tug_solver *solver, tug_solve_info *info);
void solve_closest(tug_solver *solver, tug_solve_info *info);

static inline int compares_with_references(int32_t form)
{
    return form == TUG_FORM_AVERAGE || form == TUG_FORM_MINIMAL || form == TUG_FORM_CLOSEST;
}

#endif
