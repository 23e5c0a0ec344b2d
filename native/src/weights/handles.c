/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "weights/handles.h"

#include "memory.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

void handle_map_free(handle_map *map)
{
    release(map->owner);
    release(map->follows);
    release(map->unknowns);
    release(map->row_of);
    memset(map, 0, sizeof *map);
}

static tug_status allocate_map(const tug_mesh *mesh, handle_map *map)
{
    size_t size = (size_t)mesh->vertex_count, components = (size_t)mesh->component_count;
    memset(map, 0, sizeof *map);
    map->owner = allocate(size, sizeof(int32_t));
    map->follows = allocate(components, sizeof(int32_t));
    map->unknowns = allocate(size, sizeof(int32_t));
    map->row_of = allocate(size, sizeof(int32_t));
    if (!map->owner || !map->follows || !map->unknowns || !map->row_of) {
        return fail_memory();
    }
    for (size_t v = 0; v < size; v++) {
        map->owner[v] = no_handle;
        map->row_of[v] = -1;
    }
    for (size_t c = 0; c < components; c++) {
        map->follows[c] = no_handle;
    }
    return TUG_OK;
}

static tug_status claim_vertex(const tug_mesh *mesh, handle_map *map, int32_t handle,
                               int32_t vertex)
{
    if (vertex < 0 || vertex >= mesh->vertex_count) {
        return fail(TUG_ERROR_ARGUMENT, "tug_compute_weights: handle %d names vertex %d of %d",
                    handle, vertex, mesh->vertex_count);
    }
    int32_t owner = map->owner[vertex];
    if (owner != no_handle && owner != handle) {
        return fail(TUG_ERROR_HANDLES,
                    "tug_compute_weights: handles %d and %d share vertex %d: give each handle "
                    "vertices of its own",
                    owner, handle, vertex);
    }
    map->owner[vertex] = handle;
    int32_t *follows = map->follows + mesh->component[vertex];
    *follows = *follows == no_handle || *follows == handle ? handle : several_handles;
    return TUG_OK;
}

static tug_status claim_vertices(const tug_mesh *mesh, const int32_t *starts,
                                 const int32_t *vertices, int32_t handle_count, handle_map *map)
{
    for (int32_t h = 0; h < handle_count; h++) {
        for (int32_t i = starts[h]; i < starts[h + 1]; i++) {
            tug_status status = claim_vertex(mesh, map, h, vertices[i]);
            if (status != TUG_OK) {
                return status;
            }
        }
    }
    return TUG_OK;
}

static tug_status refuse_component(const tug_mesh *mesh, int32_t component)
{
    int32_t count = 0, example = -1;
    for (int32_t v = mesh->vertex_count - 1; v >= 0; v--) {
        if (mesh->component[v] == component) {
            count++;
            example = v;
        }
    }
    return fail(TUG_ERROR_HANDLES,
                "tug_compute_weights: component %d of %d (%d vertices, for example vertex %d) has "
                "no handle: put a handle on it, or let it follow the nearest handle",
                component, mesh->component_count, count, example);
}

static double squared_distance(const tug_mesh *mesh, int32_t a, int32_t b)
{
    size_t k = (size_t)mesh->dimension;
    double sum = 0.0;
    for (size_t d = 0; d < k; d++) {
        double difference = mesh->vertices[k * (size_t)a + d] - mesh->vertices[k * (size_t)b + d];
        sum += difference * difference;
    }
    return sum;
}

/* The handle of the handle vertex nearest to any vertex of an orphan. distance: of each component
 * to its nearest handle so far. */
static void follow_nearest_handles(const tug_mesh *mesh, const int32_t *vertices, int32_t count,
                                   handle_map *map, double *distance)
{
    for (int32_t c = 0; c < mesh->component_count; c++) {
        distance[c] = map->follows[c] == no_handle ? INFINITY : -1.0;
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        int32_t component = mesh->component[v];
        for (int32_t i = 0; distance[component] >= 0.0 && i < count; i++) {
            double here = squared_distance(mesh, v, vertices[i]);
            if (here < distance[component]) {
                distance[component] = here;
                map->follows[component] = map->owner[vertices[i]];
            }
        }
    }
}

static tug_status adopt_orphans(const tug_mesh *mesh, const int32_t *vertices, int32_t count,
                                int follow_nearest, handle_map *map)
{
    int32_t orphan = 0;
    while (orphan < mesh->component_count && map->follows[orphan] != no_handle) {
        orphan++;
    }
    if (orphan == mesh->component_count) {
        return TUG_OK;
    }
    if (!follow_nearest) {
        return refuse_component(mesh, orphan);
    }
    double *distance = allocate((size_t)mesh->component_count, sizeof *distance);
    if (distance == NULL) {
        return fail_memory();
    }
    follow_nearest_handles(mesh, vertices, count, map, distance);
    release(distance);
    return TUG_OK;
}

static void list_unknowns(const tug_mesh *mesh, handle_map *map)
{
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        if (map->owner[v] == no_handle && map->follows[mesh->component[v]] == several_handles) {
            map->row_of[v] = map->unknown_count;
            map->unknowns[map->unknown_count++] = v;
        }
    }
}

tug_status handle_map_create(const tug_mesh *mesh, const int32_t *handle_starts,
                             const int32_t *handle_vertices, int32_t handle_count,
                             int follow_nearest, handle_map *out)
{
    tug_status status = allocate_map(mesh, out);
    if (status == TUG_OK) {
        status = claim_vertices(mesh, handle_starts, handle_vertices, handle_count, out);
    }
    if (status == TUG_OK) {
        status =
            adopt_orphans(mesh, handle_vertices, handle_starts[handle_count], follow_nearest, out);
    }
    if (status == TUG_OK) {
        list_unknowns(mesh, out);
    } else {
        handle_map_free(out);
    }
    return status;
}
