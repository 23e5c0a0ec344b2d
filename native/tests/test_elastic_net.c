/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Elastic nets held to their optimality conditions, which are found from X, Y and Lambda alone. */
#include "dense/dense.h"
#include "fixture.h"
#include "memory.h"
#include "solver/elastic_net.h"
#include "test.h"

enum { MAX_ROWS = 40, MAX_UNKNOWNS = 60, COLUMNS = 3 };

typedef struct question {
    int32_t rows, unknowns;
    double X[MAX_ROWS * MAX_UNKNOWNS], Y[MAX_ROWS * COLUMNS];
    double Lambda[MAX_UNKNOWNS * MAX_UNKNOWNS], T[MAX_UNKNOWNS * COLUMNS];
    double fit, smoothness, sparsity;
    tug_elastic_net_info info;
} question;

static question q;

/* Lambda is diagonal and leaves the first three entries alone, as (F 6) does. */
static void make_question(int32_t rows, int32_t unknowns, double sparsity, uint64_t *state)
{
    q = (question){.rows = rows, .unknowns = unknowns, .fit = 2.0, .smoothness = 0.3};
    q.sparsity = sparsity;
    for (int32_t i = 0; i < rows * unknowns; i++) {
        q.X[i] = random_between(state, -1.0, 1.0);
    }
    for (int32_t i = 0; i < rows * COLUMNS; i++) {
        q.Y[i] = random_between(state, -1.0, 1.0);
    }
    for (int32_t i = 3; i < unknowns; i++) {
        q.Lambda[i * (unknowns + 1)] = random_between(state, 0.0, 1.0);
    }
}

static tug_status solve(void)
{
    q.info.struct_size = sizeof q.info;
    return tug_solve_elastic_net(q.rows, q.unknowns, COLUMNS, q.X, q.Y, q.Lambda, q.fit,
                                 q.smoothness, q.sparsity, q.T, &q.info);
}

/* Minus the gradient of the smooth part: fit X^T (Y - X T) - smoothness Lambda T. */
static void find_slack(double *slack)
{
    double rest[MAX_ROWS * COLUMNS];
    int32_t b = q.unknowns, h = q.rows;
    memcpy(rest, q.Y, sizeof rest);
    add_product(h, COLUMNS, b, -1.0, q.X, b, q.T, COLUMNS, rest, COLUMNS);
    memset(slack, 0, MAX_UNKNOWNS * COLUMNS * sizeof *slack);
    add_product_tn(b, COLUMNS, h, q.fit, q.X, b, rest, COLUMNS, slack, COLUMNS);
    add_product(b, COLUMNS, b, -q.smoothness, q.Lambda, b, q.T, COLUMNS, slack, COLUMNS);
}

/* How far T is from satisfying them: the slack is the sparsity, with the entry's sign, where there
 * is one, and no larger where there is none. */
static double find_violation(void)
{
    double slack[MAX_UNKNOWNS * COLUMNS], violation = 0.0;
    find_slack(slack);
    for (int32_t i = 0; i < q.unknowns * COLUMNS; i++) {
        double t = q.T[i], off = t != 0.0 ? fabs(slack[i] - copysign(q.sparsity, t))
                                          : fmax(fabs(slack[i]) - q.sparsity, 0.0);
        violation = fmax(violation, off);
    }
    return violation;
}

static double find_objective(void)
{
    double sum = 0.0;
    for (int32_t a = 0; a < COLUMNS; a++) {
        for (int32_t r = 0; r < q.rows; r++) {
            double rest = -q.Y[r * COLUMNS + a];
            for (int32_t i = 0; i < q.unknowns; i++) {
                rest += q.X[r * q.unknowns + i] * q.T[i * COLUMNS + a];
            }
            sum += 0.5 * q.fit * rest * rest;
        }
        for (int32_t i = 0; i < q.unknowns; i++) {
            double t = q.T[i * COLUMNS + a];
            sum += q.sparsity * fabs(t);
            for (int32_t j = 0; j < q.unknowns; j++) {
                double product = q.Lambda[i * q.unknowns + j] * q.T[j * COLUMNS + a];
                sum += 0.5 * q.smoothness * t * product;
            }
        }
    }
    return sum;
}

static int32_t count_entries(void)
{
    int32_t count = 0;
    for (int32_t i = 0; i < q.unknowns * COLUMNS; i++) {
        count += q.T[i] != 0.0;
    }
    return count;
}

static void optimality_conditions_hold(void)
{
    uint64_t state = 31;
    const int32_t sizes[][2] = {{1, 1}, {10, 52}, {40, 20}, {7, 60}, {40, 60}};
    const double sparsities[] = {1e-4, 1e-2, 0.3, 3.0};
    for (int i = 0; i < 5 * 4; i++) {
        make_question(sizes[i / 4][0], sizes[i / 4][1], sparsities[i % 4], &state);
        CHECK(solve() == TUG_OK);
        CHECK(q.info.converged && q.info.gap <= 1e-12 && q.info.rounds > 0);
        CHECK(find_violation() < 1e-11);
    }
}

