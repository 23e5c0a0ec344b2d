/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One triangle: its edges, and products of vectors in space. Here in whole so that the compiler
 * sees the sizes. */
#ifndef TUG_TRIANGLE_H
#define TUG_TRIANGLE_H

#include <stddef.h>
#include <stdint.h>

/* A triangle whose area is below this part of its squared longest edge has none but rounding. */
static const double LEAST_AREA = 1e-12;

static inline double space_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void space_cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* edge: edge[c] runs opposite of corner c, from corner c + 1 to c + 2; third coordinate 0 in 2D.
 * Returns the longest one's square. */
static inline double find_edges(const double *positions, int32_t k, const int32_t *corner,
                                double edge[3][3])
{
    double longest = 0.0;
    for (int c = 0; c < 3; c++) {
        const double *from = positions + (size_t)k * (size_t)corner[(c + 1) % 3];
        const double *to = positions + (size_t)k * (size_t)corner[(c + 2) % 3];
        edge[c][2] = 0.0;
        for (int32_t d = 0; d < k; d++) {
            edge[c][d] = to[d] - from[d];
        }
        double square = space_dot(edge[c], edge[c]);
        longest = square > longest ? square : longest;
    }
    return longest;
}

#endif
