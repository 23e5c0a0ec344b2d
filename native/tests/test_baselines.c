/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The comparison systems: what each promises of examples and rigid motions, and its optimum against
 * energies summed anew over the edges of the mesh. */
#include "baselines/baselines.h"

#include "baselines/features.h"
#include "dense/rotation.h"
#include "fixture.h"
#include "test.h"

enum { METHOD_COUNT = 6 };

/* A method on a fixture, and all that it says about its last pose. */
typedef struct bench {
    fixture f;
    int32_t method;
    tug_baseline_options options;
    tug_baseline *baseline;
    tug_baseline_info info;
    double targets[3 * MAX_WEIGHTS], positions[MAX_COORDINATES], blend[MAX_SHAPES];
} bench;

enum { FIXTURE_COUNT = 4 };

static void make_numbered(fixture *f, int i)
{
    if (i < 2) {
        make_tube(f, i);
    } else if (i == 2) {
        make_strip(f);
    } else {
        make_flat(f);
    }
}

static tug_baseline_problem problem_of(const fixture *f)
{
    return (tug_baseline_problem){f->shape,     f->triangle, f->row_vertices, f->weight,
                                  f->group,     f->shapes,   f->vertices,     f->dimension,
                                  f->triangles, f->rows,     f->weights,      f->groups};
}

static void prepare(bench *b, int32_t method)
{
    tug_baseline_problem problem = problem_of(&b->f);
    b->method = method;
    b->info = (tug_baseline_info){.struct_size = sizeof b->info};
    tug_baseline_default_options(&b->options);
    tug_baseline_create(method, &problem, &b->options, &b->baseline);
}

/* Solve for the targets and ask for everything; 0 where a call fails. */
static int solve(bench *b)
{
    return tug_baseline_solve(b->baseline, b->targets, &b->info) == TUG_OK &&
           tug_baseline_get_positions(b->baseline, b->positions) == TUG_OK &&
           tug_baseline_get_blend(b->baseline, b->blend) == TUG_OK;
}

static int bounds_weights(int32_t method)
{
    return method != TUG_BASELINE_MESH_IK && method != TUG_BASELINE_REDUCED_DEFORMABLE;
}

static int is_sound(const bench *b)
{
    double sum = 0.0, least = 0.0, rows[3 * MAX_WEIGHTS], furthest = 0.0;
    for (int32_t s = 0; s < b->f.shapes; s++) {
        sum += b->blend[s];
        least = fmin(least, b->blend[s]);
    }
    apply_rows(&b->f, b->positions, rows);
    for (int32_t i = 0; i < b->f.rows * b->f.dimension; i++) {
        furthest = fmax(furthest, fabs(rows[i] - b->targets[i]));
    }
    double diagonal = diagonal_of(&b->f);
    return fabs(sum - 1.0) <= 1e-9 && (!bounds_weights(b->method) || least >= 0.0) &&
           furthest <= 1e-9 * diagonal && b->info.increase <= 1e-12 * diagonal * diagonal;
}

/* Whether a method can take on shape s exactly. */
static int knows(int32_t method, int32_t s)
{
    return s == 0 || (method != TUG_BASELINE_FAST && method != TUG_BASELINE_REDUCED_DEFORMABLE);
}

static void examples_come_back(void)
{
    for (int i = 0; i < METHOD_COUNT * FIXTURE_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i % FIXTURE_COUNT);
        prepare(&b, i / FIXTURE_COUNT);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(b.info.rounds <= 40); /* the flat strip in space starts next to a saddle */
            if (knows(b.method, s)) {
                CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-5);
                CHECK_NEAR(b.blend[s], 1.0, 1e-4);
                CHECK_NEAR(b.info.objective, 0.0, 1e-9);
            }
        }
        tug_baseline_destroy(b.baseline);
    }
}

