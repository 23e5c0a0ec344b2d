/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sets of things 0 to count - 1 that only ever merge. */
#ifndef TUG_DISJOINT_SETS_H
#define TUG_DISJOINT_SETS_H

#include <stdint.h>

/* Each thing alone. parent: count. */
void separate_sets(int32_t *parent, int32_t count);

/* The least member of the set that holds `thing`. */
int32_t find_set(int32_t *parent, int32_t thing);

void merge_sets(int32_t *parent, int32_t one, int32_t other);

#endif
