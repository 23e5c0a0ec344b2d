/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Eigenfunctions of the Laplace-Beltrami operator as weight functions (section 4.1 of the FBT
 * paper). */
#ifndef TUG_EIGENFUNCTIONS_H
#define TUG_EIGENFUNCTIONS_H

#include "status.h"

/* The contract of tug_compute_eigenfunctions; the count has been checked. */
tug_status compute_eigenfunctions(const tug_mesh *mesh, int32_t count, const progress_range *range,
                                  double *values, double *functions, tug_eigenfunctions_info *info);

#endif
