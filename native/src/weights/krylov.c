/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Block Lanczos with full orthogonalisation and thick restarts (Wu and Simon 2000, Stewart 2002).
 *
 * A Krylov space of a block holds at most as many copies of a multiple eigenvalue as the block has
 * vectors. So what has converged is locked, and another sweep searches what is orthogonal to it
 * from a new start, until a sweep finds nothing that belongs to the result. */
#include "weights/krylov.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { most_applications = 2000, rotated_at_a_time = 256 };

/* A vector is in the span of others where less of its length than this is left. */
static const double dependent = 1e-10;

/* Where less than this is left of one, what rounding has left along V shows, and goes once more. */
static const double cancelled = 1e-2;

/* How far the largest Ritz pair has to have converged before nothing larger is expected. */
static const double settled = 1e-4;

/* Eigenvalues closer than this, relatively, are one. */
static const double same_value = 1e-9;

typedef struct krylov_space {
    const krylov_problem *problem;
    int32_t size, capacity;
    int32_t locked;   /* rows of V that are known or found */
    int32_t count;    /* rows of V behind them whose images are in H */
    int32_t fresh;    /* rows of V behind those, to be applied next */
    int32_t last;     /* how many of `count` were applied last */
    double *V;        /* orthonormal rows */
    double *image;    /* krylov_block by size */
    double *H;        /* capacity by capacity: V_i . A V_j */
    double *coupling; /* krylov_block by krylov_block: last images in terms of fresh rows */
    double *ritz;     /* count by count: row i is the i-th largest Ritz vector in terms of V */
    double *theta;    /* its value, */
    double *residual; /* and the length of A y - theta y */
    double *room;     /* for products with V, rotations and LAPACK */
    double *found;    /* values of the locked rows behind the known ones, falling */
    int32_t known, have, wanted;
    uint64_t random;
    int32_t applications;
} krylov_space;

static void free_space(krylov_space *s)
{
    release(s->V);
    release(s->image);
    release(s->H);
    release(s->coupling);
    release(s->ritz);
    release(s->theta);
    release(s->residual);
    release(s->room);
    release(s->found);
}

static int allocate_space(krylov_space *s)
{
    size_t n = (size_t)s->size, most = (size_t)s->capacity;
    size_t rows = (size_t)(s->known + s->wanted) + most + krylov_block;
    s->V = allocate(rows * n, sizeof(double));
    s->image = allocate(krylov_block * n, sizeof(double));
    s->H = allocate(most * most, sizeof(double));
    s->coupling = allocate(krylov_block * krylov_block, sizeof(double));
    s->ritz = allocate(most * most, sizeof(double));
    s->theta = allocate(most, sizeof(double));
    s->residual = allocate(most, sizeof(double));
    s->room = allocate(rows * rotated_at_a_time, sizeof(double));
    s->found = allocate((size_t)s->wanted + most, sizeof(double));
    return s->V && s->image && s->H && s->coupling && s->ritz && s->theta && s->residual &&
           s->room && s->found;
}

static double *row_of(const krylov_space *s, int32_t row)
{
    return s->V + (size_t)row * (size_t)s->size;
}

/* Uniform in [-1, 1], by splitmix64. */
static double next_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

/* Take what `vectors` have along the first `rows` rows of V out of them; how much that was stays in
 * the room, vectors by rows. */
static void project(krylov_space *s, int32_t rows, int32_t vectors, double *x)
{
    int32_t n = s->size;
    if (rows == 0 || vectors == 0) {
        return;
    }
    memset(s->room, 0, (size_t)rows * (size_t)vectors * sizeof(double));
    add_product_nt(vectors, rows, n, 1.0, x, n, s->V, n, s->room, rows);
    add_product(vectors, n, rows, -1.0, s->room, rows, s->V, n, x, n);
}

/* Take what image i has along the fresh rows out of it, and note how much. */
static void separate(krylov_space *s, int32_t rows, int32_t i)
{
    size_t n = (size_t)s->size;
    double *image = s->image + (size_t)i * n;
    for (int32_t j = 0; j < s->fresh; j++) {
        const double *other = row_of(s, rows + j);
        double share = dot(image, other, n);
        s->coupling[i * krylov_block + j] += share;
        for (size_t v = 0; v < n; v++) {
            image[v] -= share * other[v];
        }
    }
}

/* What the images have beside V's first `rows` rows, made orthonormal, becomes the rows behind
 * those: image i = sum_j coupling_ij row j. The images have been projected once. */
