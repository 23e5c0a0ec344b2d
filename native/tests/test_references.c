/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energies of Shtern et al. (F 7-19), from their sums over edges: what the forms find is their
 * minimum in rotations, scale and pose, every round lowers them, and the size of the targets comes
 * out. */
#include "bench.h"
#include "dense/rotation.h"
#include "memory.h"
#include "refusal.h"
#include "test.h"

enum { NEW_FORM_COUNT = 3 };
static const int32_t NEW_FORMS[] = {TUG_FORM_AVERAGE, TUG_FORM_MINIMAL, TUG_FORM_CLOSEST};

/* E_sc of (F 7) for one shape: the poses' edges against scale R_gs p_se. */
static double energy_of_shape(const bench *b, int32_t s, double scale)
{
    double blend[MAX_PAIRS] = {0};
    for (int32_t g = 0; g < b->f.groups; g++) {
        blend[g * b->f.shapes + s] = scale;
    }
    return measure_energy(&b->f, b->positions, blend, b->rotations);
}

/* (F 9), or the term of (F 12) that the form has chosen. */
static double reference_energy(const bench *b, double scale)
{
    double sum = 0.0;
    for (int32_t s = 0; s < b->f.shapes; s++) {
        sum += b->blend[s] > 0.0 ? b->blend[s] * energy_of_shape(b, s, scale) : 0.0;
    }
    return sum;
}

static double scale_of(const bench *b)
{
    double scale = 0.0;
    tug_get_scale(b->solver, &scale);
    return scale;
}

static void prepare_numbered(bench *b, int i, uint64_t *random)
{
    make_numbered(&b->f, i % 3);
    prepare(b, NEW_FORMS[i / 3 % NEW_FORM_COUNT]);
    b->options.scale = i / 3 / NEW_FORM_COUNT % 2;
    mix_targets(&b->f, random, 0.05, b->targets);
}

static void energies_are_those_of_the_pose(void)
{
    uint64_t random = 3;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b;
        prepare_numbered(&b, i, &random);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && constraint_error(&b) <= 1e-9);
        double energy = reference_energy(&b, scale_of(&b));
        CHECK_NEAR(b.info.energy / energy, 1.0, 1e-6);
        CHECK(b.info.objective >= b.info.energy && b.info.objective <= 1.001 * b.info.energy);
        CHECK(b.options.scale || scale_of(&b) == 1.0);
        for (int32_t j = 0; j < b.f.groups * b.f.shapes; j++) {
            CHECK(b.blend[j] == b.blend[j % b.f.shapes]);
            CHECK(b.options.form == TUG_FORM_AVERAGE ? fabs(b.blend[j] * b.f.shapes - 1.0) < 1e-15
                                                     : b.blend[j] * (1.0 - b.blend[j]) == 0.0);
        }
        clear(&b);
    }
}

static void rounds_lower_the_energies(void)
{
    uint64_t random = 4;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b;
        double before = INFINITY;
        prepare_numbered(&b, i, &random);
        if (b.options.form == TUG_FORM_CLOSEST) { /* falls from the second round on only */
            clear(&b);
            continue;
        }
        for (b.options.max_rounds = 1; b.options.max_rounds <= 40; b.options.max_rounds++) {
            restart(&b);
            CHECK(solve(&b));
            CHECK(b.info.objective <= before * (1.0 + 1e-12));
            before = b.info.objective;
        }
        clear(&b);
    }
}

static void the_closest_falls_from_its_choice_on(void)
{
    uint64_t random = 5;
    for (int i = 0; i < 6; i++) {
        bench b;
        double before = INFINITY;
        prepare_numbered(&b, i, &random);
        b.options.form = TUG_FORM_CLOSEST;
        b.options.scale = i / 3;
        b.options.tolerance = 1e-300;
        for (b.options.max_rounds = 2; b.options.max_rounds <= 12; b.options.max_rounds++) {
            restart(&b);
            CHECK(solve(&b));
            CHECK(b.info.rounds == b.options.max_rounds);
            CHECK(b.info.objective <= before * (1.0 + 1e-12));
            before = b.info.objective;
        }
        b.options.max_rounds = 0;
        restart(&b);
        CHECK(solve(&b) && b.info.rounds == 10);
        clear(&b);
    }
}

/* Nothing beside it is lower: rotations turned, another scale, positions moved within the
 * dictionary and its rows. By central differences the gradient is zero. */
