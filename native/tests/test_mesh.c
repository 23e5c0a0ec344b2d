/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measures of meshes against closed forms, and every kind of bad mesh with its words. */
#include "memory.h"
#include "mesh/mesh.h"
#include "test.h"

#define COUNT(array) ((int32_t)(sizeof(array) / sizeof *(array)))

/* Meshes are written as flat arrays: `dimension` numbers a vertex, three indices a triangle. */
#define MAKE(vertices, dimension, triangles, out)                                                  \
    mesh_create(vertices, COUNT(vertices) / (dimension), dimension, triangles,                     \
                COUNT(triangles) / 3, out)

/* A unit square of two triangles in 2D. */
static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1};
static const int32_t square_triangles[] = {0, 1, 2, 0, 2, 3};

/* A tetrahedron, all faces outwards: closed, so nothing is wrong with it. */
static const double tetrahedron[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const int32_t tetrahedron_triangles[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

typedef struct verdict {
    int32_t errors, warnings;
    char text[2048];
} verdict;

/* The verdict on a mesh of 3D vertices; errors is -1 where there is none. */
static verdict judge(const double *vertices, int32_t vertex_count, const int32_t *triangles,
                     int32_t triangle_count)
{
    verdict v = {.errors = -1};
    tug_mesh *mesh;
    if (mesh_create(vertices, vertex_count, 3, triangles, triangle_count, &mesh) == TUG_OK) {
        mesh_describe(mesh, v.text, sizeof v.text, &v.errors, &v.warnings);
        mesh_destroy(mesh);
    }
    return v;
}

#define JUDGE(vertices, triangles)                                                                 \
    judge(vertices, COUNT(vertices) / 3, triangles, COUNT(triangles) / 3)

static void right_triangles_have_their_areas_and_cotangents(void)
{
    tug_mesh *mesh;
    CHECK(MAKE(square, 2, square_triangles, &mesh) == TUG_OK);
    CHECK_NEAR(mesh->area[0], 0.5, 1e-15);
    CHECK_NEAR(mesh->area[1], 0.5, 1e-15);
    CHECK_NEAR(mesh->half_cotangent[0], 0.5, 1e-15); /* 45 degrees at corner 0 of triangle 0 */
    CHECK_NEAR(mesh->half_cotangent[1], 0.0, 1e-15); /* 90 */
    CHECK_NEAR(mesh->half_cotangent[2], 0.5, 1e-15); /* 45 */
    CHECK_NEAR(mesh->mass[0], 0.25, 1e-15); /* an eighth of a square each, at a right angle two */
    CHECK_NEAR(mesh->mass[1], 0.25, 1e-15);
    CHECK_NEAR(mesh->diagonal, sqrt(2.0), 1e-15);
    mesh_destroy(mesh);
}

static void triangle_in_space_has_the_cotangents_of_its_angles(void)
{
    /* Sides 3, 4, 5 in a slanted plane: cotangents 0 at the right angle, 3/4 and 4/3. */
    const double r = sqrt(0.5);
    const double vertices[] = {1, 2, 3, 1 + 3 * r, 2 + 3 * r, 3, 1, 2, 7};
    const int32_t triangles[] = {0, 1, 2};
    tug_mesh *mesh;
    CHECK(MAKE(vertices, 3, triangles, &mesh) == TUG_OK);
    CHECK_NEAR(mesh->area[0], 6.0, 1e-13);
    CHECK_NEAR(mesh->half_cotangent[0], 0.0, 1e-14);
    CHECK_NEAR(mesh->half_cotangent[1], 3.0 / 8.0, 1e-14);
    CHECK_NEAR(mesh->half_cotangent[2], 4.0 / 6.0, 1e-14);
    mesh_destroy(mesh);
}

static void clockwise_triangles_in_the_plane_measure_the_same(void)
{
    const int32_t clockwise[] = {2, 1, 0, 3, 2, 0};
    tug_mesh *mesh;
    CHECK(MAKE(square, 2, clockwise, &mesh) == TUG_OK);
    CHECK_NEAR(mesh->area[0], 0.5, 1e-15);
    CHECK_NEAR(mesh->half_cotangent[0], 0.5, 1e-15);
    CHECK_NEAR(mesh->half_cotangent[2], 0.5, 1e-15);
    CHECK(require_sound_mesh(mesh) == TUG_OK);
    mesh_destroy(mesh);
}

static void components_are_numbered_by_their_first_vertex(void)
{
    const double vertices[] = {0, 0, 5, 5, 1, 0, 6, 5, 0, 1, 5, 6, 9, 9};
    const int32_t triangles[] = {1, 3, 5, 0, 2, 4};
    const int32_t expected[] = {0, 1, 0, 1, 0, 1, 2};
    tug_mesh *mesh;
    CHECK(MAKE(vertices, 2, triangles, &mesh) == TUG_OK);
    CHECK(mesh->component_count == 3);
    CHECK(memcmp(mesh->component, expected, sizeof expected) == 0);
    mesh_destroy(mesh);
}

static void sound_meshes_have_no_words(void)
{
    verdict closed = JUDGE(tetrahedron, tetrahedron_triangles);
    CHECK(closed.errors == 0 && closed.warnings == 0 && closed.text[0] == '\0');
    tug_mesh *open;
    int32_t errors, warnings;
    char text[8] = "before";
    CHECK(MAKE(square, 2, square_triangles, &open) == TUG_OK);
    CHECK(mesh_describe(open, text, sizeof text, &errors, &warnings) == TUG_OK);
    CHECK(errors == 0 && warnings == 0 && text[0] == '\0');
    CHECK(require_sound_mesh(open) == TUG_OK);
    mesh_destroy(open);
}

static void coordinates_that_are_not_finite_are_an_error(void)
{
    double vertices[COUNT(tetrahedron)];
    memcpy(vertices, tetrahedron, sizeof vertices);
    vertices[3 * 2 + 1] = NAN;
    vertices[3 * 3 + 2] = INFINITY;
    verdict v = JUDGE(vertices, tetrahedron_triangles);
    CHECK(v.errors == 1 && v.warnings == 0);
    CHECK(strstr(v.text, "not finite: 2, for example vertex 2.") != NULL);
}

static void triangles_of_no_area_are_an_error(void)
{
    /* A sliver on one line, two vertices in one place, and one that names a vertex twice. */
    const double vertices[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0};
    const int32_t triangles[] = {0, 1, 3, 1, 2, 3, 0, 1, 2, 0, 4, 3, 1, 2, 1};
    verdict v = JUDGE(vertices, triangles);
    CHECK(v.errors == 1);
    CHECK(strstr(v.text, "no area: 3, for example of vertices 0, 1 and 2.") != NULL);
    CHECK(strstr(v.text, "By Distance") != NULL);
}

static void smallness_is_judged_by_the_longest_edge(void)
{
    const int32_t triangles[] = {0, 1, 2};
    const double tiny[] = {0, 0, 0, 1e-9, 0, 0, 0, 1e-9, 0};
    const double thin[] = {0, 0, 0, 1e3, 0, 0, 1e3, 3e-9, 0};
    const double flat[] = {0, 0, 0, 1e3, 0, 0, 1e3, 1e-9, 0};
    const double far[] = {1e6, 1e6, 0, 1e6 + 1, 1e6, 0, 1e6, 1e6 + 1, 0};
    CHECK(JUDGE(tiny, triangles).errors == 0);
    CHECK(JUDGE(thin, triangles).errors == 0);
    CHECK(JUDGE(flat, triangles).errors == 1);
    CHECK(JUDGE(far, triangles).errors == 0);
}

static void vertices_in_no_triangle_are_an_error(void)
{
    const double vertices[] = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 8, 8, 8};
    const int32_t triangles[] = {1, 2, 3};
    verdict v = JUDGE(vertices, triangles);
    CHECK(v.errors == 1 && v.warnings == 0);
    CHECK(strstr(v.text, "no face: 2, for example vertex 0.") != NULL);
    CHECK(strstr(v.text, "Delete Loose") != NULL);
}

static void edges_of_three_triangles_are_a_warning(void)
{
    const double vertices[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, -1, 1, 0, -1, -1, 0};
    const int32_t triangles[] = {0, 1, 2, 0, 1, 3, 0, 1, 4};
    verdict v = JUDGE(vertices, triangles);
    CHECK(v.errors == 0 && v.warnings == 1);
    CHECK(strstr(v.text, "two triangles: 1, for example at the edge of vertices 0 and 1.") != NULL);
}

static void neighbours_that_face_opposite_ways_are_a_warning(void)
{
    const int32_t turned[] = {0, 1, 2, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    verdict v = JUDGE(tetrahedron, turned);
    CHECK(v.errors == 0 && v.warnings == 1);
    CHECK(strstr(v.text, "opposite ways: 3, for example at the edge of vertices 0 and 1.") != NULL);
    CHECK(strstr(v.text, "Recalculate Outside") != NULL);
}

static void pinched_vertices_are_a_warning(void)
{
    const double vertices[] = {1, 0, 0, 1, 1, 0, 0, 0, 0, -1, 0, 0, -1, -1, 0};
    const int32_t triangles[] = {0, 1, 2, 2, 3, 4};
    verdict v = JUDGE(vertices, triangles);
    CHECK(v.errors == 0 && v.warnings == 1);
    CHECK(strstr(v.text, "point only: 1, for example vertex 2.") != NULL);
}

static void triangles_that_are_there_twice_are_one_warning(void)
{
    /* The copies share their edges with the others, but are no warning of another kind. */
    int32_t triangles[COUNT(tetrahedron_triangles) + 6];
    memcpy(triangles, tetrahedron_triangles, sizeof tetrahedron_triangles);
    memcpy(triangles + 12, (int32_t[]){3, 1, 2, 2, 1, 0}, 6 * sizeof *triangles);
    verdict v = JUDGE(tetrahedron, triangles);
    CHECK(v.errors == 0 && v.warnings == 1);
    CHECK(strstr(v.text, "there twice: 2,") != NULL);
}

static void errors_stand_before_warnings(void)
{
    const double vertices[] = {1, 0, 0, 1, 1, 0, 0, 0, 0, -1, 0, 0, -1, -1, 0, NAN, 0, 0};
    const int32_t triangles[] = {0, 1, 2, 2, 3, 4, 0, 1, 2, 0, 0, 1};
    verdict v = JUDGE(vertices, triangles);
    CHECK(v.errors == 3 && v.warnings == 2);
    int lines = 1;
    for (const char *c = v.text; *c != '\0'; c++) {
        lines += *c == '\n';
    }
    CHECK(lines == 5);
    const char *last_error = strstr(v.text, "no face");
    CHECK(last_error != NULL && strstr(last_error, "point only") != NULL);
}

static void text_that_does_not_fit_is_cut(void)
{
    const double vertices[] = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, NAN, 8, 8};
    const int32_t triangles[] = {1, 2, 3};
    tug_mesh *mesh;
    CHECK(MAKE(vertices, 3, triangles, &mesh) == TUG_OK);
    char whole[1024];
    int32_t errors, warnings;
    CHECK(mesh_describe(mesh, whole, sizeof whole, &errors, &warnings) == TUG_OK);
    for (size_t capacity = 0; capacity <= strlen(whole) + 1; capacity++) {
        char text[1024];
        memset(text, '#', sizeof text);
        CHECK(mesh_describe(mesh, text, capacity, &errors, &warnings) == TUG_OK);
        CHECK(errors == 2 && warnings == 0);
        CHECK(text[capacity] == '#');
        CHECK(capacity == 0 || strlen(text) == capacity - 1);
        CHECK(capacity == 0 || strncmp(text, whole, capacity - 1) == 0);
    }
    mesh_destroy(mesh);
}

static void unsound_mesh_is_refused_with_the_first_error(void)
{
    const double vertices[] = {9, 9, 0, 0, 1, 0, 0, NAN};
    const int32_t triangles[] = {1, 2, 3};
    tug_mesh *mesh;
    CHECK(MAKE(vertices, 2, triangles, &mesh) == TUG_OK);
    CHECK(require_sound_mesh(mesh) == TUG_ERROR_MESH);
    CHECK(strstr(tug_error_text(), "not finite: 1, for example vertex 3.") != NULL);
    CHECK(strchr(tug_error_text(), '\n') == NULL);
    mesh_destroy(mesh);
}

static void warnings_do_not_refuse_a_mesh(void)
{
    const double vertices[] = {1, 0, 1, 1, 0, 0, -1, 0, -1, -1};
    const int32_t triangles[] = {0, 1, 2, 2, 3, 4};
    tug_mesh *mesh;
    CHECK(MAKE(vertices, 2, triangles, &mesh) == TUG_OK);
    CHECK(require_sound_mesh(mesh) == TUG_OK);
    mesh_destroy(mesh);
}

static void input_that_cannot_be_is_refused(void)
{
    const int32_t low[] = {0, 1, -1}, high[] = {0, 1, 2, 1, 2, 4};
    tug_mesh *mesh = (tug_mesh *)&mesh;
    CHECK(mesh_create(square, 4, 2, low, 1, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh == NULL);
    CHECK(mesh_create(square, 4, 2, high, 2, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(strstr(tug_error_text(), "triangle 1 names vertex 4 of 4") != NULL);
    CHECK(mesh_create(square, 4, 1, square_triangles, 2, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh_create(square, 2, 4, square_triangles, 2, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh_create(square, 0, 2, square_triangles, 2, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh_create(square, 4, 2, square_triangles, 0, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh_create(square, 4, 2, square_triangles, -1, &mesh) == TUG_ERROR_ARGUMENT);
    CHECK(mesh_create(square, 4, 2, square_triangles, INT32_MAX, &mesh) == TUG_ERROR_ARGUMENT);
    mesh_destroy(NULL);
}

/* Make a mesh and ask all about it; the first status that is not TUG_OK. */
static tug_status use_mesh(void)
{
    tug_mesh *mesh;
    tug_status status = MAKE(square, 2, square_triangles, &mesh);
    if (status == TUG_OK) {
        char text[64] = "before";
        int32_t errors = -1, warnings = -1;
        status = mesh_describe(mesh, text, sizeof text, &errors, &warnings);
        if (status != TUG_OK && (strcmp(text, "before") != 0 || errors != -1 || warnings != -1)) {
            status = TUG_ERROR_NUMERIC; /* changed its outputs although it failed */
        }
    }
    if (status == TUG_OK) {
        status = require_sound_mesh(mesh);
    }
    mesh_destroy(mesh);
    return status;
}

static void every_failing_allocation_is_reported_and_leaks_nothing(void)
{
    long live = live_allocations(), before = total_allocations();
    CHECK(use_mesh() == TUG_OK);
    long needed = total_allocations() - before;
    for (long successes = 0; successes < needed; successes++) {
        fail_allocations_after(successes);
        tug_status status = use_mesh();
        fail_allocations_after(-1);
        CHECK(status == TUG_ERROR_MEMORY);
        CHECK(live_allocations() == live);
    }
}

int main(int argc, char **argv)
{
    RUN(right_triangles_have_their_areas_and_cotangents);
    RUN(triangle_in_space_has_the_cotangents_of_its_angles);
    RUN(clockwise_triangles_in_the_plane_measure_the_same);
    RUN(components_are_numbered_by_their_first_vertex);
    RUN(sound_meshes_have_no_words);
    RUN(coordinates_that_are_not_finite_are_an_error);
    RUN(triangles_of_no_area_are_an_error);
    RUN(smallness_is_judged_by_the_longest_edge);
    RUN(vertices_in_no_triangle_are_an_error);
    RUN(edges_of_three_triangles_are_a_warning);
    RUN(neighbours_that_face_opposite_ways_are_a_warning);
    RUN(pinched_vertices_are_a_warning);
    RUN(triangles_that_are_there_twice_are_one_warning);
    RUN(errors_stand_before_warnings);
    RUN(text_that_does_not_fit_is_cut);
    RUN(unsound_mesh_is_refused_with_the_first_error);
    RUN(warnings_do_not_refuse_a_mesh);
    RUN(input_that_cannot_be_is_refused);
    RUN(every_failing_allocation_is_reported_and_leaks_nothing);
    return TEST_RESULT;
}
