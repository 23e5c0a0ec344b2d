/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The entries of A^-1 between the members of a set of rows that grows, from the factor of A. */
#ifndef TUG_INVERSE_BLOCK_H
#define TUG_INVERSE_BLOCK_H

#include "sparse/sparse.h"

typedef struct inverse_block inverse_block;

/* The empty set. The supernodes must outlive it. */
tug_status inverse_block_create(const supernodes *nodes, inverse_block **out);

/* NULL is allowed. */
void inverse_block_destroy(inverse_block *block);

/* Add `count` rows of A that are not yet members. Work: for each new row its path to the root of
 * the elimination tree, and for each pair with a member the part of the path they share. After a
 * failure the block can only be destroyed. */
tug_status inverse_block_extend(inverse_block *block, const int32_t *rows, int32_t count);

/* Entry (a, b) of the members in the order they came in is at a stride + b. */
const double *inverse_block_entries(const inverse_block *block, int32_t *stride);

#endif
