/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "spread.h"

#include "memory.h"

#include <math.h>

/* Edges from each vertex, and a heap of vertices by distance for Dijkstra's algorithm. Distances
 * only fall from one sample to the next, so each run visits no more than what the new sample is
 * nearest to. */
typedef struct spread_workspace {
    int32_t *starts;     /* #V + 1 */
    int32_t *neighbours; /* 6 #F */
    double *distance;    /* #V: to the nearest sample */
    int32_t *heap;       /* #V */
    int32_t *place;      /* #V: in the heap, or -1 */
    int32_t heap_size;
} spread_workspace;

static void free_workspace(spread_workspace *w)
{
    release(w->starts);
    release(w->neighbours);
    release(w->distance);
    release(w->heap);
    release(w->place);
}

static int allocate_workspace(spread_workspace *w, const tug_mesh *mesh)
{
    size_t n = (size_t)mesh->vertex_count;
    w->starts = allocate(n + 1, sizeof *w->starts);
    w->neighbours = allocate(6 * (size_t)mesh->triangle_count, sizeof *w->neighbours);
    w->distance = allocate(n, sizeof *w->distance);
    w->heap = allocate(n, sizeof *w->heap);
    w->place = allocate(n, sizeof *w->place);
    return w->starts && w->neighbours && w->distance && w->heap && w->place;
}

static void list_neighbours(spread_workspace *w, const tug_mesh *mesh)
{
    int32_t n = mesh->vertex_count, corners = 3 * mesh->triangle_count;
    for (int32_t i = 0; i < corners; i++) {
        w->starts[mesh->triangles[i]] += 2;
    }
    for (int32_t v = 1; v <= n; v++) {
        w->starts[v] += w->starts[v - 1];
    }
    for (int32_t i = 0; i < corners; i++) {
        const int32_t *triangle = mesh->triangles + i / 3 * 3;
        w->neighbours[--w->starts[triangle[i % 3]]] = triangle[(i + 1) % 3];
        w->neighbours[--w->starts[triangle[i % 3]]] = triangle[(i + 2) % 3];
    }
}

static void put(spread_workspace *w, int32_t place, int32_t vertex)
{
    w->heap[place] = vertex;
    w->place[vertex] = place;
}

static void sift_up(spread_workspace *w, int32_t vertex)
{
    int32_t place = w->place[vertex];
    while (place > 0 && w->distance[w->heap[(place - 1) / 2]] > w->distance[vertex]) {
        put(w, place, w->heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(w, place, vertex);
}

static int32_t take_nearest(spread_workspace *w)
{
    int32_t nearest = w->heap[0], last = w->heap[--w->heap_size], place = 0;
    w->place[nearest] = -1;
    for (int32_t child = 1; child < w->heap_size; child = 2 * place + 1) {
        if (child + 1 < w->heap_size &&
            w->distance[w->heap[child + 1]] < w->distance[w->heap[child]]) {
            child++;
        }
        if (w->distance[w->heap[child]] >= w->distance[last]) {
            break;
        }
        put(w, place, w->heap[child]);
        place = child;
    }
    if (w->heap_size > 0) {
        put(w, place, last);
    }
    return nearest;
}

static void approach(spread_workspace *w, int32_t vertex, double distance)
{
    if (distance >= w->distance[vertex]) {
        return;
    }
    w->distance[vertex] = distance;
    if (w->place[vertex] < 0) {
        put(w, w->heap_size++, vertex);
    }
    sift_up(w, vertex);
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

static void add_sample(spread_workspace *w, const tug_mesh *mesh, int32_t sample)
{
    approach(w, sample, 0.0);
    while (w->heap_size > 0) {
        int32_t vertex = take_nearest(w);
        for (int32_t e = w->starts[vertex]; e < w->starts[vertex + 1]; e++) {
            int32_t other = w->neighbours[e];
            approach(w, other, w->distance[vertex] + edge_length(mesh, vertex, other));
        }
    }
}

static int32_t find_farthest(const spread_workspace *w, int32_t count)
{
    int32_t farthest = 0;
    for (int32_t v = 1; v < count; v++) {
        farthest = w->distance[v] > w->distance[farthest] ? v : farthest;
    }
    return farthest;
}

tug_status spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count, int32_t *vertices)
{
    tug_status status = require_sound_mesh(mesh);
    if (status != TUG_OK) {
        return status;
    }
    spread_workspace w = {0};
    if (!allocate_workspace(&w, mesh)) {
        free_workspace(&w);
        return fail_memory();
    }
    list_neighbours(&w, mesh);
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        w.distance[v] = INFINITY;
        w.place[v] = -1;
    }
    int32_t sample = first;
    for (int32_t i = 0; i < count; i++) {
        vertices[i] = sample;
        add_sample(&w, mesh, sample);
        sample = find_farthest(&w, mesh->vertex_count);
    }
    free_workspace(&w);
    return TUG_OK;
}
