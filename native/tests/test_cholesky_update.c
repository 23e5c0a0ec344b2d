/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Factors with rows added and dropped, against the matrices and against factors made anew. */
#include "dense/cholesky_update.h"
#include "dense/dense.h"
#include "fixture.h"
#include "test.h"

enum { LARGEST = 120, MANY = 12 };

typedef struct question {
    int32_t n, rows;
    double A[LARGEST * LARGEST], G[LARGEST * LARGEST]; /* A = G^T G */
    double X[MANY * LARGEST], lost[MANY * LARGEST], work[MANY * MANY];
} question;

static question q;

/* A random A: the identity plus that of `n` rows, so that its condition is modest. */
static void make_question(int32_t n, int32_t rows, uint64_t *state)
{
    double row[LARGEST];
    q.n = n;
    q.rows = rows;
    for (int32_t i = 0; i < n * n; i++) {
        q.A[i] = i % (n + 1) == 0 ? 1.0 : 0.0;
    }
    for (int32_t r = 0; r < n; r++) {
        for (int32_t i = 0; i < n; i++) {
            row[i] = random_between(state, -1.0, 1.0);
        }
        add_product_tn(n, n, 1, 1.0, row, n, row, n, q.A, n);
    }
    for (int32_t i = 0; i < rows * n; i++) {
        q.X[i] = random_between(state, -2.0, 2.0);
    }
}

static int factor(void)
{
    memcpy(q.G, q.A, sizeof q.G);
    return cholesky_factor(q.G, q.n);
}

/* A += sign X^T X */
static void change_matrix(double sign)
{
    add_product_tn(q.n, q.n, q.rows, sign, q.X, q.n, q.X, q.n, q.A, q.n);
}

static void add(void)
{
    memcpy(q.lost, q.X, sizeof q.lost);
    cholesky_add_rows(q.G, q.n, q.lost, q.rows);
}

static int drop(void)
{
    memcpy(q.lost, q.X, sizeof q.lost);
    return cholesky_drop_rows(q.G, q.n, q.lost, q.rows, q.work);
}

static double largest_of(const double *values, int32_t count)
{
    double largest = 0.0;
    for (int32_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(values[i]));
    }
    return largest;
}

/* Largest entry of A - G^T G, relative to A's; the lower part of G is not its own. */
static double factor_error(void)
{
    static double difference[LARGEST * LARGEST], upper[LARGEST * LARGEST];
    memcpy(difference, q.A, sizeof difference);
    for (int32_t i = 0; i < q.n * q.n; i++) {
        upper[i] = i % q.n >= i / q.n ? q.G[i] : 0.0;
    }
    add_product_tn(q.n, q.n, q.n, -1.0, upper, q.n, upper, q.n, difference, q.n);
    return largest_of(difference, q.n * q.n) / largest_of(q.A, q.n * q.n);
}

static int diagonal_is_positive(void)
{
    int positive = 1;
    for (int32_t i = 0; i < q.n; i++) {
        positive &= q.G[i * (q.n + 1)] > 0.0;
    }
    return positive;
}

static const int32_t SIZES[] = {1, 2, 7, 64, 65, 66, LARGEST};

static void added_rows_are_in_the_factor(void)
{
    uint64_t state = 3;
    for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
        for (int32_t rows = 1; rows <= MANY; rows += 11) {
            make_question(SIZES[i], rows, &state);
            CHECK(factor());
            add();
            change_matrix(1.0);
            CHECK(factor_error() < 1e-14);
            CHECK(diagonal_is_positive());
        }
    }
}

static void dropped_rows_leave_the_factor(void)
{
    uint64_t state = 4;
    for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
        for (int32_t rows = 1; rows <= MANY; rows += 11) {
            make_question(SIZES[i], rows, &state);
            change_matrix(1.0);
            CHECK(factor());
            change_matrix(-1.0);
            CHECK(drop());
            CHECK(factor_error() < 1e-12);
            CHECK(diagonal_is_positive());
            for (int32_t e = 0; e < rows * q.n; e++) { /* the rows come out again */
                CHECK_NEAR(q.lost[e], q.X[e], 1e-11);
            }
        }
    }
}