static void the_answer_is_a_minimum(void)
{
    uint64_t random = 6;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b, moved;
        prepare_numbered(&b, i, &random);
        b.options.max_rounds = 2000;
        CHECK(solve(&b) && b.info.converged && b.info.rounds < 300);
        double scale = scale_of(&b), least = reference_energy(&b, scale), step = 1e-4;
        for (int trial = 0; trial < 20; trial++) {
            double values[2], other_scale = b.options.scale ? random_between(&random, -1, 1) : 0.0;
            double w[MAX_PAIRS * 3];
            for (int32_t j = 0; j < b.f.groups * b.f.shapes * 3; j++) {
                w[j] = step * random_between(&random, -1.0, 1.0);
            }
            moved = b;
            mix_targets(&b.f, &random, 0.0, moved.targets);
            moved.solver = NULL;
            CHECK(solve(&moved)); /* some pose of the dictionary */
            tug_destroy_solver(moved.solver);
            bench other = moved;
            memcpy(other.targets, b.targets, sizeof b.targets);
            CHECK(tug_pose(b.solver, b.targets, moved.blend, moved.rotations) == TUG_OK);
            CHECK(tug_get_positions(b.solver, other.positions) == TUG_OK); /* of these rows */
            for (int side = 0; side < 2; side++) {
                double sign = side ? 1.0 : -1.0;
                moved = b;
                for (int32_t j = 0; j < b.f.groups * b.f.shapes; j++) {
                    double turned[3] = {sign * w[3 * j], sign * w[3 * j + 1], sign * w[3 * j + 2]};
                    turn(b.f.dimension, turned,
                         moved.rotations + j * b.f.dimension * b.f.dimension);
                }
                for (int32_t c = 0; c < coordinate_count(&b.f); c++) {
                    moved.positions[c] += sign * step * (other.positions[c] - b.positions[c]);
                }
                values[side] = reference_energy(&moved, scale + sign * step * other_scale);
                CHECK(values[side] >= least * (1.0 - 1e-9));
            }
            CHECK_NEAR((values[1] - values[0]) / (2.0 * step) / least, 0.0, 1e-3);
        }
        clear(&b);
    }
}

/* (F 16) is printed as a sum over a ratio. What minimises (F 11) in alpha alone is the ratio of two
 * sums, and there its derivative by finite differences is zero. */
static void scale_is_a_ratio_of_sums(void)
{
    uint64_t random = 7;
    for (int i = 0; i < 3; i++) {
        bench b;
        prepare_numbered(&b, i, &random);
        b.options.scale = 1;
        CHECK(solve(&b));
        double pulled = 0.0, squares = 0.0, printed = 0.0, M[9 * MAX_GROUPS], own[9 * MAX_GROUPS];
        int32_t k = b.f.dimension, kk = k * k, S = b.f.shapes;
        for (int32_t s = 0; s < S; s++) {
            double pull = 0.0, square = 0.0;
            find_moments(&b.f, s, b.positions, M);
            find_moments(&b.f, s, shape_of(&b.f, s), own);
            for (int32_t g = 0; g < b.f.groups; g++) {
                pull += trace_of_product(k, b.rotations + (g * S + s) * kk, M + g * kk);
                for (int32_t a = 0; a < k; a++) {
                    square += own[g * kk + a * k + a];
                }
            }
            pulled += pull;
            squares += square;
            printed += pull / square / S;
        }
        double scale = scale_of(&b), step = 1e-4 * scale;
        CHECK_NEAR(pulled / squares / scale, 1.0, 1e-5);
        double slope = reference_energy(&b, scale + step) - reference_energy(&b, scale - step);
        CHECK_NEAR(slope / (2.0 * step) / b.info.energy, 0.0, 1e-4);
        CHECK(reference_energy(&b, printed) > reference_energy(&b, scale));
        CHECK(fabs(printed / scale - 1.0) > 1e-4);
        clear(&b);
    }
}

/* Energies are not divided by the scale: with targets in the shapes' size, and the energy back in
 * the targets', no fixed one does better than the one that is found. */
static void no_other_scale_is_better(void)
{
    uint64_t random = 16;
    for (int i = 0; i < 3 * 2; i++) {
        bench b;
        double targets[3 * MAX_WEIGHTS];
        prepare_numbered(&b, i, &random);
        b.options.scale = 1;
        CHECK(b.options.form != TUG_FORM_CLOSEST && solve(&b) && b.info.converged);
        double least = b.info.energy, scale = scale_of(&b);
        memcpy(targets, b.targets, sizeof targets);
        b.options.scale = 0;
        restart(&b);
        for (int step = -4; step <= 4; step++) {
            double fixed = scale * (1.0 + 0.1 * step);
            for (int32_t c = 0; c < b.f.rows * b.f.dimension; c++) {
                b.targets[c] = targets[c] / fixed;
            }
            CHECK(solve(&b) && b.info.converged);
            double energy = fixed * fixed * b.info.energy / least;
            CHECK(step == 0 ? fabs(energy - 1.0) < 1e-6 : energy > 1.0 + 1e-6);
        }
        clear(&b);
    }
}

