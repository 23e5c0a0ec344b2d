/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every public call with every argument that cannot be: a status, words that name the call, and
 * nothing changed. */
#include "fixture.h"
#include "memory.h"
#include "test.h"

/* Whether a call was refused with this status in words that start with its name. The error text is
 * the last failure's, so another call has to fail in between: see REFUSED. */
static int refused(tug_status status, tug_status expected, const char *call)
{
    const char *text = tug_error_text();
    size_t length = strlen(call);
    if (status == expected && strncmp(text, call, length) == 0 && text[length] == ':' &&
        strlen(text) > length + 3 && strchr(text, '\n') == NULL) {
        return 1;
    }
    printf("%s: status %d, \"%s\"\n", call, (int)status, text);
    return 0;
}

#define REFUSED_WITH(expected, call, ...)                                                          \
    (spoil_error_text(), refused(call(__VA_ARGS__), expected, #call))
#define REFUSED(call, ...) REFUSED_WITH(TUG_ERROR_ARGUMENT, call, __VA_ARGS__)

static void spoil_error_text(void)
{
    if (strncmp(tug_error_text(), "tug_find", 8) != 0) {
        tug_find_components(NULL, NULL, NULL);
    } else {
        tug_check_mesh(NULL, NULL, 0, NULL, NULL);
    }
}

/* Any address that is not NULL: what a failed call has to replace. */
static char rubbish;
#define RUBBISH ((void *)&rubbish)

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
    CHECK(REFUSED(tug_find_distances, NULL, sources, 1, out));
    CHECK(REFUSED(tug_find_distances, mesh, NULL, 1, out));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 1, NULL));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 0, out));
    CHECK(REFUSED(tug_find_distances, mesh, sources, 2, out));
    sources[0] = -1;
    CHECK(REFUSED(tug_find_distances, mesh, sources, 1, out));
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

static void tug_solve_elastic_net_refuses(void)
{
    double X[] = {1, 2, 3, 4, 5, 7}, Y[] = {1, 2}, L[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double T[] = {-7.0, -7.0, -7.0};
    tug_elastic_net_info info = {.struct_size = sizeof info, .rounds = -7};
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, NULL, Y, L, 1.0, 1.0, 1.0, T, &info));
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, NULL, L, 1.0, 1.0, 1.0, T, &info));
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, 1.0, 1.0, NULL, &info));
    const int32_t counts[][3] = {{0, 3, 1}, {2, 0, 1}, {2, 3, 0}, {-2, -3, 1}, {2, -3, -1}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        CHECK(REFUSED(tug_solve_elastic_net, counts[i][0], counts[i][1], counts[i][2], X, Y, L, 1.0,
                      1.0, 1.0, T, &info));
    }
    const double bad[] = {-1.0, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, bad[i], 1.0, 1.0, T, &info));
        CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, bad[i], 1.0, T, &info));
        CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, 1.0, bad[i], T, &info));
    }
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 0.0, 1.0, 1.0, T, &info));
    double *values[] = {X + 5, Y + 1, L + 8};
    for (int i = 0; i < 3; i++) {
        double before = *values[i];
        *values[i] = NAN;
        CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, 1.0, 1.0, T, &info));
        *values[i] = before;
    }
    L[4] = -1.0;
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, 1.0, 1.0, T, &info));
    L[4] = 1.0;
    info.struct_size--;
    CHECK(REFUSED(tug_solve_elastic_net, 2, 3, 1, X, Y, L, 1.0, 1.0, 1.0, T, &info));
    CHECK(T[0] == -7.0 && T[2] == -7.0 && info.rounds == -7);
    CHECK(tug_solve_elastic_net(2, 3, 1, X, Y, L, 1.0, 1.0, 1.0, T, NULL) == TUG_OK);
}

typedef struct weights_question {
    tug_mesh *mesh;
    int32_t starts[3], vertices[2], handles;
    tug_weights_options options;
    tug_weights_info info;
    double weights[2 * MAX_VERTICES];
} weights_question;

