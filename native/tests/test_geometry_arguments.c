/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes, surfaces and points with every argument that cannot be. */
#include "fixture.h"
#include "refusal.h"
#include "test.h"

static void tug_create_mesh_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = RUBBISH;
    int32_t n = f.vertices, t = f.triangles;
    const double *v = f.shape;
    CHECK(REFUSED(tug_create_mesh, v, n, 2, f.triangle, t, NULL));
    CHECK(REFUSED(tug_create_mesh, NULL, n, 2, f.triangle, t, &mesh) && mesh == NULL);
    const int32_t counts[][3] = {{0, 2, t}, {-1, 2, t},    {n, 1, t},        {n, 4, t},
                                 {n, 0, t}, {n, 2, 0},     {n, 2, -1},       {n, 2, INT32_MAX},
                                 {3, 2, t}, {n - 1, 2, t}, {INT32_MIN, 2, t}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        mesh = RUBBISH;
        CHECK(REFUSED(tug_create_mesh, v, counts[i][0], counts[i][1], f.triangle, counts[i][2],
                      &mesh));
        CHECK(mesh == NULL);
    }
    mesh = RUBBISH;
    CHECK(REFUSED(tug_create_mesh, v, n, 2, NULL, t, &mesh) && mesh == NULL);
    f.triangle[4] = -1;
    mesh = RUBBISH;
    CHECK(REFUSED(tug_create_mesh, v, n, 2, f.triangle, t, &mesh) && mesh == NULL);
}

static void mesh_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    char text[8] = "before";
    int32_t errors = -7, warnings = -7, numbers[MAX_VERTICES] = {-7}, count = -7;
    CHECK(REFUSED(tug_check_mesh, NULL, text, 8, &errors, &warnings));
    CHECK(REFUSED(tug_check_mesh, mesh, NULL, 8, &errors, &warnings));
    CHECK(REFUSED(tug_check_mesh, mesh, text, 0, &errors, &warnings));
    CHECK(REFUSED(tug_check_mesh, mesh, text, 8, NULL, &warnings));
    CHECK(REFUSED(tug_check_mesh, mesh, text, 8, &errors, NULL));
    CHECK(REFUSED(tug_find_components, NULL, numbers, &count));
    CHECK(REFUSED(tug_find_components, mesh, NULL, &count));
    CHECK(REFUSED(tug_find_components, mesh, numbers, NULL));
    CHECK(REFUSED(tug_spread_vertices, NULL, 0, 1, numbers));
    CHECK(REFUSED(tug_spread_vertices, mesh, 0, 1, NULL));
    CHECK(REFUSED(tug_spread_vertices, mesh, 0, 0, numbers));
    CHECK(REFUSED(tug_spread_vertices, mesh, 0, f.vertices + 1, numbers));
    CHECK(REFUSED(tug_spread_vertices, mesh, f.vertices, 1, numbers));
    CHECK(REFUSED(tug_spread_vertices, mesh, -1, 1, numbers));
    CHECK(strcmp(text, "before") == 0 && errors == -7 && warnings == -7);
    CHECK(numbers[0] == -7 && count == -7);
    tug_destroy_mesh(mesh);
}

static void surface_calls_refuse(void)
{
    fixture f, flat;
    make_tube(&f, 0);
    make_strip(&flat);
    tug_mesh *mesh = make_mesh(&f), *flat_mesh = make_mesh(&flat);
    static double out[3 * MAX_TRIANGLES] = {-7.0}, positions[MAX_COORDINATES];
    memcpy(positions, f.shape, sizeof positions);
    int32_t sources[] = {0, f.vertices};
    CHECK(REFUSED(tug_find_distances, NULL, sources, 1, out, NULL));
    CHECK(REFUSED(tug_find_distances, mesh, NULL, 1, out, NULL));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 1, NULL, NULL));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 0, out, NULL));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 2, out, NULL));
    sources[0] = -1;
    CHECK(REFUSED(tug_find_distances, mesh, sources, 1, out, NULL));
    CHECK(REFUSED(tug_find_areas, NULL, out) && REFUSED(tug_find_areas, mesh, NULL));
    CHECK(REFUSED(tug_get_cotangents, NULL, out) && REFUSED(tug_get_cotangents, mesh, NULL));
    CHECK(REFUSED(tug_find_normals, NULL, positions, out));
    CHECK(REFUSED(tug_find_normals, mesh, NULL, out));
    CHECK(REFUSED(tug_find_normals, mesh, positions, NULL));
    CHECK(REFUSED(tug_find_normals, flat_mesh, positions, out));
    const double bad[] = {NAN, INFINITY, -1e151};
    for (int i = 0; i < 3; i++) {
        positions[5] = bad[i];
        CHECK(REFUSED(tug_find_normals, mesh, positions, out));
    }
    CHECK(out[0] == -7.0);
    tug_destroy_mesh(flat_mesh);
    tug_destroy_mesh(mesh);
}

static void point_calls_refuse(void)
{
    double points[] = {0, 0, 0, 1, 1, 1}, distances[] = {-7.0, -7.0};
    int32_t nearest[] = {-7, -7};
    tug_points *p = RUBBISH;
    CHECK(REFUSED(tug_create_points, points, 2, 3, NULL));
    CHECK(REFUSED(tug_create_points, NULL, 2, 3, &p) && p == NULL);
    const int32_t counts[][2] = {{0, 3}, {-1, 3}, {2, 0}, {2, -1}, {2, 7}, {INT32_MIN, 3}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        p = RUBBISH;
        CHECK(REFUSED(tug_create_points, points, counts[i][0], counts[i][1], &p) && p == NULL);
    }
    const double bad[] = {NAN, INFINITY, -1e151};
    for (int i = 0; i < 3; i++) {
        points[4] = bad[i];
        p = RUBBISH;
        CHECK(REFUSED(tug_create_points, points, 2, 3, &p) && p == NULL);
    }
    points[4] = 1.0;
    CHECK(tug_create_points(points, 2, 3, &p) == TUG_OK);
    CHECK(REFUSED(tug_find_nearest, NULL, points, 2, 1.0, nearest, distances));
    CHECK(REFUSED(tug_find_nearest, p, NULL, 2, 1.0, nearest, distances));
    CHECK(REFUSED(tug_find_nearest, p, points, 2, 1.0, NULL, distances));
    CHECK(REFUSED(tug_find_nearest, p, points, 2, 1.0, nearest, NULL));
    CHECK(REFUSED(tug_find_nearest, p, points, 0, 1.0, nearest, distances));
    CHECK(REFUSED(tug_find_nearest, p, points, 2, -1.0, nearest, distances));
    CHECK(REFUSED(tug_find_nearest, p, points, 2, NAN, nearest, distances));
    for (int i = 0; i < 3; i++) {
        points[4] = bad[i];
        CHECK(REFUSED(tug_find_nearest, p, points, 2, 1.0, nearest, distances));
    }
    CHECK(nearest[0] == -7 && distances[0] == -7.0);
    tug_destroy_points(p);
}

int main(int argc, char **argv)
{
    RUN(tug_create_mesh_refuses);
    RUN(mesh_calls_refuse);
    RUN(surface_calls_refuse);
    RUN(point_calls_refuse);
    return TEST_RESULT;
}
