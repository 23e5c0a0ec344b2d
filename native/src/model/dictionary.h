/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The dictionary D of a model: for each weight function h a block of 1 + S k columns, W_h and W_h
 * times coordinate c of shape s. The positions of a pose are D T.
 *
 * (A 6) gives every shape of a handle a translation of its own; they are all the same column, kept
 * once. Coordinates are taken in units of the rest shape's diagonal and from the handle's own
 * middle of each shape: the same span, far better conditioned. D is never stored: its rows are made
 * where they are needed. */
#ifndef TUG_DICTIONARY_H
#define TUG_DICTIONARY_H

#include <stdint.h>

typedef struct dictionary {
    int32_t vertices, dimension, shapes, weights;
    /* Column after column, so that a block of vertices is contiguous in each. */
    const double *shape_columns;  /* #S k by #V, units of the diagonal */
    const double *weight_columns; /* #W by #V */
    const double *middles;        /* #W by #S k */
} dictionary;

/* Columns of one weight function, and of all. */
static inline int32_t block_columns(const dictionary *D)
{
    return 1 + D->shapes * D->dimension;
}

static inline int32_t dictionary_columns(const dictionary *D)
{
    return D->weights * block_columns(D);
}

/* Of the box around some points, count by k. */
double bounding_diagonal(const double *points, int32_t count, int32_t k);

/* shapes, #S by #V by k, as columns: each coordinate of each shape about its own mean, in units.
 * means: those, #S k, or NULL. */
void store_shape_columns(const dictionary *D, const double *shapes, double unit, double *columns,
                         double *means);

/* weights, #V by #W, as columns. */
void store_weight_columns(const dictionary *D, const double *weights, double *columns);

/* row += factor D_v, one vertex's row of all columns. */
void add_dictionary_row(const dictionary *D, int32_t vertex, double factor, double *row);

/* The same with the columns of `count` weight functions alone. */
void add_partial_row(const dictionary *D, const int32_t *functions, int32_t count, int32_t vertex,
                     double factor, double *row);

/* The middle of each shape as weight function h sees it: its mean weighted by masses and W_h^2. */
void find_middles(const dictionary *D, const double *mass, double *middles);

#endif
