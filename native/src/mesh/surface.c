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

/* The parts of a triangle nearer to one corner than to the others. Where an angle is obtuse their
 * common point lies outside, and half the triangle is that corner's, a quarter each other's. */
static void split_triangle(const tug_mesh *mesh, int32_t t, double share[3])
{
    const double *half_cotangent = mesh->half_cotangent + 3 * (size_t)t;
    double edge[3][3], part[3];
    find_edges(mesh->vertices, mesh->dimension, mesh->triangles + 3 * (size_t)t, edge);
    int obtuse = -1;
    for (int c = 0; c < 3; c++) {
        obtuse = half_cotangent[c] < 0.0 ? c : obtuse;
        part[c] = 0.25 * half_cotangent[c] * space_dot(edge[c], edge[c]);
    }
    for (int c = 0; c < 3; c++) {
        share[c] = obtuse < 0 ? part[(c + 1) % 3] + part[(c + 2) % 3]
                              : (c == obtuse ? 0.5 : 0.25) * mesh->area[t];
    }
}

void find_vertex_areas(const tug_mesh *mesh, double *areas)
{
    memset(areas, 0, (size_t)mesh->vertex_count * sizeof *areas);
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        double share[3];
        split_triangle(mesh, t, share);
        for (int c = 0; c < 3; c++) {
            areas[mesh->triangles[3 * (size_t)t + (size_t)c]] += share[c];
        }
    }
}
