/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Objects in several threads at once, as tug.h allows: every answer is, bit for bit, the one that a
 * thread alone gets. ThreadSanitizer sees what the library and the tests do, not what happens
 * inside CHOLMOD and OpenBLAS. */

/* Barriers are POSIX, which plain C11 hides. */
#define _POSIX_C_SOURCE 200809L

#include "bench.h"
#include "test.h"

#include <cblas.h>
#include <limits.h>
#include <pthread.h>
#include <stdlib.h>

enum { THREADS = 2, FRAMES = 6, WORKERS = 4 };

typedef void *(*thread_function)(void *self);

/* One call of `work` for each of the `count` things of `size` bytes, all at the same time. */
static int run_together(thread_function work, void *things, size_t size, int count)
{
    pthread_t threads[THREADS];
    int started = 0;
    while (started < count && pthread_create(&threads[started], NULL, work,
                                             (char *)things + (size_t)started * size) == 0) {
        started++;
    }
    for (int i = 0; i < started; i++) {
        pthread_join(threads[i], NULL);
    }
    return started == count;
}

/* ------------------------------------------------------------------------------------------------
 * Solvers on one model
 */

/* All that a solve gives. */
typedef struct answer {
    tug_solve_info info;
    double positions[MAX_COORDINATES], blend[MAX_PAIRS], costs[MAX_PAIRS], rotations[9 * MAX_PAIRS];
} answer;

/* A solver of its own on a model of several; the frames in some order, and again. */
typedef struct drag {
    const tug_model *model;
    const tug_solver_options *options;
    pthread_barrier_t *start;           /* NULL: alone */
    double (*targets)[3 * MAX_WEIGHTS]; /* FRAMES of them */
    int backwards, ok;
    answer answers[FRAMES];
} drag;

static int solve_frame(tug_solver *solver, int32_t form, const double *targets, answer *a)
{
    memset(a, 0, sizeof *a);
    a->info.struct_size = sizeof a->info;
    return tug_solve(solver, targets, &a->info) == TUG_OK &&
           tug_get_positions(solver, a->positions) == TUG_OK &&
           tug_get_blend(solver, a->blend) == TUG_OK &&
           (!has_costs(form) || tug_get_costs(solver, a->costs) == TUG_OK) &&
           tug_get_rotations(solver, a->rotations) == TUG_OK;
}

static void *solve_frames(void *self)
{
    drag *d = self;
    tug_solver *solver = NULL;
    if (d->start != NULL) {
        pthread_barrier_wait(d->start);
    }
    d->ok = tug_create_solver(d->model, d->options, &solver) == TUG_OK;
    for (int i = 0; i < 2 * FRAMES && d->ok; i++) {
        int frame = d->backwards ? FRAMES - 1 - i % FRAMES : i % FRAMES;
        d->ok = solve_frame(solver, d->options->form, d->targets[frame], &d->answers[frame]);
    }
    tug_destroy_solver(solver);
    return NULL;
}

static void compare_with_alone(bench *b)
{
    static drag alone, together[THREADS];
    double targets[FRAMES][3 * MAX_WEIGHTS];
    uint64_t state = 7;
    for (int i = 0; i < FRAMES; i++) {
        mix_targets(&b->f, &state, 0.05, targets[i]);
    }
    alone = (drag){.model = b->model, .options = &b->options, .targets = targets};
    solve_frames(&alone);
    CHECK(alone.ok);
    pthread_barrier_t start;
    CHECK(pthread_barrier_init(&start, NULL, THREADS) == 0);
    for (int i = 0; i < THREADS; i++) {
        together[i] = alone;
        together[i].start = &start;
        together[i].backwards = i % 2;
        memset(together[i].answers, 0, sizeof together[i].answers);
    }
    int ran = run_together(solve_frames, together, sizeof *together, THREADS);
    pthread_barrier_destroy(&start);
    CHECK(ran);
    for (int i = 0; i < THREADS; i++) {
        CHECK(together[i].ok);
        CHECK(memcmp(together[i].answers, alone.answers, sizeof alone.answers) == 0);
    }
}

static void solvers_on_one_model_answer_as_alone(void)
{
    static bench b;
    for (int i = 0; i < 2 * FORM_COUNT && !test_failed_here; i++) {
        make_numbered(&b.f, i / FORM_COUNT);
        prepare(&b, FORMS[i % FORM_COUNT]);
        compare_with_alone(&b);
        clear(&b);
    }
}

/* ------------------------------------------------------------------------------------------------
 * Models on one mesh
 */

typedef struct building {
    const fixture *f;
    const tug_mesh *mesh;
    pthread_barrier_t *start; /* NULL: alone */
    unsigned char *blob;
    size_t size;
} building;

/* The model of the fixture as a blob; none where that fails. */
static void *build_model(void *self)
{
    building *b = self;
    const fixture *f = b->f;
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    tug_model *model;
    if (b->start != NULL) {
        pthread_barrier_wait(b->start);
    }
    if (tug_create_model(b->mesh, f->shape, f->shapes, f->weight, f->weights, &rows, f->group,
                         f->groups, NULL, 0.0, NULL, NULL, &model) != TUG_OK) {
        return NULL;
    }
    b->size = tug_model_blob_size(model);
    b->blob = calloc(1, b->size);
    if (b->blob != NULL && tug_save_model(model, b->blob, b->size) != TUG_OK) {
        b->size = 0;
    }
    tug_destroy_model(model);
    return NULL;
}