static tug_status tug_compute_weights_of(weights_question *q)
{
    return tug_compute_weights(q->mesh, q->starts, q->vertices, q->handles, &q->options, NULL, NULL,
                               q->weights, &q->info);
}

/* One member of a sound question is spoiled; the call is refused and the weights are as before. */
static int spoiled_weights_are_refused(int i)
{
    fixture f;
    make_strip(&f);
    weights_question q = {.starts = {0, 1, 2}, .vertices = {0, f.vertices - 1}, .handles = 2};
    q.mesh = make_mesh(&f);
    tug_default_weights_options(&q.options);
    q.info.struct_size = sizeof q.info;
    q.weights[0] = -7.0;
    switch (i) {
    case 0:
        q.starts[0] = 1;
        break;
    case 1:
        q.starts[1] = 0;
        break;
    case 2:
        q.starts[2] = 1;
        break;
    case 3:
        q.vertices[1] = f.vertices;
        break;
    case 4:
        q.vertices[0] = -1;
        break;
    case 5:
        q.handles = 0;
        break;
    case 6:
        q.handles = -1;
        break;
    case 7:
        q.options.struct_size--;
        break;
    case 8:
        q.options.tolerance = 0.0;
        break;
    case 9:
        q.options.tolerance = NAN;
        break;
    case 10:
        q.options.max_iterations = 0;
        break;
    case 11:
        q.options.threads = -1;
        break;
    case 12:
        q.info.struct_size = 0;
        break;
    default:
        q.options.struct_size = 0;
    }
    int good = 0;
    spoil_error_text();
    good = refused(tug_compute_weights_of(&q), TUG_ERROR_ARGUMENT, "tug_compute_weights") &&
           q.weights[0] == -7.0;
    tug_destroy_mesh(q.mesh);
    return good;
}

static void tug_compute_weights_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    const int32_t starts[] = {0, 1}, vertices[] = {0};
    tug_weights_options options;
    double weights[MAX_VERTICES];
    tug_default_weights_options(&options);
    CHECK(REFUSED(tug_compute_weights, NULL, starts, vertices, 1, &options, NULL, NULL, weights,
                  NULL));
    CHECK(
        REFUSED(tug_compute_weights, mesh, NULL, vertices, 1, &options, NULL, NULL, weights, NULL));
    CHECK(REFUSED(tug_compute_weights, mesh, starts, NULL, 1, &options, NULL, NULL, weights, NULL));
    CHECK(REFUSED(tug_compute_weights, mesh, starts, vertices, 1, NULL, NULL, NULL, weights, NULL));
    CHECK(
        REFUSED(tug_compute_weights, mesh, starts, vertices, 1, &options, NULL, NULL, NULL, NULL));
    for (int i = 0; i <= 13; i++) {
        CHECK(spoiled_weights_are_refused(i));
    }
    tug_destroy_mesh(mesh);
}

static void handles_that_cannot_be_are_named(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    const int32_t starts[] = {0, 1, 2}, vertices[] = {3, 3};
    tug_weights_options options;
    double weights[2 * MAX_VERTICES] = {-7.0};
    tug_default_weights_options(&options);
    CHECK(REFUSED_WITH(TUG_ERROR_HANDLES, tug_compute_weights, mesh, starts, vertices, 2, &options,
                       NULL, NULL, weights, NULL));
    CHECK(weights[0] == -7.0);
    tug_destroy_mesh(mesh);
}

