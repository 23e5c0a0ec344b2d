/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where a sequence of steps is heading, from its last few (Anderson 1965): of all weighted means of
 * their starts, weights adding up to one, the one whose steps cancel best. */
#ifndef TUG_EXTRAPOLATION_H
#define TUG_EXTRAPOLATION_H

#include <stdint.h>

enum { EXTRAPOLATION_DEPTH = 10 };

/* A point is a vector of `size` numbers: `measured` of them, then their image under the positive
 * semidefinite matrix that measures steps, then whatever else goes with them. */
typedef struct extrapolation {
    int32_t size, measured;
    int32_t count, next; /* steps that are known; where the next one goes */
    double *end;         /* depth by size: where each step led */
    double *step;        /* depth by size */
    double products[EXTRAPOLATION_DEPTH][EXTRAPOLATION_DEPTH]; /* of steps, as they are measured */
} extrapolation;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int extrapolation_create(int32_t size, int32_t measured, extrapolation *e);
void extrapolation_destroy(extrapolation *e);

void forget_steps(extrapolation *e);
void record_step(extrapolation *e, const double *from, const double *to);

/* ahead: size; the mean of the ends. Returns 0 where fewer than two steps are known or they tell
 * nothing. */
int extrapolate(const extrapolation *e, double *ahead);

#endif
