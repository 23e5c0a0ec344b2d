/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/orientation.h"

#include "dense/rotation.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* What infinity stands for: the surface, as stiff as one, turns such a group by about its inverse.
 */
static const double FIRMEST = 1e7;

int orientation_create(const tug_model *model, orientation *oriented)
{
    size_t G = (size_t)model->header.groups, k = (size_t)model->header.dimension;
    oriented->firmness = allocate(G, sizeof *oriented->firmness);
    oriented->mean = allocate(G * k * k, sizeof *oriented->mean);
    oriented->spread = allocate(G, sizeof *oriented->spread);
    return oriented->firmness && oriented->mean && oriented->spread;
}

void orientation_destroy(orientation *oriented)
{
    release(oriented->firmness);
    release(oriented->mean);
    release(oriented->spread);
}

static double squared_distance(const double *A, const double *B, int32_t count)
{
    double squares = 0.0;
    for (int32_t i = 0; i < count; i++) {
        squares += (A[i] - B[i]) * (A[i] - B[i]);
    }
    return squares;
}

/* One more orientation: Welford's update of mean and spread, exact for equal ones. */
static void add_orientation(int32_t k, const double *given, double firmness, int32_t g,
                            orientation *oriented)
{
    double transposed[9] = {0}, O[9], *mean = oriented->mean + g * k * k;
    for (int32_t i = 0; i < k * k; i++) {
        transposed[i] = given[(i % k) * k + i / k];
    }
    closest_rotation(k, transposed, O);
    double before = oriented->firmness[g], share = firmness / (before + firmness);
    oriented->spread[g] += before * share * squared_distance(O, mean, k * k);
    oriented->firmness[g] += firmness;
    for (int32_t i = 0; i < k * k; i++) {
        mean[i] += share * (O[i] - mean[i]);
    }
}

void orient_groups(const tug_model *model, const double *O, const double *firmness,
                   orientation *oriented)
{
    int32_t k = model->header.dimension, G = model->header.groups;
    memset(oriented->firmness, 0, (size_t)G * sizeof *oriented->firmness);
    memset(oriented->mean, 0, (size_t)(G * k * k) * sizeof *oriented->mean);
    memset(oriented->spread, 0, (size_t)G * sizeof *oriented->spread);
    for (int32_t r = 0; r < model->header.rows; r++) {
        if (firmness[r] > 0.0) {
            add_orientation(k, O + r * k * k, fmin(firmness[r], FIRMEST), nearest_group(model, r),
                            oriented);
        }
    }
}

double orientation_energy(const tug_model *model, const orientation *oriented, int32_t g,
                          const double *R)
{
    int32_t kk = model->header.dimension * model->header.dimension;
    if (oriented == NULL || oriented->firmness[g] == 0.0) {
        return 0.0;
    }
    double away = squared_distance(R, oriented->mean + g * kk, kk);
    return model->stiffness[g] * (oriented->firmness[g] * away + oriented->spread[g]);
}

void add_orientation_pull(const tug_model *model, const orientation *oriented, int32_t g,
                          double scale, double *L)
{
    int32_t k = model->header.dimension;
    if (oriented == NULL || oriented->firmness[g] == 0.0) {
        return;
    }
    for (int32_t i = 0; i < k * k; i++) {
        L[i] += scale * oriented->firmness[g] * oriented->mean[g * k * k + (i % k) * k + i / k];
    }
}