static void tug_compute_eigenfunctions_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    double values[3] = {-7.0}, functions[3 * MAX_VERTICES] = {-7.0};
    tug_eigenfunctions_info info = {.struct_size = sizeof info - 1, .solves = -7};
    const int32_t counts[] = {0, -1, f.vertices + 1, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        CHECK(REFUSED(tug_compute_eigenfunctions, mesh, counts[i], NULL, NULL, values, functions,
                      NULL));
    }
    CHECK(REFUSED(tug_compute_eigenfunctions, NULL, 3, NULL, NULL, values, functions, NULL));
    CHECK(REFUSED(tug_compute_eigenfunctions, mesh, 3, NULL, NULL, NULL, functions, NULL));
    CHECK(REFUSED(tug_compute_eigenfunctions, mesh, 3, NULL, NULL, values, NULL, NULL));
    CHECK(REFUSED(tug_compute_eigenfunctions, mesh, 3, NULL, NULL, values, functions, &info));
    CHECK(values[0] == -7.0 && functions[0] == -7.0 && info.solves == -7);
    tug_destroy_mesh(mesh);
}

static void spoil_skeleton_options(tug_skeleton_options *options, int i)
{
    switch (i) {
    case 0:
        options->struct_size--;
        break;
    case 1:
        options->smoothness = -1e-9;
        break;
    case 2:
        options->smoothness = NAN;
        break;
    case 3:
        options->tolerance = -1.0;
        break;
    default:
        options->max_rounds = 0;
    }
}

static void tug_find_skeleton_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    double w[4 * MAX_VERTICES] = {-7.0}, *p = f.shape;
    int32_t bones = -7, n = f.shapes;
    tug_skeleton_options options;
    tug_skeleton_info info = {.struct_size = sizeof info + 1, .rounds = -7};
    for (int i = 0; i < 5; i++) {
        tug_default_skeleton_options(&options);
        spoil_skeleton_options(&options, i);
        CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, &options, NULL, NULL, w, &bones, NULL));
    }
    tug_default_skeleton_options(&options);
    CHECK(REFUSED(tug_find_skeleton, NULL, p, n, 4, &options, NULL, NULL, w, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, NULL, n, 4, &options, NULL, NULL, w, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, 0, 4, &options, NULL, NULL, w, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 0, &options, NULL, NULL, w, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, NULL, NULL, NULL, w, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, &options, NULL, NULL, NULL, &bones, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, &options, NULL, NULL, w, NULL, NULL));
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, &options, NULL, NULL, w, &bones, &info));
    p[coordinate_count(&f) + 5] = INFINITY;
    CHECK(REFUSED(tug_find_skeleton, mesh, p, n, 4, &options, NULL, NULL, w, &bones, NULL));
    CHECK(strstr(tug_error_text(), "vertex 2 of shape 1") != NULL);
    CHECK(w[0] == -7.0 && bones == -7 && info.rounds == -7);
    tug_destroy_mesh(mesh);
}

static void tug_cluster_triangles_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    int32_t groups[MAX_TRIANGLES] = {-7}, count = -7, m = f.weights;
    double *w = f.weight;
    CHECK(REFUSED(tug_cluster_triangles, NULL, w, m, 3, NULL, NULL, groups, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, NULL, m, 3, NULL, NULL, groups, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, 0, 3, NULL, NULL, groups, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, -1, 3, NULL, NULL, groups, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, m, 0, NULL, NULL, groups, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, m, 3, NULL, NULL, NULL, &count));
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, m, 3, NULL, NULL, groups, NULL));
    w[5] = NAN;
    CHECK(REFUSED(tug_cluster_triangles, mesh, w, m, 3, NULL, NULL, groups, &count));
    CHECK(groups[0] == -7 && count == -7);
    tug_destroy_mesh(mesh);
}

static void spoil_dictionary(tug_dictionary *D, double *number, int i)
{
    switch (i) {
    case 0:
        D->shapes = NULL;
        break;
    case 1:
        D->weights = NULL;
        break;
    case 2:
        D->vertex_count = 0;
        break;
    case 3:
        D->dimension = 4;
        break;
    case 4:
        D->shape_count = -1;
        break;
    case 5:
        D->weight_count = 0;
        break;
    case 6:
        D->shape_count = INT32_MAX;
        break;
    case 7:
        *number = NAN;
        break;
    default: /* all in one place */
        D->vertex_count = 1;
    }
}

