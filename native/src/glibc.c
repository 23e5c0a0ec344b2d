/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Older versions of what libtug calls in glibc, so that a library built on a recent system loads
   wherever Blender does, with glibc 2.28. The linker sends calls of X to __wrap_X (--wrap). A
   function that took a new version without a change in what it does is named by its first one. */
#define _GNU_SOURCE
#include <math.h>
#include <pthread.h>
#include <sched.h>

#define OLDER(result, name, version, parameters, ...)                                              \
    __asm__(".symver older_" #name ", " #name "@GLIBC_" version);                                  \
    result older_##name parameters;                                                                \
    result __wrap_##name parameters;                                                               \
    result __wrap_##name parameters                                                                \
    {                                                                                              \
        return older_##name(__VA_ARGS__);                                                          \
    }

OLDER(double, hypot, "2.2.5", (double x, double y), x, y)
OLDER(int, pthread_create, "2.2.5",
      (pthread_t * thread, const pthread_attr_t *attributes, void *(*start)(void *),
       void *argument),
      thread, attributes, start, argument)
OLDER(int, pthread_join, "2.2.5", (pthread_t thread, void **value), thread, value)
OLDER(int, pthread_getaffinity_np, "2.3.4", (pthread_t thread, size_t size, cpu_set_t *processors),
      thread, size, processors)
OLDER(int, pthread_setaffinity_np, "2.3.4",
      (pthread_t thread, size_t size, const cpu_set_t *processors), thread, size, processors)
