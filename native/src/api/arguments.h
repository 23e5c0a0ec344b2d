/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks of arguments, for the public calls: the only code that meets a caller's pointer. */
#ifndef TUG_ARGUMENTS_H
#define TUG_ARGUMENTS_H

#include "status.h"

#include <math.h>

#define REQUIRE(condition, ...)                                                                    \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            return fail(TUG_ERROR_ARGUMENT, __VA_ARGS__);                                          \
        }                                                                                          \
    } while (0)

#define REQUIRE_POINTER(call, pointer) REQUIRE((pointer) != NULL, call ": " #pointer " is NULL")

#define REQUIRE_SIZE(call, thing)                                                                  \
    REQUIRE((thing)->struct_size == sizeof *(thing),                                               \
            call ": struct_size of " #thing " is %zu, this library's is %zu",                      \
            (thing)->struct_size, sizeof *(thing))

#define REQUIRE_INFO(call, info)                                                                   \
    do {                                                                                           \
        if ((info) != NULL) {                                                                      \
            REQUIRE_SIZE(call, info);                                                              \
        }                                                                                          \
    } while (0)

/* The first of `count` values that is not finite, or -1. */
static inline ptrdiff_t find_not_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            return (ptrdiff_t)i;
        }
    }
    return -1;
}

/* The first of `count` coordinates that is not finite, or whose square might not be, or -1. */
static inline ptrdiff_t find_too_far(const double *coordinates, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!(fabs(coordinates[i]) <= 1e150)) {
            return (ptrdiff_t)i;
        }
    }
    return -1;
}

#endif