/* A skinned model does take on shapes that are linear images of the rest shape. */
static void linear_images_come_back(void)
{
    for (int i = 0; i < METHOD_COUNT * FIXTURE_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i % FIXTURE_COUNT);
        b.f.shapes = 2;
        double A[9] = {1.3, 0.2, 0.0, -0.3, 0.8, 0.1, 0.2, 0.0, 1.1}, none[3] = {0};
        int32_t k = b.f.dimension, size = coordinate_count(&b.f);
        memcpy(b.f.shape + size, b.f.shape, (size_t)size * sizeof(double));
        move_points(k, A, none, b.f.vertices, b.f.shape + size);
        prepare(&b, i / FIXTURE_COUNT);
        apply_rows(&b.f, shape_of(&b.f, 1), b.targets);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && b.info.converged);
        if (b.method != TUG_BASELINE_FAST) {
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, 1)) <= 1e-4);
        }
        tug_baseline_destroy(b.baseline);
    }
}

static void handles_hold_anywhere(void)
{
    uint64_t random = 31;
    for (int i = 0; i < METHOD_COUNT * FIXTURE_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i % FIXTURE_COUNT);
        prepare(&b, i / FIXTURE_COUNT);
        for (int trial = 0; trial < 8; trial++) {
            mix_targets(&b.f, &random, 0.08, b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(b.info.objective >= 0.0 && b.info.rounds > 0);
        }
        tug_baseline_destroy(b.baseline);
    }
}

/* The pose for moved targets is the moved pose. (The flat strip may buckle to either side.) */
static void rigid_motions_carry_over(void)
{
    uint64_t random = 32;
    for (int i = 0; i < METHOD_COUNT * 3; i++) {
        bench b;
        double R[9], offset[3] = {3.0, -4.0, 5.0}, moved[MAX_COORDINATES];
        make_numbered(&b.f, i % 3);
        prepare(&b, i / 3);
        int32_t k = b.f.dimension;
        int turns = b.method <= TUG_BASELINE_NONLINEAR_SHAPE_SPACE;
        for (int trial = 0; trial < 4 && b.method != TUG_BASELINE_BLEND_SHAPES; trial++) {
            identity_matrix(k, R);
            if (turns) {
                random_rotation(&random, k, R);
            }
            mix_targets(&b.f, &random, 0.03, b.targets);
            CHECK(solve(&b));
            memcpy(moved, b.positions, sizeof moved);
            move_points(k, R, offset, b.f.vertices, moved);
            move_points(k, R, offset, b.f.rows, b.targets);
            CHECK(solve(&b));
            CHECK(pose_distance(&b.f, b.positions, moved) <= 1e-5);
        }
        tug_baseline_destroy(b.baseline);
    }
}

/* What is solved in between changes nothing, and neither does the unit of length. */
static void poses_depend_on_nothing_else(void)
{
    uint64_t random = 33;
    for (int32_t method = 0; method < METHOD_COUNT; method++) {
        bench b;
        double first[MAX_COORDINATES], targets[3 * MAX_WEIGHTS];
        make_tube(&b.f, 1);
        prepare(&b, method);
        mix_targets(&b.f, &random, 0.05, targets);
        memcpy(b.targets, targets, sizeof targets);
        CHECK(solve(&b));
        memcpy(first, b.positions, sizeof first);
        mix_targets(&b.f, &random, 0.3, b.targets);
        CHECK(solve(&b));
        memcpy(b.targets, targets, sizeof targets);
        CHECK(solve(&b));
        CHECK(memcmp(first, b.positions, (size_t)coordinate_count(&b.f) * sizeof *first) == 0);
        tug_baseline_destroy(b.baseline);
        rescale(&b.f, 1000.0, 50.0);
        prepare(&b, method);
        for (int32_t i = 0; i < MAX_COORDINATES; i++) {
            first[i] = 1000.0 * first[i] + 50.0;
        }
        for (int32_t i = 0; i < b.f.rows * 3; i++) {
            b.targets[i] = 1000.0 * targets[i] + 50.0;
        }
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, b.positions, first) <= 1e-6);
        tug_baseline_destroy(b.baseline);
    }
}