static void dictionary_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    double T[MAX_COORDINATES] = {-7.0}, q[MAX_COORDINATES] = {0.0};
    int32_t atoms[] = {0, 7, 14}, chosen[30] = {-7};
    const tug_dictionary sound = dictionary_of(&f);
    for (int i = 0; i < 10; i++) {
        tug_dictionary D = sound;
        double number = f.shape[20], weight = f.weight[20];
        spoil_dictionary(&D, i == 9 ? f.weight + 20 : f.shape + 20, i == 9 ? 7 : i);
        CHECK(REFUSED(tug_reduce_dictionary, &D, 3, NULL, NULL, chosen));
        CHECK(REFUSED(tug_fit_dictionary, &D, NULL, 0, q, NULL, NULL, T, NULL));
        f.shape[20] = number;
        f.weight[20] = weight;
    }
    CHECK(REFUSED(tug_reduce_dictionary, NULL, 3, NULL, NULL, chosen));
    CHECK(REFUSED(tug_reduce_dictionary, &sound, 3, NULL, NULL, NULL));
    CHECK(REFUSED(tug_reduce_dictionary, &sound, 2, NULL, NULL, chosen));
    CHECK(REFUSED(tug_reduce_dictionary, &sound, 22, NULL, NULL, chosen));
    CHECK(REFUSED(tug_fit_dictionary, NULL, NULL, 0, q, NULL, NULL, T, NULL));
    CHECK(REFUSED(tug_fit_dictionary, &sound, NULL, 3, q, NULL, NULL, T, NULL));
    CHECK(REFUSED(tug_fit_dictionary, &sound, atoms, 3, NULL, NULL, NULL, T, NULL));
    CHECK(REFUSED(tug_fit_dictionary, &sound, atoms, 2, q, NULL, NULL, T, NULL));
    atoms[2] = 7;
    CHECK(REFUSED(tug_fit_dictionary, &sound, atoms, 3, q, NULL, NULL, T, NULL));
    atoms[2] = 21;
    CHECK(REFUSED(tug_fit_dictionary, &sound, atoms, 3, q, NULL, NULL, T, NULL));
    q[3] = INFINITY;
    CHECK(REFUSED(tug_fit_dictionary, &sound, NULL, 0, q, NULL, NULL, T, NULL));
    CHECK(T[0] == -7.0 && chosen[0] == -7);
}

/* The fixture's model, its mesh given. */
static tug_status tug_create_model_of(const fixture *f, const tug_mesh *mesh, tug_model **out)
{
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    return tug_create_model(mesh, f->shape, f->shapes, f->weight, f->weights, &rows, f->group,
                            f->groups, f->stiffness, f->smoothness, NULL, NULL, out);
}

static void tug_create_model_refuses_null(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    tug_rows rows = {f.row_starts, f.row_vertices, f.row_values, f.rows}, bare = {0};
    const void *given[] = {mesh, f.shape, f.weight, &rows, f.group};
    for (int i = 0; i < 5; i++) {
        const void *a[5];
        tug_model *model = RUBBISH;
        memcpy(a, given, sizeof a);
        a[i] = NULL;
        CHECK(REFUSED(tug_create_model, a[0], a[1], f.shapes, a[2], f.weights, a[3], a[4], f.groups,
                      f.stiffness, 0.0, NULL, NULL, &model));
        CHECK(model == NULL);
    }
    CHECK(REFUSED(tug_create_model, mesh, f.shape, f.shapes, f.weight, f.weights, &rows, f.group,
                  f.groups, f.stiffness, 0.0, NULL, NULL, NULL));
    for (int i = 0; i < 3; i++) {
        tug_model *model = RUBBISH;
        bare = (tug_rows){i == 0 ? NULL : f.row_starts, i == 1 ? NULL : f.row_vertices,
                          i == 2 ? NULL : f.row_values, f.rows};
        CHECK(REFUSED(tug_create_model, mesh, f.shape, f.shapes, f.weight, f.weights, &bare,
                      f.group, f.groups, f.stiffness, 0.0, NULL, NULL, &model));
        CHECK(model == NULL);
    }
    tug_destroy_mesh(mesh);
}

