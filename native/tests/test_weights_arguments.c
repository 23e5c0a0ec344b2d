/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Weights, groups, skeletons, dictionaries and the elastic net with every argument that cannot be.
 */
#include "fixture.h"
#include "refusal.h"
#include "test.h"

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

int main(int argc, char **argv)
{
    RUN(tug_solve_elastic_net_refuses);
    RUN(tug_compute_weights_refuses);
    RUN(handles_that_cannot_be_are_named);
    RUN(tug_compute_eigenfunctions_refuses);
    RUN(tug_find_skeleton_refuses);
    RUN(tug_cluster_triangles_refuses);
    RUN(dictionary_calls_refuse);
    return TEST_RESULT;
}
