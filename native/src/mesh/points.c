/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/points.h"

#include "memory.h"

#include <math.h>
#include <string.h>

/* Up to so many points, and one more, are compared one by one. */
enum { LEAF = 16 };

static size_t node_count(const tug_points *t)
{
    return ((size_t)2 << t->levels) - 1;
}

static int32_t middle_of(int32_t begin, int32_t end)
{
    return begin + (end - begin) / 2;
}

/* ------------------------------------------------------------------------------------------------
 * Building
 */

/* Where a point stands along an axis. Its number makes it an order without equals. */
typedef struct key {
    double coordinate;
    int32_t number;
} key;

static key key_of(const tug_points *t, int32_t place, int32_t axis)
{
    size_t entry = (size_t)place * (size_t)t->dimension + (size_t)axis;
    return (key){t->ordered[entry], t->number[place]};
}

static int comes_before(key a, key b)
{
    return a.coordinate < b.coordinate || (a.coordinate == b.coordinate && a.number < b.number);
}

static void exchange(tug_points *t, int32_t a, int32_t b)
{
    size_t d = (size_t)t->dimension;
    double *one = t->ordered + d * (size_t)a, *other = t->ordered + d * (size_t)b;
    for (size_t c = 0; c < d; c++) {
        double coordinate = one[c];
        one[c] = other[c];
        other[c] = coordinate;
    }
    int32_t number = t->number[a];
    t->number[a] = t->number[b];
    t->number[b] = number;
}

/* Any place of the range, but one that no order of the points can have been made for. */
static int32_t choose_pivot(int32_t begin, int32_t end)
{
    uint64_t mixed = ((uint64_t)begin << 32 | (uint64_t)end) * 0x9e3779b97f4a7c15u;
    return begin + (int32_t)((mixed >> 32) % (uint64_t)(end - begin));
}

/* Quickselect: none before `middle` then comes after any behind it. Expected linear time. */
static void select_middle(tug_points *t, int32_t axis, int32_t begin, int32_t middle, int32_t end)
{
    while (end - begin > 1) {
        key pivot = key_of(t, choose_pivot(begin, end), axis);
        int32_t low = begin, high = end - 1;
        while (low <= high) {
            while (comes_before(key_of(t, low, axis), pivot)) {
                low++;
            }
            while (comes_before(pivot, key_of(t, high, axis))) {
                high--;
            }
            if (low <= high) {
                exchange(t, low++, high--);
            }
        }
        if (middle <= high) {
            end = high + 1;
        } else if (middle >= low) {
            begin = low;
        } else {
            return;
        }
    }
}

/* The box and the first number of a node; returns the axis along which it is longest. */
static int32_t enclose(tug_points *t, size_t node, int32_t begin, int32_t end)
{
    size_t d = (size_t)t->dimension;
    double *low = t->boxes + 2 * d * node, *high = low + d;
    const double *point = t->ordered + d * (size_t)begin;
    int32_t first = t->number[begin], longest = 0;
    memcpy(low, point, d * sizeof *low);
    memcpy(high, point, d * sizeof *high);
    for (int32_t i = begin + 1; i < end; i++) {
        point += d;
        first = t->number[i] < first ? t->number[i] : first;
        for (size_t c = 0; c < d; c++) {
            low[c] = point[c] < low[c] ? point[c] : low[c];
            high[c] = point[c] > high[c] ? point[c] : high[c];
        }
    }
    t->first[node] = first;
    for (int32_t c = 1; c < t->dimension; c++) {
        longest = high[c] - low[c] > high[longest] - low[longest] ? c : longest;
    }
    return longest;
}

static void build(tug_points *t, size_t node, int32_t level, int32_t begin, int32_t end)
{
    int32_t axis = enclose(t, node, begin, end), middle = middle_of(begin, end);
    if (level == t->levels) {
        return;
    }
    select_middle(t, axis, begin, middle, end);
    build(t, 2 * node + 1, level + 1, begin, middle);
    build(t, 2 * node + 2, level + 1, middle, end);
}

