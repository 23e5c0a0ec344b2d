/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the rotations of the pairs i = (g, s) are found from: the moments K_i T of (A 23), without
 * T. The transforms are T = Z K^T V + F Y (reduction.h) for some V: in blocks of k by k, B_i R_i^T
 * for the T that suits blend and rotations best. */
#ifndef TUG_MOMENTS_H
#define TUG_MOMENTS_H

#include "solver_state.h"

/* V_i = B_i R_i^T of the solver's blend and rotations. */
void stack_rotations(const tug_solver *solver, double *V);

/* A V, A = K Z K^T = H - C: what V adds to the moments. tr(V^T A V) = tr(T^T L T), but for Y's
 * part. */
void find_own_moments(const tug_solver *solver, const double *V, double *AV);

/* K T = K F Y + A V. */
void find_pose_moments(const tug_solver *solver, const double *V, double *M);

/* The moments of the blended shapes themselves, in the place of the pose: sum_j B_j H_ij R_j^T. */
void find_blended_moments(const tug_solver *solver, double *N);

#endif
