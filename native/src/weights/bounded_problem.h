/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The smoothest function within [0, 1] with given values at some vertices: the minimiser of
 * w^T Q w / 2. */
#ifndef TUG_BOUNDED_PROBLEM_H
#define TUG_BOUNDED_PROBLEM_H

#include "weights/laplacian.h"

#include <stdatomic.h>

/* What all handles share; not changed by solving. */
typedef struct bounded_problem {
    const laplacian *L;
    const int32_t *unknowns; /* vertices without a given value */
    const int32_t *row_of;   /* of a vertex: its place in there, or -1 */
    int32_t unknown_count;
    const sparse_factor *factor; /* of Q in the unknowns */
    double tolerance;            /* relative duality gap */
    int32_t max_iterations;
} bounded_problem;

typedef struct bounded_result {
    int converged;
    int32_t iterations;
    double gap;          /* relative duality gap */
    double kkt_residual; /* of the stationarity, relative to the largest gradient */
    double violation;    /* of the bounds, before the final clamp */
} bounded_result;

/* w, in: the given values, and zero elsewhere; out: the function, within its bounds.
 * TUG_ERROR_CANCELLED where `stop` is set meanwhile. */
tug_status bounded_solve(const bounded_problem *problem, double *w, const atomic_int *stop,
                         bounded_result *result);

#endif
