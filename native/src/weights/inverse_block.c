/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "weights/inverse_block.h"

#include "dense/dense.h"
#include "memory.h"

#include <stdlib.h>
#include <string.h>

/* A = L L^T, so entry (a, b) of A^-1 is y_a^T y_b with L y_a = e_a. y_a is zero but on the path
 * from a to the root of the elimination tree, and its part in a supernode of the path is one row of
 * that supernode's `halves`. */
typedef struct path_part {
    int32_t count, capacity;
    int32_t *member; /* capacity */
    double *halves;  /* capacity by columns of the supernode */
    int32_t fresh;   /* how many members the running extension adds, */
    int32_t first;   /* the first of them, by place in the batch */
} path_part;

/* Members that are being added, in the order of their rows of L, so that those below a supernode
 * are neighbours. */
typedef struct fresh_member {
    int32_t position, member;
} fresh_member;

struct inverse_block {
    const supernodes *nodes;
    path_part *parts; /* one a supernode */
    int32_t *touched; /* supernodes on the paths of the batch, ascending */
    int32_t touched_count;
    fresh_member *batch;
    int32_t batch_capacity;
    int32_t count, stride;
    double *entries; /* stride by stride */
    double *work;
    size_t work_size;
};

tug_status inverse_block_create(const supernodes *nodes, inverse_block **out)
{
    *out = NULL;
    inverse_block *block = allocate(1, sizeof *block);
    if (block == NULL) {
        return fail_memory();
    }
    block->nodes = nodes;
    block->parts = allocate((size_t)nodes->count, sizeof *block->parts);
    block->touched = allocate((size_t)nodes->count, sizeof *block->touched);
    if (block->parts == NULL || block->touched == NULL) {
        inverse_block_destroy(block);
        return fail_memory();
    }
    *out = block;
    return TUG_OK;
}

void inverse_block_destroy(inverse_block *block)
{
    if (block == NULL) {
        return;
    }
    for (int32_t s = 0; block->parts != NULL && s < block->nodes->count; s++) {
        release(block->parts[s].member);
        release(block->parts[s].halves);
    }
    release(block->parts);
    release(block->touched);
    release(block->batch);
    release(block->entries);
    release(block->work);
    release(block);
}

const double *inverse_block_entries(const inverse_block *block, int32_t *stride)
{
    *stride = block->stride;
    return block->entries;
}

static int32_t columns_of(const supernodes *nodes, int32_t s)
{
    return nodes->first[s + 1] - nodes->first[s];
}

static int32_t rows_of(const supernodes *nodes, int32_t s)
{
    return nodes->row_starts[s + 1] - nodes->row_starts[s];
}

static tug_status grow_entries(inverse_block *block, int32_t count)
{
    if (count <= block->stride) {
        return TUG_OK;
    }
    int32_t stride = count + count / 2;
    double *entries = allocate((size_t)stride * (size_t)stride, sizeof *entries);
    if (entries == NULL) {
        return fail_memory();
    }
    for (int32_t a = 0; a < block->count; a++) {
        memcpy(entries + (size_t)a * (size_t)stride,
               block->entries + (size_t)a * (size_t)block->stride,
               (size_t)block->count * sizeof *entries);
    }
    release(block->entries);
    block->entries = entries;
    block->stride = stride;
    return TUG_OK;
}

static tug_status grow_batch(inverse_block *block, int32_t count)
{
    if (count <= block->batch_capacity) {
        return TUG_OK;
    }
    release(block->batch);
    block->batch_capacity = 0;
    block->batch = allocate((size_t)count, sizeof *block->batch);
    if (block->batch == NULL) {
        return fail_memory();
    }
    block->batch_capacity = count;
    return TUG_OK;
}

static tug_status grow_work(inverse_block *block, size_t size)
{
    if (size <= block->work_size) {
        return TUG_OK;
    }
    release(block->work);
    block->work_size = 0;
    block->work = allocate(size, sizeof *block->work);
    if (block->work == NULL) {
        return fail_memory();
    }
    block->work_size = size;
    return TUG_OK;
}

