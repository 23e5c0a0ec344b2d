/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Example shapes as the rest shape moved by rigid bones: q_vs = sum_j w_vj (R_js p_v + t_js), with
 * few bones a vertex. What the steps of the decomposition share. */
#ifndef TUG_SKINNING_H
#define TUG_SKINNING_H

#include "mesh/mesh.h"
#include "weights/laplacian.h"

enum { most_influences = 4, no_bone = -1 };

/* Lengths in units of the rest shape's diagonal. */
typedef struct skinning {
    int32_t vertices, dimension;
    int32_t poses; /* shapes but the rest shape */
    int32_t bones;
    double *rest;   /* #V by k */
    double *posed;  /* #V by poses by k */
    double *miss;   /* the same: posed less what the bones make of the rest shape */
    double *motion; /* bones by poses by (k + 1) by k: the rows of R^T, then t */
    int32_t *bone;  /* #V by most_influences: number or no_bone, */
    double *weight; /* and its weight: >= 0, the sum of a vertex is one */
    laplacian L;    /* with masses that sum to one */
    double smoothness;
} skinning;

static inline const double *motion_of(const skinning *s, int32_t bone, int32_t pose)
{
    int32_t k = s->dimension;
    return s->motion + (size_t)(bone * s->poses + pose) * (size_t)((k + 1) * k);
}

/* Where a bone carries a vertex in every pose: poses by k. */
static inline void carry_vertex(const skinning *s, int32_t bone, int32_t vertex, double *places)
{
    int32_t k = s->dimension;
    const double *p = s->rest + (size_t)vertex * (size_t)k;
    for (int32_t i = 0; i < s->poses; i++, places += k) {
        const double *motion = motion_of(s, bone, i);
        for (int32_t a = 0; a < k; a++) {
            places[a] = motion[k * k + a];
            for (int32_t c = 0; c < k; c++) {
                places[a] += motion[c * k + a] * p[c];
            }
        }
    }
}

#endif
