/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Distances along edges and farthest-point samples: where they are known by hand, and against all
 * distances by brute force. */
#include "fixture.h"
#include "test.h"

/* Two rows of `columns` vertices, a column every unit, the rows `width` apart; vertex 2 i + row. */
static tug_mesh *make_ladder(int32_t columns, double width, double start)
{
    double vertices[4 * 32];
    int32_t triangles[6 * 32];
    for (int32_t i = 0; i < 2 * columns; i++) {
        vertices[2 * i] = start + i / 2;
        vertices[2 * i + 1] = i % 2 * width;
    }
    for (int32_t i = 0; i < columns - 1; i++) {
        const int32_t pair[] = {2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3};
        memcpy(triangles + 6 * i, pair, sizeof pair);
    }
    tug_mesh *mesh;
    tug_create_mesh(vertices, 2 * columns, 2, triangles, 2 * (columns - 1), &mesh);
    return mesh;
}

static void samples_halve_a_strip(void)
{
    tug_mesh *mesh = make_ladder(17, 0.01, -3.0);
    int32_t vertices[5];
    CHECK(tug_spread_vertices(mesh, 0, 5, vertices) == TUG_OK);
    const int32_t columns[] = {0, 16, 8, 4, 12}; /* 4 and 12 are equally far */
    for (int i = 0; i < 3; i++) {
        CHECK(vertices[i] / 2 == columns[i]);
    }
    CHECK(vertices[3] / 2 + vertices[4] / 2 == 4 + 12);
    CHECK(vertices[3] / 2 == 4 || vertices[3] / 2 == 12);
    tug_destroy_mesh(mesh);
}

static void first_sample_is_the_one_given(void)
{
    tug_mesh *mesh = make_ladder(9, 0.01, 0.0);
    int32_t vertices[2];
    for (int32_t first = 0; first < 18; first++) {
        CHECK(tug_spread_vertices(mesh, first, 2, vertices) == TUG_OK);
        CHECK(vertices[0] == first);
        CHECK(vertices[1] / 2 == (first / 2 < 4 ? 8 : 0) || first / 2 == 4);
    }
    tug_destroy_mesh(mesh);
}

/* All distances along edges, by Floyd and Warshall. */
static void find_distances(const fixture *f, double *distance)
{
    int32_t n = f->vertices, k = f->dimension;
    for (int32_t i = 0; i < n * n; i++) {
        distance[i] = i % (n + 1) == 0 ? 0.0 : INFINITY;
    }
    for (int32_t i = 0; i < 3 * f->triangles; i++) {
        int32_t a = f->triangle[i], b = f->triangle[i / 3 * 3 + (i + 1) % 3];
        double squares = 0.0;
        for (int32_t c = 0; c < k; c++) {
            double difference = f->shape[a * k + c] - f->shape[b * k + c];
            squares += difference * difference;
        }
        distance[a * n + b] = distance[b * n + a] = sqrt(squares);
    }
    for (int32_t via = 0; via < n; via++) {
        for (int32_t i = 0; i < n * n; i++) {
            distance[i] = fmin(distance[i], distance[i / n * n + via] + distance[via * n + i % n]);
        }
    }
}

/* The distance of a vertex from the nearest of some samples. */
static double distance_from(const double *distance, int32_t n, const int32_t *samples,
                            int32_t count, int32_t vertex)
{
    double least = INFINITY;
    for (int32_t i = 0; i < count; i++) {
        least = fmin(least, distance[samples[i] * n + vertex]);
    }
    return least;
}

static void distances_are_those_of_the_shortest_paths(void)
{
    static double distance[MAX_VERTICES * MAX_VERTICES];
    fixture f;
    for (int i = 0; i < 3; i++) {
        i == 0 ? make_strip(&f) : make_tube(&f, i == 1);
        find_distances(&f, distance);
        tug_mesh *mesh = make_mesh(&f);
        double found[MAX_VERTICES];
        int32_t nearest[MAX_VERTICES];
        for (int32_t v = 0; v < f.vertices; v++) {
            const int32_t sources[] = {v, (7 * v) % f.vertices, v}; /* one of them twice */
            for (int32_t count = 1; count <= 3; count++) {
                CHECK(tug_find_distances(mesh, sources, count, found, nearest) == TUG_OK);
                for (int32_t u = 0; u < f.vertices; u++) {
                    double expected = distance_from(distance, f.vertices, sources, count, u);
                    CHECK_NEAR(found[u], expected, 1e-12);
                    int32_t own = sources[nearest[u]];
                    CHECK_NEAR(distance[own * f.vertices + u], expected, 1e-12);
                }
            }
        }
        tug_destroy_mesh(mesh);
    }
}