static tug_status grow_part(path_part *part, int32_t columns)
{
    int32_t count = part->count + part->fresh;
    if (count > part->capacity) {
        size_t capacity = (size_t)count + (size_t)count / 2, width = (size_t)columns;
        int32_t *member = allocate(capacity, sizeof *member);
        double *halves = allocate(capacity * width, sizeof *halves);
        if (member == NULL || halves == NULL) {
            release(member);
            release(halves);
            return fail_memory();
        }
        if (part->count > 0) {
            memcpy(member, part->member, (size_t)part->count * sizeof *member);
            memcpy(halves, part->halves, (size_t)part->count * width * sizeof *halves);
        }
        release(part->member);
        release(part->halves);
        part->member = member;
        part->halves = halves;
        part->capacity = (int32_t)capacity;
    }
    return TUG_OK;
}

static int compare_members(const void *a, const void *b)
{
    return ((const fresh_member *)a)->position - ((const fresh_member *)b)->position;
}

static int compare_numbers(const void *a, const void *b)
{
    return *(const int32_t *)a - *(const int32_t *)b;
}

static void order_batch(inverse_block *block, const int32_t *rows, int32_t count)
{
    for (int32_t b = 0; b < count; b++) {
        block->batch[b].position = block->nodes->position[rows[b]];
        block->batch[b].member = block->count + b;
    }
    qsort(block->batch, (size_t)count, sizeof *block->batch, compare_members);
}

static void walk_paths(inverse_block *block, int32_t count)
{
    block->touched_count = 0;
    for (int32_t b = 0; b < count; b++) {
        int32_t s = block->nodes->holder[block->batch[b].position];
        for (; s >= 0; s = block->nodes->parent[s]) {
            path_part *part = block->parts + s;
            if (part->fresh == 0) {
                part->first = b;
                block->touched[block->touched_count++] = s;
            }
            part->fresh++;
        }
    }
    qsort(block->touched, (size_t)block->touched_count, sizeof *block->touched, compare_numbers);
}

/* Rows for the new members, and in them the right-hand sides e_a. */
static tug_status open_parts(inverse_block *block, int32_t count)
{
    const supernodes *nodes = block->nodes;
    for (int32_t i = 0; i < block->touched_count; i++) {
        int32_t s = block->touched[i];
        path_part *part = block->parts + s;
        tug_status status = grow_part(part, columns_of(nodes, s));
        if (status != TUG_OK) {
            return status;
        }
        size_t width = (size_t)columns_of(nodes, s);
        memset(part->halves + (size_t)part->count * width, 0,
               (size_t)part->fresh * width * sizeof(double));
        for (int32_t f = 0; f < part->fresh; f++) {
            part->member[part->count + f] = block->batch[part->first + f].member;
        }
    }
    for (int32_t b = 0; b < count; b++) {
        int32_t position = block->batch[b].position, s = nodes->holder[position];
        path_part *part = block->parts + s;
        size_t row = (size_t)(part->count + b - part->first);
        part->halves[row * (size_t)columns_of(nodes, s) + (size_t)(position - nodes->first[s])] =
            1.0;
    }
    return TUG_OK;
}

/* Subtract what supernode s contributes to the rows below it, which lie on the rest of the path.
 * below: fresh members of s by rows below it. */
static void scatter_below(inverse_block *block, int32_t s, const double *below)
{
    const supernodes *nodes = block->nodes;
    const path_part *part = block->parts + s;
    int32_t columns = columns_of(nodes, s), count = rows_of(nodes, s) - columns;
    const int32_t *rows = nodes->rows + nodes->row_starts[s] + columns;
    for (int32_t i = 0; i < count; i++) {
        int32_t ancestor = nodes->holder[rows[i]];
        path_part *target = block->parts + ancestor;
        size_t width = (size_t)columns_of(nodes, ancestor);
        size_t row = (size_t)(target->count + part->first - target->first);
        double *to = target->halves + row * width + (size_t)(rows[i] - nodes->first[ancestor]);
        for (size_t f = 0; f < (size_t)part->fresh; f++) {
            to[f * width] += below[f * (size_t)count + (size_t)i];
        }
    }
}

