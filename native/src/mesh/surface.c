/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/surface.h"

#include "mesh/triangle.h"

#include <math.h>
#include <string.h>

/* A normal whose triangles cancel to less than this is rounding. */
static const double LEAST_NORMAL = 1e-12;

/* A triangle's unit normal at each of its corners, times the angle there. */
static void add_normals(const double *positions, const int32_t *corner, double *normals)
{
    double edge[3][3], normal[3];
    double longest = sqrt(find_edges(positions, 3, corner, edge));
    for (int c = 0; c < 3; c++) { /* else their products could overflow */
        for (int d = 0; d < 3; d++) {
            edge[c][d] /= longest;
        }
    }
    space_cross(edge[0], edge[1], normal);
    double length = sqrt(space_dot(normal, normal));
    if (!(0.5 * length > LEAST_AREA)) {
        return;
    }
    for (int c = 0; c < 3; c++) {
        double cosine = -space_dot(edge[(c + 1) % 3], edge[(c + 2) % 3]);
        double share = atan2(length, cosine) / length;
        for (int d = 0; d < 3; d++) {
            normals[3 * (size_t)corner[c] + (size_t)d] += share * normal[d];
        }
    }
}

void find_normals(const tug_mesh *mesh, const double *positions, double *normals)
{
    memset(normals, 0, 3 * (size_t)mesh->vertex_count * sizeof *normals);
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        add_normals(positions, mesh->triangles + 3 * (size_t)t, normals);
    }
    for (size_t v = 0; v < (size_t)mesh->vertex_count; v++) {
        double *normal = normals + 3 * v;
        double length = sqrt(space_dot(normal, normal));
        double scale = length > LEAST_NORMAL ? 1.0 / length : 0.0;
        for (int d = 0; d < 3; d++) {
            normal[d] *= scale;
        }
    }
}
