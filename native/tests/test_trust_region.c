/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The paper's form made convergent: its derivatives against finite differences, its objective
 * against that of the alternation, which does without either. */
#include "bench.h"
#include "dense/rotation.h"
#include "solver/moments.h"
#include "test.h"

/* 2 (E_d2 and E_d3 of (A 15) and (A 18)) for the solver's blend and rotations, at moments M. */
static double energy_of_rotations(const tug_solver *solver, const double *M)
{
    int32_t k = solver->model->header.dimension, kk = k * k;
    double N[9 * MAX_PAIRS], sum = 0.0;
    find_blended_moments(solver, N);
    for (int32_t i = 0; i < solver->model->header.groups * solver->model->header.shapes; i++) {
        sum += solver->B[i] * (trace_of_product(k, solver->R + i * kk, N + i * kk) -
                               2.0 * trace_of_product(k, solver->R + i * kk, M + i * kk));
    }
    return sum;
}

/* (A 25-28): E_d at fixed T and B, as the rotations follow moments that move. */
static void rotations_change_the_energy_as_the_slope_says(void)
{
    uint64_t random = 1;
    for (int trial = 0; trial < 30; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_TRUST_REGION);
        mix_targets(&b.f, &random, 0.1, b.targets);
        CHECK(solve(&b));
        random_blend(&random, b.f.groups, b.f.shapes, b.solver->B);
        int32_t kk = b.f.dimension * b.f.dimension, count = b.f.groups * b.f.shapes * kk;
        double M[9 * MAX_PAIRS], N[9 * MAX_PAIRS], slope[9 * MAX_PAIRS], dM[9 * MAX_PAIRS];
        double moved[9 * MAX_PAIRS], found[2], expected = 0.0, size = 0.0, step = 1e-5;
        find_pose_moments(b.solver, b.solver->V, M);
        follow_moments(b.solver, M);
        find_blended_moments(b.solver, N);
        find_rotation_slope(b.solver, M, N, slope);
        for (int32_t i = 0; i < count; i++) {
            dM[i] = random_between(&random, -1.0, 1.0) * b.model->stiffness[i / kk / b.f.shapes];
            expected += slope[i] * dM[i];
            size += fabs(slope[i] * dM[i]);
        }
        for (int side = 0; side < 2; side++) {
            for (int32_t i = 0; i < count; i++) {
                moved[i] = M[i] + (side ? step : -step) * dM[i];
            }
            follow_moments(b.solver, moved);
            found[side] = 0.5 * energy_of_rotations(b.solver, M);
        }
        CHECK(size > 1e-8);
        CHECK_NEAR((found[1] - found[0]) / (2.0 * step), expected, 1e-4 * size + 1e-8);
        clear(&b);
    }
}

static void rounds_lower_the_objective(void)
{
    uint64_t random = 2;
    for (int trial = 0; trial < 3 * SETTING_COUNT; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_TRUST_REGION);
        choose_settings(&b, trial / 3);
        b.options.form = TUG_FORM_TRUST_REGION;
        mix_targets(&b.f, &random, 0.1, b.targets);
        double before = INFINITY;
        b.info.converged = 0;
        for (b.options.max_rounds = 1; b.options.max_rounds < 60 && !b.info.converged;
             b.options.max_rounds++) {
            restart(&b);
            CHECK(solve(&b));
            CHECK(b.info.objective <= before);
            CHECK(b.info.increase == 0.0);
            CHECK(b.info.gap >= 0.0 && b.info.gap <= 1e-6 * b.info.objective + 1e-9);
            before = b.info.objective;
        }
        clear(&b);
    }
}

/* E of the pose as it stands: rotations by (A 22) from its edges. */
static double true_objective(bench *b)
{
    int32_t k = b->f.dimension, kk = k * k, S = b->f.shapes;
    double M[9 * MAX_GROUPS], rotations[9 * MAX_PAIRS];
    for (int32_t s = 0; s < S; s++) {
        find_moments(&b->f, s, b->positions, M);
        for (int32_t g = 0; g < b->f.groups; g++) {
            closest_rotation(k, M + g * kk, rotations + (g * S + s) * kk);
        }
    }
    return sqrt(measure_energy(&b->f, b->positions, b->blend, rotations)) + price_of(b);
}

static void it_ends_no_higher_than_the_alternation(void)
{
    uint64_t random = 3;
    int restless = 0, lower = 0;
    for (int trial = 0; trial < 90; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_PAPER);
        mix_targets(&b.f, &random, 0.1, b.targets);
        CHECK(solve(&b));
        restless += b.info.increase > 1e-9 * b.info.objective || !b.info.converged;
        double alternating = true_objective(&b);
        b.options.form = TUG_FORM_TRUST_REGION;
        restart(&b);
        CHECK(solve(&b));
        CHECK(b.info.converged);
        CHECK_NEAR(b.info.objective / true_objective(&b), 1.0, 1e-6);
        CHECK(b.info.objective <= alternating * (1.0 + 1e-6));
        lower += b.info.objective < alternating * (1.0 - 1e-9);
        clear(&b);
    }
    CHECK(restless > 0 && lower > 0);
}

/* Handles torn far apart: models that promise too much are refused, and the solve still ends. Where
 * a moment nearly vanishes its rotation hangs by a thread, and a solve may take more rounds. */
static void torn_handles_converge(void)
{
    enum { TRIALS = 120 };
    uint64_t random = 4;
    int converged = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        bench b;
        make_numbered(&b.f, trial % 3);
        prepare(&b, TUG_FORM_TRUST_REGION);
        b.options.squared = trial / 3 % 2;
        mix_targets(&b.f, &random, 0.5, b.targets);
        CHECK(solve(&b));
        CHECK(is_sound(&b) && constraint_error(&b) <= 1e-9);
        CHECK(b.info.increase == 0.0);
        converged += b.info.converged;
        clear(&b);
    }
    CHECK(converged >= TRIALS * 98 / 100);
}

static void a_warm_start_stays_where_the_last_solve_ended(void)
{
    uint64_t random = 5;
    for (int i = 0; i < 3; i++) {
        bench b;
        make_numbered(&b.f, i);
        prepare(&b, TUG_FORM_TRUST_REGION);
        b.options.warm_start = 1;
        mix_targets(&b.f, &random, 0.1, b.targets);
        CHECK(solve(&b));
        double objective = b.info.objective;
        CHECK(b.info.rounds > 1);
        CHECK(solve(&b));
        CHECK(b.info.converged && b.info.rounds == 1);
        CHECK_NEAR(b.info.objective / objective, 1.0, 1e-9);
        clear(&b);
    }
}

int main(int argc, char **argv)
{
    RUN(rotations_change_the_energy_as_the_slope_says);
    RUN(rounds_lower_the_objective);
    RUN(it_ends_no_higher_than_the_alternation);
    RUN(torn_handles_converge);
    RUN(a_warm_start_stays_where_the_last_solve_ended);
    return TEST_RESULT;
}
