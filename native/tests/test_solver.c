/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Poses against what they promise: examples come back, rigid motions carry over, handles are hit,
 * the past leaves no trace. Energies and objectives are computed anew from the pose. */
#include "fixture.h"
#include "memory.h"
#include "rotation.h"
#include "test.h"

static const int32_t FORMS[] = {TUG_FORM_STEADY, TUG_FORM_PAPER, TUG_FORM_NO_ROTATIONS};

enum { FORM_COUNT = 3 };

static int make_numbered(fixture *f, int i)
{
    switch (i) {
    case 0:
        make_strip(f);
        break;
    case 1:
        make_tube(f, 0);
        break;
    case 2:
        make_tube(f, 1);
        break;
    default:
        return 0;
    }
    return 1;
}

/* A solver and all that it says about its last pose. */
typedef struct bench {
    fixture f;
    tug_model *model;
    tug_solver *solver;
    tug_solver_options options;
    tug_solve_info info;
    double targets[3 * MAX_WEIGHTS];
    double positions[MAX_COORDINATES], blend[MAX_PAIRS], costs[MAX_PAIRS], rotations[9 * MAX_PAIRS];
} bench;

/* The fixture is in place; options are the defaults of a form. */
static void prepare(bench *b, int32_t form)
{
    b->model = make_model(&b->f);
    b->solver = NULL;
    tug_default_solver_options(&b->options);
    b->options.form = form;
}

static void clear(bench *b)
{
    tug_destroy_solver(b->solver);
    tug_destroy_model(b->model);
}

static void restart(bench *b)
{
    tug_destroy_solver(b->solver);
    tug_create_solver(b->model, &b->options, &b->solver);
}

/* Solve for the targets; 0 where a call fails. */
static int solve(bench *b)
{
    if (b->solver == NULL) {
        restart(b);
    }
    b->info = (tug_solve_info){.struct_size = sizeof b->info};
    return tug_solve(b->solver, b->targets, &b->info) == TUG_OK &&
           tug_get_positions(b->solver, b->positions) == TUG_OK &&
           tug_get_blend(b->solver, b->blend) == TUG_OK &&
           tug_get_costs(b->solver, b->costs) == TUG_OK &&
           tug_get_rotations(b->solver, b->rotations) == TUG_OK;
}

static int is_sound(const bench *b)
{
    const fixture *f = &b->f;
    int32_t k = f->dimension;
    double product[9], I[9];
    identity_matrix(k, I);
    for (int32_t i = 0; i < f->groups * f->shapes; i++) {
        const double *R = b->rotations + i * k * k;
        multiply_nt(k, R, R, product);
        for (int32_t e = 0; e < k * k; e++) {
            if (!(fabs(product[e] - I[e]) < 1e-12)) {
                return 0;
            }
        }
        if (!(b->blend[i] >= 0.0 && b->costs[i] >= 0.0)) {
            return 0;
        }
    }
    for (int32_t g = 0; g < f->groups; g++) {
        double sum = 0.0;
        for (int32_t s = 0; s < f->shapes; s++) {
            sum += b->blend[g * f->shapes + s];
        }
        if (!(fabs(sum - 1.0) < 1e-12)) {
            return 0;
        }
    }
    return 1;
}

/* Largest distance of a handle from its target, in parts of the diagonal. */
static double constraint_error(const bench *b)
{
    double values[3 * MAX_WEIGHTS], largest = 0.0;
    apply_rows(&b->f, b->positions, values);
    for (int32_t i = 0; i < b->f.rows * b->f.dimension; i++) {
        largest = fmax(largest, fabs(values[i] - b->targets[i]));
    }
    return largest / diagonal_of(&b->f);
}

/* E_d of the pose, from the edges. */
static double energy_of(const bench *b)
{
    return measure_energy(&b->f, b->positions, b->blend, b->rotations);
}

/* lambda times what the blend costs. A single blend pays for whole shapes. */
static double price_of(const bench *b)
{
    int32_t S = b->f.shapes, n = b->f.groups * S;
    double sum = 0.0;
    for (int32_t i = 0; i < n && !b->options.single_blend; i++) {
        sum += b->blend[i] * b->costs[i];
    }
    for (int32_t s = 0; s < S && b->options.single_blend; s++) {
        double whole = 0.0;
        for (int32_t i = s; i < n; i += S) {
            whole += b->options.squared ? b->costs[i] : b->costs[i] * b->costs[i];
        }
        sum += b->blend[s] * (b->options.squared ? whole : sqrt(whole));
    }
    return b->options.lambda * sum;
}

