/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Transforms eliminated, as in reduction.h, where K changes from round to round: min over T of
 * 1/2 tr(T^T L T) - tr(N^T T) with X T = Y. In mapped unknowns the form L + rho X^T X, which is as
 * good as L, is the identity; unknowns that depend on others are left out. */
#ifndef TUG_BASELINES_ELIMINATION_H
#define TUG_BASELINES_ELIMINATION_H

#include "status.h"

typedef struct elimination {
    int32_t unknowns, rows, rank;
    double rho;
    double *G;       /* unknowns square: upper triangular factor in its leading rank */
    double *scale;   /* unknowns */
    int32_t *pivots; /* unknowns */
    double *X;       /* rows by rank: mapped */
    double *F;       /* rows by rank: (X X^T)^-1 X */
    double *along;   /* rows: room to work in */
} elimination;

/* L: unknowns square. X: rows by unknowns. TUG_ERROR_HANDLES where the rows of X depend on each
 * other. The members are the caller's to destroy, also after a failure. */
tug_status elimination_create(const double *L, const double *X, int32_t unknowns, int32_t rows,
                              elimination *out);
void elimination_destroy(elimination *e);

/* V: count by rank, the rows of K (count by unknowns) in the mapped unknowns. */
void map_rows(const elimination *e, const double *K, int32_t count, double *V);

/* V <- V (I - F^T X): what is left where X T may not change. */
void free_rows(elimination *e, int32_t count, double *V);

/* t: rank by k, the mapped unknowns of least energy with X T = Y. Returns tr(T^T L T). */
double place_rows(const elimination *e, const double *Y, int32_t k, double *t);

/* T: unknowns by count, from the transpose of the mapped unknowns, count by rank, which is lost. */
void unmap_columns(const elimination *e, double *V, int32_t count, double *T);

#endif
