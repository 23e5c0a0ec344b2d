/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Deformation gradients as a rotation and a stretch, F = R S, and their nonlinear blend
 *
 *     M(w) = exp(sum_s w_s log R_s) sum_s w_s S_s
 *
 * of Sumner et al. 2005, for any number of elements (triangles or groups of them). */
#ifndef TUG_BASELINES_FEATURES_H
#define TUG_BASELINES_FEATURES_H

#include "mesh/mesh.h"

typedef struct feature_set {
    int32_t k, elements, shapes;
    double *turn;    /* #E by #S by tangent components: log R */
    double *stretch; /* #E by #S by k by k: S */
} feature_set;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int features_create(int32_t k, int32_t elements, int32_t shapes, feature_set *out);
void features_destroy(feature_set *features);

/* F of one element of one shape, k by k. */
void set_feature(feature_set *features, int32_t element, int32_t shape, const double *F);

/* M of one element, k by k. */
void blend_features(const feature_set *features, int32_t element, const double *w, double *M);

/* dM: #S by k by k, the derivatives of M in each weight. */
void differentiate_features(const feature_set *features, int32_t element, const double *w,
                            double *dM);

/* The deformation gradient of a triangle from the mesh to other positions; in space the unit
 * normal goes to the unit normal. */
void find_gradient(const tug_mesh *mesh, const double *positions, int32_t triangle, double *F);

/* The rotation vector of R, of an angle of at most pi. */
void rotation_logarithm(int32_t k, const double *R, double *w);

#endif
