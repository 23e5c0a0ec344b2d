/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The cotangent Laplacian L and the lumped mass M of a mesh, and the bilaplacian Q = L M^-1 L. */
#ifndef TUG_LAPLACIAN_H
#define TUG_LAPLACIAN_H

#include "sparse/sparse.h"

/* L by rows (or columns: it is symmetric), both triangles; positive semidefinite. The mass,
 * each vertex's Voronoi area, is divided by the whole, so that nothing depends on the unit of
 * length. */
typedef struct laplacian {
    int32_t size;
    int32_t *starts; /* size + 1 */
    int32_t *columns;
    double *values;
    double *mass; /* size */
} laplacian;

/* steepest: the energy of a triangle with a larger half cotangent is scaled down to it as a whole,
 * which leaves L positive semidefinite. Nothing sees slivers but the rounding, which they ruin. */
tug_status laplacian_create(const tug_mesh *mesh, double steepest, laplacian *out);

/* Frees the arrays, not the struct. NULL members are allowed. */
void laplacian_free(laplacian *L);

/* u = M^-1 L w; returns the energy w^T Q w / 2 = u^T M u / 2. */
double laplacian_bend(const laplacian *L, const double *w, double *u);

/* y = L u: with laplacian_bend before it, y = Q w. */
void laplacian_apply(const laplacian *L, const double *u, double *y);

/* The lower triangle of L + shift M. */
tug_status shifted_laplacian(const laplacian *L, double shift, sparse_matrix *out);

/* The part of Q in the rows and columns of `vertices`. row_of: the place of a vertex in there, or
 * -1. */
tug_status bilaplacian_part(const laplacian *L, const int32_t *vertices, int32_t count,
                            const int32_t *row_of, sparse_matrix *out);

#endif
