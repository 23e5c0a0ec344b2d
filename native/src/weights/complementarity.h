/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear complementarity: l >= 0 and y = q + G l >= 0 with l_i y_i = 0, for a symmetric positive
 * semidefinite G; the multipliers of a convex quadratic program. */
#ifndef TUG_COMPLEMENTARITY_H
#define TUG_COMPLEMENTARITY_H

#include "status.h"

typedef struct complementarity {
    int32_t count, capacity;
    double *sign; /* 1 or -1: the problem's G is diag(sign) G diag(sign) */
    double *q;
    double *l;        /* the solution, or the best non-negative guess at it */
    uint8_t *support; /* in and out: where l may be positive */
    /* Work room: the part of G in the support with its factor, and vectors. */
    double *factor, *part, *slack;
    int32_t *members, *pivots;
    int32_t factor_capacity;
} complementarity;

/* Room for `count` unknowns; what is there stays. A zeroed struct is an empty problem. */
tug_status complementarity_reserve(complementarity *problem, int32_t count);

void complementarity_free(complementarity *problem);

/* G: its rows `stride` apart. *solved: whether l solves it; a next call goes on from there. */
tug_status complementarity_solve(complementarity *problem, const double *G, int32_t stride,
                                 int *solved);

#endif
