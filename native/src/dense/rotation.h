/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rotations in two and three dimensions: k by k, row-major, and their tangent vectors, one angle or
 * a rotation vector. */
#ifndef TUG_ROTATION_H
#define TUG_ROTATION_H

#include "dense/small_matrix.h"

/* Components of a tangent vector: 1 in the plane, 3 in space. */
static inline int32_t tangent_size(int32_t k)
{
    return k == 3 ? 3 : 1;
}

/* The rotation R that maximises tr(R M), (A 22). Where M leaves a choice (rank below k - 1), some
 * maximiser. (closest_rotation.c) */
void closest_rotation(int32_t k, const double *M, double *R);

/* The same for `count` matrices that follow each other, for less each. R may be M. */
void closest_rotations(int32_t k, int32_t count, const double *M, double *R);

/* Of the unit quaternion q, its real part first. */
void quaternion_matrix(const double *q, double *R);

/* R <- exp(w) R. */
void turn(int32_t k, const double *w, double *R);

/* The angle between two rotations, radians. */
double angle_between(int32_t k, const double *A, const double *B);

/* The same from |A - B|^2. */
double angle_of_distance(double squares);

/* a with tr(W M) = a . w for the skew matrix W of every w. */
void axial_vector(int32_t k, const double *M, double *a);

/* W with W x = w x x, or w times a quarter turn in the plane: tr(W M) = w . axial_vector(M). */
void skew_matrix(int32_t k, const double *w, double *W);

/* The derivative of closest_rotation, (A 29-30). As M moves by dM, its closest rotation R becomes
 * exp(w) R with J w = axial_vector(R dM), J = tr(R M) I - R M: R M has to stay symmetric. In the
 * basis of M's singular vectors J is diagonal, sums of two singular values. Here w = J^-1 a, for
 * any a: J is symmetric, so this is the derivative's adjoint too. Where M leaves R open (J
 * singular), w is zero. */
void solve_for_turn(int32_t k, const double *R, const double *M, const double *a, double *w);

#endif