/* A shape that is there twice, or nearly so, leaves weights open, but not the pose. */
static void duplicates_do_no_harm(void)
{
    uint64_t random = 41;
    for (int32_t method = 0; method < METHOD_COUNT; method++) {
        bench b;
        make_tube(&b.f, 0);
        duplicate_shape(&b.f, 1);
        for (int32_t i = 0; i < coordinate_count(&b.f); i++) {
            b.f.shape[(b.f.shapes - 1) * coordinate_count(&b.f) + i] +=
                random_between(&random, -1e-7, 1e-7);
        }
        prepare(&b, method);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(!knows(method, s) || pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-5);
        }
        tug_baseline_destroy(b.baseline);
    }
}

/* The strip once more beside itself, without handles of its own. */
static void add_second_part(fixture *f)
{
    int32_t n = f->vertices, size = coordinate_count(f), F = f->triangles;
    for (int32_t s = f->shapes - 1; s >= 0; s--) {
        double *to = f->shape + (size_t)(2 * s * size);
        memmove(to, f->shape + (size_t)(s * size), (size_t)size * sizeof *to);
        for (int32_t i = 0; i < size; i++) {
            to[size + i] = to[i] + (i % 2 == 1 ? 2.0 + s : 0.0);
        }
    }
    memcpy(f->weight + n * f->weights, f->weight, (size_t)(n * f->weights) * sizeof *f->weight);
    memcpy(f->group + F, f->group, (size_t)F * sizeof *f->group);
    for (int32_t i = 0; i < 3 * F; i++) {
        f->triangle[3 * F + i] = f->triangle[i] + n;
    }
    f->vertices = 2 * n;
    f->triangles = 2 * F;
}

static void parts_without_handles_follow(void)
{
    for (int32_t method = 0; method < METHOD_COUNT; method++) {
        bench b;
        make_strip(&b.f);
        add_second_part(&b.f);
        prepare(&b, method);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(!knows(method, s) || pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-5);
        }
        tug_baseline_destroy(b.baseline);
    }
}

static int32_t likeliest_shape(const bench *b)
{
    int32_t best = 0;
    for (int32_t s = 1; s < b->f.shapes; s++) {
        best = b->blend[s] > b->blend[best] ? s : best;
    }
    return best;
}

/* E_d of shape s alone in the pose, with the best rotation of every group. */
static double measure_rigidity(const bench *b, int32_t s)
{
    double M[9 * MAX_GROUPS], blend[MAX_PAIRS] = {0}, rotations[9 * MAX_PAIRS] = {0};
    int32_t kk = b->f.dimension * b->f.dimension;
    find_moments(&b->f, s, b->positions, M);
    for (int32_t g = 0; g < b->f.groups; g++) {
        int32_t pair = g * b->f.shapes + s;
        blend[pair] = 1.0;
        closest_rotation(b->f.dimension, M + g * kk, rotations + pair * kk);
    }
    return measure_energy(&b->f, b->positions, blend, rotations);
}

static void single_shapes_are_rigid(void)
{
    uint64_t random = 34;
    for (int i = 0; i < 2 * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        prepare(&b, i / 3);
        for (int trial = 0; trial < 4; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            double energy = measure_rigidity(&b, likeliest_shape(&b));
            CHECK_NEAR(energy / b.info.objective, 1.0, 1e-5);
        }
        tug_baseline_destroy(b.baseline);
    }
}

