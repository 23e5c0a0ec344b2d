/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Trees in an array of parents; a root is the least of its set. */
#include "mesh/disjoint_sets.h"

void separate_sets(int32_t *parent, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        parent[i] = i;
    }
}

int32_t find_set(int32_t *parent, int32_t thing)
{
    while (parent[thing] != thing) {
        parent[thing] = parent[parent[thing]];
        thing = parent[thing];
    }
    return thing;
}

void merge_sets(int32_t *parent, int32_t one, int32_t other)
{
    one = find_set(parent, one);
    other = find_set(parent, other);
    if (one < other) {
        parent[other] = one;
    } else {
        parent[one] = other;
    }
}
