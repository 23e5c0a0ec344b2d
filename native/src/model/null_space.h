/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The examples themselves have no energy, and neither has a translation: that much is known of a
 * reduced energy exactly, and rounding has lost it. Putting it back lets handles that sit on an
 * example be seen as such: the square root of (A 10) would show an error of 1e-14 as 1e-7. */
#ifndef TUG_NULL_SPACE_H
#define TUG_NULL_SPACE_H

#include "model/reduction.h"

/* Make the quadratic form [C, -K F; -(K F)^T, F^T L F] in (V, Y) vanish on the span of N's columns.
 * N: turned + rows by `columns`, overwritten. O((turned + rows)^2 columns). */
tug_status restore_null_space(reduction *energy, double *N, int32_t columns);

#endif