static void examples_come_back(void)
{
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3]);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b));
            CHECK(b.info.converged);
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
            for (int32_t g = 0; g < b.f.groups; g++) {
                CHECK(b.blend[g * b.f.shapes + s] >= 0.99);
                CHECK_NEAR(b.costs[g * b.f.shapes + s], 0.0, 1e-5 * diagonal_of(&b.f));
            }
            CHECK_NEAR(b.info.objective, 0.0, 1e-6 * diagonal_of(&b.f));
            CHECK_NEAR(b.info.gap, 0.0, 1e-6 * diagonal_of(&b.f));
        }
        clear(&b);
    }
}

static void turned_examples_come_back(void)
{
    uint64_t random = 19;
    for (int i = 0; i < 2 * 3 * 5; i++) {
        bench b;
        double example[MAX_COORDINATES], R[9], offset[3] = {7.0, -5.0, 3.0};
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3 % 2]);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            memcpy(example, shape_of(&b.f, s), (size_t)coordinate_count(&b.f) * sizeof *example);
            random_rotation(&random, b.f.dimension, R);
            move_points(b.f.dimension, R, offset, b.f.vertices, example);
            apply_rows(&b.f, example, b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(pose_distance(&b.f, b.positions, example) <= 1e-6);
        }
        clear(&b);
    }
}

/* Far from well conditioned: digits are lost, but not the promise. */
static void broad_weights_keep_the_promises(void)
{
    uint64_t random = 20;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        broaden_weights(&b.f);
        prepare(&b, FORMS[i / 3]);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && b.info.converged);
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-5);
            CHECK_NEAR(b.info.gap, 0.0, 1e-5 * diagonal_of(&b.f));
        }
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b) && constraint_error(&b) <= 1e-9);
            CHECK_NEAR(b.info.energy / energy_of(&b), 1.0, 1e-3);
        }
        clear(&b);
    }
}

/* The strip in space and a shape that is there twice: the pose is still the example's, whatever the
 * blend. */
static void examples_come_back_from_poor_dictionaries(void)
{
    for (int i = 0; i < FORM_COUNT * 2; i++) {
        bench b;
        i % 2 ? make_flat(&b.f) : make_tube(&b.f, 1);
        duplicate_shape(&b.f, 1);
        prepare(&b, FORMS[i / 2]);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b));
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
        }
        clear(&b);
    }
}

static void handles_are_hit(void)
{
    uint64_t random = 1;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3]);
        for (int trial = 0; trial < 10; trial++) {
            mix_targets(&b.f, &random, 0.1, b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b));
            CHECK(constraint_error(&b) <= 1e-10);
        }
        clear(&b);
    }
}

static void rigid_motions_carry_over(void)
{
    uint64_t random = 2;
    for (int i = 0; i < 2 * 3 * 4; i++) {
        bench b;
        double pose[MAX_COORDINATES], R[9], offset[3];
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3 % 2]);
        int32_t k = b.f.dimension;
        mix_targets(&b.f, &random, 0.03, b.targets);
        CHECK(solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        random_rotation(&random, k, R);
        for (int32_t a = 0; a < k; a++) {
            offset[a] = random_between(&random, -20.0, 20.0);
        }
        move_points(k, R, offset, b.f.vertices, pose);
        move_points(k, R, offset, b.f.rows, b.targets);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, pose, b.positions) <= 1e-7);
        clear(&b);
    }
}

static void translations_carry_over_without_rotations(void)
{
    uint64_t random = 3;
    bench b;
    double pose[MAX_COORDINATES], I[9], offset[] = {5.0, -7.0, 11.0};
    make_tube(&b.f, 0);
    prepare(&b, TUG_FORM_NO_ROTATIONS);
    mix_targets(&b.f, &random, 0.1, b.targets);
    CHECK(solve(&b));
    memcpy(pose, b.positions, sizeof pose);
    identity_matrix(3, I);
    for (int32_t i = 0; i < b.f.groups * b.f.shapes; i++) {
        CHECK(angle_between(3, b.rotations + 9 * i, I) < 1e-13);
    }
    move_points(3, I, offset, b.f.vertices, pose);
    move_points(3, I, offset, b.f.rows, b.targets);
    CHECK(solve(&b));
    CHECK(pose_distance(&b.f, pose, b.positions) <= 1e-9);
    clear(&b);
}

/* Settings number i: of form, root, one blend or many; there are 12. */
static void choose_settings(bench *b, int i)
{
    b->options.form = FORMS[i % 3];
    b->options.squared = i / 3 % 2;
    b->options.single_blend = i / 6 % 2;
}

