/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lloyd's k-means with the bounds of Hamerly 2010: a triangle is only compared with all centres
 * where the triangle inequality does not already show that its own is still the nearest. */
#include "model/groups.h"

#include "memory.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

enum { most_rounds = 100 };

/* Triangles closer than this part of the spread of all are the same. */
static const double least_distance = 1e-9;

typedef struct clustering {
    int32_t points, dimension, centres;
    const double *area;   /* of a point: its weight */
    double *point;        /* points by dimension: mean weights of a triangle's corners */
    double *centre, *sum; /* centres by dimension */
    double *mass, *moved; /* of a centre: area of its points; its last move */
    double *margin;       /* of a centre: half the distance to the nearest other */
    double *upper;        /* of a point: at least the distance to its centre, */
    double *lower;        /* and at most that to any other */
    int32_t *group;       /* of a point: its centre */
} clustering;

static void close_clustering(clustering *k)
{
    release(k->point);
    release(k->centre);
    release(k->sum);
    release(k->mass);
    release(k->moved);
    release(k->margin);
    release(k->upper);
    release(k->lower);
    release(k->group);
}

static tug_status open_clustering(clustering *k, const tug_mesh *mesh, int32_t dimension,
                                  int32_t wanted)
{
    size_t points = (size_t)mesh->triangle_count, width = (size_t)dimension, most = (size_t)wanted;
    *k = (clustering){.points = mesh->triangle_count, .dimension = dimension, .area = mesh->area};
    k->point = allocate(points * width, sizeof(double));
    k->centre = allocate(most * width, sizeof(double));
    k->sum = allocate(most * width, sizeof(double));
    k->mass = allocate(most, sizeof(double));
    k->moved = allocate(most, sizeof(double));
    k->margin = allocate(most, sizeof(double));
    k->upper = allocate(points, sizeof(double));
    k->lower = allocate(points, sizeof(double));
    k->group = allocate(points, sizeof(int32_t));
    int complete = k->point && k->centre && k->sum && k->mass && k->moved && k->margin &&
                   k->upper && k->lower && k->group;
    return complete ? TUG_OK : fail_memory();
}

static void average_corners(clustering *k, const tug_mesh *mesh, const double *weights)
{
    size_t width = (size_t)k->dimension;
    for (size_t t = 0; t < (size_t)k->points; t++) {
        const int32_t *corner = mesh->triangles + 3 * t;
        const double *a = weights + width * (size_t)corner[0];
        const double *b = weights + width * (size_t)corner[1];
        const double *c = weights + width * (size_t)corner[2];
        for (size_t d = 0; d < width; d++) {
            k->point[t * width + d] = (a[d] + b[d] + c[d]) / 3.0;
        }
    }
}

static const double *point_at(const clustering *k, int32_t point)
{
    return k->point + (size_t)point * (size_t)k->dimension;
}

static double *centre_at(const clustering *k, int32_t centre)
{
    return k->centre + (size_t)centre * (size_t)k->dimension;
}

static double distance(const clustering *k, const double *a, const double *b)
{
    double sum = 0.0;
    for (int32_t d = 0; d < k->dimension; d++) {
        sum += (a[d] - b[d]) * (a[d] - b[d]);
    }
    return sqrt(sum);
}

static void find_mean(const clustering *k, double *mean)
{
    double mass = 0.0;
    memset(mean, 0, (size_t)k->dimension * sizeof *mean);
    for (int32_t i = 0; i < k->points; i++) {
        mass += k->area[i];
        for (int32_t d = 0; d < k->dimension; d++) {
            mean[d] += k->area[i] * point_at(k, i)[d];
        }
    }
    for (int32_t d = 0; d < k->dimension; d++) {
        mean[d] /= mass > 0.0 ? mass : 1.0;
    }
}

/* The point farthest from the mean, then always the one farthest from all seeds so far; upper and
 * lower become the distances to the nearest and the second nearest seed. */
static void choose_seeds(clustering *k, int32_t wanted)
{
    double spread = 0.0;
    find_mean(k, centre_at(k, 0));
    for (int32_t i = 0; i < k->points; i++) {
        k->upper[i] = distance(k, point_at(k, i), centre_at(k, 0));
        k->lower[i] = INFINITY;
    }
    while (k->centres < wanted) {
        int32_t farthest = 0;
        for (int32_t i = 1; i < k->points; i++) {
            farthest = k->upper[i] > k->upper[farthest] ? i : farthest;
        }
        spread = fmax(spread, k->upper[farthest]);
        if (k->centres > 0 && !(k->upper[farthest] > least_distance * spread)) {
            break;
        }
        int32_t seed = k->centres++;
        memcpy(centre_at(k, seed), point_at(k, farthest), (size_t)k->dimension * sizeof(double));
        for (int32_t i = 0; i < k->points; i++) {
            double here = distance(k, point_at(k, i), centre_at(k, seed));
            if (seed == 0 || here < k->upper[i]) {
                k->lower[i] = seed == 0 ? INFINITY : k->upper[i];
                k->upper[i] = here;
                k->group[i] = seed;
            } else {
                k->lower[i] = fmin(k->lower[i], here);
            }
        }
    }
}

