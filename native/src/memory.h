/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every allocation of the library itself (CHOLMOD and OpenBLAS keep their own). */
#ifndef TUG_MEMORY_H
#define TUG_MEMORY_H

#include <stddef.h>

/* Zeroed room for count things of `size` bytes; NULL where it fails or the product overflows. Never
 * NULL for a count of zero. */
void *allocate(size_t count, size_t size);

/* NULL is allowed. */
void release(void *memory);

/* For tests: the allocation after `successes` more fails, and so do all later ones; negative: none.
 * Not for use while other threads allocate. */
void fail_allocations_after(long successes);

/* For tests: blocks allocated and not yet released, and allocations ever made. */
long live_allocations(void);
long total_allocations(void);

/* For tests: bytes ever asked for. */
size_t allocated_bytes(void);

#endif
