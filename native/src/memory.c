/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "memory.h"

#include <stdatomic.h>
#include <stdlib.h>

static atomic_long live;
static atomic_long total;
static atomic_size_t bytes;
static atomic_long successes_left = -1;

/* Counts down to zero and stays there; below zero it is switched off. */
static int may_allocate(void)
{
    long left = atomic_load(&successes_left);
    if (left > 0) {
        atomic_fetch_sub(&successes_left, 1);
    }
    return left != 0;
}

void *allocate(size_t count, size_t size)
{
    if (!may_allocate()) {
        return NULL;
    }
    void *memory = calloc(count > 0 ? count : 1, size > 0 ? size : 1);
    if (memory != NULL) {
        atomic_fetch_add(&live, 1);
        atomic_fetch_add(&total, 1);
        atomic_fetch_add(&bytes, count * size);
    }
    return memory;
}

void release(void *memory)
{
    if (memory != NULL) {
        atomic_fetch_sub(&live, 1);
        free(memory);
    }
}

void fail_allocations_after(long successes)
{
    atomic_store(&successes_left, successes);
}

long live_allocations(void)
{
    return atomic_load(&live);
}

long total_allocations(void)
{
    return atomic_load(&total);
}

size_t allocated_bytes(void)
{
    return atomic_load(&bytes);
}
