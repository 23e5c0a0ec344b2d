/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/pose_rotations.h"

#include "dense/rotation.h"

#include <string.h>

/* M += weight p q^T for the edge between two vertices. */
static void add_edge(int32_t k, double weight, const double *shape, const double *positions,
                     int32_t from, int32_t to, double *M)
{
    double p[3], q[3];
    for (int32_t a = 0; a < k; a++) {
        p[a] =
            shape[(size_t)to * (size_t)k + (size_t)a] - shape[(size_t)from * (size_t)k + (size_t)a];
        q[a] = positions[(size_t)to * (size_t)k + (size_t)a] -
               positions[(size_t)from * (size_t)k + (size_t)a];
    }
    for (int32_t i = 0; i < k * k; i++) {
        M[i] += weight * p[i / k] * q[i % k];
    }
}

void find_pose_rotations(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                         const int32_t *groups, int32_t group_count, const double *positions,
                         double *rotations)
{
    int32_t k = mesh->dimension, kk = k * k, pairs = group_count * shape_count;
    size_t coordinates = (size_t)mesh->vertex_count * (size_t)k;
    memset(rotations, 0, (size_t)(pairs * kk) * sizeof *rotations);
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const int32_t *corner = mesh->triangles + i / 3 * 3;
        double *M = rotations + (size_t)(groups[i / 3] * shape_count * kk);
        for (int32_t s = 0; s < shape_count; s++) {
            add_edge(k, mesh->half_cotangent[i], shapes + (size_t)s * coordinates, positions,
                     corner[(i + 1) % 3], corner[(i + 2) % 3], M + s * kk);
        }
    }
    closest_rotations(k, pairs, rotations, rotations);
}
