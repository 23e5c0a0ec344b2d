/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparison systems that are given what cannot be, or too little memory. */
#include "baselines/baselines.h"

#include "fixture.h"
#include "memory.h"
#include "test.h"

enum { METHOD_COUNT = 6 };

static tug_baseline_problem problem_of(const fixture *f)
{
    return (tug_baseline_problem){f->shape,     f->triangle, f->row_vertices, f->weight,
                                  f->group,     f->shapes,   f->vertices,     f->dimension,
                                  f->triangles, f->rows,     f->weights,      f->groups};
}

/* The status of a creation with one thing changed, which must leave no object behind. */
static tug_status try_creating(const tug_baseline_problem *problem,
                               const tug_baseline_options *options, int32_t method)
{
    static char rubbish;
    tug_baseline *out = (tug_baseline *)&rubbish;
    tug_status status = tug_baseline_create(method, problem, options, &out);
    if (status == TUG_OK) {
        tug_baseline_destroy(out);
        return TUG_OK;
    }
    return out == NULL && tug_error_text()[0] != '\0' ? status : TUG_OK;
}

static void bad_arguments_are_refused(void)
{
    fixture f;
    make_strip(&f);
    tug_baseline_options options, bad_options;
    tug_baseline_default_options(&options);
    const tug_baseline_problem good = problem_of(&f);
    CHECK(try_creating(&good, &options, 0) == TUG_OK);
    CHECK(try_creating(&good, &options, -1) == TUG_ERROR_ARGUMENT);
    CHECK(try_creating(&good, &options, METHOD_COUNT) == TUG_ERROR_ARGUMENT);
    CHECK(try_creating(NULL, &options, 0) == TUG_ERROR_ARGUMENT);
    CHECK(try_creating(&good, NULL, 0) == TUG_ERROR_ARGUMENT);
#define REFUSED(field, value, wanted)                                                              \
    do {                                                                                           \
        tug_baseline_problem bad = good;                                                           \
        bad.field = (value);                                                                       \
        CHECK(try_creating(&bad, &options, 3) == (wanted));                                        \
    } while (0)
    REFUSED(shapes, NULL, TUG_ERROR_ARGUMENT);
    REFUSED(triangles, NULL, TUG_ERROR_ARGUMENT);
    REFUSED(handles, NULL, TUG_ERROR_ARGUMENT);
    REFUSED(weights, NULL, TUG_ERROR_ARGUMENT);
    REFUSED(groups, NULL, TUG_ERROR_ARGUMENT);
    REFUSED(dimension, 4, TUG_ERROR_ARGUMENT);
    REFUSED(shape_count, 0, TUG_ERROR_ARGUMENT);
    REFUSED(triangle_count, -1, TUG_ERROR_ARGUMENT);
    REFUSED(vertex_count, 7, TUG_ERROR_ARGUMENT);
    REFUSED(group_count, 2, TUG_ERROR_ARGUMENT);
    REFUSED(group_count, 7, TUG_ERROR_ARGUMENT);
    int32_t twice[3] = {4, 8, 4}, outside[3] = {4, 8, 1000};
    REFUSED(handles, twice, TUG_ERROR_HANDLES);
    REFUSED(handles, outside, TUG_ERROR_ARGUMENT);
    bad_options = options, bad_options.struct_size--;
    CHECK(try_creating(&good, &bad_options, 0) == TUG_ERROR_ARGUMENT);
    bad_options = options, bad_options.max_rounds = 0;
    CHECK(try_creating(&good, &bad_options, 0) == TUG_ERROR_ARGUMENT);
    bad_options = options, bad_options.tolerance = 0.0;
    CHECK(try_creating(&good, &bad_options, 0) == TUG_ERROR_ARGUMENT);
    f.shape[10] = NAN;
    CHECK(try_creating(&good, &options, 0) == TUG_ERROR_ARGUMENT);
}

static void bad_questions_are_refused(void)
{
    fixture f;
    double targets[3 * MAX_WEIGHTS], positions[MAX_COORDINATES], blend[MAX_SHAPES];
    tug_baseline *baseline;
    tug_baseline_options options;
    tug_baseline_info info = {.struct_size = sizeof info + 1};
    make_strip(&f);
    tug_baseline_problem problem = problem_of(&f);
    tug_baseline_default_options(&options);
    CHECK(tug_baseline_create(TUG_BASELINE_FAST, &problem, &options, &baseline) == TUG_OK);
    CHECK(tug_baseline_get_positions(baseline, positions) == TUG_ERROR_ARGUMENT);
    CHECK(tug_baseline_get_blend(baseline, blend) == TUG_ERROR_ARGUMENT);
    apply_rows(&f, f.shape, targets);
    CHECK(tug_baseline_solve(NULL, targets, NULL) == TUG_ERROR_ARGUMENT);
    CHECK(tug_baseline_solve(baseline, NULL, NULL) == TUG_ERROR_ARGUMENT);
    CHECK(tug_baseline_solve(baseline, targets, &info) == TUG_ERROR_ARGUMENT);
    targets[2] = INFINITY;
    CHECK(tug_baseline_solve(baseline, targets, NULL) == TUG_ERROR_ARGUMENT);
    targets[2] = 0.0;
    CHECK(tug_baseline_solve(baseline, targets, NULL) == TUG_OK);
    CHECK(tug_baseline_get_positions(baseline, NULL) == TUG_ERROR_ARGUMENT);
    CHECK(tug_baseline_get_blend(baseline, NULL) == TUG_ERROR_ARGUMENT);
    tug_baseline_destroy(baseline);
    tug_baseline_destroy(NULL);
}

