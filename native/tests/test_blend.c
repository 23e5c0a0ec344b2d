/* SPDX-License-Identifier: GPL-3.0-or-later */
/* (A 20) on the simplices. Instances are u(B) = 1/2 |A B - y|^2, so that u is known without
 * cancellation, and whether a blend is optimal is judged from A, y and d alone. */
#include "fixture.h"
#include "test.h"

enum { MAX_UNKNOWNS = 40, MAX_ROWS = 60 };

typedef struct problem {
    int32_t groups, shapes, n, rows;
    double A[MAX_ROWS * MAX_UNKNOWNS], y[MAX_ROWS];
    double d[MAX_UNKNOWNS], lambda;
    int32_t squared;
    double Q[MAX_UNKNOWNS * MAX_UNKNOWNS], c[MAX_UNKNOWNS], r;
} problem;

/* Q = A^T A, c = - A^T y, r = y^T y. */
static void reduce(problem *p)
{
    p->r = 0.0;
    for (int32_t i = 0; i < p->n; i++) {
        p->c[i] = 0.0;
        for (int32_t j = 0; j < p->n; j++) {
            p->Q[i * p->n + j] = 0.0;
        }
    }
    for (int32_t e = 0; e < p->rows; e++) {
        const double *row = p->A + e * p->n;
        for (int32_t i = 0; i < p->n; i++) {
            for (int32_t j = 0; j < p->n; j++) {
                p->Q[i * p->n + j] += row[i] * row[j];
            }
            p->c[i] -= row[i] * p->y[e];
        }
        p->r += p->y[e] * p->y[e];
    }
}

static void make_problem(problem *p, uint64_t *state, int32_t groups, int32_t shapes, int32_t rows)
{
    *p = (problem){.groups = groups, .shapes = shapes, .n = groups * shapes, .rows = rows};
    for (int32_t i = 0; i < rows * p->n; i++) {
        p->A[i] = random_between(state, -1.0, 1.0);
    }
    for (int32_t e = 0; e < rows; e++) {
        p->y[e] = random_between(state, -0.4, 0.4) * groups;
    }
    for (int32_t i = 0; i < p->n; i++) {
        p->d[i] = random_between(state, 0.0, 1.0);
    }
    p->lambda = 0.5;
    reduce(p);
}

/* y <- A B and the costs of B's entries are zero: u = 0 at B. */
static void put_target_on(problem *p, const double *B)
{
    for (int32_t e = 0; e < p->rows; e++) {
        p->y[e] = 0.0;
        for (int32_t i = 0; i < p->n; i++) {
            p->y[e] += p->A[e * p->n + i] * B[i];
        }
    }
    for (int32_t i = 0; i < p->n; i++) {
        p->d[i] = B[i] > 0.0 ? 0.0 : p->d[i];
    }
    reduce(p);
}

/* Shape `to` of every group becomes weights . its other shapes. */
static void make_dependent(problem *p, int32_t to, const double *weights)
{
    for (int32_t e = 0; e < p->rows; e++) {
        for (int32_t g = 0; g < p->groups; g++) {
            double sum = 0.0;
            for (int32_t s = 0; s < p->shapes; s++) {
                sum += s == to ? 0.0 : weights[s] * p->A[e * p->n + g * p->shapes + s];
            }
            p->A[e * p->n + g * p->shapes + to] = sum;
        }
    }
    reduce(p);
}

/* A B - y, and u. */
static double find_residual(const problem *p, const double *B, double *residual)
{
    double u = 0.0;
    for (int32_t e = 0; e < p->rows; e++) {
        residual[e] = -p->y[e];
        for (int32_t i = 0; i < p->n; i++) {
            residual[e] += p->A[e * p->n + i] * B[i];
        }
        u += 0.5 * residual[e] * residual[e];
    }
    return u;
}

