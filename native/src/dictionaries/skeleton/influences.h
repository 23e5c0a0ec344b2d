/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sparse convex weights of vertices for bones whose motions are given. */
#ifndef TUG_INFLUENCES_H
#define TUG_INFLUENCES_H

#include "dictionaries/skeleton/skinning.h"

/* Room for the steps on one vertex. */
typedef struct influence_room {
    double *misses;   /* bones by poses by k: where each bone alone carries it, less where it is */
    double *pull;     /* bones: of the neighbours' weights */
    double *gradient; /* bones */
    double *sum;      /* poses by k */
} influence_room;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int influence_room_create(const skinning *s, influence_room *room);
void influence_room_destroy(influence_room *room);

/* Minimise m_v |sum_j w_j c_j|^2 + smoothness (L_vv |w|^2 + 2 sum_u L_vu w_u . w), the part of the
 * objective that has the weights w of vertex v, over at most most_influences bones. It never rises.
 */
void improve_vertex(skinning *s, int32_t vertex, influence_room *room);

#endif
