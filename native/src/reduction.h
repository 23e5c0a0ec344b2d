/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A rigidity energy with its transforms eliminated (design: docs/algorithm.md, "Eliminating T").
 *
 * The energy is 1/2 tr(T^T L T) - tr(N^T T) + 1/2 tr(V H V^T) with N = K^T V^T, where V stacks
 * blend weight times rotation, k by `turned`; T is bound by X T = Y. Its minimiser is T = Z N + F
 * Y, and what is left is a quadratic form in V and Y of constant matrices. */
#ifndef TUG_REDUCTION_H
#define TUG_REDUCTION_H

#include "status.h"

typedef struct reduction {
    int32_t turned;   /* rows of K: k for each rotation */
    int32_t rows;     /* of X */
    int32_t unknowns; /* rows of T */
    double *C;        /* turned by turned: H - K Z K^T */
    double *KF;       /* turned by rows */
    double *FLF;      /* rows by rows: F^T L F */
    double *ZK;       /* turned by unknowns: (Z K^T)^T */
    double *F;        /* rows by unknowns: F^T */
} reduction;

/* Fill all of `out` but the H that the caller has put in its C. L: unknowns by unknowns. X: rows by
 * unknowns. K: turned by unknowns. rank: unknowns that are independent; the others are held at
 * zero. TUG_ERROR_HANDLES where the rows of X depend on each other. O(unknowns^3 + turned^2
 * unknowns). */
tug_status eliminate_transforms(const double *L, const double *X, const double *K, reduction *out,
                                int32_t *rank);

/* The pull of the rows on the rotations, K F Y: turned by k. Y: rows by k. */
void find_pull(const reduction *energy, const double *Y, int32_t k, double *pull);

/* tr(Y^T F^T L F Y), twice the energy of Y without rotations. */
double energy_of_rows(const reduction *energy, const double *Y, int32_t k);

/* T = Z K^T V^T + F Y, unknowns by k. V: turned by k, its blocks the transposes of blend weight
 * times rotation. */
void recover_transforms(const reduction *energy, const double *V, const double *Y, int32_t k,
                        double *T);

#endif
