/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What blended features say to a reduced model: with p_e(w) = M_t(w) p_0e on the edges of triangle
 * t, the moments of (A 16) and (A 19) for a shape that depends on w, and their derivatives. */
#ifndef TUG_BASELINES_FEATURE_MOMENTS_H
#define TUG_BASELINES_FEATURE_MOMENTS_H

#include "features.h"
#include "model/dictionary.h"

typedef struct feature_moments {
    const tug_mesh *mesh;
    const dictionary *D;
    feature_set features; /* of the triangles */
    int32_t *groups;      /* #F */
    int32_t group_count;

    double *K;    /* #G k by b: sum_e c p_e(w) D_e, b = dictionary_columns */
    double *H;    /* #G by k by k: sum_e c p_e p_e^T */
    double *dK;   /* #S by #G k by b */
    double *dH;   /* #S by #G by k by k */
    double *gram; /* #S by #S: sum_e c dp_e . dp_e */

    /* Room to work in; a field is p(w) or one of its derivatives. */
    double *M;                   /* (1 + #S) by k by k */
    double *divergence;          /* #V by fields by k, zero between calls */
    double *D_rows, *field_rows; /* blocks of rows of the two */
    double *product;             /* fields k by b */
    int32_t *seen;               /* #V: 1 + the last group that had the vertex */
} feature_moments;

/* Returns 0 where memory is short; it can then be destroyed all the same. The features are the
 * caller's to set. */
int feature_moments_create(const tug_mesh *mesh, const dictionary *D, const int32_t *groups,
                           int32_t group_count, int32_t shapes, feature_moments *out);
void feature_moments_destroy(feature_moments *moments);

/* K and H at w; with `derivatives`, all. O(#V b fields). */
void find_feature_moments(feature_moments *moments, const double *w, int derivatives);

#endif