static void more_sparsity_leaves_fewer_entries(void)
{
    uint64_t state = 32;
    int32_t before = MAX_UNKNOWNS * COLUMNS + 1;
    for (double sparsity = 1e-3; sparsity < 200.0; sparsity *= 10.0) {
        state = 32;
        make_question(20, 60, sparsity, &state);
        CHECK(solve() == TUG_OK);
        CHECK(count_entries() < before || before == 0);
        before = count_entries();
    }
    CHECK(before == 0);
}

static void no_point_nearby_is_better(void)
{
    uint64_t state = 33;
    make_question(12, 30, 0.2, &state);
    CHECK(solve() == TUG_OK);
    double least = find_objective();
    for (int32_t i = 0; i < q.unknowns * COLUMNS; i++) {
        for (double move = -1e-3; move < 2e-3; move += 2e-3) {
            q.T[i] += move;
            CHECK(find_objective() > least);
            q.T[i] -= move;
        }
    }
}

/* The whole range of sparsities, down to where (F 22) is the limit. */
static void least_squares_are_the_limit(void)
{
    uint64_t state = 34;
    double dense[MAX_UNKNOWNS * COLUMNS];
    make_question(40, 20, 0.0, &state);
    CHECK(solve() == TUG_OK);
    CHECK(q.info.converged && q.info.rounds == 0 && q.info.gap == 0.0);
    CHECK(find_violation() < 1e-12);
    memcpy(dense, q.T, sizeof dense);
    q.sparsity = 1e-7;
    CHECK(solve() == TUG_OK);
    for (int32_t i = 0; i < q.unknowns * COLUMNS; i++) {
        CHECK_NEAR(q.T[i], dense[i], 1e-6);
    }
}

/* With more columns than rows and no Lambda many T are as good. */
static void least_squares_have_the_least_norm(void)
{
    uint64_t state = 35;
    make_question(6, 25, 0.0, &state);
    CHECK(tug_solve_elastic_net(6, 25, COLUMNS, q.X, q.Y, NULL, 2.0, 0.3, 0.0, q.T, NULL) ==
          TUG_OK);
    memset(q.Lambda, 0, sizeof q.Lambda);
    CHECK(find_violation() < 1e-12);
    /* T = X^T Z: it has no part that X does not see. */
    double products[6 * 6] = {0}, Z[6 * COLUMNS], least[25 * COLUMNS] = {0};
    add_product_nt(6, 6, 25, 1.0, q.X, 25, q.X, 25, products, 6);
    memcpy(Z, q.Y, sizeof Z);
    solve_dense(products, 6, Z, COLUMNS);
    add_product_tn(25, COLUMNS, 6, 1.0, q.X, 25, Z, COLUMNS, least, COLUMNS);
    for (int32_t i = 0; i < 25 * COLUMNS; i++) {
        CHECK_NEAR(q.T[i], least[i], 1e-12);
    }
}

static void columns_may_be_equal_or_nearly(void)
{
    uint64_t state = 36;
    for (int nearly = 0; nearly < 2; nearly++) {
        make_question(10, 40, 0.05, &state);
        memset(q.Lambda, 0, sizeof q.Lambda);
        for (int32_t i = 0; i < q.rows * q.unknowns; i++) {
            int32_t column = i % q.unknowns;
            if (column >= 20) {
                q.X[i] = q.X[i - 20] + nearly * 1e-5 * random_between(&state, -1.0, 1.0);
            }
        }
        CHECK(solve() == TUG_OK);
        CHECK(q.info.converged && find_violation() < 1e-9);
        for (int32_t a = 0; a < COLUMNS; a++) { /* no more entries than there are rows */
            int32_t entries = 0;
            for (int32_t i = 0; i < q.unknowns; i++) {
                entries += q.T[i * COLUMNS + a] != 0.0;
            }
            CHECK(entries <= q.rows);
        }
    }
}

static void columns_of_zeros_stay_zero(void)
{
    uint64_t state = 37;
    for (int sparse = 0; sparse < 2; sparse++) {
        make_question(10, 15, 0.1 * sparse, &state);
        memset(q.Lambda, 0, sizeof q.Lambda);
        for (int32_t r = 0; r < q.rows; r++) {
            q.X[r * q.unknowns + 4] = 0.0;
        }
        CHECK(solve() == TUG_OK);
        for (int32_t a = 0; a < COLUMNS; a++) {
            CHECK_NEAR(q.T[4 * COLUMNS + a], 0.0, sparse ? 0.0 : 1e-13);
        }
        memset(q.X, 0, sizeof q.X);
        CHECK(solve() == TUG_OK);
        CHECK(count_entries() == 0);
    }
}

static void without_a_wish_there_is_nothing(void)
{
    uint64_t state = 38;
    make_question(10, 15, 0.1, &state);
    memset(q.Y, 0, sizeof q.Y);
    CHECK(solve() == TUG_OK);
    CHECK(q.info.converged && q.info.gap == 0.0 && count_entries() == 0);
}