static double objective_at(const problem *p, const double *B)
{
    double residual[MAX_ROWS], u = find_residual(p, B, residual), cost = 0.0;
    for (int32_t i = 0; i < p->n; i++) {
        cost += p->lambda * p->d[i] * B[i];
    }
    return (p->squared ? u : sqrt(u)) + cost;
}

/* What is lost of f where u is found from Q, c and r, as the library has to. */
static double rounding_at(const problem *p, const double *B)
{
    double residual[MAX_ROWS], u = find_residual(p, B, residual), lost = 4e-15 * p->r;
    return 1e-13 + (p->squared ? lost : sqrt(u + lost) - sqrt(u));
}

/* How far f(B) can be above its minimum: grad f^T B - min grad f^T B'. */
static double gap_at(const problem *p, const double *B)
{
    double residual[MAX_ROWS], u = find_residual(p, B, residual), gap = 0.0;
    for (int32_t g = 0; g < p->groups; g++) {
        double mean = 0.0, least = INFINITY;
        for (int32_t i = g * p->shapes; i < (g + 1) * p->shapes; i++) {
            double slope = 0.0;
            for (int32_t e = 0; e < p->rows; e++) {
                slope += p->A[e * p->n + i] * residual[e];
            }
            slope = slope / (p->squared ? 1.0 : 2.0 * sqrt(u)) + p->lambda * p->d[i];
            mean += B[i] * slope;
            least = fmin(least, slope);
        }
        gap += mean - least;
    }
    return gap;
}

static int is_blend(const problem *p, const double *B)
{
    for (int32_t g = 0; g < p->groups; g++) {
        double sum = 0.0;
        for (int32_t i = g * p->shapes; i < (g + 1) * p->shapes; i++) {
            if (!(B[i] >= 0.0)) {
                return 0;
            }
            sum += B[i];
        }
        if (!(fabs(sum - 1.0) <= 1e-12)) {
            return 0;
        }
    }
    return 1;
}

/* The objective of the result, computed anew; NaN where the result or its info is not sound: not a
 * blend, worse than the start, or an objective or gap that says something else. */
static double minimise(const problem *p, double *B)
{
    tug_blend_info info = {.struct_size = sizeof info};
    double before = objective_at(p, B);
    tug_status status = tug_minimise_blend(p->groups, p->shapes, p->Q, p->c, p->r, p->d, p->lambda,
                                           p->squared, B, &info);
    double after = objective_at(p, B), noise = rounding_at(p, B);
    int sound = status == TUG_OK && is_blend(p, B) && after <= before + noise &&
                fabs(info.objective - after) <= noise && info.gap >= 0.0 && info.pivots >= 0;
    return sound ? after : NAN;
}

static double minimise_from_anywhere(const problem *p, uint64_t *state, double *B)
{
    random_blend(state, p->groups, p->shapes, B);
    return minimise(p, B);
}

/* Two shapes, one group: f on the segment from t = 0 to 1 by hand. With u = h + v (t - t0)^2 and
 * the cost's slope m, f' = 0 at t - t0 = - m sqrt(h / (v (v - m^2))). */
static double closed_form(const problem *p)
{
    double aa = 0.0, ab = 0.0, bb = 0.0, slope = p->lambda * (p->d[1] - p->d[0]);
    for (int32_t e = 0; e < p->rows; e++) {
        double a = p->A[2 * e] - p->y[e], b = p->A[2 * e + 1] - p->A[2 * e];
        aa += a * a, ab += a * b, bb += b * b;
    }
    double middle = -ab / bb, v = 0.5 * bb, h = fmax(0.5 * (aa - ab * ab / bb), 0.0), shift;
    if (p->squared) {
        shift = -slope / (2.0 * v);
    } else {
        shift = v > slope * slope ? -slope * sqrt(h / (v * (v - slope * slope))) : -slope * 1e9;
    }
    return fmin(fmax(middle + shift, 0.0), 1.0);
}

