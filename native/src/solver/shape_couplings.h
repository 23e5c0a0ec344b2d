/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How turned shapes pull on each other's moments: A = K Z K^T of moments.h in blocks of two shapes,
 * each over all groups, so that its products run along memory.
 *
 * Vectors are stacks of k by k blocks, one a pair (g, s), as rows of columns: #S by k by `stride`,
 * where column c of shape s has component a of group g at g k + a. A rotation's block is its
 * transpose, so that row c of R stands there. */
#ifndef TUG_SHAPE_COUPLINGS_H
#define TUG_SHAPE_COUPLINGS_H

#include "model/model.h"

typedef struct shape_couplings {
    int32_t shapes, k;
    int32_t size;   /* #G k */
    int32_t stride; /* the same in whole vectors: what is beyond is zero */
    int32_t all;    /* 0: only blocks of a shape with itself */
    double *blocks; /* of shapes s <= t: `size` by `stride` */
} shape_couplings;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int couplings_create(const tug_model *model, int all, shape_couplings *couplings);
void couplings_destroy(shape_couplings *couplings);

/* The blocks of a joint problem: the model's, or the same with rows that give way. O((#G #S k)^2).
 */
void find_couplings(const tug_model *model, const reduction *energy, shape_couplings *couplings);

/* Doubles of one shape's part of a stack. */
static inline int32_t slice_size(const shape_couplings *couplings)
{
    return couplings->k * couplings->stride;
}

/* The block of a shape with itself. */
const double *own_coupling(const shape_couplings *couplings, int32_t s);

/* AX = A X for the shapes from `first` on, as if the others were zero; only their part is written.
 */
void couple_shapes(const shape_couplings *couplings, int32_t first, int32_t count, const double *X,
                   double *AX);

/* Between one shape's part of a stack, its slice, and k by k blocks, or rotations, of which two
 * groups' are `pitch` doubles apart. */
void scatter_blocks(const shape_couplings *couplings, const double *blocks, int32_t pitch,
                    double *slice);
void gather_rotations(const shape_couplings *couplings, const double *slice, int32_t pitch,
                      double *R);
void scatter_rotations(const shape_couplings *couplings, const double *R, int32_t pitch,
                       double *slice);

#endif
