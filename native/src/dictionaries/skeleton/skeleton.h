/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bones and weights from the examples themselves, for the skeleton dictionary of the FBT paper:
 * smooth skinning decomposition with rigid bones (Le and Deng 2012). */
#ifndef TUG_SKELETON_H
#define TUG_SKELETON_H

#include "status.h"

/* The contract of tug_find_skeleton; the counts and values have been checked. */
tug_status find_skeleton(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                         int32_t wanted, const tug_skeleton_options *options,
                         const progress_range *range, double *weights, int32_t *bone_count,
                         tug_skeleton_info *info);

#endif