static void append_images(krylov_space *s, int32_t rows, int32_t images)
{
    size_t n = (size_t)s->size;
    memset(s->coupling, 0, krylov_block * krylov_block * sizeof(double));
    s->fresh = 0;
    double before[krylov_block];
    for (int32_t i = 0; i < images; i++) {
        const double *image = s->image + (size_t)i * n;
        before[i] = sqrt(dot(image, image, n));
    }
    project(s, rows, images, s->image);
    for (int32_t i = 0; i < images; i++) {
        double *image = s->image + (size_t)i * n, *row = row_of(s, rows + s->fresh);
        separate(s, rows, i);
        separate(s, rows, i);
        double length = sqrt(dot(image, image, n));
        if (length < cancelled * before[i]) {
            project(s, rows, 1, image);
            separate(s, rows, i);
            length = sqrt(dot(image, image, n));
        }
        if (!(length > dependent * before[i])) {
            continue;
        }
        s->coupling[i * krylov_block + s->fresh] = length;
        for (size_t v = 0; v < n; v++) {
            row[v] = image[v] / length;
        }
        s->fresh++;
    }
}

static void start_sweep(krylov_space *s)
{
    size_t entries = krylov_block * (size_t)s->size;
    for (size_t i = 0; i < entries; i++) {
        s->image[i] = next_random(&s->random);
    }
    s->count = 0;
    project(s, s->locked, krylov_block, s->image);
    append_images(s, s->locked, krylov_block);
}

/* Apply the operator to the fresh rows: they join `count`, and what is new in their images becomes
 * fresh. */
static tug_status expand(krylov_space *s)
{
    size_t n = (size_t)s->size;
    int32_t first = s->count, joined = s->fresh, most = s->capacity;
    double *rows = row_of(s, s->locked + first);
    memset(rows + (size_t)joined * n, 0, (size_t)(krylov_block - joined) * n * sizeof(double));
    tug_status status = s->problem->apply(s->problem->context, rows, s->image);
    if (status != TUG_OK) {
        return status;
    }
    s->applications++;
    s->count += joined;
    s->last = joined;
    int32_t all = s->locked + s->count;
    project(s, all, joined, s->image);
    for (int32_t i = 0; i < joined; i++) {
        for (int32_t j = 0; j < s->count; j++) {
            double product = s->room[i * all + s->locked + j];
            s->H[(first + i) * most + j] = s->H[j * most + first + i] = product;
        }
    }
    append_images(s, all, joined);
    return TUG_OK;
}

/* Ritz pairs of H by falling values, with the lengths of their residuals: what the last rows' share
 * of a vector has in the fresh rows. */
static tug_status find_ritz_pairs(krylov_space *s)
{
    int32_t m = s->count;
    for (int32_t i = 0; i < m; i++) {
        for (int32_t j = 0; j < m; j++) { /* LAPACK's values rise: those of -H are those wanted */
            s->ritz[i * m + j] = -s->H[i * s->capacity + j];
        }
    }
    if (!symmetric_eigenpairs(s->ritz, m, s->theta, s->room)) {
        return fail(TUG_ERROR_NUMERIC, "a dense eigenproblem did not converge");
    }
    for (int32_t i = 0; i < m; i++) {
        s->theta[i] = -s->theta[i];
        double squares = 0.0;
        for (int32_t j = 0; j < s->fresh; j++) {
            double part = 0.0;
            for (int32_t l = 0; l < s->last; l++) {
                part += s->ritz[i * m + m - s->last + l] * s->coupling[l * krylov_block + j];
            }
            squares += part * part;
        }
        s->residual[i] = sqrt(squares);
    }
    return TUG_OK;
}

/* How many of the Ritz values are larger than what they displace from the result. */
static int32_t count_results(const krylov_space *s)
{
    int32_t results = 0;
    while (results < s->wanted && results < s->count) {
        int32_t displaced = s->wanted - 1 - results;
        if (displaced < s->have && s->theta[results] <= s->found[displaced] * (1.0 + same_value)) {
            break;
        }
        results++;
    }
    return results;
}

static int sweep_is_done(const krylov_space *s, int32_t results)
{
    if (s->fresh == 0) {
        return 1;
    }
    for (int32_t i = 0; i < results; i++) {
        if (s->residual[i] > s->problem->tolerance * s->theta[i]) {
            return 0;
        }
    }
    return results > 0 ? s->have + results >= s->wanted : s->residual[0] <= settled * s->theta[0];
}

