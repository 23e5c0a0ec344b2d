/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Normals and areas of vertices, where they are known by hand and by symmetry. */
#include "fixture.h"
#include "mesh/mesh.h"
#include "test.h"

static const double CUBE[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,
                              0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
/* Outward. Corners have two to five triangles each. */
static const int32_t CUBE_FACES[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                     1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};

static void normals_of_a_cube_are_its_diagonals(void)
{
    tug_mesh *mesh;
    double normals[24];
    CHECK(tug_create_mesh(CUBE, 8, 3, CUBE_FACES, 12, &mesh) == TUG_OK);
    CHECK(tug_find_normals(mesh, CUBE, normals) == TUG_OK);
    for (int i = 0; i < 24; i++) { /* however its squares are cut in two */
        CHECK_NEAR(normals[i], (2.0 * CUBE[i] - 1.0) / sqrt(3.0), 1e-15);
    }
    tug_destroy_mesh(mesh);
}

static void normals_are_units_and_turn_with_the_pose(void)
{
    fixture f;
    make_tube(&f, 1);
    tug_mesh *mesh = make_mesh(&f);
    uint64_t state = 21;
    const double offset[] = {3.0, -2.0, 5.0}, none[] = {0.0, 0.0, 0.0};
    static double pose[MAX_COORDINATES], before[MAX_COORDINATES], after[MAX_COORDINATES];
    for (int32_t s = 0; s < f.shapes; s++) {
        double R[9];
        random_rotation(&state, 3, R);
        memcpy(pose, shape_of(&f, s), (size_t)coordinate_count(&f) * sizeof *pose);
        CHECK(tug_find_normals(mesh, pose, before) == TUG_OK);
        move_points(3, R, offset, f.vertices, pose);
        CHECK(tug_find_normals(mesh, pose, after) == TUG_OK);
        move_points(3, R, none, f.vertices, before);
        for (int32_t v = 0; v < f.vertices; v++) {
            double square = 0.0;
            for (int32_t c = 0; c < 3; c++) {
                CHECK_NEAR(after[3 * v + c], before[3 * v + c], 1e-13);
                square += after[3 * v + c] * after[3 * v + c];
            }
            CHECK_NEAR(square, 1.0, 1e-14);
        }
    }
    tug_destroy_mesh(mesh);
}

static void normals_do_not_depend_on_the_unit(void)
{
    fixture f;
    make_tube(&f, 0);
    tug_mesh *mesh = make_mesh(&f);
    static double scaled[MAX_COORDINATES], before[MAX_COORDINATES], after[MAX_COORDINATES];
    CHECK(tug_find_normals(mesh, f.shape, before) == TUG_OK);
    const double factors[] = {1e-140, 1e140};
    for (int i = 0; i < 2; i++) {
        for (int32_t c = 0; c < coordinate_count(&f); c++) {
            scaled[c] = factors[i] * f.shape[c];
        }
        CHECK(tug_find_normals(mesh, scaled, after) == TUG_OK);
        for (int32_t c = 0; c < coordinate_count(&f); c++) {
            CHECK_NEAR(after[c], before[c], 1e-14);
        }
    }
    tug_destroy_mesh(mesh);
}

/* A pose may fold triangles to lines and points; what is left decides. */
static void triangles_without_area_have_no_say(void)
{
    const double flat[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const int32_t triangles[] = {0, 1, 2, 0, 2, 3};
    tug_mesh *mesh;
    double normals[12];
    CHECK(tug_create_mesh(flat, 4, 3, triangles, 2, &mesh) == TUG_OK);
    double pose[12];
    memcpy(pose, flat, sizeof pose);
    pose[9] = pose[10] = 0.5; /* vertex 3 on the diagonal */
    CHECK(tug_find_normals(mesh, pose, normals) == TUG_OK);
    for (int c = 0; c < 12; c++) {
        CHECK_NEAR(normals[c], c % 3 == 2 && c < 9 ? 1.0 : 0.0, 1e-15);
    }
    memcpy(pose, flat, sizeof pose);
    memcpy(pose + 9, pose + 3, 3 * sizeof *pose); /* folded over: two sides that cancel */
    CHECK(tug_find_normals(mesh, pose, normals) == TUG_OK);
    for (int c = 0; c < 3; c++) {
        CHECK(normals[c] == 0.0 && normals[6 + c] == 0.0);
    }
    memset(pose, 0, sizeof pose);
    CHECK(tug_find_normals(mesh, pose, normals) == TUG_OK);
    for (int c = 0; c < 12; c++) {
        CHECK(normals[c] == 0.0);
    }
    tug_destroy_mesh(mesh);
}

static void areas_sum_to_that_of_the_mesh(void)
{
    fixture f;
    for (int i = 0; i < 3; i++) {
        i == 0 ? make_strip(&f) : make_tube(&f, i == 1);
        tug_mesh *mesh = make_mesh(&f);
        double areas[MAX_VERTICES], sum = 0.0, whole = 0.0;
        CHECK(tug_find_areas(mesh, areas) == TUG_OK);
        for (int32_t v = 0; v < f.vertices; v++) {
            CHECK(areas[v] > 0.0);
            sum += areas[v];
        }
        for (int32_t t = 0; t < f.triangles; t++) {
            whole += mesh->area[t];
        }
        CHECK_NEAR(sum, whole, 1e-13 * whole);
        tug_destroy_mesh(mesh);
    }
}

/* The fan of a square from its middle has right angles; a hexagon none larger; a flat triangle an
 * obtuse one. */
static void areas_are_those_of_voronoi_cells(void)
{
    double vertices[14], areas[7];
    int32_t triangles[18];
    for (int sides = 4; sides <= 6; sides += 2) {
        vertices[0] = vertices[1] = 0.0;
        for (int i = 0; i < sides; i++) {
            double angle = 2.0 * acos(-1.0) * i / sides;
            vertices[2 * i + 2] = cos(angle);
            vertices[2 * i + 3] = sin(angle);
            const int32_t triangle[] = {0, 1 + i, 1 + (i + 1) % sides};
            memcpy(triangles + 3 * i, triangle, sizeof triangle);
        }
        tug_mesh *mesh;
        CHECK(tug_create_mesh(vertices, sides + 1, 2, triangles, sides, &mesh) == TUG_OK);
        CHECK(tug_find_areas(mesh, areas) == TUG_OK);
        /* The cell is a square of side 1; a hexagon of inner radius 1/2. */
        CHECK_NEAR(areas[0], sides == 4 ? 1.0 : sqrt(3.0) / 2.0, 1e-15);
        tug_destroy_mesh(mesh);
    }
    const double flat[] = {-2, 0, 2, 0, 0, 1};
    const int32_t corners[] = {0, 1, 2};
    tug_mesh *mesh;
    CHECK(tug_create_mesh(flat, 3, 2, corners, 1, &mesh) == TUG_OK);
    CHECK(tug_find_areas(mesh, areas) == TUG_OK);
    CHECK_NEAR(areas[0], 0.5, 1e-15);
    CHECK_NEAR(areas[1], 0.5, 1e-15);
    CHECK_NEAR(areas[2], 1.0, 1e-15);
    tug_destroy_mesh(mesh);
}

static void cotangents_are_those_of_the_angles(void)
{
    fixture f;
    for (int i = 0; i < 2; i++) {
        i == 0 ? make_strip(&f) : make_tube(&f, 0);
        tug_mesh *mesh = make_mesh(&f);
        double half[3 * MAX_TRIANGLES];
        CHECK(tug_get_cotangents(mesh, half) == TUG_OK);
        for (int32_t c = 0; c < 3 * f.triangles; c++) {
            CHECK_NEAR(half[c], edge_weight(&f, c), 1e-13);
        }
        tug_destroy_mesh(mesh);
    }
}

static void unsound_meshes_have_no_areas(void)
{
    const double vertices[] = {0, 0, 1, 0, 2, 0};
    const int32_t triangles[] = {0, 1, 2};
    tug_mesh *mesh;
    double out[3] = {-7.0, -7.0, -7.0};
    CHECK(tug_create_mesh(vertices, 3, 2, triangles, 1, &mesh) == TUG_OK);
    CHECK(tug_find_areas(mesh, out) == TUG_ERROR_MESH);
    CHECK(tug_get_cotangents(mesh, out) == TUG_ERROR_MESH);
    CHECK(out[0] == -7.0 && out[2] == -7.0);
    tug_destroy_mesh(mesh);
}

int main(int argc, char **argv)
{
    RUN(normals_of_a_cube_are_its_diagonals);
    RUN(normals_are_units_and_turn_with_the_pose);
    RUN(normals_do_not_depend_on_the_unit);
    RUN(triangles_without_area_have_no_say);
    RUN(areas_sum_to_that_of_the_mesh);
    RUN(areas_are_those_of_voronoi_cells);
    RUN(cotangents_are_those_of_the_angles);
    RUN(unsound_meshes_have_no_areas);
    return TEST_RESULT;
}
