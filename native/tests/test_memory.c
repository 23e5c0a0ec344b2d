/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calls that cannot go on: each allocation in turn fails, and each report of progress asks to stop.
 * Nothing may leak and no output may change. */
#include "fixture.h"
#include "memory.h"
#include "test.h"

/* The things a call may need, made beforehand, and places for what it gives. */
typedef struct bench {
    fixture f;
    tug_mesh *mesh;
    tug_model *model;
    tug_solver *solver;
    size_t blob_size;
    unsigned char blob[1 << 18];
    tug_progress progress;
    void *user;
} bench;

static int prepare(bench *b)
{
    memset(b, 0, sizeof *b);
    make_strip(&b->f);
    b->mesh = make_mesh(&b->f);
    b->model = make_model(&b->f);
    b->blob_size = tug_model_blob_size(b->model);
    tug_solver_options options;
    tug_default_solver_options(&options);
    tug_create_solver(b->model, &options, &b->solver);
    return b->blob_size <= sizeof b->blob &&
           tug_save_model(b->model, b->blob, b->blob_size) == TUG_OK;
}

static void clear(bench *b)
{
    tug_destroy_solver(b->solver);
    tug_destroy_model(b->model);
    tug_destroy_mesh(b->mesh);
}

/* A call under test. Returns its status, or -1 where a failure changed an output. */
typedef int (*call)(bench *b);

enum { CHANGED = -1 };

static char rubbish; /* what a failed call has to replace by NULL */

static int call_create_mesh(bench *b)
{
    tug_mesh *mesh = (tug_mesh *)&rubbish;
    tug_status status =
        tug_create_mesh(b->f.shape, b->f.vertices, 2, b->f.triangle, b->f.triangles, &mesh);
    if (status == TUG_OK) {
        tug_destroy_mesh(mesh);
    }
    return status == TUG_OK || mesh == NULL ? (int)status : CHANGED;
}

