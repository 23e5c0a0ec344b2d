/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rotations of a pose that is given by its positions. */
#ifndef TUG_POSE_ROTATIONS_H
#define TUG_POSE_ROTATIONS_H

#include "mesh/mesh.h"

/* (A 22-23): the rotation closest to sum_e c_ge p_se q_e^T for every group and shape, over the
 * edges of the group's triangles. rotations: #G by #S by k by k. O(#F #S). */
void find_pose_rotations(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                         const int32_t *groups, int32_t group_count, const double *positions,
                         double *rotations);

#endif
