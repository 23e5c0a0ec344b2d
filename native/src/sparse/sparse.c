/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "sparse/sparse.h"

#include "memory.h"

#include <cholmod.h>
#include <string.h>

struct sparse_factor {
    cholmod_common common;
    cholmod_factor *L;
    supernodes nodes;
    int32_t *parent, *holder, *position;
};

struct sparse_solver {
    cholmod_common common;
    const sparse_factor *factor;
    int32_t columns;
    cholmod_dense *X, *Y, *E; /* result and work room, kept by CHOLMOD between solves */
};

void sparse_matrix_free(sparse_matrix *matrix)
{
    release(matrix->starts);
    release(matrix->rows);
    release(matrix->values);
    memset(matrix, 0, sizeof *matrix);
}

static void start_silently(cholmod_common *common)
{
    cholmod_start(common);
    common->print = 0;
    common->supernodal = CHOLMOD_SUPERNODAL;
}

/* CHOLMOD's negative states are errors, its positive ones warnings. */
static tug_status status_of(const cholmod_common *common)
{
    switch (common->status) {
    case CHOLMOD_OK:
        return TUG_OK;
    case CHOLMOD_NOT_POSDEF:
        return fail(TUG_ERROR_NUMERIC, "a sparse matrix is not positive definite");
    case CHOLMOD_OUT_OF_MEMORY:
    case CHOLMOD_TOO_LARGE:
        return fail_memory();
    default:
        return fail(TUG_ERROR_NUMERIC, "a sparse factorisation failed (%d)", common->status);
    }
}

static cholmod_sparse borrow_matrix(const sparse_matrix *matrix)
{
    size_t entries = (size_t)matrix->starts[matrix->size];
    cholmod_sparse A = {.nrow = (size_t)matrix->size,
                        .ncol = (size_t)matrix->size,
                        .nzmax = entries,
                        .p = matrix->starts,
                        .i = matrix->rows,
                        .x = matrix->values,
                        .stype = -1,
                        .itype = CHOLMOD_INT,
                        .xtype = CHOLMOD_REAL,
                        .dtype = CHOLMOD_DOUBLE,
                        .sorted = 0,
                        .packed = 1};
    return A;
}

static tug_status factorise(sparse_factor *factor, const sparse_matrix *matrix)
{
    cholmod_sparse A = borrow_matrix(matrix);
    factor->L = cholmod_analyze(&A, &factor->common);
    if (factor->L == NULL) {
        return status_of(&factor->common);
    }
    cholmod_factorize(&A, factor->L, &factor->common);
    return status_of(&factor->common);
}

static tug_status describe_supernodes(sparse_factor *factor)
{
    const cholmod_factor *L = factor->L;
    supernodes *nodes = &factor->nodes;
    nodes->size = (int32_t)L->n;
    nodes->count = (int32_t)L->nsuper;
    nodes->first = L->super;
    nodes->row_starts = L->pi;
    nodes->rows = L->s;
    nodes->value_starts = L->px;
    nodes->values = L->x;
    nodes->parent = factor->parent = allocate(L->nsuper, sizeof(int32_t));
    nodes->holder = factor->holder = allocate(L->n, sizeof(int32_t));
    nodes->position = factor->position = allocate(L->n, sizeof(int32_t));
    if (factor->parent == NULL || factor->holder == NULL || factor->position == NULL) {
        return fail_memory();
    }
    const int32_t *order = L->Perm;
    for (int32_t i = 0; i < nodes->size; i++) {
        factor->position[order[i]] = i;
    }
    for (int32_t s = 0; s < nodes->count; s++) {
        for (int32_t c = nodes->first[s]; c < nodes->first[s + 1]; c++) {
            factor->holder[c] = s;
        }
    }
    for (int32_t s = 0; s < nodes->count; s++) {
        int32_t below = nodes->row_starts[s] + nodes->first[s + 1] - nodes->first[s];
        int32_t has_parent = below < nodes->row_starts[s + 1];
        factor->parent[s] = has_parent ? factor->holder[nodes->rows[below]] : -1;
    }
    return TUG_OK;
}

tug_status sparse_factor_create(const sparse_matrix *matrix, sparse_factor **out)
{
    *out = NULL;
    sparse_factor *factor = allocate(1, sizeof *factor);
    if (factor == NULL) {
        return fail_memory();
    }
    start_silently(&factor->common);
    tug_status status = factorise(factor, matrix);
    if (status == TUG_OK) {
        status = describe_supernodes(factor);
    }
    if (status != TUG_OK) {
        sparse_factor_destroy(factor);
        return status;
    }
    *out = factor;
    return TUG_OK;
}

void sparse_factor_destroy(sparse_factor *factor)
{
    if (factor == NULL) {
        return;
    }
    cholmod_free_factor(&factor->L, &factor->common);
    cholmod_finish(&factor->common);
    release(factor->parent);
    release(factor->holder);
    release(factor->position);
    release(factor);
}

const supernodes *sparse_factor_supernodes(const sparse_factor *factor)
{
    return &factor->nodes;
}

tug_status sparse_solver_create(const sparse_factor *factor, int32_t columns, sparse_solver **out)
{
    *out = NULL;
    sparse_solver *solver = allocate(1, sizeof *solver);
    if (solver == NULL) {
        return fail_memory();
    }
    start_silently(&solver->common);
    solver->factor = factor;
    solver->columns = columns;
    *out = solver;
    return TUG_OK;
}

void sparse_solver_destroy(sparse_solver *solver)
{
    if (solver == NULL) {
        return;
    }
    cholmod_free_dense(&solver->X, &solver->common);
    cholmod_free_dense(&solver->Y, &solver->common);
    cholmod_free_dense(&solver->E, &solver->common);
    cholmod_finish(&solver->common);
    release(solver);
}

/* b is only read: CHOLMOD's struct has no const. */
static cholmod_dense borrow_vectors(const double *b, size_t size, size_t columns)
{
    cholmod_dense B = {.nrow = size,
                       .ncol = columns,
                       .nzmax = size * columns,
                       .d = size,
                       .xtype = CHOLMOD_REAL,
                       .dtype = CHOLMOD_DOUBLE};
    memcpy(&B.x, &b, sizeof B.x);
    return B;
}

tug_status sparse_solve(sparse_solver *solver, const double *b, double *x)
{
    size_t size = solver->factor->L->n, columns = (size_t)solver->columns;
    cholmod_dense B = borrow_vectors(b, size, columns);
    cholmod_factor *L = solver->factor->L;
    if (!cholmod_solve2(CHOLMOD_A, L, &B, NULL, &solver->X, NULL, &solver->Y, &solver->E,
                        &solver->common)) {
        return status_of(&solver->common);
    }
    memcpy(x, solver->X->x, size * columns * sizeof(double));
    return TUG_OK;
}
