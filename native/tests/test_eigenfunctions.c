/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Eigenfunctions of the Laplace-Beltrami operator: against closed forms, and against L and M added
 * up here from the triangles. */
#include "bench.h"
#include "mesh/mesh.h"
#include "test.h"

#include <stdlib.h>

enum { most_functions = 60, octahedra = 12 };

typedef struct result {
    int32_t vertices, count;
    double values[most_functions];
    double functions[most_functions * MAX_VERTICES]; /* #V by count */
    tug_eigenfunctions_info info;
} result;

static result result_one, result_other; /* too large for a stack */

static tug_status compute(const tug_mesh *mesh, int32_t count, result *r)
{
    r->vertices = mesh->vertex_count;
    r->count = count;
    r->info.struct_size = sizeof r->info;
    return tug_compute_eigenfunctions(mesh, count, NULL, NULL, r->values, r->functions, &r->info);
}

static double value_at(const result *r, int32_t function, int32_t vertex)
{
    return r->functions[vertex * r->count + function];
}

/* Masses in parts of the whole area. */
static void find_mass(const tug_mesh *mesh, double *mass)
{
    double area = 0.0;
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        area += mesh->area[t];
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        mass[v] = mesh->mass[v] / area;
    }
}

/* |L f - mu M f| in the norm of M^-1. */
static double residual_of(const tug_mesh *mesh, const double *mass, const result *r, int32_t i)
{
    double rest[MAX_VERTICES], squares = 0.0;
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        rest[v] = -r->values[i] * mass[v] * value_at(r, i, v);
    }
    for (int32_t e = 0; e < 3 * mesh->triangle_count; e++) {
        int32_t a = mesh->triangles[e / 3 * 3 + (e + 1) % 3];
        int32_t b = mesh->triangles[e / 3 * 3 + (e + 2) % 3];
        double flow = mesh->half_cotangent[e] * (value_at(r, i, a) - value_at(r, i, b));
        rest[a] += flow;
        rest[b] -= flow;
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        squares += rest[v] * rest[v] / mass[v];
    }
    return sqrt(squares);
}

/* 0 where they are. */
static double distance_from_orthonormal(const double *mass, const result *r)
{
    double largest = 0.0;
    for (int32_t i = 0; i < r->count; i++) {
        for (int32_t j = 0; j <= i; j++) {
            double product = i == j ? -1.0 : 0.0;
            for (int32_t v = 0; v < r->vertices; v++) {
                product += mass[v] * value_at(r, i, v) * value_at(r, j, v);
            }
            largest = fmax(largest, fabs(product));
        }
    }
    return largest;
}

/* Regular octahedra of growing or equal size, side by side. */
static tug_mesh *make_octahedra(int32_t count, double growth)
{
    static const int32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                    2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    double vertices[18 * octahedra] = {0};
    int32_t triangles[24 * octahedra];
    for (int32_t c = 0; c < count; c++) {
        double radius = pow(growth, c);
        for (int32_t i = 0; i < 6; i++) {
            double *vertex = vertices + 18 * c + 3 * i;
            vertex[i / 2] = i % 2 ? -radius : radius;
            vertex[0] += 10.0 * radius * c;
        }
        for (int32_t i = 0; i < 24; i++) {
            triangles[24 * c + i] = 6 * c + faces[i];
        }
    }
    tug_mesh *mesh;
    return tug_create_mesh(vertices, 6 * count, 3, triangles, 8 * count, &mesh) == TUG_OK ? mesh
                                                                                          : NULL;
}

/* Its edges all have weight cot 60 degrees = 1 / sqrt(3), and as a graph its Laplacian has the
 * eigenvalues 0, 4 three times and 6 twice. */
static void an_octahedron_has_the_values_of_its_graph(void)
{
    static const double graph[] = {0, 4, 4, 4, 6, 6};
    tug_mesh *mesh = make_octahedra(1, 1.0);
    CHECK(mesh != NULL && compute(mesh, 6, &result_one) == TUG_OK);
    for (int i = 0; i < 6; i++) {
        CHECK_NEAR(result_one.values[i], graph[i] * 6.0 / sqrt(3.0), 1e-11);
    }
    tug_destroy_mesh(mesh);
}

