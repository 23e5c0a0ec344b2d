/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which weight functions a group sees. Handles far away have weight zero on it, so that its forms
 * need the columns of a few weight functions only. */
#ifndef TUG_SUPPORT_H
#define TUG_SUPPORT_H

#include "mesh/mesh.h"
#include "model/dictionary.h"

/* Group g sees functions[starts[g]] to functions[starts[g + 1] - 1], in rising order. */
typedef struct support {
    int32_t *starts;    /* #G + 1 */
    int32_t *functions; /* starts[#G] */
} support;

static inline int32_t support_count(const support *s, int32_t g)
{
    return s->starts[g + 1] - s->starts[g];
}

static inline const int32_t *support_of(const support *s, int32_t g)
{
    return s->functions + s->starts[g];
}

/* The functions that are not zero everywhere on each group. weights: #V by #W. groups: #F. */
tug_status support_create(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                          const int32_t *groups, int32_t group_count, support *out);
void support_destroy(support *s);

#endif