/* By Newton's method, however far the shapes are from the targets: local and global steps alone
 * take hundreds, and Newton's without the scale's part of the Hessian some more. */
static void single_shapes_converge_soon(void)
{
    uint64_t random = 17;
    for (int i = 0; i < 3 * 2 * 2 * 4; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        prepare(&b, i / 3 % 2 ? TUG_FORM_CLOSEST : TUG_FORM_MINIMAL);
        b.options.scale = i / 6 % 2;
        b.options.max_rounds = 200;
        b.options.tolerance = 1e-9;
        mix_targets(&b.f, &random, 0.3, b.targets);
        CHECK(solve(&b));
        CHECK(b.info.converged && b.info.rounds <= 23);
        clear(&b);
    }
}

/* Each of the energies of (F 12), from a solver that has the others' shapes in the dictionary but
 * is told to start anywhere: the smallest of all is the form's. */
static void the_minimum_is_the_smallest(void)
{
    uint64_t random = 8;
    for (int i = 0; i < 12; i++) {
        bench b;
        prepare_numbered(&b, i % 3, &random);
        b.options.form = TUG_FORM_MINIMAL;
        b.options.scale = i % 2;
        CHECK(solve(&b));
        double least = b.info.energy, scale = scale_of(&b);
        for (int32_t s = 0; s < b.f.shapes; s++) { /* with each shape's rotations, its best pose */
            double blend[MAX_PAIRS] = {0}, targets[3 * MAX_WEIGHTS];
            bench alone = b;
            for (int32_t g = 0; g < b.f.groups; g++) {
                blend[g * b.f.shapes + s] = 1.0;
            }
            for (int32_t c = 0; c < b.f.rows * b.f.dimension; c++) {
                targets[c] = b.targets[c] / scale;
            }
            CHECK(tug_pose(b.solver, targets, blend, b.rotations) == TUG_OK);
            CHECK(tug_get_positions(b.solver, alone.positions) == TUG_OK);
            double energy = scale * scale * energy_of_shape(&alone, s, 1.0);
            CHECK(energy >= least * (1.0 - 1e-6));
            CHECK(b.blend[s] == 0.0 || fabs(energy / least - 1.0) < 1e-6);
        }
        clear(&b);
    }
}

/* Targets of another size: the same pose in that size, whatever it is. */
static void sizes_come_out(void)
{
    const double sizes[] = {1.5, 0.7, 10.0};
    uint64_t random = 9;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 3; i++) {
        bench b;
        double pose[MAX_COORDINATES], size = sizes[i / 3 / NEW_FORM_COUNT];
        prepare_numbered(&b, i % (3 * NEW_FORM_COUNT), &random);
        b.options.scale = 1;
        CHECK(solve(&b));
        double scale = scale_of(&b);
        memcpy(pose, b.positions, sizeof pose);
        for (int32_t c = 0; c < b.f.rows * b.f.dimension; c++) {
            b.targets[c] *= size;
        }
        CHECK(solve(&b));
        CHECK_NEAR(scale_of(&b) / (size * scale), 1.0, 1e-5);
        for (int32_t c = 0; c < coordinate_count(&b.f); c++) {
            b.positions[c] /= size;
        }
        CHECK(pose_distance(&b.f, b.positions, pose) <= 1e-5);
        clear(&b);
    }
}

/* Examples larger or smaller than they were given come back from the minimal energy, and their size
 * from the closest shape too: that may be another one, and then its pose is another. */
static void scaled_examples_come_back(void)
{
    const double sizes[] = {1.5, 0.7};
    uint64_t random = 10;
    for (int i = 0; i < 12; i++) {
        bench b;
        double example[MAX_COORDINATES], R[9], offset[3] = {3.0, -2.0, 1.0}, size = sizes[i % 2];
        make_numbered(&b.f, i / 2 % 3);
        prepare(&b, i < 6 ? TUG_FORM_MINIMAL : TUG_FORM_CLOSEST);
        b.options.scale = 1;
        for (int32_t s = 0; s < b.f.shapes; s++) {
            for (int32_t c = 0; c < coordinate_count(&b.f); c++) {
                example[c] = size * shape_of(&b.f, s)[c];
            }
            random_rotation(&random, b.f.dimension, R);
            move_points(b.f.dimension, R, offset, b.f.vertices, example);
            apply_rows(&b.f, example, b.targets);
            CHECK(solve(&b));
            CHECK_NEAR(scale_of(&b) / size, 1.0, 1e-2);
            CHECK(i >= 6 || pose_distance(&b.f, b.positions, example) <= 1e-6);
        }
        clear(&b);
    }
}