/* Twelve of them have the first eigenvalue 36 times: more often than a block of the search has
 * vectors. */
static void every_copy_of_an_eigenvalue_is_found(void)
{
    double mass[6 * octahedra];
    tug_mesh *mesh = make_octahedra(octahedra, 1.0);
    int32_t firsts = 4 * octahedra;
    CHECK(mesh != NULL && compute(mesh, firsts + 3, &result_one) == TUG_OK);
    CHECK(result_one.info.constants == octahedra);
    for (int32_t i = 0; i < firsts + 3; i++) {
        double graph = i < octahedra ? 0.0 : i < firsts ? 4.0 : 6.0;
        CHECK_NEAR(result_one.values[i], graph * 6.0 * octahedra / sqrt(3.0), 1e-9);
    }
    find_mass(mesh, mass);
    CHECK(distance_from_orthonormal(mass, &result_one) < 1e-12);
    tug_destroy_mesh(mesh);
}

static void each_function_solves_the_equation(void)
{
    double mass[MAX_VERTICES];
    for (int form = 0; form < 3; form++) {
        fixture f;
        form == 0 ? make_strip(&f) : make_tube(&f, form == 1);
        tug_mesh *mesh = make_mesh(&f);
        CHECK(compute(mesh, 15, &result_one) == TUG_OK);
        find_mass(mesh, mass);
        CHECK(result_one.values[0] == 0.0 && result_one.info.constants == 1);
        for (int32_t i = 1; i < 15; i++) {
            double mu = result_one.values[i];
            CHECK(mu > 0.0 && mu >= result_one.values[i - 1]);
            CHECK(residual_of(mesh, mass, &result_one, i) < 1e-10 * mu);
        }
        CHECK(result_one.info.residual < 1e-10 && result_one.info.residual > 0.0);
        CHECK(distance_from_orthonormal(mass, &result_one) < 1e-12);
        tug_destroy_mesh(mesh);
    }
}

static void a_function_of_every_vertex_can_be_had(void)
{
    fixture f;
    make_strip(&f);
    double mass[MAX_VERTICES], trace = 0.0, sum = 0.0;
    tug_mesh *mesh = make_mesh(&f);
    double *values = malloc(sizeof(double) * MAX_VERTICES);
    double *functions = malloc(sizeof(double) * MAX_VERTICES * MAX_VERTICES);
    CHECK(values != NULL && functions != NULL);
    CHECK(tug_compute_eigenfunctions(mesh, f.vertices, NULL, NULL, values, functions, NULL) ==
          TUG_OK);
    find_mass(mesh, mass);
    for (int32_t e = 0; e < 3 * f.triangles; e++) {
        trace += mesh->half_cotangent[e] / mass[mesh->triangles[e / 3 * 3 + (e + 1) % 3]];
        trace += mesh->half_cotangent[e] / mass[mesh->triangles[e / 3 * 3 + (e + 2) % 3]];
    }
    for (int32_t i = 0; i < f.vertices; i++) {
        sum += values[i];
    }
    CHECK_NEAR(sum, trace, 1e-9 * trace);
    free(values);
    free(functions);
    tug_destroy_mesh(mesh);
}

