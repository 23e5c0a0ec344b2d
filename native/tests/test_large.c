/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many handles of short reach with many shapes: what such a model takes, and that its solves are
 * those of a model that knows nothing of reach or of working sets. */
#include "dense/small_matrix.h"
#include "memory.h"
#include "solver/contraction.h"
#include "solver/solver_state.h"

#include "fixture.h"
#include "test.h"

#include <stdlib.h>

enum {
    DIMENSION = 2,
    HANDLES = 20,
    SHAPES = 12,
    GROUPS = 76, /* four between two handles */
    ALONG = 2 * GROUPS + 1,
    ACROSS = 3,
    POINTS = ALONG * ACROSS,
    PAIRS = GROUPS * SHAPES
};

/* A strip that is bent in many ways, with weights that reach to the next handle. */
typedef struct strip {
    double shapes[SHAPES * POINTS * DIMENSION], weights[POINTS * HANDLES];
    int32_t triangles[12 * POINTS], groups[4 * POINTS], triangle_count;
    int32_t starts[HANDLES + 1], vertices[HANDLES];
    double ones[HANDLES], targets[HANDLES * DIMENSION];
} strip;

/* Shape 0 is straight; the others wind, each in its own way. */
static void bend_strip(int32_t s, double *points)
{
    double x = 0.0, y = 0.0, step = 0.25;
    for (int32_t i = 0; i < ALONG; i++) {
        double t = (double)i / (ALONG - 1), waves = 0.7 + 0.45 * s;
        double angle = s == 0 ? 0.0 : 0.9 * sin(3.0 * waves * t + 1.3 * s);
        double thickness = 0.5 * (1.0 + 0.2 * sin((double)s) * sin(9.0 * t + s));
        for (int32_t j = 0; j < ACROSS; j++, points += DIMENSION) {
            points[0] = x - thickness * (j - 1) * sin(angle);
            points[1] = y + thickness * (j - 1) * cos(angle);
        }
        x += step * cos(angle), y += step * sin(angle);
    }
}

/* zero: what stands for the weight of a handle that does not reach. */
static strip *make_winding_strip(double zero)
{
    strip *f = calloc(1, sizeof *f);
    for (int32_t s = 0; s < SHAPES; s++) {
        bend_strip(s, f->shapes + s * POINTS * DIMENSION);
    }
    for (int32_t i = 0; i < POINTS * HANDLES; i++) {
        double place = (double)(i / HANDLES / ACROSS) / (ALONG - 1) * (HANDLES - 1);
        double distance = fabs(place - i % HANDLES);
        f->weights[i] = distance < 1.0 ? 1.0 - distance : zero;
    }
    for (int32_t i = 0; i < (ALONG - 1) * (ACROSS - 1); i++) {
        int32_t a = i / (ACROSS - 1) * ACROSS + i % (ACROSS - 1);
        int32_t corners[] = {a, a + ACROSS, a + 1, a + 1, a + ACROSS, a + ACROSS + 1};
        memcpy(f->triangles + 3 * f->triangle_count, corners, sizeof corners);
        for (int32_t t = 0; t < 2; t++) {
            f->groups[f->triangle_count++] = i / (ACROSS - 1) * GROUPS / (ALONG - 1);
        }
    }
    for (int32_t h = 0; h < HANDLES; h++) {
        f->vertices[h] = h * (ALONG - 1) / (HANDLES - 1) * ACROSS + h % 2 * (ACROSS - 1);
        f->ones[h] = 1.0;
        f->starts[h + 1] = h + 1;
    }
    return f;
}

/* One half like one shape, one half like another, and a little of neither. */
static void mix_halves(strip *f, uint64_t *random)
{
    for (int32_t i = 0; i < HANDLES * DIMENSION; i++) {
        int32_t s = i < HANDLES ? 3 : 7,
                at = f->vertices[i / DIMENSION] * DIMENSION + i % DIMENSION;
        f->targets[i] = f->shapes[s * POINTS * DIMENSION + at] + random_between(random, -0.1, 0.1);
    }
}

static tug_model *make_strip_model(const strip *f)
{
    tug_rows rows = {f->starts, f->vertices, f->ones, HANDLES};
    tug_mesh *mesh;
    tug_model *model = NULL;
    tug_create_mesh(f->shapes, POINTS, DIMENSION, f->triangles, f->triangle_count, &mesh);
    tug_create_model(mesh, f->shapes, SHAPES, f->weights, HANDLES, &rows, f->groups, GROUPS, NULL,
                     0.0, NULL, NULL, &model);
    tug_destroy_mesh(mesh);
    return model;
}

static tug_solver *solve_strip(const strip *f, const tug_model *model, double prior, double lambda,
                               tug_solve_info *info)
{
    tug_solver_options options;
    tug_solver *solver = NULL;
    tug_default_solver_options(&options);
    options.prior = prior;
    options.lambda = lambda;
    tug_create_solver(model, &options, &solver);
    *info = (tug_solve_info){.struct_size = sizeof *info};
    tug_solve(solver, f->targets, info);
    return solver;
}

/* Half of C and of the factor, the single shapes' C, and their forms over the three handles that a
 * group sees at most; a fifth for all that grows more slowly. */
