/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A rigidity energy with its transforms eliminated (design: docs/algorithm.md, "Eliminating T").
 *
 * The energy is 1/2 tr(T^T L T) - tr(N^T T) + 1/2 tr(V H V^T) with N = K^T V^T, where V stacks
 * blend weight times rotation, k by `turned`; T is bound by X T = Y. Its minimiser is T = Z N + F
 * Y, and what is left is a quadratic form in V and Y of constant matrices. Where rows are soft, the
 * energy has 1/2 sum_r beta_r |(X T - Y)_r|^2 in place of the bound, with B = diag(beta), and
 * M = L + X^T B X, Z = M^-1, F = Z X^T B.
 *
 * L, K and X have a block of columns for every weight function. Group g has `group_rows` rows of K,
 * which are zero but in the columns of the functions in its support. Z is not stored: with the
 * factor of M = L + rho X^T X it is Z N = T0 - F X T0, T0 = M^-1 N. */
#ifndef TUG_REDUCTION_H
#define TUG_REDUCTION_H

#include "model/support.h"

typedef struct reduction {
    const support *support;
    int32_t groups, group_rows; /* rows of K for each group: k for each rotation */
    int32_t turned;             /* groups times group_rows: rows of K */
    int32_t rows;               /* of X */
    int32_t unknowns;           /* rows of T */
    int32_t block;              /* of them, those of one weight function */
    int32_t shapes;             /* of the blocks of C; 0: C is square */
    int32_t *rank;              /* 1: unknowns that are independent; the others are held at zero */
    int32_t *pivots;            /* unknowns: the independent ones first, in the factor's order */
    double *scale;              /* unknowns: M has a diagonal of one when scaled by it */
    double *factor;             /* of the scaled M in the independent unknowns */
    double *K;                  /* #G by group_rows by support times block */
    double *X;                  /* rows by unknowns */
    double *firmness;           /* rows: beta of soft ones, or NULL where all are pinned */
    double *C;                  /* H - K Z K^T, see read_block */
    double *KF;                 /* turned by rows */
    double *FLF; /* rows by rows: F^T L F; B - B X F for soft rows: the energy of Y without V */
    double *F;   /* rows by unknowns: F^T */
} reduction;

/* Doubles of C. Square: turned by turned. Else by blocks of two groups g <= h, k by k by #S by #S,
 * the order in which blends and rotations contract them: k k matrices, each of one component of all
 * pairs of shapes. */
size_t coupling_size(const reduction *r);

/* Doubles of C before the block of g <= h, where it is not square. */
size_t coupling_offset(const reduction *r, int32_t g, int32_t h);

/* Columns in which a group's rows of K are not zero, and the first of these rows. */
int32_t group_columns(const reduction *r, int32_t g);
double *group_rows_of_K(const reduction *r, int32_t g);

/* The block of groups g <= h of C, group_rows square, row-major; in a square C, both its places are
 * written. */
void read_block(const reduction *r, int32_t g, int32_t h, double *block);
void write_block(reduction *r, int32_t g, int32_t h, const double *block);

/* The lower triangle of the L that `r` was made from, in its independent unknowns and zero in the
 * others. O(unknowns^3). */
tug_status restore_form(const reduction *r, double *L);

/* The first half of the elimination: all but C and KF, from K and X. L: unknowns by unknowns, its
 * lower triangle; overwritten. TUG_ERROR_HANDLES where the rows of X depend on each other.
 * O(unknowns^3). */
tug_status factor_transforms(double *L, reduction *r);

/* The second: C and KF, where C has H in the blocks of its groups. range: reports on it.
 * O(turned unknowns^2). */
tug_status eliminate_transforms(reduction *r, const progress_range *range);

/* The pull of the rows on the rotations, K F Y: turned by k. Y: rows by k. */
void find_pull(const reduction *energy, const double *Y, int32_t k, double *pull);

/* tr(Y^T F^T L F Y), twice the energy of Y without rotations. */
double energy_of_rows(const reduction *energy, const double *Y, int32_t k);

/* Doubles of work for recover_transforms. */
static inline size_t recovery_size(const reduction *r, int32_t k)
{
    return (size_t)(2 * r->unknowns + r->rows) * (size_t)k;
}

/* beta_r |(X T - Y)_r|^2, twice what a soft row adds to the energy. */
double soft_row_energy(const reduction *energy, int32_t row, const double *T, const double *Y,
                       int32_t k);

/* T = Z K^T V^T + F Y, unknowns by k. V: turned by k, its blocks the transposes of blend weight
 * times rotation. */
void recover_transforms(const reduction *energy, const double *V, const double *Y, int32_t k,
                        double *work, double *T);

#endif