/* The paper's steps and Newton's end in the same place, where they start near enough to it. */
static void local_and_global_steps_reach_newton(void)
{
    uint64_t random = 35;
    for (int i = 0; i < 2 * 3; i++) {
        bench b, paper;
        make_numbered(&b.f, i % 3);
        prepare(&b, i / 3);
        paper = b;
        tug_baseline_problem problem = problem_of(&b.f);
        paper.options.local_global = 1;
        paper.options.max_rounds = 20000;
        paper.options.tolerance = 1e-8;
        CHECK(tug_baseline_create(i / 3, &problem, &paper.options, &paper.baseline) == TUG_OK);
        apply_rows(&b.f, shape_of(&b.f, 0), b.targets);
        for (int32_t j = 0; j < b.f.rows * b.f.dimension; j++) {
            b.targets[j] += random_between(&random, -0.05, 0.05);
        }
        memcpy(paper.targets, b.targets, sizeof b.targets);
        CHECK(solve(&b) && solve(&paper));
        CHECK(is_sound(&paper) && paper.info.converged);
        CHECK(paper.info.rounds > b.info.rounds);
        CHECK(pose_distance(&b.f, b.positions, paper.positions) <= 1e-4);
        tug_baseline_destroy(b.baseline);
        tug_baseline_destroy(paper.baseline);
    }
}

/* The deformation gradients of MeshIK's triangles, of the groups (their best linear fit), or of the
 * triangles turned to the rest shape by their groups. */
static void take_features(const bench *b, feature_set *features)
{
    int32_t k = b->f.dimension, kk = k * k;
    tug_mesh *mesh = make_mesh(&b->f);
    double rest[9 * MAX_GROUPS], M[9 * MAX_GROUPS], A[9], F[9], Q[9], turned[9];
    find_moments(&b->f, 0, shape_of(&b->f, 0), rest);
    features_create(k, b->f.triangles, b->f.shapes, features);
    for (int32_t i = 0; i < b->f.shapes * b->f.triangles; i++) {
        int32_t s = i / b->f.triangles, t = i % b->f.triangles, g = b->f.group[t];
        find_moments(&b->f, 0, shape_of(&b->f, s), M);
        find_gradient(mesh, shape_of(&b->f, s), t, F);
        if (b->method == TUG_BASELINE_NONLINEAR_SHAPE_SPACE) {
            closest_rotation(k, M + g * kk, turned); /* the group's turn, which Q takes back */
            for (int32_t e = 0; e < kk; e++) {
                Q[e] = turned[e % k * k + e / k];
            }
            multiply(k, Q, F, turned);
            memcpy(F, turned, sizeof F);
        } else if (b->method == TUG_BASELINE_REDUCED_DEFORMABLE) {
            memcpy(A, rest + g * kk, sizeof A);
            memcpy(turned, M + g * kk, sizeof turned);
            solve_dense(A, k, turned, k);
            for (int32_t e = 0; e < kk; e++) {
                F[e] = turned[e % k * k + e / k];
            }
        }
        set_feature(features, t, s, F);
    }
    tug_destroy_mesh(mesh);
}

/* M p_0 and q of the edge opposite of a corner. */
static void take_edge(const bench *b, const double *M, int32_t corner, double *wanted, double *edge)
{
    int32_t k = b->f.dimension;
    const int32_t *triangle = b->f.triangle + corner / 3 * 3;
    int32_t from = triangle[(corner + 1) % 3] * k, to = triangle[(corner + 2) % 3] * k;
    for (int32_t a = 0; a < k; a++) {
        edge[a] = b->positions[to + a] - b->positions[from + a];
        wanted[a] = 0.0;
        for (int32_t c = 0; c < k; c++) {
            wanted[a] += M[a * k + c] * (b->f.shape[to + c] - b->f.shape[from + c]);
        }
    }
}