static void every_sample_is_a_farthest_vertex(void)
{
    static double distance[MAX_VERTICES * MAX_VERTICES];
    fixture f;
    for (int i = 0; i < 3; i++) {
        i == 0 ? make_strip(&f) : make_tube(&f, i == 1);
        find_distances(&f, distance);
        tug_mesh *mesh = make_mesh(&f);
        int32_t samples[MAX_VERTICES];
        CHECK(tug_spread_vertices(mesh, 7, f.vertices, samples) == TUG_OK);
        for (int32_t count = 1; count < f.vertices; count++) {
            double own = distance_from(distance, f.vertices, samples, count, samples[count]);
            CHECK(own > 0.0); /* none comes twice */
            for (int32_t v = 0; v < f.vertices; v++) {
                CHECK(distance_from(distance, f.vertices, samples, count, v) <= own + 1e-12);
            }
        }
        tug_destroy_mesh(mesh);
    }
}

static void components_come_before_distances(void)
{
    /* A long triangle and two tiny ones. */
    const double vertices[] = {0, 0, 9, 0, 9, 1, 20, 0, 20.1, 0, 20, 0.1, 30, 0, 30.1, 0, 30, 0.1};
    const int32_t triangles[] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    tug_mesh *mesh;
    int32_t samples[9], seen[3] = {0};
    CHECK(tug_create_mesh(vertices, 9, 2, triangles, 3, &mesh) == TUG_OK);
    CHECK(tug_spread_vertices(mesh, 4, 4, samples) == TUG_OK);
    CHECK(samples[0] == 4);
    for (int i = 0; i < 3; i++) {
        seen[samples[i] / 3]++;
    }
    CHECK(seen[0] == 1 && seen[1] == 1 && seen[2] == 1);
    CHECK(samples[3] / 3 == 0);
    double distances[9];
    int32_t nearest[9];
    CHECK(tug_find_distances(mesh, samples, 1, distances, nearest) == TUG_OK);
    for (int i = 0; i < 9; i++) {
        CHECK(isfinite(distances[i]) == (i / 3 == 1)); /* there is no way to other components */
        CHECK(nearest[i] == (i / 3 == 1 ? 0 : -1));
    }
    tug_destroy_mesh(mesh);
}

static void counts_that_cannot_be_are_refused(void)
{
    tug_mesh *mesh = make_ladder(4, 1.0, 0.0);
    int32_t vertices[9] = {-7};
    CHECK(tug_spread_vertices(mesh, 0, 0, vertices) == TUG_ERROR_ARGUMENT);
    CHECK(tug_spread_vertices(mesh, 0, -1, vertices) == TUG_ERROR_ARGUMENT);
    CHECK(tug_spread_vertices(mesh, 0, 9, vertices) == TUG_ERROR_ARGUMENT);
    CHECK(tug_spread_vertices(mesh, -1, 1, vertices) == TUG_ERROR_ARGUMENT);
    CHECK(tug_spread_vertices(mesh, 8, 1, vertices) == TUG_ERROR_ARGUMENT);
    CHECK(vertices[0] == -7);
    CHECK(tug_spread_vertices(mesh, 0, 8, vertices) == TUG_OK);
    tug_destroy_mesh(mesh);
}

int main(int argc, char **argv)
{
    RUN(samples_halve_a_strip);
    RUN(first_sample_is_the_one_given);
    RUN(distances_are_those_of_the_shortest_paths);
    RUN(every_sample_is_a_farthest_vertex);
    RUN(components_come_before_distances);
    RUN(counts_that_cannot_be_are_refused);
    return TEST_RESULT;
}