/* Centres to the means of their points; one without points stays. Returns the largest move. */
static double move_centres(clustering *k)
{
    size_t width = (size_t)k->dimension;
    memset(k->sum, 0, (size_t)k->centres * width * sizeof(double));
    memset(k->mass, 0, (size_t)k->centres * sizeof(double));
    for (int32_t i = 0; i < k->points; i++) {
        double *sum = k->sum + (size_t)k->group[i] * width;
        const double *point = point_at(k, i);
        k->mass[k->group[i]] += k->area[i];
        for (size_t d = 0; d < width; d++) {
            sum[d] += k->area[i] * point[d];
        }
    }
    double largest = 0.0;
    for (int32_t c = 0; c < k->centres; c++) {
        double *sum = k->sum + (size_t)c * width;
        k->moved[c] = 0.0;
        if (k->mass[c] > 0.0) {
            for (size_t d = 0; d < width; d++) {
                sum[d] /= k->mass[c];
            }
            k->moved[c] = distance(k, sum, centre_at(k, c));
            memcpy(centre_at(k, c), sum, width * sizeof(double));
        }
        largest = fmax(largest, k->moved[c]);
    }
    return largest;
}

static void find_margins(clustering *k)
{
    for (int32_t a = 0; a < k->centres; a++) {
        k->margin[a] = INFINITY;
        for (int32_t b = 0; b < k->centres; b++) {
            if (b != a) {
                double gap = 0.5 * distance(k, centre_at(k, a), centre_at(k, b));
                k->margin[a] = fmin(k->margin[a], gap);
            }
        }
    }
}

static void find_nearest(clustering *k, int32_t point)
{
    double nearest = INFINITY, second = INFINITY;
    for (int32_t c = 0; c < k->centres; c++) {
        double here = distance(k, point_at(k, point), centre_at(k, c));
        if (here < nearest) {
            second = nearest;
            nearest = here;
            k->group[point] = c;
        } else {
            second = fmin(second, here);
        }
    }
    k->upper[point] = nearest;
    k->lower[point] = second;
}

/* Returns how many points changed their centre. */
static int32_t assign_points(clustering *k, double largest_move)
{
    int32_t changed = 0;
    find_margins(k);
    for (int32_t i = 0; i < k->points; i++) {
        int32_t group = k->group[i];
        k->upper[i] += k->moved[group];
        k->lower[i] -= largest_move;
        double safe = fmax(k->lower[i], k->margin[group]);
        if (k->upper[i] > safe) {
            k->upper[i] = distance(k, point_at(k, i), centre_at(k, group));
        }
        if (k->upper[i] > safe) {
            find_nearest(k, i);
            changed += k->group[i] != group;
        }
    }
    return changed;
}

static tug_status run_rounds(clustering *k, const progress_range *range)
{
    int32_t changed = 1;
    for (int32_t round = 0; round < most_rounds && changed > 0; round++) {
        tug_status status = report(range, "grouping triangles", (double)round / most_rounds);
        if (status != TUG_OK) {
            return status;
        }
        changed = assign_points(k, move_centres(k));
    }
    return TUG_OK;
}

/* Number the centres that have points, in the order of the seeds. number: of a centre. */
static int32_t number_groups(const clustering *k, int32_t *number)
{
    int32_t count = 0;
    for (int32_t i = 0; i < k->points; i++) {
        number[k->group[i]] = 1;
    }
    for (int32_t c = 0; c < k->centres; c++) {
        number[c] = number[c] ? count++ : -1;
    }
    return count;
}

tug_status cluster_triangles(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                             int32_t wanted, const progress_range *range, int32_t *groups,
                             int32_t *group_count)
{
    clustering k;
    int32_t most = wanted < mesh->triangle_count ? wanted : mesh->triangle_count;
    int32_t *number = allocate((size_t)most, sizeof *number);
    tug_status status = open_clustering(&k, mesh, weight_count, most);
    if (number == NULL) {
        status = fail_memory();
    }
    if (status == TUG_OK) {
        average_corners(&k, mesh, weights);
        choose_seeds(&k, most);
        status = run_rounds(&k, range);
    }
    if (status == TUG_OK) {
        *group_count = number_groups(&k, number);
        for (int32_t i = 0; i < k.points; i++) {
            groups[i] = number[k.group[i]];
        }
    }
    release(number);
    close_clustering(&k);
    return status;
}