/* The groups' best rotations of what the weights w ask for onto the pose. */
static void fit_groups(const bench *b, const feature_set *features, const double *w, double *R)
{
    int32_t k = b->f.dimension, kk = k * k;
    double moments[9 * MAX_GROUPS] = {0}, M[9], wanted[3], edge[3];
    for (int32_t i = 0; i < 3 * b->f.triangles; i++) {
        blend_features(features, i / 3, w, M);
        take_edge(b, M, i, wanted, edge);
        for (int32_t e = 0; e < kk; e++) {
            moments[b->f.group[i / 3] * kk + e] +=
                edge_weight(&b->f, i) * wanted[e / k] * edge[e % k];
        }
    }
    for (int32_t g = 0; g < b->f.groups; g++) {
        identity_matrix(k, R + g * kk);
        if (b->method == TUG_BASELINE_NONLINEAR_SHAPE_SPACE) {
            closest_rotation(k, moments + g * kk, R + g * kk);
        }
    }
}

/* 1/2 sum c | q_e - R M(w) p_0e |^2 of the pose. */
static double measure_features(const bench *b, const feature_set *features, const double *w)
{
    int32_t k = b->f.dimension, kk = k * k;
    double R[9 * MAX_GROUPS], M[9], wanted[3], edge[3], none[3] = {0}, sum = 0.0;
    fit_groups(b, features, w, R);
    for (int32_t i = 0; i < 3 * b->f.triangles; i++) {
        blend_features(features, i / 3, w, M);
        take_edge(b, M, i, wanted, edge);
        move_points(k, R + b->f.group[i / 3] * kk, none, 1, wanted);
        for (int32_t a = 0; a < k; a++) {
            sum += 0.5 * edge_weight(&b->f, i) * (edge[a] - wanted[a]) * (edge[a] - wanted[a]);
        }
    }
    return sum;
}

/* In a pose of least energy the weights have no better either: from shape s to shape r the energy
 * does not fall, and where both can give it does not rise. */
static void weights_are_stationary(void)
{
    uint64_t random = 36;
    for (int i = 0; i < 3 * 3; i++) {
        bench b;
        feature_set features;
        make_numbered(&b.f, i % 3);
        prepare(&b, TUG_BASELINE_NONLINEAR_SHAPE_SPACE + i / 3);
        take_features(&b, &features);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        double energy = measure_features(&b, &features, b.blend);
        CHECK_NEAR(energy / b.info.objective, 1.0, 1e-4);
        for (int32_t pair = 0; pair < b.f.shapes * b.f.shapes; pair++) {
            int32_t s = pair / b.f.shapes, r = pair % b.f.shapes;
            double step = 1e-4, w[MAX_SHAPES];
            memcpy(w, b.blend, sizeof w);
            w[s] -= step;
            w[r] += step;
            if (s != r && (w[s] >= 0.0 || !bounds_weights(b.method))) {
                double rise = measure_features(&b, &features, w) - energy;
                CHECK(rise >= -1e-5 * step * energy);
            }
        }
        features_destroy(&features);
        tug_baseline_destroy(b.baseline);
    }
}

/* Half of firmness times the squared distances of the fixture's rows from the targets. */
static double measure_rows(const bench *b, double firmness)
{
    double rows[3 * MAX_WEIGHTS], sum = 0.0;
    apply_rows(&b->f, b->positions, rows);
    for (int32_t i = 0; i < b->f.rows * b->f.dimension; i++) {
        sum += 0.5 * firmness * (rows[i] - b->targets[i]) * (rows[i] - b->targets[i]);
    }
    return sum;
}

static void soften_rows(bench *b, double firmness)
{
    double each[MAX_WEIGHTS];
    for (int32_t r = 0; r < b->f.rows; r++) {
        each[r] = firmness;
    }
    tug_rows rows = {b->f.row_starts, b->f.row_vertices, b->f.row_values, b->f.rows};
    CHECK(tug_baseline_change_rows(b->baseline, &rows, each) == TUG_OK);
}

/* The objective of soft rows is that of the pose and of the rows; the firmer they are the more it
 * is, but no more than where they are pinned, and the nearer they come. */