static void spoil_fixture(fixture *f, int i)
{
    switch (i) {
    case 0:
        f->shapes = 0;
        break;
    case 1:
        f->weights = 0;
        break;
    case 2:
        f->groups = 0;
        break;
    case 3:
        f->rows = 0;
        break;
    case 4:
        f->row_starts[0] = 1;
        break;
    case 5:
        f->row_starts[1] = 0;
        break;
    case 6:
        f->row_starts[2] = -3;
        break;
    case 7:
        f->row_vertices[1] = f->vertices;
        break;
    case 8:
        f->row_vertices[1] = -1;
        break;
    case 9:
        f->row_values[2] = INFINITY;
        break;
    case 10:
        f->group[3] = f->groups;
        break;
    case 11:
        f->group[3] = -1;
        break;
    case 12:
        f->groups++; /* the last is then empty */
        break;
    case 13:
        f->shape[9] = NAN;
        break;
    case 14:
        f->shape[f->shapes * coordinate_count(f) - 1] = -INFINITY;
        break;
    case 15:
        f->weight[f->vertices * f->weights - 1] = NAN;
        break;
    case 16:
        f->shapes = -1;
        break;
    case 17:
        f->stiffness[5] = 0.0;
        break;
    case 18:
        f->stiffness[0] = NAN;
        break;
    case 19:
        f->stiffness[f->triangles - 1] = INFINITY;
        break;
    case 20:
        f->smoothness = -1e-9;
        break;
    case 21:
        f->smoothness = NAN;
        break;
    default:
        memset(f->shape, 0, sizeof f->shape); /* all vertices in one place */
    }
}

static void tug_create_model_refuses(void)
{
    for (int i = 0; i <= 22; i++) {
        fixture f;
        make_strip(&f);
        tug_mesh *mesh = make_mesh(&f);
        tug_model *model = RUBBISH;
        spoil_fixture(&f, i);
        spoil_error_text();
        CHECK(
            refused(tug_create_model_of(&f, mesh, &model), TUG_ERROR_ARGUMENT, "tug_create_model"));
        CHECK(model == NULL);
        tug_destroy_mesh(mesh);
    }
}

static void models_that_cannot_be_are_named(void)
{
    fixture f;
    make_strip(&f);
    f.row_vertices[1] = f.row_vertices[0];
    tug_mesh *mesh = make_mesh(&f);
    tug_model *model = RUBBISH;
    spoil_error_text();
    CHECK(tug_create_model_of(&f, mesh, &model) == TUG_ERROR_HANDLES);
    CHECK(strstr(tug_error_text(), "no two may hold the same place") != NULL);
    CHECK(model == NULL);
    tug_destroy_mesh(mesh);

    make_strip(&f);
    f.triangle[1] = f.triangle[0];
    mesh = make_mesh(&f);
    model = RUBBISH;
    spoil_error_text();
    CHECK(tug_create_model_of(&f, mesh, &model) == TUG_ERROR_MESH);
    CHECK(strstr(tug_error_text(), "no area") != NULL);
    CHECK(model == NULL);
    int32_t sample = -7;
    CHECK(tug_spread_vertices(mesh, 0, 1, &sample) == TUG_ERROR_MESH);
    CHECK(sample == -7);
    tug_destroy_mesh(mesh);
}

