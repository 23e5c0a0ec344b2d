/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/spread.h"

#include "mesh/edge_distance.h"

static int32_t find_farthest(const edge_distance *d)
{
    int32_t farthest = 0;
    for (int32_t v = 1; v < d->mesh->vertex_count; v++) {
        farthest = d->distance[v] > d->distance[farthest] ? v : farthest;
    }
    return farthest;
}

tug_status spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count, int32_t *vertices)
{
    edge_distance d;
    tug_status status = edge_distance_create(mesh, &d);
    if (status != TUG_OK) {
        return status;
    }
    int32_t sample = first;
    for (int32_t i = 0; i < count; i++) {
        vertices[i] = sample;
        add_source(&d, sample);
        follow_sources(&d);
        sample = find_farthest(&d);
    }
    edge_distance_free(&d);
    return TUG_OK;
}
