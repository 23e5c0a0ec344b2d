/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Triangles with what is computed from them once: areas, cotangents, components. */
#ifndef TUG_MESH_H
#define TUG_MESH_H

#include "status.h"

struct tug_mesh {
    int32_t vertex_count, dimension, triangle_count;
    double *vertices;   /* #V by k */
    int32_t *triangles; /* #F by 3 */
    double *area;       /* #F; 0 where it is less than 1e-12 of the squared longest edge */
    /* #F by 3: half the cotangent of the angle at corner c, the weight of the edge opposite of it.
     * Zero where the triangle has no area. */
    double *half_cotangent;
    double *mass;       /* #V: Voronoi areas, positive around triangles that have area */
    int32_t *component; /* #V */
    int32_t component_count;
    double diagonal; /* of the bounding box */
};

/* tug_create_mesh, its checks included, but for those for NULL. */
tug_status mesh_create(const double *vertices, int32_t vertex_count, int32_t dimension,
                       const int32_t *triangles, int32_t triangle_count, tug_mesh **out);
void mesh_destroy(tug_mesh *mesh);

/* The text of tug_check_mesh, and the numbers of its lines. */
tug_status mesh_describe(const tug_mesh *mesh, char *text, size_t capacity, int32_t *errors,
                         int32_t *warnings);

/* TUG_ERROR_MESH with the first error of tug_check_mesh where there is one. */
tug_status require_sound_mesh(const tug_mesh *mesh);

#endif