static void two_shapes_agree_with_the_closed_form(void)
{
    uint64_t state = 1;
    int inside = 0;
    for (int i = 0; i < 400; i++) {
        problem p;
        double B[2];
        make_problem(&p, &state, 1, 2, 3);
        p.squared = i % 2;
        p.lambda = random_between(&state, 0.0, 1.0);
        CHECK(isfinite(minimise_from_anywhere(&p, &state, B)));
        CHECK_NEAR(B[1], closed_form(&p), 1e-7);
        inside += B[0] > 0.0 && B[1] > 0.0;
    }
    CHECK(inside > 100 && inside < 350); /* both kinds were there */
}

/* The least objective on a grid of `steps` a side: for one group of three shapes or two of two. */
static double search_grid(const problem *p, int steps)
{
    double least = INFINITY;
    for (int i = 0; i <= steps; i++) {
        for (int j = 0; j <= steps; j++) {
            double a = (double)i / steps, b = (double)j / steps;
            const double three[] = {a, b, 1.0 - a - b}, two[] = {a, 1.0 - a, b, 1.0 - b};
            if (p->groups == 2 || i + j <= steps) {
                least = fmin(least, objective_at(p, p->groups == 2 ? two : three));
            }
        }
    }
    return least;
}

static void no_point_of_a_fine_grid_is_better(void)
{
    uint64_t state = 2;
    for (int i = 0; i < 60; i++) {
        problem p;
        double B[4];
        make_problem(&p, &state, 1 + i % 2, i % 2 ? 2 : 3, 4);
        p.squared = i / 2 % 2;
        double objective = minimise_from_anywhere(&p, &state, B), grid = search_grid(&p, 200);
        CHECK(objective <= grid + 1e-12);
        CHECK(objective >= grid - 0.02); /* and the grid comes near it */
    }
}

/* Instance number i of a family that takes in sizes, both forms and definite and rank-poor Q. */
static void make_numbered(problem *p, uint64_t *state, int i)
{
    const int32_t groups[] = {1, 3, 8, 4}, shapes[] = {6, 4, 5, 1};
    int32_t n = groups[i % 4] * shapes[i % 4];
    make_problem(p, state, groups[i % 4], shapes[i % 4], i / 4 % 2 ? n + 5 : n / 2 + 1);
    p->squared = i / 8 % 2;
}

static void result_is_optimal(void)
{
    uint64_t state = 3;
    for (int i = 0; i < 320; i++) {
        problem p;
        double B[MAX_UNKNOWNS], residual[MAX_ROWS];
        make_numbered(&p, &state, i);
        double objective = minimise_from_anywhere(&p, &state, B);
        CHECK(isfinite(objective));
        if (find_residual(&p, B, residual) > 1e-10) { /* f is smooth here */
            CHECK_NEAR(gap_at(&p, B), 0.0, 1e-9);
        }
    }
}

static void every_start_ends_at_the_same_objective(void)
{
    uint64_t state = 4;
    for (int i = 0; i < 64; i++) {
        problem p;
        double B[MAX_UNKNOWNS], least = INFINITY, largest = 0.0;
        make_numbered(&p, &state, i);
        for (int start = 0; start < 12; start++) {
            double objective = minimise_from_anywhere(&p, &state, B);
            CHECK(isfinite(objective));
            least = fmin(least, objective);
            largest = fmax(largest, objective);
        }
        CHECK_NEAR(largest, least, 1e-12 + 2.0 * rounding_at(&p, B));
    }
}