static void memory_is_that_of_the_symmetric_constants(void)
{
    strip *f = make_winding_strip(0.0);
    double turned = (double)PAIRS * DIMENSION, alone = (double)GROUPS * DIMENSION;
    double unknowns = HANDLES * (1.0 + SHAPES * DIMENSION);
    double seen = 3.0 * (1 + DIMENSION), forms = PAIRS * seen * seen;
    double promised =
        1.2 * sizeof(double) *
        (0.5 * turned * turned + 0.5 * unknowns * unknowns + SHAPES * alone * alone + forms);
    double before = (double)allocated_bytes();
    tug_model *model = make_strip_model(f);
    double asked_for = (double)allocated_bytes() - before;
    CHECK(model != NULL);
    CHECK((double)tug_model_blob_size(model) < promised);
    CHECK(asked_for < 1.5 * promised); /* along the way, whether or not at once */
    tug_destroy_model(model);
    free(f);
}

static void reach_changes_no_pose(void)
{
    uint64_t random = 1;
    strip *f = make_winding_strip(0.0), *dense = make_winding_strip(1e-300);
    tug_model *model = make_strip_model(f), *dense_model = make_strip_model(dense);
    CHECK(model != NULL && dense_model != NULL);
    CHECK(3 * model->header.seen < dense_model->header.seen);
    CHECK(2 * model->energy.support->starts[1] < HANDLES);
    for (int trial = 0; trial < 3; trial++) {
        static double q[POINTS * DIMENSION], dense_q[POINTS * DIMENSION];
        tug_solve_info info, dense_info;
        mix_halves(f, &random);
        memcpy(dense->targets, f->targets, sizeof f->targets);
        tug_solver *solver = solve_strip(f, model, 0.1, 0.5, &info);
        tug_solver *reference = solve_strip(dense, dense_model, 0.1, 0.5, &dense_info);
        CHECK(info.converged && dense_info.converged);
        CHECK_NEAR(info.objective / dense_info.objective, 1.0, 1e-8);
        CHECK(tug_get_positions(solver, q) == TUG_OK);
        CHECK(tug_get_positions(reference, dense_q) == TUG_OK);
        for (int32_t i = 0; i < POINTS * DIMENSION; i++) {
            CHECK_NEAR(q[i], dense_q[i], 1e-6);
        }
        tug_destroy_solver(solver);
        tug_destroy_solver(reference);
    }
    tug_destroy_model(model);
    tug_destroy_model(dense_model);
    free(f);
    free(dense);
}

/* (A 20) over all entries at the solver's rotations; its own blend is in B, which is replaced. */
static blend_result minimise_over_all(const tug_solver *solver, double *B)
{
    const tug_model *model = solver->model;
    double *Q = calloc((size_t)PAIRS * PAIRS, sizeof *Q), c[PAIRS], constant = 0.0;
    coupling all = joint_coupling(&model->energy);
    blend_workspace workspace;
    contract_rotations(&all, solver->group_R, Q);
    for (int32_t i = 0; i < PAIRS; i++) {
        c[i] = -trace_of_product(DIMENSION, solver->group_R + i / SHAPES * 4, solver->pull + i * 4);
    }
    for (int32_t i = 0; i < 4 * GROUPS; i++) {
        double difference = solver->group_R[i] - solver->prior_R[i];
        constant += LEAST_PRIOR * model->stiffness[i / 4] * difference * difference;
    }
    blend_problem problem = {GROUPS, SHAPES, Q, c, solver->r + constant, solver->d, 0};
    blend_workspace_create(GROUPS, SHAPES, &workspace);
    blend_result result = minimise_blend(&problem, &workspace, B);
    blend_workspace_destroy(&workspace);
    free(Q);
    return result;
}

static void working_set_finds_the_optimum_over_all(void)
{
    uint64_t random = 2;
    strip *f = make_winding_strip(0.0);
    tug_model *model = make_strip_model(f);
    double unit = model->header.unit;
    int32_t width = 0;
    for (int trial = 0; trial < 3; trial++) {
        static double B[PAIRS], all_B[PAIRS];
        tug_solve_info info;
        mix_halves(f, &random);
        /* The smaller the costs, the less they tell at first which entries count. */
        const double lambda = (const double[]){3.0, 0.5, 0.0}[trial];
        tug_solver *solver = solve_strip(f, model, 0.0, lambda, &info);
        CHECK(trial == 0 ? solver->set.width < SHAPES : solver->set.width > width);
        width = solver->set.width;
        CHECK(info.converged && info.gap <= 1e-9 * info.objective);
        CHECK(tug_get_blend(solver, B) == TUG_OK);
        memset(all_B, 0, sizeof all_B);
        for (int32_t g = 0; g < GROUPS; g++) {
            all_B[g * SHAPES + g % SHAPES] = 1.0;
        }
        blend_result all = minimise_over_all(solver, all_B);
        CHECK_NEAR(info.objective / (unit * all.objective), 1.0, 1e-9);
        for (int32_t i = 0; i < PAIRS && lambda > 0.0; i++) {
            CHECK_NEAR(B[i], all_B[i], 1e-5);
        }
        tug_destroy_solver(solver);
    }
    tug_destroy_model(model);
    free(f);
}

static void solves_allocate_nothing(void)
{
    uint64_t random = 3;
    strip *f = make_winding_strip(0.0);
    tug_model *model = make_strip_model(f);
    tug_solve_info info;
    mix_halves(f, &random);
    tug_solver *solver = solve_strip(f, model, 0.1, 0.5, &info);
    long before = total_allocations();
    mix_halves(f, &random);
    CHECK(tug_solve(solver, f->targets, NULL) == TUG_OK);
    CHECK(total_allocations() == before);
    tug_destroy_solver(solver);
    tug_destroy_model(model);
    free(f);
}

int main(int argc, char **argv)
{
    RUN(memory_is_that_of_the_symmetric_constants);
    RUN(reach_changes_no_pose);
    RUN(working_set_finds_the_optimum_over_all);
    RUN(solves_allocate_nothing);
    return TEST_RESULT;
}