static void the_lower_part_is_left_alone(void)
{
    uint64_t state = 5;
    make_question(20, 3, &state);
    CHECK(factor());
    for (int32_t i = 0; i < q.n; i++) {
        for (int32_t j = 0; j < i; j++) {
            q.G[i * q.n + j] = -7.0;
        }
    }
    add();
    CHECK(drop());
    CHECK(factor_error() < 1e-13);
    for (int32_t i = 0; i < q.n; i++) {
        for (int32_t j = 0; j < i; j++) {
            CHECK(q.G[i * q.n + j] == -7.0);
        }
    }
}

static void rows_of_zeros_change_nothing(void)
{
    uint64_t state = 6;
    static double before[LARGEST * LARGEST];
    make_question(30, 4, &state);
    memset(q.X, 0, sizeof q.X);
    CHECK(factor());
    memcpy(before, q.G, sizeof before);
    add();
    CHECK(memcmp(before, q.G, sizeof before) == 0);
    CHECK(drop());
    CHECK(memcmp(before, q.G, sizeof before) == 0);
}

static void what_is_not_there_cannot_be_dropped(void)
{
    uint64_t state = 7;
    static double before[LARGEST * LARGEST];
    make_question(25, 3, &state);
    CHECK(factor());
    memcpy(before, q.G, sizeof before);
    for (int32_t i = 0; i < q.rows * q.n; i++) {
        q.X[i] *= 100.0;
    }
    CHECK(!drop());
    CHECK(memcmp(before, q.G, sizeof before) == 0);
}

static void rows_may_go_one_by_one_but_not_together(void)
{
    static double before[LARGEST * LARGEST];
    q = (question){.n = 2, .rows = 1, .A = {1.0, 0.0, 0.0, 1.0}, .X = {0.6, 0.6, 0.6, 0.6}};
    CHECK(factor() && drop());
    CHECK(factor());
    memcpy(before, q.G, sizeof before);
    q.rows = 2;
    CHECK(!drop());
    CHECK(memcmp(before, q.G, sizeof before) == 0);
}

/* A unit matrix with a stiff direction x x^T, of which all but a part is dropped: the factor has
 * lost as many digits as the part has, and no more; where it has lost nearly all, it says so. */
static void near_singular_factors_are_told(void)
{
    enum { N = 40 };
    uint64_t state = 8;
    for (int digits = 1; digits <= 15; digits += 2) {
        double left = pow(10.0, -digits), squares = 0.0;
        q.n = N;
        q.rows = 1;
        for (int32_t i = 0; i < N; i++) {
            q.X[i] = random_between(&state, -1.0, 1.0);
            squares += q.X[i] * q.X[i];
        }
        for (int32_t i = 0; i < N; i++) {
            q.X[i] *= sqrt((1.0 - left) / squares);
        }
        for (int32_t i = 0; i < N * N; i++) {
            q.A[i] = i % (N + 1) == 0 ? 1.0 : 0.0;
        }
        CHECK(factor());
        change_matrix(-1.0);
        CHECK(drop() == (digits < 12));
        if (digits < 12) {
            CHECK(factor_error() < 1e-14); /* backward: of A, not of its inverse */
            CHECK(diagonal_is_positive());
            double solved[N];
            memcpy(solved, q.X, sizeof solved);
            cholesky_solve(q.G, N, solved, 1); /* A^-1 x = x / left */
            for (int32_t i = 0; i < N; i++) {
                CHECK_NEAR(solved[i] * left, q.X[i], 1e-14 / left);
            }
        }
    }
}

/* As a session would: rows come and go many times. */
static void errors_do_not_add_up(void)
{
    uint64_t state = 9;
    make_question(60, 8, &state);
    CHECK(factor());
    for (int round = 0; round < 200; round++) {
        for (int32_t i = 0; i < q.rows * q.n; i++) {
            q.X[i] = random_between(&state, -2.0, 2.0);
        }
        add();
        CHECK(drop());
    }
    CHECK(factor_error() < 1e-12);
}

int main(int argc, char **argv)
{
    RUN(added_rows_are_in_the_factor);
    RUN(dropped_rows_leave_the_factor);
    RUN(the_lower_part_is_left_alone);
    RUN(rows_of_zeros_change_nothing);
    RUN(what_is_not_there_cannot_be_dropped);
    RUN(rows_may_go_one_by_one_but_not_together);
    RUN(near_singular_factors_are_told);
    RUN(errors_do_not_add_up);
    return TEST_RESULT;
}