static void energy_is_that_of_the_pose(void)
{
    uint64_t random = 4;
    for (int i = 0; i < 36; i++) {
        bench b;
        make_numbered(&b.f, i / 12);
        prepare(&b, 0);
        choose_settings(&b, i);
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            CHECK(is_sound(&b));
            CHECK_NEAR(b.info.energy / energy_of(&b), 1.0, 1e-6);
        }
        clear(&b);
    }
}

static void objective_is_root_of_energy_and_price(void)
{
    uint64_t random = 5;
    for (int i = 0; i < 36; i++) {
        bench b;
        make_numbered(&b.f, i / 12);
        prepare(&b, 0);
        choose_settings(&b, i);
        b.options.prior = 0.0;
        b.options.lambda = 0.3;
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            double energy = energy_of(&b);
            double objective = (b.options.squared ? energy : sqrt(energy)) + price_of(&b);
            CHECK_NEAR(b.info.objective / objective, 1.0, 1e-6);
        }
        clear(&b);
    }
}

/* With a prior the objective is more, and never more than at the prior's own rotations. */
static void prior_only_adds_to_the_objective(void)
{
    uint64_t random = 6;
    bench b;
    make_tube(&b.f, 0);
    prepare(&b, TUG_FORM_STEADY);
    for (int trial = 0; trial < 20; trial++) {
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        double energy = energy_of(&b);
        CHECK(b.info.objective >= sqrt(energy) + price_of(&b) - 1e-9);
        CHECK_NEAR(b.info.energy / energy, 1.0, 1e-6);
    }
    clear(&b);
}

static void single_blend_is_one_for_all_groups(void)
{
    uint64_t random = 7;
    for (int i = 0; i < 9; i++) {
        bench b;
        make_numbered(&b.f, i / 3);
        prepare(&b, FORMS[i % 3]);
        b.options.single_blend = 1;
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            for (int32_t g = 1; g < b.f.groups; g++) {
                CHECK(memcmp(b.blend + g * b.f.shapes, b.blend,
                             (size_t)b.f.shapes * sizeof *b.blend) == 0);
            }
        }
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(b.blend[s] >= 0.99);
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
        }
        clear(&b);
    }
}

static void steady_solves_converge(void)
{
    uint64_t random = 8;
    for (int i = 0; i < 3; i++) {
        bench b;
        make_numbered(&b.f, i);
        prepare(&b, TUG_FORM_STEADY);
        for (int trial = 0; trial < 100; trial++) {
            mix_targets(&b.f, &random, trial % 3 * 0.05, b.targets);
            CHECK(solve(&b));
            CHECK(b.info.converged);
            CHECK(b.info.rounds <= 40);
            CHECK(b.info.residual <= b.options.tolerance);
            CHECK(b.info.gap >= 0.0 && b.info.gap <= 1e-6 * b.info.objective + 1e-9);
            CHECK(b.info.increase == 0.0);
            CHECK(is_sound(&b));
        }
        clear(&b);
    }
}

static void steady_rounds_lower_the_objective(void)
{
    uint64_t random = 9;
    for (int trial = 0; trial < 10; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_STEADY);
        mix_targets(&b.f, &random, 0.1, b.targets);
        double before = INFINITY;
        b.info.converged = 0;
        for (b.options.max_rounds = 1; b.options.max_rounds < 40 && !b.info.converged;
             b.options.max_rounds++) {
            restart(&b);
            CHECK(solve(&b));
            CHECK(b.info.objective <= before + 1e-12);
            before = b.info.objective;
        }
        CHECK(b.info.converged && b.options.max_rounds > 3);
        clear(&b);
    }
}

/* phi(R) = min over B and T, at rotations beside those of the pose, is no lower. */
static void steady_pose_is_a_minimum(void)
{
    uint64_t random = 10;
    for (int trial = 0; trial < 6; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_STEADY);
        b.options.prior = 0.0;
        b.options.squared = 1; /* E + lambda d B: linear in what is mixed below */
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        double least = energy_of(&b) + price_of(&b);
        int32_t k = b.f.dimension, S = b.f.shapes;
        for (int other = 0; other < 50; other++) {
            bench moved = b;
            double mixed[MAX_PAIRS], w[3], size = pow(10.0, random_between(&random, -5.0, -1.0));
            random_blend(&random, b.f.groups, S, mixed);
            for (int32_t j = 0; j < b.f.groups * S; j++) {
                moved.blend[j] = size * mixed[j] + (1.0 - size) * b.blend[j];
                for (int32_t a = 0; a < 3 && j % S == 0; a++) {
                    w[a] = random_between(&random, -size, size);
                }
                turn(k, w, moved.rotations + j * k * k);
            }
            CHECK(energy_of(&moved) + price_of(&moved) >= least * (1.0 - 1e-7));
        }
        clear(&b);
    }
}

