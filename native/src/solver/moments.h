/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the rotations of the pairs i = (g, s) are found from: the moments K_i T of (A 23), without
 * T. The transforms are T = Z K^T V + F Y (reduction.h) for some V: in blocks of k by k, B_i R_i^T
 * for the T that suits blend and rotations best. */
#ifndef TUG_MOMENTS_H
#define TUG_MOMENTS_H

#include "solver/solver_state.h"

/* V_i = B_i R_i^T of the solver's blend and rotations, times its scale. */
void stack_rotations(const tug_solver *solver, double *V);

/* A V, A = K Z K^T = H - C: what V adds to the moments. tr(V^T A V) = tr(T^T L T), but for Y's
 * part. */
void find_own_moments(const tug_solver *solver, const double *V, double *AV);

/* K T = K F Y + A V. */
void find_pose_moments(const tug_solver *solver, const double *V, double *M);

/* (A 22): each pair's rotation closest to its moment. What the moments leave open is held at the
 * optimum of the shape alone, by a prior of LEAST_PRIOR: so R is a smooth function of T. */
void follow_moments(tug_solver *solver, const double *M);

/* The moments of the blended shapes themselves, in the place of the pose: sum_j B_j H_ij R_j^T. */
void find_blended_moments(const tug_solver *solver, double *N);

/* Q_ij += weight tr(R_i H_ij R_j^T) for pairs of one group: the Hessian of E_d in B at fixed T. */
void add_blend_stiffness(const tug_solver *solver, double weight, double *Q);

/* d_R E_d, (A 25-28): slope_i, k by k, is the derivative of E_d in the moment M_i by way of R_i,
 *
 *     sum_i tr(dR_i D_i) = sum_i tr(slope_i^T dM_i),   D_i = B_i (N_i - M_i),
 *
 * where dR_i comes from dM_i by (A 29-30). The paper has N_i alone in D_i; M_i adds nothing, since
 * R_i maximises tr(R_i M_i), but to digits where the pose fits the blend. */
void find_rotation_slope(const tug_solver *solver, const double *M, const double *N, double *slope);

#endif
