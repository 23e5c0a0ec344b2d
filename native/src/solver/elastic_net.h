/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sparse least squares, (F 20-23): for each column t of T and y of Y the minimiser of
 *
 *     1/2 fit |X t - y|^2 + 1/2 smoothness t^T Lambda t + sparsity |t|_1
 *
 * with fit, smoothness and sparsity the paper's beta_lc, beta_sm and beta_sp. */
#ifndef TUG_ELASTIC_NET_H
#define TUG_ELASTIC_NET_H

#include "status.h"

typedef struct elastic_net_problem {
    int32_t rows, unknowns;
    const double *X;      /* rows by unknowns */
    const double *Lambda; /* unknowns by unknowns, positive semidefinite; NULL: zero */
    double fit, smoothness, sparsity;
} elastic_net_problem;

/* What does not depend on Y, and room for a solve. */
typedef struct elastic_net {
    int32_t rows, unknowns;
    double fit, sparsity;
    double *X;        /* rows by unknowns */
    double *G;        /* unknowns square: fit X^T X + smoothness Lambda */
    double *inverse;  /* unknowns by rows: T = inverse Y, where sparsity is zero; else NULL */
    double *t;        /* unknowns: the column that is looked for */
    double *c;        /* unknowns: fit X^T y */
    double *slack;    /* unknowns: c - G t, minus the gradient of the smooth part */
    double *factor;   /* unknowns square: of G in the support of t, its diagonal scaled to one */
    double *scale;    /* unknowns: of the members of the support */
    double *step;     /* unknowns: of the members */
    double *work;     /* 2 unknowns */
    int32_t *members; /* unknowns: the support */
    int32_t *pivots;  /* unknowns */
} elastic_net;

/* O(unknowns^2 rows); where sparsity is zero O(unknowns^3). TUG_ERROR_NUMERIC where X and Lambda
 * are too large for their squares. On failure nothing need be freed. */
tug_status elastic_net_create(const elastic_net_problem *problem, elastic_net *out);
void elastic_net_free(elastic_net *net);

/* Y: rows by k, its squares finite. T: unknowns by k. Allocates nothing. */
void elastic_net_solve(elastic_net *net, const double *Y, int32_t k, double *T,
                       tug_elastic_net_info *info);

/* tug_solve_elastic_net, its arguments checked but for the sign of Lambda. */
tug_status solve_elastic_net(const elastic_net_problem *problem, const double *Y, int32_t k,
                             double *T, tug_elastic_net_info *info);

#endif