static void rows_can_be_soft(void)
{
    uint64_t random = 38;
    for (int i = 0; i < 3; i++) {
        bench b;
        feature_set features;
        make_numbered(&b.f, i);
        prepare(&b, TUG_BASELINE_REDUCED_DEFORMABLE);
        take_features(&b, &features);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        double pinned = b.info.objective, last = 0.0, apart = INFINITY;
        for (double firmness = 1e-3; firmness <= 1e3; firmness *= 100.0) {
            soften_rows(&b, firmness);
            CHECK(solve(&b) && b.info.converged);
            double energy = measure_features(&b, &features, b.blend) + measure_rows(&b, firmness);
            CHECK_NEAR(energy / b.info.objective, 1.0, 1e-4);
            CHECK(b.info.objective > last && b.info.objective < pinned);
            CHECK(measure_rows(&b, 1.0) < apart);
            last = b.info.objective;
            apart = measure_rows(&b, 1.0);
        }
        CHECK_NEAR(last / pinned, 1.0, 1e-2);
        features_destroy(&features);
        tug_baseline_destroy(b.baseline);
    }
}

/* No vertex of MeshIK's pose can lower its energy. */
static void vertices_are_stationary(void)
{
    uint64_t random = 37;
    bench b;
    feature_set features;
    make_tube(&b.f, 1);
    prepare(&b, TUG_BASELINE_MESH_IK);
    take_features(&b, &features);
    mix_targets(&b.f, &random, 0.05, b.targets);
    CHECK(solve(&b));
    double energy = measure_features(&b, &features, b.blend);
    for (int trial = 0; trial < 100; trial++) {
        int32_t v = (int32_t)random_between(&random, 0.0, b.f.vertices), pinned = 0;
        for (int32_t h = 0; h < b.f.rows; h++) {
            pinned |= b.f.row_vertices[h] == v;
        }
        if (!pinned) {
            double kept = b.positions[3 * v], step = random_between(&random, -1e-3, 1e-3);
            b.positions[3 * v] += step;
            CHECK(measure_features(&b, &features, b.blend) > energy);
            b.positions[3 * v] = kept;
        }
    }
    features_destroy(&features);
    tug_baseline_destroy(b.baseline);
}

/* |H sum b p - Y|^2 does not fall from the optimum to any shape. */
static void blend_shapes_are_optimal(void)
{
    uint64_t random = 38;
    for (int i = 0; i < 3; i++) {
        bench b;
        double rows[MAX_SHAPES][3 * MAX_WEIGHTS], left[3 * MAX_WEIGHTS];
        make_numbered(&b.f, i);
        prepare(&b, TUG_BASELINE_BLEND_SHAPES);
        mix_targets(&b.f, &random, 0.1, b.targets);
        CHECK(solve(&b));
        memcpy(left, b.targets, sizeof left);
        int32_t length = b.f.rows * b.f.dimension;
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), rows[s]);
            for (int32_t j = 0; j < length; j++) {
                left[j] -= b.blend[s] * rows[s][j];
            }
        }
        for (int32_t s = 0; s < b.f.shapes; s++) {
            double slope = 0.0;
            for (int32_t j = 0; j < length; j++) {
                slope -= left[j] * (rows[s][j] + left[j] - b.targets[j]);
            }
            CHECK(slope >= -1e-6);
            CHECK(b.blend[s] <= 1e-6 || slope <= 1e-6);
        }
        tug_baseline_destroy(b.baseline);
    }
}

int main(int argc, char **argv)
{
    RUN(examples_come_back);
    RUN(linear_images_come_back);
    RUN(handles_hold_anywhere);
    RUN(rigid_motions_carry_over);
    RUN(poses_depend_on_nothing_else);
    RUN(duplicates_do_no_harm);
    RUN(parts_without_handles_follow);
    RUN(single_shapes_are_rigid);
    RUN(local_and_global_steps_reach_newton);
    RUN(weights_are_stationary);
    RUN(rows_can_be_soft);
    RUN(vertices_are_stationary);
    RUN(blend_shapes_are_optimal);
    return TEST_RESULT;
}
