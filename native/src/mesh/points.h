/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Nearest points, by a k-d tree. */
#ifndef TUG_POINTS_H
#define TUG_POINTS_H

#include "status.h"

enum { MAX_POINT_DIMENSION = 6 };

/* A binary tree in an array, node i above nodes 2 i + 1 and 2 i + 2. Each node is for a range of
 * the ordered points; its children halve it, and on the lowest of the levels there are leaves only,
 * so no node need say where its range is. */
struct tug_points {
    int32_t count, dimension;
    int32_t levels;  /* above the leaves */
    double *ordered; /* count by dimension: the points in the order of the leaves */
    int32_t *number; /* count: of an ordered point, as the caller counts */
    double *boxes;   /* nodes by 2 dimension: least and largest coordinates */
    int32_t *first;  /* nodes: the least number in it */
};

/* tug_create_points, its arguments checked. */
tug_status points_create(const double *points, int32_t count, int32_t dimension, tug_points **out);
void points_destroy(tug_points *points);

/* tug_find_nearest for one query, its arguments checked. */
void find_nearest(const tug_points *points, const double *query, double limit, int32_t *nearest,
                  double *distance);

#endif
