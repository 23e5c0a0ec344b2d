/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Our own dense kernels, in every order that they treat in another way, against sums written out.
 */
#include "dense/dense.h"
#include "fixture.h"
#include "test.h"

enum { MOST = 70, COLUMNS = 5 };

static void random_numbers(uint64_t *state, int32_t count, double *values)
{
    for (int32_t i = 0; i < count; i++) {
        values[i] = random_between(state, -1.0, 1.0);
    }
}

/* Symmetric, its eigenvalues between one and three. */
static void make_definite(uint64_t *state, int32_t n, double *A)
{
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j <= i; j++) {
            double entry = random_between(state, -1.0, 1.0) / n;
            A[i * n + j] = A[j * n + i] = i == j ? 2.0 + entry : entry;
        }
    }
}

static void factor_has_the_matrix_as_its_square(void)
{
    static double A[MOST * MOST], G[MOST * MOST];
    uint64_t state = 1;
    for (int32_t n = 1; n <= MOST; n++) {
        make_definite(&state, n, A);
        memcpy(G, A, sizeof A);
        CHECK(cholesky_factor(G, n));
        for (int32_t i = 0; i < n * n; i++) {
            double sum = 0.0;
            for (int32_t l = 0; l <= i / n && l <= i % n; l++) {
                sum += G[l * n + i / n] * G[l * n + i % n];
            }
            CHECK_NEAR(sum, A[i], 1e-14);
        }
    }
}

static void matrix_with_a_negative_direction_has_no_factor(void)
{
    static double A[MOST * MOST];
    uint64_t state = 2;
    for (int32_t n = 1; n <= 24; n++) {
        for (int32_t bad = 0; bad < n; bad++) {
            make_definite(&state, n, A);
            A[bad * n + bad] = -0.1;
            CHECK(!cholesky_factor(A, n));
            make_definite(&state, n, A);
            A[bad * n + bad] = NAN;
            CHECK(!cholesky_factor(A, n));
        }
    }
}

static void solutions_solve(void)
{
    static double A[MOST * MOST], G[MOST * MOST], b[MOST * COLUMNS], x[MOST * COLUMNS];
    uint64_t state = 3;
    for (int32_t n = 1; n <= MOST; n++) {
        for (int32_t columns = 1; columns <= COLUMNS; columns += COLUMNS - 1) {
            make_definite(&state, n, A);
            random_numbers(&state, n * columns, b);
            memcpy(G, A, sizeof A);
            memcpy(x, b, sizeof b);
            CHECK(cholesky_factor(G, n));
            cholesky_solve(G, n, x, columns);
            for (int32_t i = 0; i < n * columns; i++) {
                double sum = 0.0;
                for (int32_t j = 0; j < n; j++) {
                    sum += A[i / columns * n + j] * x[j * columns + i % columns];
                }
                CHECK_NEAR(sum, b[i], 1e-13);
            }
        }
    }
}

static void half_a_solution_has_the_whole_one_as_its_square(void)
{
    static double G[MOST * MOST], half[MOST * COLUMNS], whole[MOST * COLUMNS], b[MOST * COLUMNS];
    uint64_t state = 4;
    for (int32_t n = 1; n <= MOST; n++) {
        double gram[COLUMNS * COLUMNS] = {0.0};
        make_definite(&state, n, G);
        random_numbers(&state, n * COLUMNS, b);
        memcpy(half, b, sizeof b);
        memcpy(whole, b, sizeof b);
        CHECK(cholesky_factor(G, n));
        cholesky_solve_half(G, n, half, COLUMNS);
        cholesky_solve(G, n, whole, COLUMNS);
        add_gram(COLUMNS, n, 1.0, half, COLUMNS, gram, COLUMNS);
        for (int32_t i = 0; i < COLUMNS; i++) {
            for (int32_t j = i; j < COLUMNS; j++) {
                double sum = 0.0;
                for (int32_t l = 0; l < n; l++) {
                    sum += b[l * COLUMNS + i] * whole[l * COLUMNS + j];
                }
                CHECK_NEAR(gram[i * COLUMNS + j], sum, 1e-13);
            }
        }
    }
}

static void thin_products_are_added(void)
{
    static double A[COLUMNS * MOST], V[COLUMNS * 3], T[MOST * 3], before[MOST * 3];
    uint64_t state = 5;
    for (int32_t n = 1; n <= MOST; n++) {
        int32_t k = 2 + n % 2;
        random_numbers(&state, COLUMNS * n, A);
        random_numbers(&state, COLUMNS * k, V);
        random_numbers(&state, n * k, T);
        memcpy(before, T, sizeof T);
        add_thin_product_tn(COLUMNS, n, k, A, V, T);
        for (int32_t i = 0; i < n * k; i++) {
            double sum = before[i];
            for (int32_t l = 0; l < COLUMNS; l++) {
                sum += A[l * n + i / k] * V[l * k + i % k];
            }
            CHECK_NEAR(T[i], sum, 1e-14);
        }
    }
}

int main(int argc, char **argv)
{
    RUN(factor_has_the_matrix_as_its_square);
    RUN(matrix_with_a_negative_direction_has_no_factor);
    RUN(solutions_solve);
    RUN(half_a_solution_has_the_whole_one_as_its_square);
    RUN(thin_products_are_added);
    return TEST_RESULT;
}
