/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Nearest points against a search of them all, bit for bit. */
#include "fixture.h"
#include "test.h"

enum { POINTS = 700, QUERIES = 60, MAX_DIMENSION = 6 };

typedef struct question {
    int32_t count, dimension;
    double points[POINTS * MAX_DIMENSION], queries[QUERIES * MAX_DIMENSION];
    int32_t nearest[QUERIES];
    double distances[QUERIES];
} question;

static question q;

static void make_random(int32_t count, int32_t dimension, uint64_t *state)
{
    q.count = count;
    q.dimension = dimension;
    for (int32_t i = 0; i < count * dimension; i++) {
        q.points[i] = random_between(state, -1.0, 1.0);
    }
    for (int32_t i = 0; i < QUERIES * dimension; i++) {
        q.queries[i] = random_between(state, -2.0, 2.0);
    }
}

/* Points and queries on a grid: many at the same distance. */
static void round_all(void)
{
    for (int32_t i = 0; i < q.count * q.dimension; i++) {
        q.points[i] = round(2.0 * q.points[i]);
    }
    for (int32_t i = 0; i < QUERIES * q.dimension; i++) {
        q.queries[i] = 0.5 * round(4.0 * q.queries[i]);
    }
}

static int ask(double limit)
{
    tug_points *points;
    int found =
        tug_create_points(q.points, q.count, q.dimension, &points) == TUG_OK &&
        tug_find_nearest(points, q.queries, QUERIES, limit, q.nearest, q.distances) == TUG_OK;
    tug_destroy_points(points);
    return found;
}

static void search_all(int32_t query, double limit, int32_t *nearest, double *distance)
{
    double least = limit * limit;
    *nearest = -1;
    for (int32_t i = 0; i < q.count; i++) {
        double square = 0.0;
        for (int32_t c = 0; c < q.dimension; c++) {
            double difference = q.points[i * q.dimension + c] - q.queries[query * q.dimension + c];
            square += difference * difference;
        }
        if (square < least || (square == least && *nearest < 0)) {
            least = square;
            *nearest = i;
        }
    }
    *distance = *nearest < 0 ? INFINITY : sqrt(least);
}

static int agrees(double limit)
{
    int same = ask(limit);
    for (int32_t i = 0; i < QUERIES && same; i++) {
        int32_t nearest;
        double distance;
        search_all(i, limit, &nearest, &distance);
        same = nearest == q.nearest[i] && distance == q.distances[i];
    }
    return same;
}

static void nearest_is_that_of_brute_force(void)
{
    uint64_t state = 11;
    for (int32_t dimension = 1; dimension <= MAX_DIMENSION; dimension++) {
        for (int32_t count = 1; count <= POINTS; count = 2 * count + 1) {
            make_random(count, dimension, &state);
            CHECK(agrees(INFINITY));
            CHECK(agrees(0.4));
        }
    }
}

static void of_equals_the_first_is_taken(void)
{
    uint64_t state = 12;
    for (int32_t dimension = 1; dimension <= MAX_DIMENSION; dimension++) {
        make_random(POINTS, dimension, &state);
        round_all();
        CHECK(agrees(INFINITY));
        CHECK(agrees(0.5)); /* a point exactly at the limit counts */
        CHECK(agrees(0.0));
    }
}

static void points_may_all_be_one(void)
{
    uint64_t state = 13;
    make_random(POINTS, 3, &state);
    for (int32_t i = 3; i < 3 * POINTS; i++) {
        q.points[i] = q.points[i % 3];
    }
    CHECK(agrees(INFINITY));
    CHECK(q.nearest[0] == 0);
}

static void sorted_points_are_no_harder(void)
{
    uint64_t state = 14;
    make_random(POINTS, 2, &state);
    for (int32_t i = 0; i < POINTS; i++) {
        q.points[2 * i] = i % 2 ? i : -i;
        q.points[2 * i + 1] = 1e-3 * i;
    }
    CHECK(agrees(INFINITY));
}

/* The same points in any order have the same distances. */
static void order_does_not_matter(void)
{
    uint64_t state = 15;
    make_random(POINTS, 6, &state);
    CHECK(ask(INFINITY));
    double distances[QUERIES];
    memcpy(distances, q.distances, sizeof distances);
    for (int32_t i = 0; i < POINTS / 2; i++) {
        for (int32_t c = 0; c < 6; c++) {
            double *one = q.points + 6 * i + c, *other = q.points + 6 * (POINTS - 1 - i) + c;
            double exchanged = *one;
            *one = *other;
            *other = exchanged;
        }
    }
    CHECK(agrees(INFINITY));
    CHECK(memcmp(distances, q.distances, sizeof distances) == 0);
}

static void far_points_do_not_overflow(void)
{
    uint64_t state = 16;
    make_random(40, 6, &state);
    for (int32_t i = 0; i < 40 * 6; i++) {
        q.points[i] = copysign(1e150, q.points[i]);
    }
    for (int32_t i = 0; i < QUERIES * 6; i++) {
        q.queries[i] = copysign(1e150, q.queries[i]);
    }
    CHECK(agrees(INFINITY));
    CHECK(isfinite(q.distances[0]));
}

static void every_point_finds_itself(void)
{
    uint64_t state = 17;
    make_random(QUERIES, 4, &state);
    memcpy(q.queries, q.points, QUERIES * 4 * sizeof *q.points);
    CHECK(ask(0.0));
    for (int32_t i = 0; i < QUERIES; i++) {
        CHECK(q.nearest[i] == i && q.distances[i] == 0.0);
    }
}

int main(int argc, char **argv)
{
    RUN(nearest_is_that_of_brute_force);
    RUN(of_equals_the_first_is_taken);
    RUN(points_may_all_be_one);
    RUN(sorted_points_are_no_harder);
    RUN(order_does_not_matter);
    RUN(far_points_do_not_overflow);
    RUN(every_point_finds_itself);
    return TEST_RESULT;
}
