/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sparse systems, blocks of their inverses, and complementarity problems. */
#include "memory.h"
#include "sparse/sparse.h"
#include "weights/complementarity.h"
#include "weights/inverse_block.h"

#include "test.h"

#include <stdlib.h>

enum { side = 12, unknowns = side * side };

/* The five-point Laplacian of a grid, and a little on the diagonal. */
static tug_status grid_matrix(sparse_matrix *A, double diagonal)
{
    A->size = unknowns;
    A->starts = allocate(unknowns + 1, sizeof(int32_t));
    A->rows = allocate(3 * unknowns, sizeof(int32_t));
    A->values = allocate(3 * unknowns, sizeof(double));
    if (!A->starts || !A->rows || !A->values) {
        sparse_matrix_free(A);
        return fail_memory();
    }
    int32_t end = 0;
    for (int32_t i = 0; i < unknowns; i++) {
        int32_t below[] = {i, i % side < side - 1 ? i + 1 : unknowns, i + side};
        for (int b = 0; b < 3; b++) {
            if (below[b] < unknowns) {
                A->rows[end] = below[b];
                A->values[end++] = b == 0 ? diagonal : -1.0;
            }
        }
        A->starts[i + 1] = end;
    }
    return TUG_OK;
}

static void multiply(const sparse_matrix *A, const double *x, double *y)
{
    memset(y, 0, (size_t)A->size * sizeof *y);
    for (int32_t c = 0; c < A->size; c++) {
        for (int32_t k = A->starts[c]; k < A->starts[c + 1]; k++) {
            y[A->rows[k]] += A->values[k] * x[c];
            y[c] += A->rows[k] == c ? 0.0 : A->values[k] * x[A->rows[k]];
        }
    }
}

static void solves_several_right_hand_sides(void)
{
    sparse_matrix A;
    sparse_factor *factor;
    sparse_solver *solver;
    double b[2 * unknowns], x[2 * unknowns], back[unknowns];
    for (int i = 0; i < 2 * unknowns; i++) {
        b[i] = sin(3.0 * i);
    }
    CHECK(grid_matrix(&A, 4.1) == TUG_OK);
    CHECK(sparse_factor_create(&A, &factor) == TUG_OK);
    CHECK(sparse_solver_create(factor, 2, &solver) == TUG_OK);
    for (int round = 0; round < 2; round++) {
        CHECK(sparse_solve(solver, b, x) == TUG_OK);
        for (int column = 0; column < 2; column++) {
            multiply(&A, x + column * unknowns, back);
            for (int i = 0; i < unknowns; i++) {
                CHECK_NEAR(back[i], b[column * unknowns + i], 1e-12);
            }
        }
    }
    sparse_solver_destroy(solver);
    sparse_factor_destroy(factor);
    sparse_matrix_free(&A);
}

static void refuses_an_indefinite_matrix(void)
{
    sparse_matrix A;
    sparse_factor *factor;
    CHECK(grid_matrix(&A, 1.0) == TUG_OK);
    CHECK(sparse_factor_create(&A, &factor) == TUG_ERROR_NUMERIC);
    CHECK(factor == NULL);
    CHECK(strstr(tug_error_text(), "positive definite") != NULL);
    sparse_matrix_free(&A);
}

/* In three batches: the entries of earlier members stay, those with new members appear. */
static void inverse_block_is_that_of_the_solves(void)
{
    sparse_matrix A;
    sparse_factor *factor;
    sparse_solver *solver;
    inverse_block *block;
    double unit[unknowns], column[unknowns];
    int32_t rows[40], stride;
    for (int32_t i = 0; i < 40; i++) {
        rows[i] = 89 * i % unknowns;
    }
    CHECK(grid_matrix(&A, 4.1) == TUG_OK);
    CHECK(sparse_factor_create(&A, &factor) == TUG_OK);
    CHECK(sparse_solver_create(factor, 1, &solver) == TUG_OK);
    CHECK(inverse_block_create(sparse_factor_supernodes(factor), &block) == TUG_OK);
    CHECK(inverse_block_extend(block, rows, 1) == TUG_OK);
    CHECK(inverse_block_extend(block, rows + 1, 20) == TUG_OK);
    CHECK(inverse_block_extend(block, rows + 21, 19) == TUG_OK);
    const double *entries = inverse_block_entries(block, &stride);
    for (int32_t b = 0; b < 40; b++) {
        memset(unit, 0, sizeof unit);
        unit[rows[b]] = 1.0;
        CHECK(sparse_solve(solver, unit, column) == TUG_OK);
        for (int32_t a = 0; a < 40; a++) {
            CHECK_NEAR(entries[a * stride + b], column[rows[a]], 1e-14);
        }
    }
    inverse_block_destroy(block);
    sparse_solver_destroy(solver);
    sparse_factor_destroy(factor);
    sparse_matrix_free(&A);
}

