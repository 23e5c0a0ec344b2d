/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The largest eigenpairs of a symmetric operator, multiple ones included. */
#ifndef TUG_KRYLOV_H
#define TUG_KRYLOV_H

#include "status.h"

enum { krylov_block = 4 }; /* vectors that the operator is applied to at a time */

/* images: of krylov_block vectors, one after the other. */
typedef tug_status (*krylov_operator)(void *context, const double *vectors, double *images);

typedef struct krylov_problem {
    int32_t size;
    krylov_operator apply; /* positive definite */
    void *context;
    double tolerance;            /* of a pair's residual, in parts of its eigenvalue */
    const progress_range *range; /* with its stage: reported at every application */
    const char *stage;
} krylov_problem;

/* The `wanted` largest eigenpairs orthogonal to the `known` orthonormal vectors that lead `vectors`
 * (known + wanted by size) and span an invariant subspace; the vectors found follow them, by
 * falling values (wanted). known + wanted is at most the size. applications: of the operator.
 * TUG_ERROR_NUMERIC where the tolerance cannot be met. The start is always the same. */
tug_status krylov_largest(const krylov_problem *problem, int32_t known, int32_t wanted,
                          double *vectors, double *values, int32_t *applications);

#endif