/* The columns of supernode s in L y = e, for the new members below it. */
static tug_status eliminate(inverse_block *block, int32_t s)
{
    const supernodes *nodes = block->nodes;
    const path_part *part = block->parts + s;
    int32_t columns = columns_of(nodes, s), rows = rows_of(nodes, s), below = rows - columns;
    /* The values column after column are L^T in rows. */
    const double *transposed = nodes->values + nodes->value_starts[s];
    double *fresh = part->halves + (size_t)part->count * (size_t)columns;
    solve_right_upper(fresh, part->fresh, columns, transposed, columns, rows);
    if (below == 0) {
        return TUG_OK;
    }
    size_t size = (size_t)part->fresh * (size_t)below;
    tug_status status = grow_work(block, size);
    if (status == TUG_OK) {
        memset(block->work, 0, size * sizeof(double));
        add_product(part->fresh, below, columns, -1.0, fresh, columns, transposed + columns, rows,
                    block->work, below);
        scatter_below(block, s, block->work);
    }
    return status;
}

/* The part of y_a^T y_b in supernode s, for the new members a and all b. */
static tug_status multiply(inverse_block *block, int32_t s)
{
    const path_part *part = block->parts + s;
    int32_t columns = columns_of(block->nodes, s), all = part->count + part->fresh;
    size_t size = (size_t)part->fresh * (size_t)all;
    tug_status status = grow_work(block, size);
    if (status != TUG_OK) {
        return status;
    }
    memset(block->work, 0, size * sizeof(double));
    add_product_nt(part->fresh, all, columns, 1.0,
                   part->halves + (size_t)part->count * (size_t)columns, columns, part->halves,
                   columns, block->work, all);
    for (int32_t f = 0; f < part->fresh; f++) {
        double *row =
            block->entries + (size_t)part->member[part->count + f] * (size_t)block->stride;
        const double *from = block->work + (size_t)f * (size_t)all;
        for (int32_t b = 0; b < all; b++) {
            row[part->member[b]] += from[b];
        }
    }
    return TUG_OK;
}

static tug_status follow_paths(inverse_block *block)
{
    for (int32_t i = 0; i < block->touched_count; i++) {
        int32_t s = block->touched[i];
        tug_status status = eliminate(block, s);
        if (status == TUG_OK) {
            status = multiply(block, s);
        }
        if (status != TUG_OK) {
            return status;
        }
    }
    return TUG_OK;
}

static void close_parts(inverse_block *block, int32_t count)
{
    for (int32_t i = 0; i < block->touched_count; i++) {
        path_part *part = block->parts + block->touched[i];
        part->count += part->fresh;
        part->fresh = 0;
    }
    size_t stride = (size_t)block->stride;
    for (size_t a = (size_t)block->count; a < (size_t)(block->count + count); a++) {
        for (size_t b = 0; b < a; b++) {
            block->entries[b * stride + a] = block->entries[a * stride + b];
        }
    }
    block->count += count;
}

tug_status inverse_block_extend(inverse_block *block, const int32_t *rows, int32_t count)
{
    tug_status status = grow_entries(block, block->count + count);
    if (status == TUG_OK) {
        status = grow_batch(block, count);
    }
    if (status != TUG_OK) {
        return status;
    }
    order_batch(block, rows, count);
    walk_paths(block, count);
    status = open_parts(block, count);
    if (status == TUG_OK) {
        status = follow_paths(block);
    }
    if (status == TUG_OK) {
        close_parts(block, count);
    }
    return status;
}
