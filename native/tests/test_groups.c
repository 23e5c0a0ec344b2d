/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Edge groups: triangles clustered by their weights. */
#include "memory.h"
#include "mesh/mesh.h"
#include "model/groups.h"

#include "test.h"

#include <stdlib.h>

enum { cells = 40, rows = 6, vertex_count = (cells + 1) * (rows + 1) };
enum { triangle_count = 2 * cells * rows };

static const progress_range silent = {NULL, NULL, 0.0, 1.0};

/* A strip of squares, from x = 0 to cells. */
static tug_mesh *make_strip(void)
{
    static double vertices[2 * vertex_count];
    static int32_t triangles[3 * triangle_count];
    int32_t *corner = triangles;
    for (int32_t y = 0; y <= rows; y++) {
        for (int32_t x = 0; x <= cells; x++) {
            int32_t v = y * (cells + 1) + x;
            vertices[2 * v] = x;
            vertices[2 * v + 1] = y;
            if (x < cells && y < rows) {
                int32_t square[] = {v, v + 1, v + cells + 2, v, v + cells + 2, v + cells + 1};
                memcpy(corner, square, sizeof square);
                corner += 6;
            }
        }
    }
    tug_mesh *mesh;
    return mesh_create(vertices, vertex_count, 2, triangles, triangle_count, &mesh) == TUG_OK
               ? mesh
               : NULL;
}

/* Two weights, linear along the strip. */
static void linear_weights(double *weights)
{
    for (int32_t v = 0; v < vertex_count; v++) {
        weights[2 * v] = (v % (cells + 1)) / (double)cells;
        weights[2 * v + 1] = 1.0 - weights[2 * v];
    }
}

/* One-dimensional k-means of a uniform density: equal intervals. */
static void linear_weights_give_equal_intervals(void)
{
    double weights[2 * vertex_count], mass[4] = {0};
    int32_t groups[triangle_count], count;
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    linear_weights(weights);
    CHECK(cluster_triangles(mesh, weights, 2, 4, &silent, groups, &count) == TUG_OK);
    CHECK(count == 4);
    for (int32_t t = 0; t < triangle_count; t++) {
        mass[groups[t]] += mesh->area[t];
        CHECK(groups[t] == groups[t % (2 * cells)]);
    }
    for (int g = 0; g < 4; g++) {
        CHECK_NEAR(mass[g], cells * rows / 4.0, rows);
    }
    mesh_destroy(mesh);
}

static double distance_to(const double *point, const double *centre)
{
    return hypot(point[0] - centre[0], point[1] - centre[1]);
}

/* Every triangle is with the nearest of the area-weighted means, recomputed here. */
static void result_is_a_fixed_point(void)
{
    double weights[2 * vertex_count], point[2 * triangle_count], mean[2 * 7] = {0}, mass[7] = {0};
    int32_t groups[triangle_count], count;
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    for (int32_t v = 0; v < vertex_count; v++) {
        weights[2 * v] = sin(0.1 * v);
        weights[2 * v + 1] = cos(0.37 * v) * 0.5;
    }
    CHECK(cluster_triangles(mesh, weights, 2, 7, &silent, groups, &count) == TUG_OK);
    CHECK(count == 7);
    for (int32_t t = 0; t < triangle_count; t++) {
        int32_t g = groups[t];
        mass[g] += mesh->area[t];
        for (int d = 0; d < 2; d++) {
            const int32_t *corner = mesh->triangles + 3 * t;
            point[2 * t + d] = (weights[2 * corner[0] + d] + weights[2 * corner[1] + d] +
                                weights[2 * corner[2] + d]) /
                               3.0;
            mean[2 * g + d] += mesh->area[t] * point[2 * t + d];
        }
    }
    for (int g = 0; g < 7; g++) {
        mean[2 * g] /= mass[g];
        mean[2 * g + 1] /= mass[g];
    }
    for (int32_t t = 0; t < triangle_count; t++) {
        double own = distance_to(point + 2 * t, mean + 2 * groups[t]);
        for (int g = 0; g < 7; g++) {
            CHECK(own <= distance_to(point + 2 * t, mean + 2 * g) + 1e-12);
        }
    }
    mesh_destroy(mesh);
}

/* Three kinds of triangles only: the weights are constant but for a jump along two columns. */
static void equal_triangles_share_a_group(void)
{
    double weights[vertex_count] = {0};
    int32_t groups[triangle_count], count;
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    CHECK(cluster_triangles(mesh, weights, 1, 5, &silent, groups, &count) == TUG_OK);
    CHECK(count == 1);
    for (int32_t v = 0; v < vertex_count; v++) {
        weights[v] = v % (cells + 1) < cells / 2 ? 0.0 : 1.0;
    }
    CHECK(cluster_triangles(mesh, weights, 1, 100000, &silent, groups, &count) == TUG_OK);
    CHECK(count == 4);
    for (int32_t t = 0; t < triangle_count; t++) {
        CHECK(groups[t] >= 0 && groups[t] < count);
    }
    mesh_destroy(mesh);
}

static void is_deterministic(void)
{
    double weights[2 * vertex_count];
    int32_t first[triangle_count], second[triangle_count], one, other;
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    linear_weights(weights);
    CHECK(cluster_triangles(mesh, weights, 2, 9, &silent, first, &one) == TUG_OK);
    CHECK(cluster_triangles(mesh, weights, 2, 9, &silent, second, &other) == TUG_OK);
    CHECK(one == other);
    CHECK(memcmp(first, second, sizeof first) == 0);
    mesh_destroy(mesh);
}

static int cancel_at_third(void *user, const char *stage, double fraction)
{
    int *calls = user;
    (void)stage, (void)fraction;
    return ++*calls == 3;
}

static void cancel_leaves_the_output(void)
{
    double weights[2 * vertex_count];
    int32_t groups[triangle_count], count = -7;
    int calls = 0;
    progress_range range = {cancel_at_third, &calls, 0.0, 1.0};
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    linear_weights(weights);
    groups[0] = -7;
    CHECK(cluster_triangles(mesh, weights, 2, 9, &range, groups, &count) == TUG_ERROR_CANCELLED);
    CHECK(calls == 3 && count == -7 && groups[0] == -7);
    mesh_destroy(mesh);
}

static void survives_every_failing_allocation(void)
{
    double weights[2 * vertex_count];
    int32_t groups[triangle_count], count;
    tug_mesh *mesh = make_strip();
    CHECK(mesh != NULL);
    linear_weights(weights);
    long before = live_allocations();
    tug_status status = TUG_ERROR_MEMORY;
    for (long successes = 0; status == TUG_ERROR_MEMORY && successes < 100; successes++) {
        fail_allocations_after(successes);
        status = cluster_triangles(mesh, weights, 2, 4, &silent, groups, &count);
        fail_allocations_after(-1);
        CHECK(live_allocations() == before);
    }
    CHECK(status == TUG_OK);
    mesh_destroy(mesh);
}

int main(int argc, char **argv)
{
    RUN(linear_weights_give_equal_intervals);
    RUN(result_is_a_fixed_point);
    RUN(equal_triangles_share_a_group);
    RUN(is_deterministic);
    RUN(cancel_leaves_the_output);
    RUN(survives_every_failing_allocation);
    return TEST_RESULT;
}
