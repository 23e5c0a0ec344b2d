/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The smoothness energy (F 6): how much of the shapes, and which translation, each vertex takes, as
 * functions on the surface, each with half the Laplacian energy int (Laplacian f)^2 of them.
 *
 * The influence of coordinate c on one coordinate of the pose is sum_h T_hc W_h; the translation is
 * what is left for shapes about their own means. Examples and their rigid motions are influences
 * that are constant: they have no such energy. */
#ifndef TUG_SMOOTHNESS_H
#define TUG_SMOOTHNESS_H

#include "mesh/mesh.h"
#include "model/dictionary.h"

/* S = weight W^T L M^-1 L W, #W square, with the cotangent Laplacian L of the mesh and the lumped
 * mass M in parts of the whole: diag(mu^2) for its eigenfunctions. O(#V #W^2), and room for another
 * #V by #W. */
tug_status find_smoothness(const tug_mesh *mesh, const dictionary *D, double weight, double *S);

/* Lambda, (F 6), added to the lower triangle of L, for the `count` coordinates from `first` on of
 * the dictionary's: (1 + count) columns a weight function. */
void add_smoothness(const dictionary *D, const double *S, int32_t first, int32_t count, double *L);

#endif
