/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where steps are heading: exact for a linear map, nothing for too few steps. */
#include "dense/extrapolation.h"
#include "fixture.h"
#include "test.h"

enum { SIZE = 7, MEASURED = 3 };

/* x <- x + (goal - x) rate, measured by a diagonal; the last entry goes with the first. */
static void go(const double *rate, const double *goal, const double *from, double *to)
{
    for (int i = 0; i < MEASURED; i++) {
        to[i] = from[i] + rate[i] * (goal[i] - from[i]);
        to[MEASURED + i] = (i + 1) * to[i];
    }
    to[SIZE - 1] = 5.0 * to[0];
}

static void linear_steps_lead_to_their_goal(void)
{
    const double rate[] = {0.5, 0.2, 0.05}, goal[] = {3.0, -1.0, 2.0};
    double from[SIZE] = {0}, to[SIZE], ahead[SIZE];
    extrapolation path = {0};
    CHECK(extrapolation_create(SIZE, MEASURED, &path));
    for (int round = 0; round < MEASURED + 1; round++) {
        go(rate, goal, from, to);
        record_step(&path, from, to);
        memcpy(from, to, sizeof from);
        CHECK(extrapolate(&path, ahead) == (round > 0));
    }
    for (int i = 0; i < MEASURED; i++) {
        CHECK_NEAR(ahead[i], goal[i], 1e-4);
        CHECK_NEAR(ahead[MEASURED + i], (i + 1) * goal[i], 3e-4);
    }
    CHECK_NEAR(ahead[SIZE - 1], 5.0 * goal[0], 5e-4);
    forget_steps(&path);
    CHECK(!extrapolate(&path, ahead));
    extrapolation_destroy(&path);
}

static void only_the_last_steps_count(void)
{
    const double rate[] = {0.5, 0.2, 0.05}, goal[] = {3.0, -1.0, 2.0};
    double from[SIZE] = {0}, to[SIZE], ahead[SIZE], other[SIZE];
    extrapolation path = {0}, late = {0};
    uint64_t random = 1;
    CHECK(extrapolation_create(SIZE, MEASURED, &path) &&
          extrapolation_create(SIZE, MEASURED, &late));
    for (int round = 0; round < 2 * EXTRAPOLATION_DEPTH + 3; round++) {
        for (int i = 0; i < MEASURED; i++) {
            from[i] = random_between(&random, -1.0, 1.0);
            from[MEASURED + i] = (i + 1) * from[i];
        }
        from[SIZE - 1] = 5.0 * from[0];
        go(rate, goal, from, to);
        record_step(&path, from, to);
        if (round >= EXTRAPOLATION_DEPTH + 3) {
            record_step(&late, from, to);
        }
    }
    CHECK(extrapolate(&path, ahead) && extrapolate(&late, other));
    for (int i = 0; i < SIZE; i++) {
        CHECK_NEAR(ahead[i], other[i], 1e-6);
    }
    extrapolation_destroy(&path);
    extrapolation_destroy(&late);
}

static void steps_of_no_length_tell_nothing(void)
{
    double here[SIZE] = {1.0, 2.0, 3.0}, ahead[SIZE];
    extrapolation path = {0};
    CHECK(extrapolation_create(SIZE, MEASURED, &path));
    record_step(&path, here, here);
    record_step(&path, here, here);
    CHECK(!extrapolate(&path, ahead));
    extrapolation_destroy(&path);
}

int main(int argc, char **argv)
{
    RUN(linear_steps_lead_to_their_goal);
    RUN(only_the_last_steps_count);
    RUN(steps_of_no_length_tell_nothing);
    return TEST_RESULT;
}