static int same_blobs(const building *one, const building *other)
{
    return one->blob != NULL && other->blob != NULL && one->size == other->size &&
           memcmp(one->blob, other->blob, one->size) == 0;
}

static void models_on_one_mesh_are_as_alone(void)
{
    static fixture f;
    make_tube(&f, 1);
    tug_mesh *mesh = make_mesh(&f);
    pthread_barrier_t start;
    CHECK(mesh != NULL && pthread_barrier_init(&start, NULL, THREADS) == 0);
    building alone = {.f = &f, .mesh = mesh}, together[THREADS];
    build_model(&alone);
    for (int i = 0; i < THREADS; i++) {
        together[i] = (building){.f = &f, .mesh = mesh, .start = &start};
    }
    int same = run_together(build_model, together, sizeof *together, THREADS) && alone.size > 0;
    for (int i = 0; i < THREADS; i++) {
        same = same && same_blobs(&alone, &together[i]);
        free(together[i].blob);
    }
    free(alone.blob);
    pthread_barrier_destroy(&start);
    tug_destroy_mesh(mesh);
    CHECK(same);
}

/* ------------------------------------------------------------------------------------------------
 * Weights
 */

typedef struct weighing {
    const fixture *f;
    const tug_mesh *mesh;
    int32_t workers;
    int calls, calls_allowed; /* of the progress callback: one more of them cancels */
    tug_status status;
    char error_text[256];
    double weights[MAX_WEIGHTS * MAX_VERTICES];
} weighing;

static int count_calls(void *user, const char *stage, double fraction)
{
    weighing *w = user;
    (void)stage, (void)fraction;
    return ++w->calls > w->calls_allowed;
}

/* A handle at the vertex of each row. */
static void *weigh(void *self)
{
    weighing *w = self;
    tug_weights_options options;
    tug_default_weights_options(&options);
    options.threads = w->workers;
    w->status = tug_compute_weights(w->mesh, w->f->row_starts, w->f->row_vertices, w->f->rows,
                                    &options, count_calls, w, w->weights, NULL);
    snprintf(w->error_text, sizeof w->error_text, "%s", tug_error_text());
    return NULL;
}

static int is_unset(const weighing *w)
{
    static const double nothing[MAX_WEIGHTS * MAX_VERTICES];
    return memcmp(w->weights, nothing, sizeof nothing) == 0;
}

/* Two calls on one mesh, of several threads each. `calls_allowed`: to the second. */
static void weigh_together(const weighing *alone, int calls_allowed, weighing *together)
{
    for (int i = 0; i < THREADS; i++) {
        together[i] = (weighing){.f = alone->f,
                                 .mesh = alone->mesh,
                                 .workers = WORKERS,
                                 .calls_allowed = i == 1 ? calls_allowed : INT_MAX};
    }
    CHECK(run_together(weigh, together, sizeof *together, THREADS));
    CHECK(together[0].status == TUG_OK && together[0].error_text[0] == '\0');
    CHECK(memcmp(together[0].weights, alone->weights, sizeof alone->weights) == 0);
}

static void compare_weights(const fixture *f, const tug_mesh *mesh)
{
    static weighing alone, together[THREADS];
    alone = (weighing){.f = f, .mesh = mesh, .workers = 1, .calls_allowed = INT_MAX};
    weigh(&alone);
    CHECK(alone.status == TUG_OK);
    weigh_together(&alone, INT_MAX, together);
    CHECK(together[1].status == TUG_OK);
    CHECK(memcmp(together[1].weights, alone.weights, sizeof alone.weights) == 0);
    /* While the energy is factored, and while the handles are solved. */
    for (int calls = 0; calls < 2 && !test_failed_here; calls++) {
        weigh_together(&alone, calls, together);
        CHECK(together[1].status == TUG_ERROR_CANCELLED && is_unset(&together[1]));
        CHECK(strstr(together[1].error_text, "cancelled") != NULL);
    }
}

static void weights_do_not_depend_on_threads(void)
{
    static fixture f;
    make_tube(&f, 0);
    tug_mesh *mesh = make_mesh(&f);
    compare_weights(&f, mesh);
    tug_destroy_mesh(mesh);
}

/* ------------------------------------------------------------------------------------------------
 * BLAS
 */

/* A process that only loads models must not start threads in its solves either. */
static void loading_a_model_leaves_blas_one_thread(void)
{
    static fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f), *loaded = NULL;
    size_t size = tug_model_blob_size(model);
    void *blob = malloc(size);
    CHECK(blob != NULL && tug_save_model(model, blob, size) == TUG_OK);
    openblas_set_num_threads(THREADS);
    CHECK(tug_load_model(blob, size, &loaded) == TUG_OK);
    CHECK(openblas_get_num_threads() == 1);
    tug_destroy_model(loaded);
    tug_destroy_model(model);
    free(blob);
}

int main(int argc, char **argv)
{
    RUN(solvers_on_one_model_answer_as_alone);
    RUN(models_on_one_mesh_are_as_alone);
    RUN(weights_do_not_depend_on_threads);
    RUN(loading_a_model_leaves_blas_one_thread);
    return TEST_RESULT;
}
