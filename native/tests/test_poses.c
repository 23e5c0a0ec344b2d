/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Poses against what they promise: examples come back, rigid motions carry over, handles are hit,
 * in every form and from poor models too. */
#include "bench.h"
#include "dense/rotation.h"
#include "test.h"

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
    for (int i = 0; i < TURNING_FORM_COUNT * 3 * 5; i++) {
        bench b;
        double example[MAX_COORDINATES], R[9], offset[3] = {7.0, -5.0, 3.0};
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3 % TURNING_FORM_COUNT]);
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

static void examples_come_back_whatever_the_stiffness(void)
{
    uint64_t random = 21;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        vary_stiffness(&b.f, &random);
        prepare(&b, FORMS[i / 3]);
        CHECK(finds_examples(&b, 1e-6));
        clear(&b);
    }
}

/* Energy per area of the rest shape in the first half of the groups, over that in the others. */
static double softness_ratio(const bench *b)
{
    double energies[MAX_GROUPS], first = 0.0, second = 0.0;
    fixture plain = b->f;
    for (int32_t t = 0; t < plain.triangles; t++) {
        plain.stiffness[t] = 1.0;
    }
    measure_groups(&plain, b->positions, b->blend, b->rotations, energies);
    for (int32_t g = 0; g < plain.groups; g++) {
        *(2 * g < plain.groups ? &first : &second) += energies[g];
    }
    return first / second;
}

static void stiff_regions_deform_less(void)
{
    for (int i = 0; i < 3; i++) {
        bench b, stiff;
        make_numbered(&b.f, i);
        b.f.shapes = 1;
        stiff.f = b.f;
        for (int32_t t = 0; t < b.f.triangles; t++) {
            stiff.f.stiffness[t] = 2 * b.f.group[t] < b.f.groups ? 20.0 : 1.0;
        }
        prepare(&b, TUG_FORM_STEADY);
        prepare(&stiff, TUG_FORM_STEADY);
        apply_rows(&b.f, b.f.shape, b.targets);
        b.targets[b.f.rows * b.f.dimension - 1] += 0.3 * diagonal_of(&b.f);
        memcpy(stiff.targets, b.targets, sizeof b.targets);
        CHECK(solve(&b) && solve(&stiff));
        CHECK(constraint_error(&stiff) <= 1e-10);
        CHECK(softness_ratio(&stiff) < 0.5 * softness_ratio(&b));
        clear(&b);
        clear(&stiff);
    }
}

/* Twice as stiff everywhere is the same pose at twice the energy. */
static void even_stiffness_moves_nothing(void)
{
    uint64_t random = 22;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b, stiff;
        make_numbered(&b.f, i % 3);
        stiff.f = b.f;
        for (int32_t t = 0; t < b.f.triangles; t++) {
            stiff.f.stiffness[t] = 2.0;
        }
        prepare(&b, FORMS[i / 3]);
        prepare(&stiff, FORMS[i / 3]);
        mix_targets(&b.f, &random, 0.03, b.targets);
        memcpy(stiff.targets, b.targets, sizeof b.targets);
        CHECK(solve(&b) && solve(&stiff));
        CHECK(pose_distance(&b.f, b.positions, stiff.positions) <= 1e-6);
        CHECK_NEAR(stiff.info.energy / b.info.energy, 2.0, 1e-5);
        clear(&b);
        clear(&stiff);
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
    for (int i = 0; i < TURNING_FORM_COUNT * 3 * 4; i++) {
        bench b;
        double pose[MAX_COORDINATES], R[9], offset[3];
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3 % TURNING_FORM_COUNT]);
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

static void single_blend_is_one_for_all_groups(void)
{
    uint64_t random = 7;
    for (int i = 0; i < FORM_COUNT * 3; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3]);
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
        CHECK(b.info.converged);
        CHECK_NEAR(energy_of(&b), 0.0, 1e-4); /* all shapes cost nothing: a prior between them */
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

int main(int argc, char **argv)
{
    RUN(examples_come_back);
    RUN(turned_examples_come_back);
    RUN(broad_weights_keep_the_promises);
    RUN(examples_come_back_from_poor_dictionaries);
    RUN(examples_come_back_whatever_the_stiffness);
    RUN(stiff_regions_deform_less);
    RUN(even_stiffness_moves_nothing);
    RUN(handles_are_hit);
    RUN(rigid_motions_carry_over);
    RUN(translations_carry_over_without_rotations);
    RUN(single_blend_is_one_for_all_groups);
    RUN(free_handles_follow);
    RUN(rows_of_several_vertices_are_kept);
    RUN(unit_and_place_of_the_model_do_not_count);
    RUN(one_handle_gives_a_pose);
    RUN(handles_in_one_point_give_a_pose);
    RUN(one_shape_and_one_group_are_enough);
    return TEST_RESULT;
}