static void model_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f), *other = RUBBISH;
    tug_model_sizes sizes = {.struct_size = sizeof sizes, .vertices = -7};
    char blob[8] = "before";
    CHECK(REFUSED(tug_get_model_sizes, NULL, &sizes));
    CHECK(REFUSED(tug_get_model_sizes, model, NULL));
    sizes.struct_size = sizeof sizes + 4;
    CHECK(REFUSED(tug_get_model_sizes, model, &sizes));
    CHECK(sizes.vertices == -7 && sizes.struct_size == sizeof sizes + 4);
    CHECK(tug_model_blob_size(NULL) == 0);
    CHECK(REFUSED(tug_save_model, NULL, blob, sizeof blob));
    CHECK(REFUSED(tug_save_model, model, NULL, tug_model_blob_size(model)));
    CHECK(REFUSED(tug_save_model, model, blob, sizeof blob));
    CHECK(strcmp(blob, "before") == 0);
    CHECK(REFUSED(tug_load_model, NULL, 8, &other) && other == NULL);
    CHECK(REFUSED(tug_load_model, blob, sizeof blob, NULL));
    other = RUBBISH;
    CHECK(REFUSED_WITH(TUG_ERROR_BLOB, tug_load_model, blob, sizeof blob, &other));
    CHECK(other == NULL);
    tug_destroy_model(model);
}

static void spoil_options(tug_solver_options *options, int i)
{
    switch (i) {
    case 0:
        options->struct_size = 0;
        break;
    case 1:
        options->struct_size++;
        break;
    case 2:
        options->form = -1;
        break;
    case 3:
        options->form = 7;
        break;
    case 4:
        options->lambda = -0.1;
        break;
    case 5:
        options->lambda = NAN;
        break;
    case 6:
        options->lambda = INFINITY;
        break;
    case 7:
        options->prior = -1.0;
        break;
    case 8:
        options->prior = NAN;
        break;
    case 9:
        options->tolerance = 0.0;
        break;
    case 10:
        options->tolerance = NAN;
        break;
    case 11:
        options->scale = 1; /* in the steady form */
        break;
    default:
        options->max_rounds = -1;
    }
}

static void tug_create_solver_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f);
    tug_solver_options options;
    tug_solver *solver = RUBBISH;
    tug_default_solver_options(&options);
    CHECK(REFUSED(tug_create_solver, model, &options, NULL));
    CHECK(REFUSED(tug_create_solver, NULL, &options, &solver) && solver == NULL);
    solver = RUBBISH;
    CHECK(REFUSED(tug_create_solver, model, NULL, &solver) && solver == NULL);
    for (int i = 0; i <= 12; i++) {
        tug_default_solver_options(&options);
        spoil_options(&options, i);
        solver = RUBBISH;
        CHECK(REFUSED(tug_create_solver, model, &options, &solver));
        CHECK(solver == NULL);
    }
    tug_destroy_model(model);
}

