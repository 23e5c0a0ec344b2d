/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Four doubles at a time, for inner loops whose sums have to stay in registers: compilers turn
 * plain loops into vectors, but not into tiles. Where the processor has shorter vectors, the
 * compiler splits these. */
#ifndef TUG_VECTOR_H
#define TUG_VECTOR_H

#include "dense/dispatch.h"

#include <stddef.h>

enum { LANES = 4 };

/* At any address of a double. */
typedef double packed __attribute__((vector_size(LANES * sizeof(double)), aligned(8), may_alias));

/* For the parts of a DISPATCHED function: they are compiled with it, for the same processor, and
 * unrolled over the constants that they are called with. */
#define PART static inline __attribute__((always_inline))

PART const packed *packed_at(const double *first)
{
    return (const packed *)first;
}

PART packed *writable_packed_at(double *first)
{
    return (packed *)first;
}

PART double sum_of_lanes(const packed *x)
{
    return ((*x)[0] + (*x)[1]) + ((*x)[2] + (*x)[3]);
}

#endif