/* No size and no direction in the targets: nothing is divided by zero. */
static void coinciding_targets_are_borne(void)
{
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b;
        uint64_t random = 11;
        prepare_numbered(&b, i, &random);
        for (int32_t c = 0; c < b.f.rows * b.f.dimension; c++) {
            b.targets[c] = 2.0;
        }
        CHECK(solve(&b));
        CHECK(is_sound(&b) && isfinite(b.info.objective));
        for (int32_t c = 0; c < coordinate_count(&b.f); c++) {
            CHECK(isfinite(b.positions[c]));
        }
        clear(&b);
    }
}

static void rigid_motions_carry_over(void)
{
    uint64_t random = 12;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b;
        double pose[MAX_COORDINATES], R[9], offset[3] = {-4.0, 2.0, 9.0};
        prepare_numbered(&b, i, &random);
        CHECK(solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        random_rotation(&random, b.f.dimension, R);
        move_points(b.f.dimension, R, offset, b.f.vertices, pose);
        move_points(b.f.dimension, R, offset, b.f.rows, b.targets);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, b.positions, pose) <= 1e-4);
        clear(&b);
    }
}

static void nothing_is_remembered_or_allocated(void)
{
    uint64_t random = 13;
    for (int i = 0; i < 3 * NEW_FORM_COUNT * 2; i++) {
        bench b;
        double first[MAX_COORDINATES], targets[3 * MAX_WEIGHTS];
        prepare_numbered(&b, i, &random);
        CHECK(solve(&b));
        memcpy(first, b.positions, sizeof first);
        memcpy(targets, b.targets, sizeof targets);
        long before = total_allocations();
        mix_targets(&b.f, &random, 0.2, b.targets);
        CHECK(solve(&b));
        memcpy(b.targets, targets, sizeof targets);
        CHECK(solve(&b));
        CHECK(total_allocations() == before);
        CHECK(memcmp(first, b.positions, (size_t)coordinate_count(&b.f) * sizeof *first) == 0);
        clear(&b);
    }
}

/* From its own answer a form has nothing left to do; from a cold start's optima it does the same as
 * cold. */
static void solves_start_from_given_rotations(void)
{
    uint64_t random = 14;
    const int32_t forms[] = {TUG_FORM_AVERAGE, TUG_FORM_MINIMAL, TUG_FORM_PAPER, TUG_FORM_STEADY,
                             TUG_FORM_TRUST_REGION};
    for (int i = 0; i < 3 * 5; i++) {
        bench b;
        double pose[MAX_COORDINATES], far[9 * MAX_PAIRS];
        make_numbered(&b.f, i % 3);
        prepare(&b, forms[i / 3]);
        b.options.prior = 0.0;
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        int32_t rounds = b.info.rounds;
        memcpy(far, b.rotations, sizeof far);
        CHECK(tug_solve_from(b.solver, b.targets, far, &b.info) == TUG_OK);
        CHECK(b.info.rounds <= rounds);
        CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
        CHECK(b.options.form >= TUG_FORM_AVERAGE || pose_distance(&b.f, b.positions, pose) <= 1e-3);
        CHECK(b.options.form < TUG_FORM_AVERAGE || b.info.rounds <= 3);
        CHECK(b.options.form < TUG_FORM_AVERAGE || pose_distance(&b.f, b.positions, pose) <= 1e-4);
        for (int32_t j = 0; j < b.f.groups * b.f.shapes; j++) {
            random_rotation(&random, b.f.dimension, far + j * b.f.dimension * b.f.dimension);
        }
        b.options.max_rounds = 1;
        restart(&b);
        CHECK(tug_solve_from(b.solver, b.targets, far, &b.info) == TUG_OK);
        CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
        CHECK(pose_distance(&b.f, b.positions, pose) > 1e-3); /* they do count */
        clear(&b);
    }
}

static void there_are_no_costs(void)
{
    uint64_t random = 15;
    for (int i = 0; i < 3 * NEW_FORM_COUNT; i++) {
        bench b;
        prepare_numbered(&b, i, &random);
        CHECK(solve(&b));
        CHECK(REFUSED(tug_get_costs, b.solver, b.costs));
        clear(&b);
    }
}

int main(int argc, char **argv)
{
    RUN(energies_are_those_of_the_pose);
    RUN(rounds_lower_the_energies);
    RUN(the_closest_falls_from_its_choice_on);
    RUN(the_answer_is_a_minimum);
    RUN(scale_is_a_ratio_of_sums);
    RUN(no_other_scale_is_better);
    RUN(single_shapes_converge_soon);
    RUN(the_minimum_is_the_smallest);
    RUN(sizes_come_out);
    RUN(scaled_examples_come_back);
    RUN(coinciding_targets_are_borne);
    RUN(rigid_motions_carry_over);
    RUN(nothing_is_remembered_or_allocated);
    RUN(solves_start_from_given_rotations);
    RUN(there_are_no_costs);
    return TEST_RESULT;
}