static void gap_is_a_true_bound(void)
{
    uint64_t state = 5;
    for (int i = 0; i < 160; i++) {
        problem p;
        double B[MAX_UNKNOWNS], other[MAX_UNKNOWNS];
        tug_blend_info info = {.struct_size = sizeof info};
        make_numbered(&p, &state, i);
        random_blend(&state, p.groups, p.shapes, B);
        CHECK(tug_minimise_blend(p.groups, p.shapes, p.Q, p.c, p.r, p.d, p.lambda, p.squared, B,
                                 &info) == TUG_OK);
        CHECK(info.gap <= 1e-7 * (1.0 + info.objective));
        for (int trial = 0; trial < 50; trial++) {
            random_blend(&state, p.groups, p.shapes, other);
            double mix = pow(10.0, random_between(&state, -6.0, 0.0));
            for (int32_t j = 0; j < p.n; j++) {
                other[j] = mix * other[j] + (1.0 - mix) * B[j];
            }
            CHECK(info.objective - info.gap <= objective_at(&p, other) + 1e-12);
        }
    }
}

static void target_on_a_shape_gives_that_shape(void)
{
    uint64_t state = 6;
    for (int i = 0; i < 100; i++) {
        problem p;
        double B[MAX_UNKNOWNS], shape[MAX_UNKNOWNS] = {0};
        make_problem(&p, &state, 1 + i % 5, 2 + i % 4, 45);
        for (int32_t g = 0; g < p.groups; g++) {
            shape[g * p.shapes + (g + i) % p.shapes] = 1.0;
        }
        put_target_on(&p, shape);
        p.squared = i / 3 % 2;
        double objective = minimise_from_anywhere(&p, &state, B);
        CHECK_NEAR(objective, 0.0, 1e-7);
        for (int32_t j = 0; j < p.n; j++) {
            CHECK_NEAR(B[j], shape[j], 1e-7);
        }
    }
}

/* Q, c and r come from sums of far larger terms: where u is zero they may say that it is below. */
static void rounding_does_not_spoil_the_gap(void)
{
    uint64_t state = 11;
    for (int i = 0; i < 40; i++) {
        problem p;
        double B[MAX_UNKNOWNS], shape[MAX_UNKNOWNS] = {0};
        tug_blend_info info = {.struct_size = sizeof info};
        make_problem(&p, &state, 1 + i % 5, 2 + i % 4, 45);
        for (int32_t g = 0; g < p.groups; g++) {
            shape[g * p.shapes + (g + i) % p.shapes] = 1.0;
        }
        put_target_on(&p, shape);
        p.r *= 1.0 - 1e-9;
        for (int32_t j = 0; j < p.n; j++) {
            p.c[j] *= 1.0 + random_between(&state, -1e-10, 1e-10);
        }
        random_blend(&state, p.groups, p.shapes, B);
        CHECK(tug_minimise_blend(p.groups, p.shapes, p.Q, p.c, p.r, p.d, p.lambda, 0, B, &info) ==
              TUG_OK);
        CHECK_NEAR(info.objective, 0.0, 1e-7 * sqrt(p.r)); /* u counts as 4e-15 r at least */
        CHECK_NEAR(info.gap, 0.0, 1e-7);
    }
}

/* Shapes that nearly agree in a group, the targets on the first of them: what the energy says of
 * exchanging them drowns in the rounding of Q, c and r, and what it costs is little, but does not.
 */
static void make_agreeing(problem *p, uint64_t *state, int i, double rounding, double *first)
{
    make_problem(p, state, 1 + i % 5, 2 + i % 7, 45);
    double agreement = pow(10.0, random_between(state, -9.0, -5.0));
    for (int32_t j = 0; j < p->rows * p->n; j++) {
        p->A[j] = p->A[j / p->shapes * p->shapes] + agreement * random_between(state, -1.0, 1.0);
    }
    for (int32_t j = 0; j < p->n; j++) {
        first[j] = j % p->shapes == 0 ? 1.0 : 0.0;
    }
    put_target_on(p, first);
    p->lambda = pow(10.0, random_between(state, -8.0, -3.0));
    for (int32_t j = 0; j < p->n; j++) {
        p->c[j] += rounding * p->r * random_between(state, -1.0, 1.0);
    }
}

