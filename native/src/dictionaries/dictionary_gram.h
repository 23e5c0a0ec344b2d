/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A dictionary on its own, without a model, and its inner products. */
#ifndef TUG_DICTIONARY_GRAM_H
#define TUG_DICTIONARY_GRAM_H

#include "model/dictionary.h"
#include "status.h"

/* The arrays of a dictionary, of a caller's shapes and weights. */
typedef struct own_dictionary {
    dictionary D;
    double unit;
    double *shape_columns, *weight_columns, *middles;
    double *means; /* #S k: of the shapes, in units of length */
} own_dictionary;

/* Not all vertices of shape 0 may be in one place. */
tug_status own_dictionary_create(const tug_dictionary *given, own_dictionary *out);

/* Frees the arrays, not the struct. NULL members are allowed. */
void own_dictionary_free(own_dictionary *own);

/* Work on `count` vertices from `first` on, of which rows holds D's rows. */
typedef void (*row_visitor)(void *context, int32_t first, int32_t count, const double *rows);

/* Make the rows of D some at a time. */
tug_status visit_rows(const dictionary *D, row_visitor visit, void *context,
                      const progress_range *range, const char *stage);

/* gram = D^T D, every column with every other. */
tug_status find_gram(const dictionary *D, const progress_range *range, double *gram);

#endif