static void the_past_leaves_no_trace(void)
{
    uint64_t random = 11;
    for (int i = 0; i < 36; i++) {
        bench b;
        double first[MAX_COORDINATES], first_targets[3 * MAX_WEIGHTS];
        make_numbered(&b.f, i / 12);
        prepare(&b, 0);
        choose_settings(&b, i);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        memcpy(first, b.positions, sizeof first);
        memcpy(first_targets, b.targets, sizeof first_targets);
        for (int other = 0; other < 2; other++) {
            mix_targets(&b.f, &random, 0.2, b.targets);
            CHECK(solve(&b));
            CHECK(pose_distance(&b.f, b.positions, first) > 1e-3);
        }
        memcpy(b.targets, first_targets, sizeof first_targets);
        CHECK(solve(&b));
        CHECK(memcmp(first, b.positions, (size_t)coordinate_count(&b.f) * sizeof *first) == 0);
        restart(&b);
        CHECK(solve(&b));
        CHECK(memcmp(first, b.positions, (size_t)coordinate_count(&b.f) * sizeof *first) == 0);
        clear(&b);
    }
}

static void warm_starts_end_at_the_same_pose(void)
{
    uint64_t random = 12;
    for (int i = 0; i < 3; i++) {
        bench cold, warm;
        make_numbered(&cold.f, i);
        warm.f = cold.f;
        prepare(&cold, TUG_FORM_STEADY);
        prepare(&warm, TUG_FORM_STEADY);
        warm.options.warm_start = 1;
        for (int trial = 0; trial < 20; trial++) {
            mix_targets(&cold.f, &random, 0.02, cold.targets);
            memcpy(warm.targets, cold.targets, sizeof warm.targets);
            CHECK(solve(&cold) && solve(&warm));
            CHECK(warm.info.converged);
            CHECK(pose_distance(&cold.f, cold.positions, warm.positions) <= 1e-5);
        }
        int32_t rounds = warm.info.rounds;
        CHECK(solve(&warm));
        CHECK(rounds > 1 && warm.info.rounds == 1); /* it started where it had ended */
        clear(&cold);
        clear(&warm);
    }
}

static void free_handles_follow(void)
{
    for (int i = 0; i < FORM_COUNT; i++) {
        bench b;
        uint64_t random = 13;
        make_tube(&b.f, 1);
        free_last_handle(&b.f);
        prepare(&b, FORMS[i]);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
        }
        mix_targets(&b.f, &random, 0.1, b.targets);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && constraint_error(&b) <= 1e-10);
        clear(&b);
    }
}

/* A row that is the mean of three vertices. */
static void rows_of_several_vertices_are_kept(void)
{
    uint64_t random = 14;
    bench b;
    make_tube(&b.f, 0);
    const int32_t vertices[] = {0, 4, 7, 72, 153, 239}, starts[] = {0, 3, 4, 5, 6};
    const double values[] = {0.5, 0.25, 0.25, 1.0, 1.0, 1.0};
    memcpy(b.f.row_vertices, vertices, sizeof vertices);
    memcpy(b.f.row_starts, starts, sizeof starts);
    memcpy(b.f.row_values, values, sizeof values);
    prepare(&b, TUG_FORM_STEADY);
    for (int trial = 0; trial < 5; trial++) {
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        CHECK(constraint_error(&b) <= 1e-10);
        CHECK_NEAR(b.info.energy / energy_of(&b), 1.0, 1e-6);
    }
    clear(&b);
}

static void unit_and_place_of_the_model_do_not_count(void)
{
    const double factors[] = {1e-3, 1e3, 1.0}, places[] = {0.0, 0.0, 1e3};
    for (int i = 0; i < 9; i++) {
        bench b, other;
        uint64_t random = 15;
        double factor = factors[i % 3], offset = places[i % 3], I[9], along[3];
        make_numbered(&b.f, i / 3);
        other.f = b.f;
        offset *= diagonal_of(&b.f);
        rescale(&other.f, factor, offset);
        prepare(&b, TUG_FORM_STEADY);
        prepare(&other, TUG_FORM_STEADY);
        identity_matrix(b.f.dimension, I);
        for (int32_t a = 0; a < b.f.dimension; a++) {
            I[a * (b.f.dimension + 1)] = factor;
            along[a] = offset;
        }
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            memcpy(other.targets, b.targets, sizeof b.targets);
            move_points(b.f.dimension, I, along, b.f.rows, other.targets);
            CHECK(solve(&b) && solve(&other));
            move_points(b.f.dimension, I, along, b.f.vertices, b.positions);
            CHECK(pose_distance(&other.f, b.positions, other.positions) <= 1e-7);
            CHECK_NEAR(other.info.objective / factor / b.info.objective, 1.0, 1e-7);
            CHECK_NEAR(other.info.energy / factor / factor / b.info.energy, 1.0, 1e-6);
        }
        clear(&b);
        clear(&other);
    }
}