static void rounding_does_not_lead_away_from_an_example(void)
{
    uint64_t state = 12;
    for (int i = 0; i < 200; i++) {
        problem p;
        double B[MAX_UNKNOWNS];
        make_agreeing(&p, &state, i, 1e-15, B);
        CHECK_NEAR(minimise(&p, B), 0.0, 1e-7 * sqrt(p.r));
    }
}

/* f as Q, c and r have it, rounding and all, u counting as 4e-15 r at least. */
static double reduced_objective(const problem *p, const double *B)
{
    double u = 0.5 * p->r, cost = 0.0;
    for (int32_t i = 0; i < p->n; i++) {
        u += B[i] * p->c[i];
        cost += p->lambda * p->d[i] * B[i];
        for (int32_t j = 0; j < p->n; j++) {
            u += 0.5 * B[i] * p->Q[i * p->n + j] * B[j];
        }
    }
    return sqrt(fmax(u, 4e-15 * p->r)) + cost;
}

static void objective_does_not_rise_where_rounding_is_coarse(void)
{
    uint64_t state = 13;
    for (int i = 0; i < 400; i++) {
        problem p;
        double B[MAX_UNKNOWNS];
        tug_blend_info info = {.struct_size = sizeof info};
        make_agreeing(&p, &state, i, 3e-14, B);
        double before = reduced_objective(&p, B);
        CHECK(tug_minimise_blend(p.groups, p.shapes, p.Q, p.c, p.r, p.d, p.lambda, 0, B, &info) ==
              TUG_OK);
        CHECK(info.objective <= before + 6e-8 * sqrt(p.r)); /* sqrt(4e-15 r), what u hides */
    }
}

static void target_within_the_shapes_is_met_when_costs_do_not_count(void)
{
    uint64_t state = 7;
    for (int i = 0; i < 60; i++) {
        problem p;
        double B[MAX_UNKNOWNS], inner[MAX_UNKNOWNS];
        make_problem(&p, &state, 1 + i % 5, 2 + i % 4, 45);
        random_blend(&state, p.groups, p.shapes, inner);
        put_target_on(&p, inner);
        p.squared = i / 2 % 2;
        p.lambda = 0.0;
        double objective = minimise_from_anywhere(&p, &state, B);
        CHECK_NEAR(objective, 0.0, 1e-7);
        for (int32_t j = 0; j < p.n; j++) {
            CHECK_NEAR(B[j], inner[j], 1e-6);
        }
    }
}

static void shapes_that_are_there_twice_do_no_harm(void)
{
    uint64_t state = 8;
    for (int i = 0; i < 80; i++) {
        problem p;
        double B[MAX_UNKNOWNS], weights[8] = {0}, objective, residual[MAX_ROWS];
        make_problem(&p, &state, 1 + i % 5, 3 + i % 3, 45);
        weights[0] = i % 2 ? 1.0 : 0.4; /* a copy, or between two others */
        weights[p.shapes - 1] = i % 2 ? 0.0 : 0.6;
        make_dependent(&p, p.shapes - 2, weights);
        p.squared = i / 4 % 2;
        objective = minimise_from_anywhere(&p, &state, B);
        CHECK(isfinite(objective));
        if (find_residual(&p, B, residual) > 1e-10) {
            CHECK_NEAR(gap_at(&p, B), 0.0, 1e-9);
        }
    }
}

static void cheapest_shapes_win_where_nothing_else_counts(void)
{
    uint64_t state = 9;
    for (int i = 0; i < 40; i++) {
        problem p;
        double B[MAX_UNKNOWNS];
        int huge = i % 2; /* lambda, or else Q and c are zero */
        make_problem(&p, &state, 1 + i % 5, 2 + i % 4, huge ? 45 : 1);
        p.squared = i / 2 % 2;
        for (int32_t j = 0; j < p.n && !huge; j++) {
            p.A[j] = 0.0;
        }
        reduce(&p);
        p.lambda = huge ? 1e9 : 0.5;
        random_blend(&state, p.groups, p.shapes, B);
        CHECK(tug_minimise_blend(p.groups, p.shapes, p.Q, p.c, p.r, p.d, p.lambda, p.squared, B,
                                 NULL) == TUG_OK);
        CHECK(is_blend(&p, B));
        for (int32_t j = 0; j < p.n; j++) {
            for (int32_t k = j / p.shapes * p.shapes; k < (j / p.shapes + 1) * p.shapes; k++) {
                CHECK(B[j] < 1e-7 || p.d[j] <= p.d[k] + 1e-9);
            }
        }
    }
}

