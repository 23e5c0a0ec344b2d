/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A test is a function that stops at its first CHECK that does not hold; main lists them with RUN
 * and returns TEST_RESULT. argv[1], where given, is part of the names to run. */
#ifndef TUG_TEST_H
#define TUG_TEST_H

#include <math.h>
#include <stdio.h>
#include <string.h>

static int tests_passed, tests_failed, test_failed_here;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            printf("%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                         \
            test_failed_here = 1;                                                                  \
            return;                                                                                \
        }                                                                                          \
    } while (0)

#define CHECK_NEAR(value, expected, tolerance)                                                     \
    do {                                                                                           \
        double near_value = (value), near_expected = (expected);                                   \
        if (!(fabs(near_value - near_expected) <= (tolerance))) {                                  \
            printf("%s:%d: %s is %.17g, not %.17g\n", __FILE__, __LINE__, #value, near_value,      \
                   near_expected);                                                                 \
            test_failed_here = 1;                                                                  \
            return;                                                                                \
        }                                                                                          \
    } while (0)

#define RUN(test)                                                                                  \
    do {                                                                                           \
        if (argc < 2 || strstr(#test, argv[1]) != NULL) {                                          \
            test_failed_here = 0;                                                                  \
            test();                                                                                \
            printf("%s %s\n", test_failed_here ? "FAIL" : "ok  ", #test);                          \
            tests_failed += test_failed_here;                                                      \
            tests_passed += !test_failed_here;                                                     \
        }                                                                                          \
    } while (0)

#define TEST_RESULT                                                                                \
    (printf("%d passed, %d failed\n", tests_passed, tests_failed), tests_failed != 0)

#endif
