/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Farthest-point sampling along the edges of a mesh. */
#ifndef TUG_SPREAD_H
#define TUG_SPREAD_H

#include "mesh/mesh.h"

/* tug_spread_vertices, its arguments checked. */
tug_status spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count, int32_t *vertices);

#endif