static void bad_rows_are_refused(void)
{
    fixture f;
    make_strip(&f);
    double firmness[MAX_WEIGHTS] = {1.0, 1.0, 1.0}, too_firm[MAX_WEIGHTS] = {1.0, 1.0, 1e9};
    tug_rows rows = {f.row_starts, f.row_vertices, f.row_values, f.rows}, none = rows;
    none.count = 0;
    tug_baseline_problem problem = problem_of(&f);
    tug_baseline_options options;
    tug_baseline_default_options(&options);
    for (int32_t method = 0; method < METHOD_COUNT; method++) {
        tug_baseline *baseline;
        CHECK(tug_baseline_create(method, &problem, &options, &baseline) == TUG_OK);
        int can = method == TUG_BASELINE_REDUCED_DEFORMABLE;
#define CHANGED(rows, firmness) (tug_baseline_change_rows(baseline, rows, firmness) == TUG_OK)
        CHECK(CHANGED(&rows, firmness) == can);
        CHECK(!CHANGED(NULL, firmness) && !CHANGED(&rows, NULL) && !CHANGED(&none, firmness));
        CHECK(!CHANGED(&rows, too_firm));
        tug_baseline_destroy(baseline);
    }
    CHECK(tug_baseline_change_rows(NULL, &rows, firmness) == TUG_ERROR_ARGUMENT);
}

/* Each allocation in turn fails: rows are changed, or stay as they were. */
static void failed_changes_change_nothing(void)
{
    fixture f;
    make_strip(&f);
    double firmness[MAX_WEIGHTS] = {1.0, 1.0, 1.0}, targets[3 * MAX_WEIGHTS];
    static double before[MAX_COORDINATES], after[MAX_COORDINATES];
    tug_rows rows = {f.row_starts, f.row_vertices, f.row_values, 2};
    tug_baseline_problem problem = problem_of(&f);
    tug_baseline_options options;
    tug_baseline *baseline;
    tug_baseline_default_options(&options);
    tug_baseline_create(TUG_BASELINE_REDUCED_DEFORMABLE, &problem, &options, &baseline);
    apply_rows(&f, f.shape, targets);
    targets[0] += 0.1;
    CHECK(tug_baseline_solve(baseline, targets, NULL) == TUG_OK);
    tug_baseline_get_positions(baseline, before);
    tug_status status = TUG_ERROR_MEMORY;
    for (long successes = 0; status != TUG_OK; successes++) {
        long live = live_allocations();
        fail_allocations_after(successes);
        status = tug_baseline_change_rows(baseline, &rows, firmness);
        fail_allocations_after(-1);
        CHECK(status == TUG_OK || status == TUG_ERROR_MEMORY);
        CHECK(live_allocations() == live);
        CHECK(tug_baseline_solve(baseline, targets, NULL) == TUG_OK);
        tug_baseline_get_positions(baseline, after);
        CHECK((pose_distance(&f, before, after) == 0.0) == (status != TUG_OK));
    }
    tug_baseline_destroy(baseline);
}

/* Each allocation in turn fails: the call says so and leaves nothing behind. */
static void failed_allocations_leave_nothing(void)
{
    fixture f;
    make_strip(&f);
    tug_baseline_problem problem = problem_of(&f);
    tug_baseline_options options;
    tug_baseline_default_options(&options);
    for (int32_t method = 0; method < METHOD_COUNT; method++) {
        long before = live_allocations();
        tug_status status = TUG_ERROR_MEMORY;
        for (long successes = 0; status != TUG_OK; successes++) {
            fail_allocations_after(successes);
            status = try_creating(&problem, &options, method);
            fail_allocations_after(-1);
            CHECK(status == TUG_OK || status == TUG_ERROR_MEMORY);
            CHECK(live_allocations() == before);
        }
    }
}

int main(int argc, char **argv)
{
    RUN(bad_arguments_are_refused);
    RUN(bad_questions_are_refused);
    RUN(bad_rows_are_refused);
    RUN(failed_changes_change_nothing);
    RUN(failed_allocations_leave_nothing);
    return TEST_RESULT;
}
