/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a solver says about its pose, computed anew from the pose; that it converges, and that the
 * past leaves no trace. */
#include "bench.h"
#include "dense/rotation.h"
#include "memory.h"
#include "test.h"

static void energy_is_that_of_the_pose(void)
{
    uint64_t random = 4;
    for (int i = 0; i < 3 * SETTING_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i / SETTING_COUNT);
        if (i % 2) {
            vary_stiffness(&b.f, &random);
        }
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
    for (int i = 0; i < 3 * SETTING_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i / SETTING_COUNT);
        prepare(&b, 0);
        choose_settings(&b, i);
        b.options.prior = 0.0;
        b.options.lambda = 0.3;
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.05, b.targets);
            CHECK(solve(&b));
            double energy = energy_of(&b);
            int root = !b.options.squared && b.options.form != TUG_FORM_MINIMAL;
            double objective = (root ? sqrt(energy) : energy) + price_of(&b);
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
            CHECK(b.info.increase <= 1e-12);
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
    for (int i = 0; i < 3 * SETTING_COUNT; i++) {
        bench b;
        double first[MAX_COORDINATES], first_targets[3 * MAX_WEIGHTS];
        make_numbered(&b.f, i / SETTING_COUNT);
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

/* Blend and rotations of a solve give its pose back; those of two, mixed, one that still meets the
 * handles and has no more energy than any other with them. */
static void posing_takes_blend_and_rotations_as_they_are(void)
{
    uint64_t random = 23;
    for (int i = 0; i < 3 * SETTING_COUNT; i++) {
        bench b;
        double pose[MAX_COORDINATES];
        make_numbered(&b.f, i / SETTING_COUNT);
        prepare(&b, 0);
        choose_settings(&b, i);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        bench other = b;
        other.solver = NULL;
        CHECK(solve(&other));
        restart(&b);
        CHECK(tug_pose(b.solver, b.targets, other.blend, other.rotations) == TUG_OK);
        CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
        /* The trust region's transforms are those of its blend and rotations in the limit only. */
        int by_steps = b.options.form == TUG_FORM_TRUST_REGION;
        CHECK(pose_distance(&b.f, b.positions, pose) <= (by_steps ? 1e-3 : 1e-9));
        CHECK(tug_get_costs(b.solver, b.costs) == TUG_ERROR_ARGUMENT);

        mix_targets(&b.f, &random, 0.05, other.targets);
        CHECK(tug_pose(b.solver, other.targets, other.blend, other.rotations) == TUG_OK);
        CHECK(tug_get_positions(b.solver, other.positions) == TUG_OK);
        CHECK(tug_get_blend(b.solver, b.blend) == TUG_OK);
        CHECK(memcmp(b.blend, other.blend, sizeof(double) * (size_t)b.f.shapes) == 0);
        CHECK(constraint_error(&other) <= 1e-9);
        tug_destroy_solver(other.solver);
        clear(&b);
    }
}

/* Between two poses of the same handles: every pose in the space has the form of one with other
 * blend and rotations, so a mixture of positions has no less energy. */
static void a_pose_is_the_least_of_its_blend_and_rotations(void)
{
    uint64_t random = 24;
    for (int i = 0; i < 3; i++) {
        bench b, moved;
        make_numbered(&b.f, i);
        prepare(&b, TUG_FORM_STEADY);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        random_blend(&random, b.f.groups, b.f.shapes, b.blend);
        moved = b;
        CHECK(tug_pose(b.solver, b.targets, b.blend, b.rotations) == TUG_OK);
        CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
        double least = energy_of(&b);
        for (int trial = 0; trial < 20; trial++) {
            double share = pow(10.0, random_between(&random, -3.0, 0.0));
            random_blend(&random, b.f.groups, b.f.shapes, moved.blend);
            CHECK(tug_pose(b.solver, b.targets, moved.blend, b.rotations) == TUG_OK);
            CHECK(tug_get_positions(b.solver, moved.positions) == TUG_OK);
            memcpy(moved.blend, b.blend, sizeof b.blend);
            for (int32_t c = 0; c < coordinate_count(&b.f); c++) {
                moved.positions[c] = b.positions[c] + share * (moved.positions[c] - b.positions[c]);
            }
            CHECK(energy_of(&moved) >= least * (1.0 - 1e-9));
        }
        clear(&b);
    }
}

static void a_warm_start_after_a_pose_is_cold(void)
{
    uint64_t random = 25;
    for (int i = 0; i < 2; i++) {
        bench b;
        double cold[MAX_COORDINATES];
        make_tube(&b.f, 0);
        prepare(&b, FORMS[i]);
        b.options.warm_start = 1;
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        memcpy(cold, b.positions, sizeof cold);
        CHECK(tug_pose(b.solver, b.targets, b.blend, b.rotations) == TUG_OK);
        CHECK(solve(&b));
        CHECK(memcmp(cold, b.positions, (size_t)coordinate_count(&b.f) * sizeof *cold) == 0);
        clear(&b);
    }
}

static void solving_allocates_nothing(void)
{
    uint64_t random = 17;
    for (int i = 0; i < SETTING_COUNT; i++) {
        bench b;
        make_tube(&b.f, 1);
        prepare(&b, 0);
        choose_settings(&b, i);
        restart(&b);
        long before = total_allocations();
        for (int trial = 0; trial < 5; trial++) {
            mix_targets(&b.f, &random, 0.1, b.targets);
            CHECK(solve(&b));
            CHECK(tug_pose(b.solver, b.targets, b.blend, b.rotations) == TUG_OK);
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
    RUN(energy_is_that_of_the_pose);
    RUN(objective_is_root_of_energy_and_price);
    RUN(prior_only_adds_to_the_objective);
    RUN(steady_solves_converge);
    RUN(steady_rounds_lower_the_objective);
    RUN(steady_pose_is_a_minimum);
    RUN(the_past_leaves_no_trace);
    RUN(warm_starts_end_at_the_same_pose);
    RUN(posing_takes_blend_and_rotations_as_they_are);
    RUN(a_pose_is_the_least_of_its_blend_and_rotations);
    RUN(a_warm_start_after_a_pose_is_cold);
    RUN(solving_allocates_nothing);
    RUN(targets_that_are_not_finite_leave_the_pose);
    return TEST_RESULT;
}