static void solver_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f);
    tug_solver_options options;
    tug_solver *solver, *warm;
    tug_solve_info info = {.struct_size = sizeof info, .rounds = -7};
    double targets[2 * MAX_WEIGHTS] = {0}, out[9 * MAX_VERTICES] = {-7.0};
    double blend[MAX_PAIRS] = {0}, rotations[4 * MAX_PAIRS] = {0};
    for (int32_t i = 0; i < f.groups * f.shapes; i++) {
        blend[i] = i % f.shapes == 0;
        rotations[4 * i] = rotations[4 * i + 3] = 1.0;
    }
    double firmness[MAX_WEIGHTS] = {0}, turned[4 * MAX_WEIGHTS] = {0};
    tug_default_solver_options(&options);
    CHECK(tug_create_solver(model, &options, &solver) == TUG_OK);
    options.warm_start = 1;
    CHECK(tug_create_solver(model, &options, &warm) == TUG_OK);
    for (int solved = 0; solved < 2; solved++) { /* before the first pose there is none to get */
        CHECK(solved || REFUSED(tug_get_positions, solver, out));
        CHECK(solved || REFUSED(tug_get_blend, solver, out));
        CHECK(solved || REFUSED(tug_get_costs, solver, out));
        CHECK(solved || REFUSED(tug_get_rotations, solver, out));
        CHECK(solved || REFUSED(tug_get_scale, solver, out));
        CHECK(REFUSED(tug_get_scale, NULL, out) && REFUSED(tug_get_scale, solver, NULL));
        CHECK(REFUSED(tug_get_positions, NULL, out) && REFUSED(tug_get_positions, solver, NULL));
        CHECK(REFUSED(tug_get_blend, NULL, out) && REFUSED(tug_get_blend, solver, NULL));
        CHECK(REFUSED(tug_get_costs, NULL, out) && REFUSED(tug_get_costs, solver, NULL));
        CHECK(REFUSED(tug_get_rotations, NULL, out) && REFUSED(tug_get_rotations, solver, NULL));
        CHECK(REFUSED(tug_solve, NULL, targets, &info) && REFUSED(tug_solve, solver, NULL, &info));
        targets[3] = NAN;
        CHECK(REFUSED(tug_solve, solver, targets, &info));
        targets[3] = 0.0;
        info.struct_size--;
        CHECK(REFUSED(tug_solve, solver, targets, &info));
        info.struct_size++;
        CHECK(REFUSED(tug_set_firmness, NULL, firmness));
        CHECK(REFUSED(tug_set_firmness, solver, NULL));
        firmness[1] = solved ? -1e-30 : NAN;
        CHECK(REFUSED(tug_set_firmness, solver, firmness));
        CHECK(strstr(tug_error_text(), "row 1") != NULL);
        CHECK(REFUSED(tug_set_orientations, NULL, targets, targets));
        CHECK(REFUSED(tug_set_orientations, solver, NULL, targets));
        CHECK(REFUSED(tug_set_orientations, solver, targets, NULL));
        CHECK(REFUSED(tug_set_orientations, solver, turned, firmness));
        firmness[1] = INFINITY;
        for (int i = 0; i < 4; i++) { /* sheared, mirrored, not finite, zero */
            const double spoiled[4][4] = {{1, 1e-3, 0, 1}, {1, 0, 0, -1}, {1, NAN, 0, 1}, {0}};
            memcpy(turned + 4, spoiled[i], sizeof spoiled[i]);
            CHECK(REFUSED(tug_set_orientations, solver, turned, firmness));
            CHECK(strstr(tug_error_text(), "row 1") != NULL);
        }
        CHECK(REFUSED(tug_pose, NULL, targets, blend, rotations));
        CHECK(REFUSED(tug_pose, solver, NULL, blend, rotations));
        CHECK(REFUSED(tug_pose, solver, targets, NULL, rotations));
        CHECK(REFUSED(tug_pose, solver, targets, blend, NULL));
        CHECK(REFUSED(tug_pose, solver, targets, out, rotations)); /* no blend */
        CHECK(REFUSED(tug_pose, solver, targets, blend, out));     /* no rotations */
        CHECK(REFUSED(tug_solve_from, NULL, targets, rotations, &info));
        CHECK(REFUSED(tug_solve_from, solver, NULL, rotations, &info));
        CHECK(REFUSED(tug_solve_from, solver, targets, NULL, &info));
        CHECK(REFUSED(tug_solve_from, solver, targets, out, &info)); /* no rotations */
        CHECK(strstr(tug_error_text(), "shape 0 in group 0") != NULL);
        CHECK(REFUSED(tug_solve_from, warm, targets, rotations, &info));
        targets[3] = INFINITY;
        CHECK(REFUSED(tug_solve_from, solver, targets, rotations, &info));
        CHECK(REFUSED(tug_pose, solver, targets, blend, rotations));
        targets[3] = 0.0;
        CHECK(out[0] == -7.0 && info.rounds == -7);
        CHECK(tug_solve(solver, targets, NULL) == TUG_OK);
    }
    tug_destroy_solver(warm);
    tug_destroy_solver(solver);
    tug_destroy_model(model);
}