/* Constant on each component, the constant 1 first, and the largest component apart first. */
static void every_component_has_a_constant(void)
{
    double mass[6 * octahedra];
    tug_mesh *mesh = make_octahedra(4, 1.5);
    CHECK(mesh != NULL && compute(mesh, 7, &result_one) == TUG_OK);
    find_mass(mesh, mass);
    CHECK(result_one.info.constants == 4);
    for (int32_t v = 0; v < 24; v++) {
        CHECK_NEAR(value_at(&result_one, 0, v), 1.0, 1e-14);
        for (int32_t i = 1; i < 4; i++) {
            CHECK_NEAR(value_at(&result_one, i, v), value_at(&result_one, i, v / 6 * 6), 1e-12);
        }
        CHECK((value_at(&result_one, 1, v) > 0.0) == (v / 6 == 2));
        CHECK((value_at(&result_one, 1, v) == 0.0) == (v / 6 < 2));
    }
    CHECK(distance_from_orthonormal(mass, &result_one) < 1e-12);
    CHECK(compute(mesh, 2, &result_other) == TUG_OK);
    CHECK(result_other.info.constants == 2);
    for (int32_t v = 0; v < 24; v++) {
        CHECK(value_at(&result_other, 0, v) == value_at(&result_one, 0, v));
        CHECK(value_at(&result_other, 1, v) == value_at(&result_one, 1, v));
    }
    tug_destroy_mesh(mesh);
}

static void the_unit_of_length_does_not_matter(void)
{
    fixture f;
    make_tube(&f, 1);
    tug_mesh *mesh = make_mesh(&f);
    CHECK(compute(mesh, 10, &result_one) == TUG_OK);
    tug_destroy_mesh(mesh);
    rescale(&f, 1024.0, 0.0);
    mesh = make_mesh(&f);
    CHECK(compute(mesh, 10, &result_other) == TUG_OK);
    for (int32_t i = 0; i < 10 * f.vertices; i++) {
        CHECK_NEAR(result_other.functions[i], result_one.functions[i], 1e-9);
    }
    for (int32_t i = 0; i < 10; i++) {
        CHECK_NEAR(result_other.values[i], result_one.values[i], 1e-9 * result_one.values[i]);
    }
    tug_destroy_mesh(mesh);
}

static void the_sign_is_that_of_the_first_large_value(void)
{
    fixture f;
    make_tube(&f, 0);
    tug_mesh *mesh = make_mesh(&f);
    CHECK(compute(mesh, 8, &result_one) == TUG_OK);
    for (int32_t i = 0; i < 8; i++) {
        double largest = 0.0;
        int32_t first = 0;
        for (int32_t v = 0; v < f.vertices; v++) {
            largest = fmax(largest, fabs(value_at(&result_one, i, v)));
        }
        while (fabs(value_at(&result_one, i, first)) < 0.5 * largest) {
            first++;
        }
        CHECK(value_at(&result_one, i, first) > 0.0);
    }
    CHECK(compute(mesh, 8, &result_other) == TUG_OK);
    size_t size = 8 * (size_t)f.vertices * sizeof(double);
    CHECK(memcmp(result_one.functions, result_other.functions, size) == 0);
    tug_destroy_mesh(mesh);
}

/* A model takes them as weights, and finds an example again. */
static void a_model_can_be_made_of_them(void)
{
    bench b = {.model = NULL};
    make_tube(&b.f, 1);
    tug_mesh *mesh = make_mesh(&b.f);
    tug_rows rows = {b.f.row_starts, b.f.row_vertices, b.f.row_values, b.f.rows};
    tug_default_solver_options(&b.options);
    CHECK(compute(mesh, 6, &result_one) == TUG_OK);
    CHECK(tug_create_model(mesh, b.f.shape, b.f.shapes, result_one.functions, 6, &rows, b.f.group,
                           b.f.groups, NULL, 0.0, NULL, NULL, &b.model) == TUG_OK);
    CHECK(finds_examples(&b, 1e-4));
    clear(&b);
    tug_destroy_mesh(mesh);
}

int main(int argc, char **argv)
{
    RUN(an_octahedron_has_the_values_of_its_graph);
    RUN(every_copy_of_an_eigenvalue_is_found);
    RUN(each_function_solves_the_equation);
    RUN(a_function_of_every_vertex_can_be_had);
    RUN(every_component_has_a_constant);
    RUN(the_unit_of_length_does_not_matter);
    RUN(the_sign_is_that_of_the_first_large_value);
    RUN(a_model_can_be_made_of_them);
    return TEST_RESULT;
}
