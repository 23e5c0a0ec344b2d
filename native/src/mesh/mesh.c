/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is computed of a mesh when it is made. */
#include "mesh/mesh.h"

#include "memory.h"
#include "mesh/disjoint_sets.h"
#include "mesh/triangle.h"

#include <math.h>
#include <string.h>

/* The parts of a triangle nearer to one corner than to the others, a quarter to a half each. Where
 * an angle is obtuse their common point lies outside, and half the triangle is that corner's. */
static void split_triangle(double edge[3][3], const double *half_cotangent, double area,
                           double share[3])
{
    double part[3];
    int obtuse = -1;
    for (int c = 0; c < 3; c++) {
        obtuse = half_cotangent[c] < 0.0 ? c : obtuse;
        part[c] = 0.25 * half_cotangent[c] * space_dot(edge[c], edge[c]);
    }
    for (int c = 0; c < 3; c++) {
        share[c] =
            obtuse < 0 ? part[(c + 1) % 3] + part[(c + 2) % 3] : (c == obtuse ? 0.5 : 0.25) * area;
    }
}

static void measure_triangle(tug_mesh *mesh, int32_t t)
{
    const int32_t *corner = mesh->triangles + 3 * (size_t)t;
    double edge[3][3], normal[3], share[3];
    double longest = find_edges(mesh->vertices, mesh->dimension, corner, edge);
    space_cross(edge[0], edge[1], normal);
    double area = 0.5 * sqrt(space_dot(normal, normal));
    if (area <= LEAST_AREA * longest) {
        return;
    }
    mesh->area[t] = area;
    double *half_cotangent = mesh->half_cotangent + 3 * (size_t)t;
    for (int c = 0; c < 3; c++) {
        /* cot = cos / sin = dot / (2 area); edge c + 1 runs towards the corner, hence the sign. */
        half_cotangent[c] = -space_dot(edge[(c + 1) % 3], edge[(c + 2) % 3]) / (4.0 * area);
    }
    split_triangle(edge, half_cotangent, area, share);
    for (int c = 0; c < 3; c++) {
        mesh->mass[corner[c]] += share[c];
    }
}

static double box_diagonal(const tug_mesh *mesh)
{
    double square = 0.0;
    size_t k = (size_t)mesh->dimension, entries = k * (size_t)mesh->vertex_count;
    for (size_t d = 0; d < k; d++) {
        double low = mesh->vertices[d], high = low;
        for (size_t i = d; i < entries; i += k) {
            low = fmin(low, mesh->vertices[i]);
            high = fmax(high, mesh->vertices[i]);
        }
        square += (high - low) * (high - low);
    }
    return sqrt(square);
}

static tug_status find_components(tug_mesh *mesh)
{
    int32_t *parent = allocate((size_t)mesh->vertex_count, sizeof *parent);
    if (parent == NULL) {
        return fail_memory();
    }
    separate_sets(parent, mesh->vertex_count);
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *corner = mesh->triangles + 3 * (size_t)t;
        merge_sets(parent, corner[0], corner[1]);
        merge_sets(parent, corner[0], corner[2]);
    }
    /* A set is named by its least vertex, so that vertex is met first. */
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        int32_t first = find_set(parent, v);
        mesh->component[v] = first == v ? mesh->component_count++ : mesh->component[first];
    }
    release(parent);
    return TUG_OK;
}

static tug_status check_input(int32_t vertex_count, int32_t dimension, const int32_t *triangles,
                              int32_t triangle_count)
{
    if (dimension != 2 && dimension != 3) {
        return fail(TUG_ERROR_ARGUMENT, "tug_create_mesh: dimension is %d, not 2 or 3", dimension);
    }
    if (vertex_count < 1 || triangle_count < 1) {
        return fail(TUG_ERROR_ARGUMENT, "tug_create_mesh: a mesh of %d vertices and %d triangles",
                    vertex_count, triangle_count);
    }
    if (triangle_count > INT32_MAX / 3) {
        return fail(TUG_ERROR_ARGUMENT, "tug_create_mesh: more than %d triangles", INT32_MAX / 3);
    }
    for (int32_t i = 0; i < 3 * triangle_count; i++) {
        if (triangles[i] < 0 || triangles[i] >= vertex_count) {
            return fail(TUG_ERROR_ARGUMENT, "tug_create_mesh: triangle %d names vertex %d of %d",
                        i / 3, triangles[i], vertex_count);
        }
    }
    return TUG_OK;
}

static tug_status allocate_mesh(tug_mesh *mesh)
{
    size_t vertices = (size_t)mesh->vertex_count, triangles = (size_t)mesh->triangle_count;
    mesh->vertices = allocate(vertices * (size_t)mesh->dimension, sizeof(double));
    mesh->triangles = allocate(3 * triangles, sizeof(int32_t));
    mesh->area = allocate(triangles, sizeof(double));
    mesh->half_cotangent = allocate(3 * triangles, sizeof(double));
    mesh->mass = allocate(vertices, sizeof(double));
    mesh->component = allocate(vertices, sizeof(int32_t));
    int complete = mesh->vertices && mesh->triangles && mesh->area && mesh->half_cotangent &&
                   mesh->mass && mesh->component;
    return complete ? TUG_OK : fail_memory();
}

static tug_status fill_mesh(tug_mesh *mesh, const double *vertices, const int32_t *triangles)
{
    tug_status status = allocate_mesh(mesh);
    if (status != TUG_OK) {
        return status;
    }
    size_t entries = (size_t)mesh->vertex_count * (size_t)mesh->dimension;
    memcpy(mesh->vertices, vertices, entries * sizeof(double));
    memcpy(mesh->triangles, triangles, 3 * (size_t)mesh->triangle_count * sizeof(int32_t));
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        measure_triangle(mesh, t);
    }
    mesh->diagonal = box_diagonal(mesh);
    return find_components(mesh);
}

tug_status mesh_create(const double *vertices, int32_t vertex_count, int32_t dimension,
                       const int32_t *triangles, int32_t triangle_count, tug_mesh **out)
{
    *out = NULL;
    tug_status status = check_input(vertex_count, dimension, triangles, triangle_count);
    if (status != TUG_OK) {
        return status;
    }
    tug_mesh *mesh = allocate(1, sizeof *mesh);
    if (mesh == NULL) {
        return fail_memory();
    }
    mesh->vertex_count = vertex_count;
    mesh->dimension = dimension;
    mesh->triangle_count = triangle_count;
    status = fill_mesh(mesh, vertices, triangles);
    if (status != TUG_OK) {
        mesh_destroy(mesh);
        return status;
    }
    *out = mesh;
    return TUG_OK;
}

void mesh_destroy(tug_mesh *mesh)
{
    if (mesh == NULL) {
        return;
    }
    release(mesh->vertices);
    release(mesh->triangles);
    release(mesh->area);
    release(mesh->half_cotangent);
    release(mesh->mass);
    release(mesh->component);
    release(mesh);
}