static void one_handle_gives_a_pose(void)
{
    for (int i = 0; i < FORM_COUNT; i++) {
        bench b;
        make_strip(&b.f);
        b.f.rows = 1;
        prepare(&b, FORMS[i]);
        memcpy(b.targets, (double[]){3.0, 4.0}, 2 * sizeof(double));
        CHECK(solve(&b));
        CHECK(is_sound(&b) && constraint_error(&b) <= 1e-10);
        CHECK_NEAR(energy_of(&b), 0.0, 1e-4);
        clear(&b);
    }
}

static void handles_in_one_point_give_a_pose(void)
{
    for (int i = 0; i < FORM_COUNT * 2; i++) {
        bench b;
        i % 2 ? make_tube(&b.f, 1) : make_strip(&b.f);
        prepare(&b, FORMS[i / 2]);
        memset(b.targets, 0, sizeof b.targets);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && constraint_error(&b) <= 1e-10);
        CHECK_NEAR(b.info.energy / energy_of(&b), 1.0, 1e-6);
        clear(&b);
    }
}

static void one_shape_and_one_group_are_enough(void)
{
    uint64_t random = 16;
    for (int i = 0; i < FORM_COUNT * 2; i++) {
        bench b;
        i % 2 ? make_tube(&b.f, 1) : make_strip(&b.f);
        b.f.shapes = 1;
        b.f.groups = 1;
        memset(b.f.group, 0, sizeof b.f.group);
        prepare(&b, FORMS[i / 2]);
        apply_rows(&b.f, b.f.shape, b.targets);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, b.positions, b.f.shape) <= 1e-6);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && b.info.converged && constraint_error(&b) <= 1e-10);
        CHECK(b.blend[0] == 1.0);
        clear(&b);
    }
}

static void solving_allocates_nothing(void)
{
    uint64_t random = 17;
    for (int i = 0; i < 12; i++) {
        bench b;
        make_tube(&b.f, 1);
        prepare(&b, 0);
        choose_settings(&b, i);
        restart(&b);
        long before = total_allocations();
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.1, b.targets);
            CHECK(solve(&b));
        }
        CHECK(total_allocations() == before);
        clear(&b);
    }
}

static void targets_that_are_not_finite_leave_the_pose(void)
{
    bench b;
    double before[MAX_COORDINATES];
    uint64_t random = 18;
    make_tube(&b.f, 1);
    prepare(&b, TUG_FORM_STEADY);
    mix_targets(&b.f, &random, 0.1, b.targets);
    CHECK(solve(&b));
    memcpy(before, b.positions, sizeof before);
    b.targets[4] = NAN;
    CHECK(tug_solve(b.solver, b.targets, &b.info) == TUG_ERROR_ARGUMENT);
    CHECK(strstr(tug_error_text(), "row 1") != NULL);
    CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
    CHECK(memcmp(before, b.positions, (size_t)coordinate_count(&b.f) * sizeof *before) == 0);
    clear(&b);
}

int main(int argc, char **argv)
{
    RUN(examples_come_back);
    RUN(examples_come_back_from_poor_dictionaries);
    RUN(turned_examples_come_back);
    RUN(broad_weights_keep_the_promises);
    RUN(handles_are_hit);
    RUN(rigid_motions_carry_over);
    RUN(translations_carry_over_without_rotations);
    RUN(energy_is_that_of_the_pose);
    RUN(objective_is_root_of_energy_and_price);
    RUN(prior_only_adds_to_the_objective);
    RUN(single_blend_is_one_for_all_groups);
    RUN(steady_solves_converge);
    RUN(steady_rounds_lower_the_objective);
    RUN(steady_pose_is_a_minimum);
    RUN(the_past_leaves_no_trace);
    RUN(warm_starts_end_at_the_same_pose);
    RUN(free_handles_follow);
    RUN(rows_of_several_vertices_are_kept);
    RUN(unit_and_place_of_the_model_do_not_count);
    RUN(one_handle_gives_a_pose);
    RUN(handles_in_one_point_give_a_pose);
    RUN(one_shape_and_one_group_are_enough);
    RUN(solving_allocates_nothing);
    RUN(targets_that_are_not_finite_leave_the_pose);
    return TEST_RESULT;
}