tug_status points_create(const double *points, int32_t count, int32_t dimension, tug_points **out)
{
    *out = NULL;
    tug_points *t = allocate(1, sizeof *t);
    if (t == NULL) {
        return fail_memory();
    }
    t->count = count;
    t->dimension = dimension;
    while (count >> t->levels > LEAF) {
        t->levels++;
    }
    size_t d = (size_t)dimension, n = (size_t)count;
    t->ordered = allocate(n * d, sizeof *t->ordered);
    t->number = allocate(n, sizeof *t->number);
    t->boxes = allocate(node_count(t) * 2 * d, sizeof *t->boxes);
    t->first = allocate(node_count(t), sizeof *t->first);
    if (!t->ordered || !t->number || !t->boxes || !t->first) {
        points_destroy(t);
        return fail_memory();
    }
    for (int32_t i = 0; i < count; i++) {
        t->number[i] = i;
    }
    memcpy(t->ordered, points, n * d * sizeof *points);
    build(t, 0, 0, 0, count);
    *out = t;
    return TUG_OK;
}

void points_destroy(tug_points *t)
{
    if (t == NULL) {
        return;
    }
    release(t->ordered);
    release(t->number);
    release(t->boxes);
    release(t->first);
    release(t);
}

/* ------------------------------------------------------------------------------------------------
 * Searching
 */

/* What is nearest so far. Of points at the same distance it is the one of the least number, so that
 * the result does not depend on the order of the search. */
typedef struct search {
    const tug_points *tree;
    const double *query;
    double square; /* of the distance */
    int32_t nearest;
} search;

static int is_better(const search *s, double square, int32_t number)
{
    return square < s->square || (square == s->square && number < s->nearest);
}

/* Squared distance of the query from a node's box. Its terms are none larger than those of any
 * point inside, and rounding is monotonic, so neither is the sum, as computed. */
static double measure_box(const search *s, size_t node)
{
    size_t d = (size_t)s->tree->dimension;
    const double *low = s->tree->boxes + 2 * d * node, *high = low + d;
    double square = 0.0;
    for (size_t c = 0; c < d; c++) {
        double below = low[c] - s->query[c], above = s->query[c] - high[c];
        double gap = below > above ? below : above;
        gap = gap > 0.0 ? gap : 0.0;
        square += gap * gap;
    }
    return square;
}

static void search_leaf(search *s, int32_t begin, int32_t end)
{
    size_t d = (size_t)s->tree->dimension;
    for (int32_t i = begin; i < end; i++) {
        const double *point = s->tree->ordered + d * (size_t)i;
        double square = 0.0;
        for (size_t c = 0; c < d; c++) {
            double difference = point[c] - s->query[c];
            square += difference * difference;
        }
        if (is_better(s, square, s->tree->number[i])) {
            s->square = square;
            s->nearest = s->tree->number[i];
        }
    }
}

/* Both halves, the one with the nearer box first, where they can still hold anything better. */
static void search_node(search *s, size_t node, int32_t level, int32_t begin, int32_t end)
{
    if (level == s->tree->levels) {
        search_leaf(s, begin, end);
        return;
    }
    const int32_t *first = s->tree->first;
    int32_t bounds[] = {begin, middle_of(begin, end), end};
    double square[2];
    for (size_t half = 0; half < 2; half++) {
        square[half] = measure_box(s, 2 * node + 1 + half);
    }
    size_t nearer = square[1] < square[0] ||
                    (square[1] == square[0] && first[2 * node + 2] < first[2 * node + 1]);
    for (size_t turn = 0; turn < 2; turn++) {
        size_t half = turn == 0 ? nearer : 1 - nearer, child = 2 * node + 1 + half;
        if (is_better(s, square[half], first[child])) {
            search_node(s, child, level + 1, bounds[half], bounds[half + 1]);
        }
    }
}

void find_nearest(const tug_points *points, const double *query, double limit, int32_t *nearest,
                  double *distance)
{
    search s = {points, query, limit * limit, INT32_MAX};
    search_node(&s, 0, 0, 0, points->count);
    *nearest = s.nearest < INT32_MAX ? s.nearest : -1;
    *distance = s.nearest < INT32_MAX ? sqrt(s.square) : INFINITY;
}
