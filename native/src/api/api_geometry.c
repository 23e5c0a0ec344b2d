/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The public calls on meshes and points: argument checks, and nothing else. */
#include "api/arguments.h"
#include "mesh/edge_distance.h"
#include "mesh/mesh.h"
#include "mesh/points.h"
#include "mesh/spread.h"
#include "mesh/surface.h"

#include <string.h>

tug_status tug_create_mesh(const double *vertices, int32_t vertex_count, int32_t dimension,
                           const int32_t *triangles, int32_t triangle_count, tug_mesh **out)
{
    REQUIRE_POINTER("tug_create_mesh", out);
    *out = NULL;
    REQUIRE_POINTER("tug_create_mesh", vertices);
    REQUIRE_POINTER("tug_create_mesh", triangles);
    REQUIRE(vertex_count > 0, "tug_create_mesh: the mesh has no vertices");
    REQUIRE(triangle_count > 0, "tug_create_mesh: the mesh has no faces");
    REQUIRE(triangle_count <= INT32_MAX / 3, "tug_create_mesh: %d triangles are too many",
            triangle_count);
    REQUIRE(dimension == 2 || dimension == 3, "tug_create_mesh: the dimension is %d, not 2 or 3",
            dimension);
    for (int32_t i = 0; i < 3 * triangle_count; i++) {
        REQUIRE(triangles[i] >= 0 && triangles[i] < vertex_count,
                "tug_create_mesh: triangle %d names vertex %d of %d", i / 3, triangles[i],
                vertex_count);
    }
    return mesh_create(vertices, vertex_count, dimension, triangles, triangle_count, out);
}

void tug_destroy_mesh(tug_mesh *mesh)
{
    mesh_destroy(mesh);
}

tug_status tug_check_mesh(const tug_mesh *mesh, char *text, size_t capacity, int32_t *errors,
                          int32_t *warnings)
{
    REQUIRE_POINTER("tug_check_mesh", mesh);
    REQUIRE_POINTER("tug_check_mesh", text);
    REQUIRE_POINTER("tug_check_mesh", errors);
    REQUIRE_POINTER("tug_check_mesh", warnings);
    REQUIRE(capacity > 0, "tug_check_mesh: the text has no room");
    return mesh_describe(mesh, text, capacity, errors, warnings);
}

tug_status tug_find_components(const tug_mesh *mesh, int32_t *component, int32_t *count)
{
    REQUIRE_POINTER("tug_find_components", mesh);
    REQUIRE_POINTER("tug_find_components", component);
    REQUIRE_POINTER("tug_find_components", count);
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        component[v] = mesh->component[v];
    }
    *count = mesh->component_count;
    return TUG_OK;
}

tug_status tug_spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count,
                               int32_t *vertices)
{
    REQUIRE_POINTER("tug_spread_vertices", mesh);
    REQUIRE_POINTER("tug_spread_vertices", vertices);
    REQUIRE(count > 0 && count <= mesh->vertex_count,
            "tug_spread_vertices: %d of %d vertices are wanted", count, mesh->vertex_count);
    REQUIRE(first >= 0 && first < mesh->vertex_count, "tug_spread_vertices: there is no vertex %d",
            first);
    return spread_vertices(mesh, first, count, vertices);
}

tug_status tug_find_distances(const tug_mesh *mesh, const int32_t *sources, int32_t count,
                              double *distances, int32_t *nearest)
{
    REQUIRE_POINTER("tug_find_distances", mesh);
    REQUIRE_POINTER("tug_find_distances", sources);
    REQUIRE_POINTER("tug_find_distances", distances);
    REQUIRE(count > 0, "tug_find_distances: there are no vertices to measure from");
    for (int32_t i = 0; i < count; i++) {
        REQUIRE(sources[i] >= 0 && sources[i] < mesh->vertex_count,
                "tug_find_distances: there is no vertex %d", sources[i]);
    }
    return find_distances(mesh, sources, count, distances, nearest);
}

tug_status tug_find_areas(const tug_mesh *mesh, double *areas)
{
    REQUIRE_POINTER("tug_find_areas", mesh);
    REQUIRE_POINTER("tug_find_areas", areas);
    tug_status status = require_sound_mesh(mesh);
    if (status == TUG_OK) {
        memcpy(areas, mesh->mass, (size_t)mesh->vertex_count * sizeof *areas);
    }
    return status;
}

tug_status tug_get_cotangents(const tug_mesh *mesh, double *half_cotangents)
{
    REQUIRE_POINTER("tug_get_cotangents", mesh);
    REQUIRE_POINTER("tug_get_cotangents", half_cotangents);
    tug_status status = require_sound_mesh(mesh);
    if (status == TUG_OK) {
        size_t corners = 3 * (size_t)mesh->triangle_count;
        memcpy(half_cotangents, mesh->half_cotangent, corners * sizeof *half_cotangents);
    }
    return status;
}

tug_status tug_find_normals(const tug_mesh *mesh, const double *positions, double *normals)
{
    REQUIRE_POINTER("tug_find_normals", mesh);
    REQUIRE_POINTER("tug_find_normals", positions);
    REQUIRE_POINTER("tug_find_normals", normals);
    REQUIRE(mesh->dimension == 3, "tug_find_normals: the dimension is %d, not 3", mesh->dimension);
    ptrdiff_t bad = find_too_far(positions, 3 * (size_t)mesh->vertex_count);
    REQUIRE(bad < 0, "tug_find_normals: vertex %td has a coordinate that is not within 1e150",
            bad / 3);
    find_normals(mesh, positions, normals);
    return TUG_OK;
}

tug_status tug_create_points(const double *points, int32_t count, int32_t dimension,
                             tug_points **out)
{
    REQUIRE_POINTER("tug_create_points", out);
    *out = NULL;
    REQUIRE_POINTER("tug_create_points", points);
    REQUIRE(count > 0, "tug_create_points: there are no points");
    REQUIRE(dimension >= 1 && dimension <= MAX_POINT_DIMENSION,
            "tug_create_points: the dimension is %d, not 1 to %d", dimension, MAX_POINT_DIMENSION);
    ptrdiff_t bad = find_too_far(points, (size_t)count * (size_t)dimension);
    REQUIRE(bad < 0, "tug_create_points: point %td has a coordinate that is not within 1e150",
            bad / dimension);
    return points_create(points, count, dimension, out);
}

void tug_destroy_points(tug_points *points)
{
    points_destroy(points);
}

tug_status tug_find_nearest(const tug_points *points, const double *queries, int32_t count,
                            double limit, int32_t *nearest, double *distances)
{
    REQUIRE_POINTER("tug_find_nearest", points);
    REQUIRE_POINTER("tug_find_nearest", queries);
    REQUIRE_POINTER("tug_find_nearest", nearest);
    REQUIRE_POINTER("tug_find_nearest", distances);
    REQUIRE(count > 0, "tug_find_nearest: there are no queries");
    REQUIRE(limit >= 0.0, "tug_find_nearest: the limit is %g: it cannot be negative", limit);
    int32_t d = points->dimension;
    ptrdiff_t bad = find_too_far(queries, (size_t)count * (size_t)d);
    REQUIRE(bad < 0, "tug_find_nearest: query %td has a coordinate that is not within 1e150",
            bad / d);
    for (size_t i = 0; i < (size_t)count; i++) {
        find_nearest(points, queries + i * (size_t)d, limit, nearest + i, distances + i);
    }
    return TUG_OK;
}
