/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sparse symmetric positive definite systems; sparse.c is the only place that knows CHOLMOD. */
#ifndef TUG_SPARSE_H
#define TUG_SPARSE_H

#include "status.h"

/* The lower triangle of a symmetric matrix by columns, diagonal included: column c has values[k] in
 * row rows[k] for starts[c] <= k < starts[c + 1], in any order. */
typedef struct sparse_matrix {
    int32_t size;
    int32_t *starts; /* size + 1 */
    int32_t *rows;
    double *values;
} sparse_matrix;

/* Frees the arrays, not the struct. NULL members are allowed. */
void sparse_matrix_free(sparse_matrix *matrix);

/* P A P^T = L L^T with a fill-reducing order P. Immutable: any number of threads may use it. */
typedef struct sparse_factor sparse_factor;

/* TUG_ERROR_NUMERIC where the matrix is not positive definite. */
tug_status sparse_factor_create(const sparse_matrix *matrix, sparse_factor **out);

/* No solver on it may be alive. NULL is allowed. */
void sparse_factor_destroy(sparse_factor *factor);

/* L by supernodes, neighbouring columns that share their rows below. Supernode s has columns
 * first[s] to first[s + 1] - 1 and rows rows[row_starts[s]] to rows[row_starts[s + 1] - 1], of
 * which the first are the columns themselves. Its values begin at values[value_starts[s]], column
 * after column. The subtree below a supernode is a range of columns that ends with its own. */
typedef struct supernodes {
    int32_t size, count;
    const int32_t *first, *row_starts, *rows, *value_starts;
    const double *values;
    const int32_t *parent;   /* of a supernode: the one that holds its first row below; or -1 */
    const int32_t *holder;   /* of a column of L: its supernode */
    const int32_t *position; /* of a row of A: its row of L */
} supernodes;

const supernodes *sparse_factor_supernodes(const sparse_factor *factor);

/* One thread's room to solve with a factor, which must outlive it. */
typedef struct sparse_solver sparse_solver;

/* columns: how many right-hand sides every solve has. */
tug_status sparse_solver_create(const sparse_factor *factor, int32_t columns, sparse_solver **out);

/* NULL is allowed. */
void sparse_solver_destroy(sparse_solver *solver);

/* A x = b. b, x: `columns` vectors of the matrix' size, one after the other; they may be the same.
 * After the first solve no memory is allocated. */
tug_status sparse_solve(sparse_solver *solver, const double *b, double *x);

#endif
