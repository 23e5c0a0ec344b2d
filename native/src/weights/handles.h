/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which handle a vertex or a component belongs to, and whether the handles are usable. */
#ifndef TUG_HANDLES_H
#define TUG_HANDLES_H

#include "status.h"

/* What a component follows, where it is not one handle alone. */
enum { no_handle = -1, several_handles = -2 };

typedef struct handle_map {
    int32_t *owner;    /* #V: the handle of a vertex, or no_handle */
    int32_t *follows;  /* of a component: its only handle, or several_handles */
    int32_t *unknowns; /* vertices without owner in components of several handles */
    int32_t *row_of;   /* #V: the place of a vertex in there, or -1 */
    int32_t unknown_count;
} handle_map;

/* TUG_ERROR_HANDLES where handles share a vertex, or where a component has none and is not to
 * follow the nearest one. */
tug_status handle_map_create(const tug_mesh *mesh, const int32_t *handle_starts,
                             const int32_t *handle_vertices, int32_t handle_count,
                             int follow_nearest, handle_map *out);

/* Frees the arrays, not the struct. NULL members are allowed. */
void handle_map_free(handle_map *map);

#endif