/* G = H H^T + 0.01 with a pseudo-random H, of mixed signs. */
static void fill_problem(complementarity *problem, double *G, int32_t count, unsigned seed)
{
    double H[40 * 40];
    srand(seed);
    for (int32_t i = 0; i < count * count; i++) {
        H[i] = rand() / (double)RAND_MAX - 0.5;
    }
    for (int32_t a = 0; a < count; a++) {
        for (int32_t b = 0; b < count; b++) {
            G[a * count + b] = a == b ? 0.01 : 0.0;
            for (int32_t c = 0; c < count; c++) {
                G[a * count + b] += H[a * count + c] * H[b * count + c];
            }
        }
        problem->sign[a] = a % 3 == 0 ? -1.0 : 1.0;
        problem->q[a] = rand() / (double)RAND_MAX - 0.5;
        problem->support[a] = a % 2 == 0;
    }
    problem->count = count;
}

static void complementarity_holds(void)
{
    double G[40 * 40];
    for (unsigned seed = 0; seed < 30; seed++) {
        complementarity problem = {0};
        int32_t count = 1 + (int32_t)seed, solved;
        CHECK(complementarity_reserve(&problem, count) == TUG_OK);
        fill_problem(&problem, G, count, seed);
        CHECK(complementarity_solve(&problem, G, count, &solved) == TUG_OK);
        CHECK(solved);
        for (int32_t a = 0; a < count; a++) {
            double slack = problem.q[a];
            for (int32_t b = 0; b < count; b++) {
                slack += problem.sign[a] * G[a * count + b] * problem.sign[b] * problem.l[b];
            }
            CHECK(problem.l[a] >= 0.0);
            CHECK(slack >= -1e-9);
            CHECK_NEAR(problem.l[a] * slack, 0.0, 1e-8);
        }
        complementarity_free(&problem);
    }
}

/* Twice the same row: one of the two carries the multiplier. */
static void complementarity_takes_dependent_rows(void)
{
    double G[] = {2.0, 2.0, 2.0, 2.0};
    complementarity problem = {0};
    int solved;
    CHECK(complementarity_reserve(&problem, 2) == TUG_OK);
    problem.count = 2;
    problem.sign[0] = problem.sign[1] = 1.0;
    problem.q[0] = problem.q[1] = -1.0;
    problem.support[0] = problem.support[1] = 1;
    CHECK(complementarity_solve(&problem, G, 2, &solved) == TUG_OK);
    CHECK(solved);
    CHECK_NEAR(problem.l[0] + problem.l[1], 0.5, 1e-12);
    complementarity_free(&problem);
}

static void survives_every_failing_allocation(void)
{
    long before = live_allocations();
    tug_status status = TUG_ERROR_MEMORY;
    for (long successes = 0; status == TUG_ERROR_MEMORY && successes < 10000; successes++) {
        sparse_matrix A = {0};
        sparse_factor *factor = NULL;
        sparse_solver *solver = NULL;
        inverse_block *block = NULL;
        int32_t rows[] = {3, 100, 7, 8, 9, 10, 11, 12};
        fail_allocations_after(successes);
        status = grid_matrix(&A, 4.1);
        status = status == TUG_OK ? sparse_factor_create(&A, &factor) : status;
        status = status == TUG_OK ? sparse_solver_create(factor, 1, &solver) : status;
        status = status == TUG_OK ? inverse_block_create(sparse_factor_supernodes(factor), &block)
                                  : status;
        status = status == TUG_OK ? inverse_block_extend(block, rows, 2) : status;
        status = status == TUG_OK ? inverse_block_extend(block, rows + 2, 6) : status;
        fail_allocations_after(-1);
        inverse_block_destroy(block);
        sparse_solver_destroy(solver);
        sparse_factor_destroy(factor);
        sparse_matrix_free(&A);
        CHECK(live_allocations() == before);
    }
    CHECK(status == TUG_OK);
}

int main(int argc, char **argv)
{
    RUN(solves_several_right_hand_sides);
    RUN(refuses_an_indefinite_matrix);
    RUN(inverse_block_is_that_of_the_solves);
    RUN(complementarity_holds);
    RUN(complementarity_takes_dependent_rows);
    RUN(survives_every_failing_allocation);
    return TEST_RESULT;
}