static void penalty_may_be_any_semidefinite_matrix(void)
{
    uint64_t state = 39;
    make_question(10, 30, 0.1, &state);
    double differences[20 * 30];
    for (int32_t i = 0; i < 20 * 30; i++) {
        differences[i] = random_between(&state, -1.0, 1.0);
    }
    memset(q.Lambda, 0, sizeof q.Lambda);
    add_product_tn(30, 30, 20, 1.0, differences, 30, differences, 30, q.Lambda, 30);
    CHECK(solve() == TUG_OK);
    CHECK(q.info.converged && find_violation() < 1e-11);
    double symmetric[MAX_UNKNOWNS * COLUMNS];
    memcpy(symmetric, q.T, sizeof symmetric);
    q.Lambda[5 * 30 + 9] += 2.0; /* what is skew has no say */
    q.Lambda[9 * 30 + 5] -= 2.0;
    CHECK(solve() == TUG_OK);
    for (int32_t i = 0; i < 30 * COLUMNS; i++) {
        CHECK_NEAR(q.T[i], symmetric[i], 1e-12);
    }
    q.Lambda[0] = -1.0;
    CHECK(solve() == TUG_ERROR_ARGUMENT);
    CHECK(strstr(tug_error_text(), "semidefinite") != NULL);
    CHECK_NEAR(q.T[0], symmetric[0], 1e-12);
}

static void unit_of_length_does_not_matter(void)
{
    uint64_t state = 40;
    double T[MAX_UNKNOWNS * COLUMNS];
    make_question(10, 40, 0.1, &state);
    CHECK(solve() == TUG_OK);
    memcpy(T, q.T, sizeof T);
    const double unit = 1e8;
    for (int32_t i = 0; i < q.rows * COLUMNS; i++) {
        q.Y[i] *= unit;
    }
    q.sparsity *= unit;
    CHECK(solve() == TUG_OK);
    CHECK(q.info.converged);
    for (int32_t i = 0; i < q.unknowns * COLUMNS; i++) {
        CHECK_NEAR(q.T[i] / unit, T[i], 1e-12);
    }
}

/* More than the rounding of the products leaves is not found, and said so. */
static void a_gap_that_cannot_be_closed_is_told(void)
{
    uint64_t state = 41;
    make_question(40, 20, 1e-14, &state);
    CHECK(solve() == TUG_OK);
    CHECK(!q.info.converged && q.info.gap > 1e-12 && q.info.rounds < 100);
    CHECK(find_violation() < 1e-11);
}

static void numbers_too_large_are_told(void)
{
    uint64_t state = 42;
    for (int i = 0; i < 4; i++) {
        make_question(10, 15, i % 2 * 0.1, &state);
        (i < 2 ? q.X : q.Y)[3] = 1e200;
        q.X[1] = i < 2 ? 1.0 : 1e150; /* its product with Y overflows, its square does not */
        q.T[0] = -7.0;
        q.info.rounds = -7;
        CHECK(solve() == TUG_ERROR_NUMERIC);
        CHECK(q.T[0] == -7.0 && q.info.rounds == -7);
    }
}

/* One net answers many questions, without memory of them and without allocating. */
static void solves_allocate_nothing(void)
{
    uint64_t state = 43;
    for (int sparse = 0; sparse < 2; sparse++) {
        make_question(10, 30, 0.1 * sparse, &state);
        CHECK(solve() == TUG_OK);
        elastic_net_problem problem = {q.rows, q.unknowns,   q.X,       q.Lambda,
                                       q.fit,  q.smoothness, q.sparsity};
        elastic_net net;
        double other[MAX_ROWS * COLUMNS], T[MAX_UNKNOWNS * COLUMNS];
        CHECK(elastic_net_create(&problem, &net) == TUG_OK);
        for (int32_t i = 0; i < q.rows * COLUMNS; i++) {
            other[i] = 5.0 * q.Y[q.rows * COLUMNS - 1 - i];
        }
        long before = total_allocations();
        elastic_net_solve(&net, other, COLUMNS, T, &q.info);
        elastic_net_solve(&net, q.Y, COLUMNS, T, &q.info);
        CHECK(total_allocations() == before);
        CHECK(memcmp(T, q.T, (size_t)q.unknowns * COLUMNS * sizeof *T) == 0);
        elastic_net_free(&net);
    }
}

int main(int argc, char **argv)
{
    RUN(optimality_conditions_hold);
    RUN(more_sparsity_leaves_fewer_entries);
    RUN(no_point_nearby_is_better);
    RUN(least_squares_are_the_limit);
    RUN(least_squares_have_the_least_norm);
    RUN(columns_may_be_equal_or_nearly);
    RUN(columns_of_zeros_stay_zero);
    RUN(without_a_wish_there_is_nothing);
    RUN(penalty_may_be_any_semidefinite_matrix);
    RUN(unit_of_length_does_not_matter);
    RUN(a_gap_that_cannot_be_closed_is_told);
    RUN(numbers_too_large_are_told);
    RUN(solves_allocate_nothing);
    return TEST_RESULT;
}
