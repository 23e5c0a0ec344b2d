/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Distances along the edges of a mesh, by Dijkstra's algorithm from ever more sources. Distances
 * only fall from one source to the next, so each is followed no farther than where it is the
 * nearest. */
#ifndef TUG_EDGE_DISTANCE_H
#define TUG_EDGE_DISTANCE_H

#include "mesh/mesh.h"

typedef struct edge_distance {
    const tug_mesh *mesh;
    double *distance;    /* #V: to the nearest source, INFINITY where there is none */
    int32_t *source;     /* #V: that source, of several equally near one */
    int32_t *starts;     /* #V + 1 */
    int32_t *neighbours; /* 6 #F */
    int32_t *heap;       /* #V: vertices by distance */
    int32_t *place;      /* #V: in the heap, or -1 */
    int32_t heap_size;
} edge_distance;

/* Without sources. The mesh has to be sound, and to outlive it. */
tug_status edge_distance_create(const tug_mesh *mesh, edge_distance *out);

/* Frees the arrays, not the struct. NULL members are allowed. */
void edge_distance_free(edge_distance *d);

/* One more source. Distances hold after follow_sources. */
void add_source(edge_distance *d, int32_t vertex);

/* O(v log v), v being the vertices that are nearest to sources added since the last call. */
void follow_sources(edge_distance *d);

/* tug_find_distances, its arguments checked. */
tug_status find_distances(const tug_mesh *mesh, const int32_t *sources, int32_t count,
                          double *distances, int32_t *nearest);

#endif