/* The first rows behind the locked ones become the `kept` largest Ritz vectors. */
static void rotate(krylov_space *s, int32_t kept)
{
    size_t n = (size_t)s->size;
    for (size_t from = 0; from < n; from += rotated_at_a_time) {
        size_t width = n - from < rotated_at_a_time ? n - from : rotated_at_a_time;
        double *rows = row_of(s, s->locked) + from;
        memset(s->room, 0, (size_t)kept * width * sizeof(double));
        add_product(kept, (int32_t)width, s->count, 1.0, s->ritz, s->count, rows, s->size, s->room,
                    (int32_t)width);
        for (size_t i = 0; i < (size_t)kept; i++) {
            memcpy(rows + i * n, s->room + i * width, width * sizeof(double));
        }
    }
}

/* With the largest Ritz vectors and the fresh rows the space goes on as before. */
static void restart(krylov_space *s)
{
    size_t n = (size_t)s->size;
    int32_t kept = (s->wanted + s->count) / 2;
    kept = kept < s->capacity - 2 * krylov_block ? kept : s->capacity - 2 * krylov_block;
    rotate(s, kept);
    memmove(row_of(s, s->locked + kept), row_of(s, s->locked + s->count),
            (size_t)s->fresh * n * sizeof(double));
    memset(s->H, 0, (size_t)s->capacity * (size_t)s->capacity * sizeof(double));
    for (int32_t i = 0; i < kept; i++) {
        s->H[i * s->capacity + i] = s->theta[i];
    }
    s->count = kept;
}

/* Lock the largest Ritz vectors, sorted into those that were found before. */
static void lock(krylov_space *s, int32_t results)
{
    size_t n = (size_t)s->size;
    rotate(s, results);
    for (int32_t i = 0; i < results; i++) {
        int32_t place = s->have + i;
        memcpy(s->image, row_of(s, s->known + place), n * sizeof(double));
        for (; place > 0 && s->found[place - 1] < s->theta[i]; place--) {
            s->found[place] = s->found[place - 1];
            memcpy(row_of(s, s->known + place), row_of(s, s->known + place - 1),
                   n * sizeof(double));
        }
        s->found[place] = s->theta[i];
        memcpy(row_of(s, s->known + place), s->image, n * sizeof(double));
    }
    s->have = s->have + results < s->wanted ? s->have + results : s->wanted;
    s->locked = s->known + s->have;
}

/* results: how many were found. */
static tug_status sweep(krylov_space *s, int32_t *results)
{
    start_sweep(s);
    *results = 0;
    while (s->fresh > 0) {
        double done = s->applications / (s->applications + 10.0);
        tug_status status = report(s->problem->range, s->problem->stage, done);
        if (status == TUG_OK && s->applications == most_applications) {
            status = fail(TUG_ERROR_NUMERIC, "eigenvectors did not converge");
        }
        if (status == TUG_OK) {
            status = expand(s);
        }
        if (status == TUG_OK) {
            status = find_ritz_pairs(s);
        }
        if (status != TUG_OK) {
            return status;
        }
        *results = count_results(s);
        if (sweep_is_done(s, *results)) {
            break;
        }
        if (s->count + s->fresh > s->capacity) {
            restart(s);
        }
    }
    lock(s, *results);
    return TUG_OK;
}

tug_status krylov_largest(const krylov_problem *problem, int32_t known, int32_t wanted,
                          double *vectors, double *values, int32_t *applications)
{
    krylov_space s = {.problem = problem,
                      .size = problem->size,
                      .capacity = 2 * wanted + 8 * krylov_block,
                      .known = known,
                      .wanted = wanted,
                      .locked = known,
                      .random = 1};
    size_t n = (size_t)problem->size;
    tug_status status = allocate_space(&s) ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        memcpy(s.V, vectors, (size_t)known * n * sizeof(double));
    }
    for (int32_t results = 1; status == TUG_OK && results > 0;) {
        status = sweep(&s, &results);
    }
    if (status == TUG_OK && s.have < wanted) {
        status = fail(TUG_ERROR_NUMERIC, "eigenvectors did not converge");
    }
    if (status == TUG_OK) {
        memcpy(vectors, s.V, (size_t)(known + wanted) * n * sizeof(double));
        memcpy(values, s.found, (size_t)wanted * sizeof(double));
        *applications = s.applications;
    }
    free_space(&s);
    return status;
}
