/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a surface is like around its vertices. */
#ifndef TUG_SURFACE_H
#define TUG_SURFACE_H

#include "mesh/mesh.h"

/* tug_find_normals, its arguments checked. */
void find_normals(const tug_mesh *mesh, const double *positions, double *normals);

#endif
