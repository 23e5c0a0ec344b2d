/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The distance of atom b from atom a is what is left of b without its part along a: |b|^2 sin^2 of
 * their angle. Medoids are chosen one by one, each where it lowers the sum of all distances most,
 * and then moved within their clusters as long as that lowers it (Kaufman and Rousseeuw 1987; Park
 * and Jun 2009). */
#include "dictionaries/medoids.h"

#include "dictionaries/dictionary_gram.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { most_rounds = 100 };

/* The part of the progress bar up to the distances. */
static const double gram_share = 0.7;

typedef struct medoid_search {
    int32_t atoms, block, medoids; /* columns; columns a weight function; medoids so far */
    double *distance;              /* atoms by atoms: of the second from the first */
    double *nearest;               /* atoms: distance from the nearest medoid, */
    int32_t *owner;                /* and which column that is */
    int32_t *chosen;               /* atoms: whether it is a medoid */
} medoid_search;

static int allocate_search(medoid_search *s)
{
    size_t atoms = (size_t)s->atoms;
    s->distance = allocate(atoms * atoms, sizeof(double));
    s->nearest = allocate(atoms, sizeof(double));
    s->owner = allocate(atoms, sizeof(int32_t));
    s->chosen = allocate(atoms, sizeof(int32_t));
    return s->distance && s->nearest && s->owner && s->chosen;
}

static void free_search(medoid_search *s)
{
    release(s->distance);
    release(s->nearest);
    release(s->owner);
    release(s->chosen);
}

static double *row_of(const medoid_search *s, int32_t atom)
{
    return s->distance + (size_t)atom * (size_t)s->atoms;
}

/* A weight function itself: always kept, since translations need it. */
static int is_weight(const medoid_search *s, int32_t atom)
{
    return atom % s->block == 0;
}

/* From inner products to distances, in place. */
static tug_status find_distances(medoid_search *s)
{
    double *squares = allocate((size_t)s->atoms, sizeof *squares);
    if (squares == NULL) {
        return fail_memory();
    }
    for (int32_t a = 0; a < s->atoms; a++) {
        squares[a] = row_of(s, a)[a];
    }
    for (int32_t a = 0; a < s->atoms; a++) {
        double *row = row_of(s, a);
        for (int32_t b = 0; b < s->atoms; b++) {
            double along = squares[a] > 0.0 ? row[b] * row[b] / squares[a] : 0.0;
            row[b] = a == b ? 0.0 : fmax(0.0, squares[b] - along);
        }
    }
    release(squares);
    return TUG_OK;
}

static void choose(medoid_search *s, int32_t medoid)
{
    const double *distance = row_of(s, medoid);
    s->chosen[medoid] = 1;
    s->medoids++;
    for (int32_t a = 0; a < s->atoms; a++) {
        if (s->medoids == 1 || distance[a] < s->nearest[a]) {
            s->nearest[a] = distance[a];
            s->owner[a] = medoid;
        }
    }
}

/* By how much one more medoid would lower the sum. */
static double gain_of(const medoid_search *s, int32_t atom)
{
    const double *distance = row_of(s, atom);
    double gain = 0.0;
    for (int32_t a = 0; a < s->atoms; a++) {
        gain += fmax(0.0, s->nearest[a] - distance[a]);
    }
    return gain;
}

static tug_status choose_all(medoid_search *s, int32_t wanted, const progress_range *range)
{
    for (int32_t a = 0; a < s->atoms; a += s->block) {
        choose(s, a);
    }
    while (s->medoids < wanted) {
        int32_t best = -1;
        double largest = -1.0;
        tug_status status = report(range, "choosing atoms", (double)s->medoids / wanted);
        if (status != TUG_OK) {
            return status;
        }
        for (int32_t a = 0; a < s->atoms; a++) {
            double gain = s->chosen[a] ? -1.0 : gain_of(s, a);
            best = gain > largest ? a : best;
            largest = fmax(largest, gain);
        }
        choose(s, best);
    }
    return TUG_OK;
}

static double cluster_cost(const medoid_search *s, int32_t cluster, int32_t medoid)
{
    const double *distance = row_of(s, medoid);
    double sum = 0.0;
    for (int32_t a = 0; a < s->atoms; a++) {
        sum += s->owner[a] == cluster ? distance[a] : 0.0;
    }
    return sum;
}

/* The member of a cluster from which the others are least far. */
static int32_t find_middle(const medoid_search *s, int32_t cluster)
{
    int32_t best = cluster;
    double least = cluster_cost(s, cluster, cluster);
    for (int32_t a = 0; a < s->atoms && !is_weight(s, cluster); a++) {
        double cost = s->owner[a] == cluster && a != cluster ? cluster_cost(s, cluster, a) : least;
        best = cost < least ? a : best;
        least = fmin(cost, least);
    }
    return best;
}

static void assign_all(medoid_search *s)
{
    s->medoids = 0;
    for (int32_t a = 0; a < s->atoms; a++) {
        if (s->chosen[a]) {
            choose(s, a);
        }
    }
}

/* Returns how many medoids moved. */
static int32_t move_medoids(medoid_search *s)
{
    int32_t moved = 0;
    for (int32_t a = 0; a < s->atoms; a++) {
        int32_t middle = s->chosen[a] && s->owner[a] == a ? find_middle(s, a) : a;
        if (middle != a) {
            s->chosen[a] = 0;
            s->chosen[middle] = 1;
            moved++;
        }
    }
    assign_all(s);
    return moved;
}

static tug_status search(medoid_search *s, const dictionary *D, int32_t wanted,
                         const progress_range *range)
{
    progress_range first = progress_part(range, 0.0, gram_share);
    progress_range second = progress_part(range, gram_share, 1.0);
    tug_status status = find_gram(D, &first, s->distance);
    if (status == TUG_OK) {
        status = find_distances(s);
    }
    if (status == TUG_OK) {
        status = choose_all(s, wanted, &second);
    }
    for (int32_t round = 0; status == TUG_OK && round < most_rounds && move_medoids(s) > 0;) {
        round++;
    }
    return status;
}

tug_status reduce_dictionary(const tug_dictionary *given, int32_t wanted,
                             const progress_range *range, int32_t *atoms)
{
    own_dictionary own;
    tug_status status = own_dictionary_create(given, &own);
    if (status != TUG_OK) {
        return status;
    }
    medoid_search s = {.atoms = dictionary_columns(&own.D), .block = block_columns(&own.D)};
    status = allocate_search(&s) ? search(&s, &own.D, wanted, range) : fail_memory();
    for (int32_t a = 0; a < s.atoms && status == TUG_OK; a++) {
        if (s.chosen[a]) {
            *atoms++ = a;
        }
    }
    free_search(&s);
    own_dictionary_free(&own);
    return status;
}
