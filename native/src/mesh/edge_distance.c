/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/edge_distance.h"

#include "memory.h"

#include <math.h>
#include <string.h>

void edge_distance_free(edge_distance *d)
{
    release(d->distance);
    release(d->source);
    release(d->starts);
    release(d->neighbours);
    release(d->heap);
    release(d->place);
}

static int allocate_arrays(edge_distance *d)
{
    size_t n = (size_t)d->mesh->vertex_count;
    d->distance = allocate(n, sizeof *d->distance);
    d->source = allocate(n, sizeof *d->source);
    d->starts = allocate(n + 1, sizeof *d->starts);
    d->neighbours = allocate(6 * (size_t)d->mesh->triangle_count, sizeof *d->neighbours);
    d->heap = allocate(n, sizeof *d->heap);
    d->place = allocate(n, sizeof *d->place);
    return d->distance && d->source && d->starts && d->neighbours && d->heap && d->place;
}

static void list_neighbours(edge_distance *d)
{
    const tug_mesh *mesh = d->mesh;
    int32_t n = mesh->vertex_count, corners = 3 * mesh->triangle_count;
    for (int32_t i = 0; i < corners; i++) {
        d->starts[mesh->triangles[i]] += 2;
    }
    for (int32_t v = 1; v <= n; v++) {
        d->starts[v] += d->starts[v - 1];
    }
    for (int32_t i = 0; i < corners; i++) {
        const int32_t *triangle = mesh->triangles + i / 3 * 3;
        d->neighbours[--d->starts[triangle[i % 3]]] = triangle[(i + 1) % 3];
        d->neighbours[--d->starts[triangle[i % 3]]] = triangle[(i + 2) % 3];
    }
}

static void put(edge_distance *d, int32_t place, int32_t vertex)
{
    d->heap[place] = vertex;
    d->place[vertex] = place;
}

static void sift_up(edge_distance *d, int32_t vertex)
{
    int32_t place = d->place[vertex];
    while (place > 0 && d->distance[d->heap[(place - 1) / 2]] > d->distance[vertex]) {
        put(d, place, d->heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(d, place, vertex);
}

static int32_t take_nearest(edge_distance *d)
{
    int32_t nearest = d->heap[0], last = d->heap[--d->heap_size], place = 0;
    d->place[nearest] = -1;
    for (int32_t child = 1; child < d->heap_size; child = 2 * place + 1) {
        if (child + 1 < d->heap_size &&
            d->distance[d->heap[child + 1]] < d->distance[d->heap[child]]) {
            child++;
        }
        if (d->distance[d->heap[child]] >= d->distance[last]) {
            break;
        }
        put(d, place, d->heap[child]);
        place = child;
    }
    if (d->heap_size > 0) {
        put(d, place, last);
    }
    return nearest;
}

static void approach(edge_distance *d, int32_t vertex, double distance, int32_t source)
{
    if (distance >= d->distance[vertex]) {
        return;
    }
    d->distance[vertex] = distance;
    d->source[vertex] = source;
    if (d->place[vertex] < 0) {
        put(d, d->heap_size++, vertex);
    }
    sift_up(d, vertex);
}

static double edge_length(const tug_mesh *mesh, int32_t a, int32_t b)
{
    double squares = 0.0;
    for (int32_t c = 0; c < mesh->dimension; c++) {
        double difference = mesh->vertices[(size_t)a * (size_t)mesh->dimension + (size_t)c] -
                            mesh->vertices[(size_t)b * (size_t)mesh->dimension + (size_t)c];
        squares += difference * difference;
    }
    return sqrt(squares);
}

tug_status edge_distance_create(const tug_mesh *mesh, edge_distance *out)
{
    memset(out, 0, sizeof *out);
    tug_status status = require_sound_mesh(mesh);
    if (status != TUG_OK) {
        return status;
    }
    out->mesh = mesh;
    if (!allocate_arrays(out)) {
        edge_distance_free(out);
        return fail_memory();
    }
    list_neighbours(out);
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        out->distance[v] = INFINITY;
        out->place[v] = -1;
    }
    return TUG_OK;
}

void add_source(edge_distance *d, int32_t vertex)
{
    approach(d, vertex, 0.0, vertex);
}

void follow_sources(edge_distance *d)
{
    while (d->heap_size > 0) {
        int32_t vertex = take_nearest(d);
        for (int32_t e = d->starts[vertex]; e < d->starts[vertex + 1]; e++) {
            int32_t other = d->neighbours[e];
            double distance = d->distance[vertex] + edge_length(d->mesh, vertex, other);
            approach(d, other, distance, d->source[vertex]);
        }
    }
}

/* nearest: for each vertex the place of its source, or -1. Takes the empty heap's places. */
static void number_sources(edge_distance *d, const int32_t *sources, int32_t count,
                           int32_t *nearest)
{
    for (int32_t i = count - 1; i >= 0; i--) {
        d->place[sources[i]] = i;
    }
    for (int32_t v = 0; v < d->mesh->vertex_count; v++) {
        nearest[v] = d->distance[v] < INFINITY ? d->place[d->source[v]] : -1;
    }
}

tug_status find_distances(const tug_mesh *mesh, const int32_t *sources, int32_t count,
                          double *distances, int32_t *nearest)
{
    edge_distance d;
    tug_status status = edge_distance_create(mesh, &d);
    if (status != TUG_OK) {
        return status;
    }
    for (int32_t i = 0; i < count; i++) {
        add_source(&d, sources[i]);
    }
    follow_sources(&d);
    memcpy(distances, d.distance, (size_t)mesh->vertex_count * sizeof *distances);
    if (nearest != NULL) {
        number_sources(&d, sources, count, nearest);
    }
    edge_distance_free(&d);
    return TUG_OK;
}