static void tug_find_rotations_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    double R[4 * MAX_PAIRS] = {-7.0};
    double *x = f.shape;
    int32_t *g = f.group, S = f.shapes, G = f.groups;
    CHECK(REFUSED(tug_find_rotations, NULL, x, S, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, NULL, S, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, NULL, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, NULL, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, x, NULL));
    CHECK(REFUSED(tug_find_rotations, mesh, x, 0, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, 0, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G - 1, x, R));
    x[coordinate_count(&f) + 1] = NAN;
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, x, R));
    x[coordinate_count(&f) + 1] = 0.0;
    x[1] = INFINITY;
    CHECK(REFUSED(tug_find_rotations, mesh, x + coordinate_count(&f), 1, g, G, x, R));
    CHECK(R[0] == -7.0);
    tug_destroy_mesh(mesh);
}

static void tug_minimise_blend_refuses(void)
{
    double Q[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, c[4] = {0}, d[4] = {0};
    double B[4] = {0.5, 0.5, 1.0, 0.0};
    tug_blend_info info = {.struct_size = sizeof info, .pivots = -7};
    CHECK(REFUSED(tug_minimise_blend, 2, 2, NULL, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, NULL, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, NULL, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, NULL, &info));
    CHECK(REFUSED(tug_minimise_blend, 0, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 0, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, -2, -2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, -0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, NAN, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, INFINITY, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, NAN, d, 0.5, 0, B, &info));
    double *coefficients[] = {Q + 15, c + 3, d + 3};
    for (int i = 0; i < 3; i++) {
        *coefficients[i] = NAN;
        CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
        *coefficients[i] = 1.0;
    }
    const double starts[][4] = {
        {0.5, 0.5, 1.0, 0.1}, {1.5, -0.5, 1.0, 0.0}, {NAN, 0.5, 1.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    for (int i = 0; i < 4; i++) {
        double bad[4];
        memcpy(bad, starts[i], sizeof bad);
        CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, bad, &info));
        CHECK(memcmp(bad, starts[i], sizeof bad) == 0);
    }
    info.struct_size = 1;
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(B[0] == 0.5 && B[2] == 1.0 && info.pivots == -7);
}

static void destroying_nothing_is_allowed(void)
{
    long live = live_allocations();
    tug_destroy_mesh(NULL);
    tug_destroy_model(NULL);
    tug_destroy_solver(NULL);
    tug_destroy_points(NULL);
    CHECK(live_allocations() == live);
}

static void library_tells_its_version(void)
{
    int major, minor, patch;
    CHECK(tug_abi() == TUG_ABI);
    CHECK(sscanf(tug_version(), "%d.%d.%d", &major, &minor, &patch) == 3);
}

int main(int argc, char **argv)
{
    RUN(tug_create_mesh_refuses);
    RUN(mesh_calls_refuse);
    RUN(surface_calls_refuse);
    RUN(point_calls_refuse);
    RUN(tug_solve_elastic_net_refuses);
    RUN(tug_compute_weights_refuses);
    RUN(handles_that_cannot_be_are_named);
    RUN(tug_compute_eigenfunctions_refuses);
    RUN(tug_find_skeleton_refuses);
    RUN(tug_cluster_triangles_refuses);
    RUN(dictionary_calls_refuse);
    RUN(tug_create_model_refuses_null);
    RUN(tug_create_model_refuses);
    RUN(models_that_cannot_be_are_named);
    RUN(model_calls_refuse);
    RUN(tug_create_solver_refuses);
    RUN(solver_calls_refuse);
    RUN(tug_find_rotations_refuses);
    RUN(tug_minimise_blend_refuses);
    RUN(destroying_nothing_is_allowed);
    RUN(library_tells_its_version);
    return TEST_RESULT;
}
