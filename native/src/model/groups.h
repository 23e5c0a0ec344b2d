/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The edge groups of (A 7): triangles with similar weights. */
#ifndef TUG_GROUPS_H
#define TUG_GROUPS_H

#include "status.h"

/* The contract of tug_cluster_triangles; the counts have been checked. */
tug_status cluster_triangles(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                             int32_t wanted, const progress_range *range, int32_t *groups,
                             int32_t *group_count);

#endif
