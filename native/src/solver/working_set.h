/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The entries of the blend that a solve looks at: a few shapes of each group, with their part of
 * every constant. With many groups and shapes nearly all entries of an optimum are zero. The others
 * are priced at an optimum over these by one gradient, and those along which the objective still
 * falls come in; where there is none it is the optimum over all. */
#ifndef TUG_WORKING_SET_H
#define TUG_WORKING_SET_H

#include "solver/contraction.h"

/* Arrays are #G by width, of the shapes in `shapes`. */
typedef struct working_set {
    int32_t width;   /* shapes of each group; all of them in small models */
    int32_t *shapes; /* in rising order */
    coupling coupling;
    double *C;    /* room for a part of the coupling; NULL where all of it is used */
    double *form; /* #G by width by width: tr(H_gst), the form of the blends' prior */
    double *B, *c, *d, *pull, *prior_B;
    double *slopes; /* #G by #S, of all entries */
} working_set;

/* Returns 0 where memory is short; the set can then be freed all the same. */
int working_set_create(const tug_model *model, int single_blend, working_set *set);
void working_set_destroy(working_set *set);

/* In each group the shapes for which `keep` is not zero, `wanted` at most, and then those of least
 * slope; with their part of the coupling `all` and the prior's form. keep, slopes: #G by #S. */
void choose_entries(const tug_model *model, const coupling *all, const double *keep,
                    const double *slopes, int32_t wanted, working_set *set);

/* part <- the set's entries of `whole`, each `size` doubles; and back, zero elsewhere. */
void gather_entries(const tug_model *model, const working_set *set, int32_t size,
                    const double *whole, double *part);
void scatter_entries(const tug_model *model, const working_set *set, const double *part,
                     double *whole);

static inline int has_all_entries(const tug_model *model, const working_set *set)
{
    return set->width == model->header.shapes;
}

#endif
