/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounded biharmonic weights (Jacobson et al. 2011), as used in section 5.1 of the AMRAP paper. */
#ifndef TUG_BOUNDED_BIHARMONIC_H
#define TUG_BOUNDED_BIHARMONIC_H

#include "status.h"

/* The contract of tug_compute_weights; the counts and the handle starts have been checked. */
tug_status bounded_biharmonic_weights(const tug_mesh *mesh, const int32_t *handle_starts,
                                      const int32_t *handle_vertices, int32_t handle_count,
                                      const tug_weights_options *options,
                                      const progress_range *range, double *weights,
                                      tug_weights_info *info);

#endif