static void nothing_to_fit_is_not_a_division_by_zero(void)
{
    for (int squared = 0; squared < 2; squared++) {
        const double Q[16] = {0}, c[4] = {0}, free_of_charge[4] = {0}, d[4] = {0.3, 0.1, 0.2, 0.4};
        double B[] = {0.5, 0.5, 0.25, 0.75};
        tug_blend_info info = {.struct_size = sizeof info};
        CHECK(tug_minimise_blend(2, 2, Q, c, 0.0, free_of_charge, 0.5, squared, B, &info) ==
              TUG_OK);
        CHECK_NEAR(info.objective + info.gap, 0.0, 1e-100);
        CHECK_NEAR(B[0] + B[1], 1.0, 1e-15);
        CHECK(tug_minimise_blend(2, 2, Q, c, 0.0, d, 0.5, squared, B, &info) == TUG_OK);
        CHECK_NEAR(info.objective, 0.15, 1e-12);
        CHECK_NEAR(B[1], 1.0, 1e-12);
        CHECK_NEAR(B[2], 1.0, 1e-12);
    }
}

/* Every length in the question times `scale`: Q, c and r by its square, d by itself. */
static void result_does_not_depend_on_the_unit(void)
{
    uint64_t state = 10;
    for (int i = 0; i < 40; i++) {
        problem p;
        double B[MAX_UNKNOWNS], other[MAX_UNKNOWNS], scale = i % 2 ? 1e-6 : 1e6;
        make_problem(&p, &state, 3, 4, 20);
        random_blend(&state, 3, 4, B);
        memcpy(other, B, sizeof other);
        CHECK(tug_minimise_blend(3, 4, p.Q, p.c, p.r, p.d, 0.5, 0, B, NULL) == TUG_OK);
        for (int32_t j = 0; j < p.rows * p.n; j++) {
            p.A[j] *= scale;
        }
        for (int32_t e = 0; e < p.rows; e++) {
            p.y[e] *= scale;
        }
        for (int32_t j = 0; j < p.n; j++) {
            p.d[j] *= scale;
        }
        reduce(&p);
        CHECK(tug_minimise_blend(3, 4, p.Q, p.c, p.r, p.d, 0.5, 0, other, NULL) == TUG_OK);
        for (int32_t j = 0; j < p.n; j++) {
            CHECK_NEAR(other[j], B[j], 1e-8);
        }
    }
}

int main(int argc, char **argv)
{
    RUN(two_shapes_agree_with_the_closed_form);
    RUN(no_point_of_a_fine_grid_is_better);
    RUN(result_is_optimal);
    RUN(every_start_ends_at_the_same_objective);
    RUN(gap_is_a_true_bound);
    RUN(target_on_a_shape_gives_that_shape);
    RUN(rounding_does_not_spoil_the_gap);
    RUN(rounding_does_not_lead_away_from_an_example);
    RUN(objective_does_not_rise_where_rounding_is_coarse);
    RUN(target_within_the_shapes_is_met_when_costs_do_not_count);
    RUN(shapes_that_are_there_twice_do_no_harm);
    RUN(cheapest_shapes_win_where_nothing_else_counts);
    RUN(nothing_to_fit_is_not_a_division_by_zero);
    RUN(result_does_not_depend_on_the_unit);
    return TEST_RESULT;
}