static int call_check_mesh(bench *b)
{
    char text[256] = "before";
    int32_t errors = -7, warnings = -7;
    tug_status status = tug_check_mesh(b->mesh, text, sizeof text, &errors, &warnings);
    int kept = strcmp(text, "before") == 0 && errors == -7 && warnings == -7;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_spread_vertices(bench *b)
{
    int32_t vertices[] = {-7, -7, -7};
    tug_status status = tug_spread_vertices(b->mesh, 0, 3, vertices);
    return status == TUG_OK || vertices[0] == -7 ? (int)status : CHANGED;
}

static int call_find_distances(bench *b)
{
    double distances[MAX_VERTICES] = {-7.0};
    const int32_t source = 3;
    tug_status status = tug_find_distances(b->mesh, &source, 1, distances, NULL);
    return status == TUG_OK || distances[0] == -7.0 ? (int)status : CHANGED;
}

static int call_create_points(bench *b)
{
    tug_points *points = (tug_points *)&rubbish;
    tug_status status = tug_create_points(b->f.shape, b->f.vertices, 2, &points);
    if (status == TUG_OK) {
        tug_destroy_points(points);
    }
    return status == TUG_OK || points == NULL ? (int)status : CHANGED;
}

static int solve_elastic_net(double sparsity)
{
    const double X[] = {1, 2, 3, 0, 1, 1}, Y[] = {1, 2}, Lambda[] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    double T[] = {-7.0, -7.0, -7.0};
    tug_elastic_net_info info = {.struct_size = sizeof info, .rounds = -7};
    tug_status status = tug_solve_elastic_net(2, 3, 1, X, Y, Lambda, 1.0, 1.0, sparsity, T, &info);
    int kept = T[0] == -7.0 && T[1] == -7.0 && T[2] == -7.0 && info.rounds == -7;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_solve_elastic_net(bench *b)
{
    (void)b;
    return solve_elastic_net(0.1);
}

static int call_solve_least_squares(bench *b)
{
    (void)b;
    return solve_elastic_net(0.0);
}

/* One thread, since allocations fail by their number. */
static int call_compute_weights(bench *b)
{
    static double weights[3 * MAX_VERTICES];
    const int32_t starts[] = {0, 1, 2, 3};
    tug_weights_options options;
    tug_weights_info info = {.struct_size = sizeof info, .iterations = -7};
    tug_default_weights_options(&options);
    options.threads = 1;
    for (int32_t i = 0; i < 3 * b->f.vertices; i++) {
        weights[i] = -7.0;
    }
    tug_status status = tug_compute_weights(b->mesh, starts, b->f.row_vertices, 3, &options,
                                            b->progress, b->user, weights, &info);
    int kept = info.iterations == -7;
    for (int32_t i = 0; i < 3 * b->f.vertices; i++) {
        kept &= weights[i] == -7.0;
    }
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_compute_eigenfunctions(bench *b)
{
    static double values[9], functions[9 * MAX_VERTICES];
    tug_eigenfunctions_info info = {.struct_size = sizeof info, .solves = -7};
    values[0] = functions[0] = -7.0;
    tug_status status =
        tug_compute_eigenfunctions(b->mesh, 9, b->progress, b->user, values, functions, &info);
    int kept = info.solves == -7 && values[0] == -7.0 && functions[0] == -7.0;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_find_skeleton(bench *b)
{
    static double weights[5 * MAX_VERTICES];
    int32_t bones = -7;
    tug_skeleton_options options;
    tug_skeleton_info info = {.struct_size = sizeof info, .rounds = -7};
    tug_default_skeleton_options(&options);
    weights[0] = -7.0;
    tug_status status = tug_find_skeleton(b->mesh, b->f.shape, b->f.shapes, 5, &options,
                                          b->progress, b->user, weights, &bones, &info);
    int kept = info.rounds == -7 && weights[0] == -7.0 && bones == -7;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_cluster_triangles(bench *b)
{
    int32_t groups[MAX_TRIANGLES], count = -7, kept = 1;
    for (int32_t t = 0; t < b->f.triangles; t++) {
        groups[t] = -7;
    }
    tug_status status = tug_cluster_triangles(b->mesh, b->f.weight, b->f.weights, 4, b->progress,
                                              b->user, groups, &count);
    for (int32_t t = 0; t < b->f.triangles; t++) {
        kept &= groups[t] == -7;
    }
    return status == TUG_OK || (kept && count == -7) ? (int)status : CHANGED;
}

static int call_reduce_dictionary(bench *b)
{
    int32_t atoms[12] = {-7};
    tug_dictionary D = dictionary_of(&b->f);
    tug_status status = tug_reduce_dictionary(&D, 12, b->progress, b->user, atoms);
    return status == TUG_OK || atoms[0] == -7 ? (int)status : CHANGED;
}

static int call_fit_dictionary(bench *b)
{
    static double transforms[3 * MAX_COORDINATES], fitted[MAX_COORDINATES];
    tug_dictionary D = dictionary_of(&b->f);
    transforms[0] = fitted[0] = -7.0;
    tug_status status =
        tug_fit_dictionary(&D, NULL, 0, b->f.shape, b->progress, b->user, transforms, fitted);
    int kept = transforms[0] == -7.0 && fitted[0] == -7.0;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

static int call_create_model(bench *b)
{
    tug_rows rows = {b->f.row_starts, b->f.row_vertices, b->f.row_values, b->f.rows};
    tug_model *model = (tug_model *)&rubbish;
    tug_status status = tug_create_model(b->mesh, b->f.shape, b->f.shapes, b->f.weight,
                                         b->f.weights, &rows, b->f.group, b->f.groups,
                                         b->f.stiffness, 0.01, b->progress, b->user, &model);
    if (status == TUG_OK) {
        tug_destroy_model(model);
    }
    return status == TUG_OK || model == NULL ? (int)status : CHANGED;
}

static int call_load_model(bench *b)
{
    tug_model *model = (tug_model *)&rubbish;
    tug_status status = tug_load_model(b->blob, b->blob_size, &model);
    if (status == TUG_OK) {
        tug_destroy_model(model);
    }
    return status == TUG_OK || model == NULL ? (int)status : CHANGED;
}

static int create_solver(bench *b, int32_t form, int32_t single_blend)
{
    tug_solver_options options;
    tug_solver *solver = (tug_solver *)&rubbish;
    tug_default_solver_options(&options);
    options.form = form;
    options.single_blend = single_blend;
    tug_status status = tug_create_solver(b->model, &options, &solver);
    if (status == TUG_OK) {
        tug_destroy_solver(solver);
    }
    return status == TUG_OK || solver == NULL ? (int)status : CHANGED;
}

static int call_create_solver(bench *b)
{
    return create_solver(b, TUG_FORM_STEADY, 0);
}

static int call_create_solver_of_one_blend(bench *b)
{
    return create_solver(b, TUG_FORM_STEADY, 1);
}

static int call_create_trust_region(bench *b)
{
    return create_solver(b, TUG_FORM_TRUST_REGION, 0);
}

/* Rows that give way where the row before was pinned: both are new. */
static int call_set_firmness(bench *b)
{
    const double soft[] = {1.0, INFINITY, 0.0};
    double before[2 * MAX_VERTICES], after[2 * MAX_VERTICES];
    tug_solve(b->solver, b->f.shape, NULL);
    tug_get_positions(b->solver, before);
    tug_status status = tug_set_firmness(b->solver, soft);
    tug_solve(b->solver, b->f.shape, NULL);
    tug_get_positions(b->solver, after);
    if (status == TUG_OK) {
        tug_set_firmness(b->solver, (double[]){INFINITY, INFINITY, INFINITY});
    }
    int kept = memcmp(before, after, (size_t)(2 * b->f.vertices) * sizeof *before) == 0;
    return (status == TUG_OK) != kept ? (int)status : CHANGED;
}

static int call_create_average(bench *b)
{
    return create_solver(b, TUG_FORM_AVERAGE, 0);
}

static int call_create_minimal(bench *b)
{
    return create_solver(b, TUG_FORM_MINIMAL, 0);
}

static int call_change_rows(bench *b)
{
    tug_rows rows = {b->f.row_starts, b->f.row_vertices, b->f.row_values, b->f.rows};
    double firmness[MAX_WEIGHTS];
    tug_model *model = (tug_model *)&rubbish;
    for (int32_t r = 0; r < b->f.rows; r++) {
        firmness[r] = 1.0;
    }
    tug_status status = tug_change_rows(b->model, &rows, firmness, &model);
    if (status == TUG_OK) {
        tug_destroy_model(model);
    }
    return status == TUG_OK || model == NULL ? (int)status : CHANGED;
}

static int call_minimise_blend(bench *b)
{
    const double Q[] = {2, 0, 0, 1}, c[] = {0, 0}, d[] = {1, 2};
    double B[] = {0.25, 0.75};
    tug_blend_info info = {.struct_size = sizeof info, .pivots = -7};
    (void)b;
    tug_status status = tug_minimise_blend(1, 2, Q, c, 1.0, d, 0.5, 0, B, &info);
    int kept = B[0] == 0.25 && B[1] == 0.75 && info.pivots == -7;
    return status == TUG_OK || kept ? (int)status : CHANGED;
}

/* Let the first allocation of the call fail, then the second, and so on. */
static void sweep_allocations(call make)
{
    bench b;
    CHECK(prepare(&b));
    long live = live_allocations(), before = total_allocations();
    CHECK(make(&b) == TUG_OK);
    CHECK(live_allocations() == live);
    long needed = total_allocations() - before;
    CHECK(needed > 0);
    for (long successes = 0; successes < needed; successes++) {
        fail_allocations_after(successes);
        int status = make(&b);
        fail_allocations_after(-1);
        CHECK(status == TUG_ERROR_MEMORY);
        CHECK(strstr(tug_error_text(), "memory") != NULL);
        CHECK(live_allocations() == live);
    }
    CHECK(make(&b) == TUG_OK); /* none of it did harm */
    clear(&b);
}

/* What a progress callback has seen, and when it asks to stop. */
typedef struct watch {
    int calls, stop_at; /* never where it is below zero */
    double fraction;
    int sound; /* fractions within 0 to 1, none falling; a stage in words */
} watch;

static int watch_progress(void *user, const char *stage, double fraction)
{
    watch *w = user;
    w->sound &= fraction >= w->fraction && fraction <= 1.0 && stage != NULL && stage[0] != '\0';
    w->fraction = fraction;
    return w->calls++ == w->stop_at;
}

/* Let the first report ask to stop, then the second, and so on. */
static void sweep_cancellations(call make)
{
    bench b;
    CHECK(prepare(&b));
    long live = live_allocations();
    watch all = {.stop_at = -1, .sound = 1};
    b.progress = watch_progress;
    b.user = &all;
    CHECK(make(&b) == TUG_OK);
    CHECK(all.calls > 0 && all.sound);
    for (int stop_at = 0; stop_at < all.calls; stop_at++) {
        watch some = {.stop_at = stop_at, .sound = 1};
        b.user = &some;
        CHECK(make(&b) == TUG_ERROR_CANCELLED);
        CHECK(some.calls == stop_at + 1); /* it is not asked again */
        CHECK(live_allocations() == live);
    }
    clear(&b);
}

#define SWEEP(of, name)                                                                            \
    static void name##_fails_cleanly(void)                                                         \
    {                                                                                              \
        sweep_##of(call_##name);                                                                   \
    }
#define SWEEP_CANCEL(name)                                                                         \
    static void name##_stops_cleanly(void)                                                         \
    {                                                                                              \
        sweep_cancellations(call_##name);                                                          \
    }

SWEEP(allocations, create_mesh)
SWEEP(allocations, check_mesh)
SWEEP(allocations, spread_vertices)
SWEEP(allocations, find_distances)
SWEEP(allocations, create_points)
SWEEP(allocations, solve_elastic_net)
SWEEP(allocations, solve_least_squares)
SWEEP(allocations, compute_weights)
SWEEP(allocations, compute_eigenfunctions)
SWEEP(allocations, find_skeleton)
SWEEP(allocations, cluster_triangles)
SWEEP(allocations, reduce_dictionary)
SWEEP(allocations, fit_dictionary)
SWEEP(allocations, create_model)
SWEEP(allocations, load_model)
SWEEP(allocations, create_solver)
SWEEP(allocations, create_solver_of_one_blend)
SWEEP(allocations, create_trust_region)
SWEEP(allocations, create_average)
SWEEP(allocations, create_minimal)
SWEEP(allocations, set_firmness)
SWEEP(allocations, change_rows)
SWEEP(allocations, minimise_blend)
SWEEP_CANCEL(compute_weights)
SWEEP_CANCEL(compute_eigenfunctions)
SWEEP_CANCEL(find_skeleton)
SWEEP_CANCEL(cluster_triangles)
SWEEP_CANCEL(reduce_dictionary)
SWEEP_CANCEL(fit_dictionary)
SWEEP_CANCEL(create_model)

static void allocate_counts_and_clears(void)
{
    long live = live_allocations(), total = total_allocations();
    double *numbers = allocate(100, sizeof *numbers);
    void *nothing = allocate(0, 8);
    CHECK(numbers != NULL && nothing != NULL);
    for (int i = 0; i < 100; i++) {
        CHECK(numbers[i] == 0.0);
    }
    CHECK(live_allocations() == live + 2 && total_allocations() == total + 2);
    release(numbers);
    release(nothing);
    release(NULL);
    CHECK(live_allocations() == live && total_allocations() == total + 2);
}

int main(int argc, char **argv)
{
    RUN(allocate_counts_and_clears);
    RUN(create_mesh_fails_cleanly);
    RUN(check_mesh_fails_cleanly);
    RUN(spread_vertices_fails_cleanly);
    RUN(find_distances_fails_cleanly);
    RUN(create_points_fails_cleanly);
    RUN(solve_elastic_net_fails_cleanly);
    RUN(solve_least_squares_fails_cleanly);
    RUN(compute_weights_fails_cleanly);
    RUN(compute_eigenfunctions_fails_cleanly);
    RUN(find_skeleton_fails_cleanly);
    RUN(cluster_triangles_fails_cleanly);
    RUN(reduce_dictionary_fails_cleanly);
    RUN(fit_dictionary_fails_cleanly);
    RUN(create_model_fails_cleanly);
    RUN(load_model_fails_cleanly);
    RUN(create_solver_fails_cleanly);
    RUN(create_solver_of_one_blend_fails_cleanly);
    RUN(create_trust_region_fails_cleanly);
    RUN(create_average_fails_cleanly);
    RUN(create_minimal_fails_cleanly);
    RUN(set_firmness_fails_cleanly);
    RUN(change_rows_fails_cleanly);
    RUN(minimise_blend_fails_cleanly);
    RUN(compute_weights_stops_cleanly);
    RUN(compute_eigenfunctions_stops_cleanly);
    RUN(find_skeleton_stops_cleanly);
    RUN(cluster_triangles_stops_cleanly);
    RUN(reduce_dictionary_stops_cleanly);
    RUN(fit_dictionary_stops_cleanly);
    RUN(create_model_stops_cleanly);
    return TEST_RESULT;
}
