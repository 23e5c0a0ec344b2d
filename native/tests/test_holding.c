/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows that give way: between pinned and free without a jump, at the least of energy and springs,
 * and examples come back all the same. */
#include "bench.h"
#include "memory.h"
#include "solver/costs.h"
#include "test.h"

static int set_all(bench *b, double firmness)
{
    double w[MAX_WEIGHTS];
    for (int32_t r = 0; r < b->f.rows; r++) {
        w[r] = firmness;
    }
    return tug_set_firmness(b->solver, w) == TUG_OK;
}

/* Of the last row; the others are pinned. */
static int set_last(bench *b, double firmness)
{
    double w[MAX_WEIGHTS];
    for (int32_t r = 0; r < b->f.rows; r++) {
        w[r] = r + 1 < b->f.rows ? INFINITY : firmness;
    }
    return tug_set_firmness(b->solver, w) == TUG_OK;
}

static void start(bench *b, int i, uint64_t *random, double noise)
{
    make_numbered(&b->f, i % 3);
    prepare(b, FORMS[i / 3 % FORM_COUNT]);
    restart(b);
    mix_targets(&b->f, random, noise, b->targets);
}

static int same_pose(const bench *b, const double *pose)
{
    return memcmp(b->positions, pose, (size_t)coordinate_count(&b->f) * sizeof *pose) == 0;
}

static void rows_are_pinned_until_told_otherwise(void)
{
    uint64_t random = 41;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        double pinned[MAX_COORDINATES];
        start(&b, i, &random, 0.05);
        CHECK(solve(&b));
        memcpy(pinned, b.positions, sizeof pinned);
        CHECK(set_all(&b, 0.5) && solve(&b));
        CHECK(pose_distance(&b.f, b.positions, pinned) > 1e-4 && constraint_error(&b) > 1e-4);
        CHECK(set_all(&b, INFINITY) && solve(&b));
        CHECK(same_pose(&b, pinned));
        clear(&b);
    }
}

static void firm_rows_tend_to_pinned_ones(void)
{
    uint64_t random = 42;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        double pinned[MAX_COORDINATES], before = INFINITY;
        start(&b, i, &random, 0.03);
        CHECK(solve(&b));
        memcpy(pinned, b.positions, sizeof pinned);
        for (double w = 1e3; w < 1e13; w *= 1e3) {
            CHECK(set_all(&b, w) && solve(&b));
            double distance = pose_distance(&b.f, b.positions, pinned);
            CHECK(distance <= 0.01 * before + 1e-8);
            CHECK(distance <= 100.0 / w + 1e-8);
            before = distance;
        }
        clear(&b);
    }
}

/* A row of firmness 0 is one that was never there. */
static void loose_rows_tend_to_none(void)
{
    uint64_t random = 43;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b, without;
        start(&b, i, &random, 0.03);
        without.f = b.f;
        without.f.rows--;
        prepare(&without, b.options.form);
        memcpy(without.targets, b.targets, sizeof b.targets);
        CHECK(solve(&without));
        /* How far from its optimum the trust region's convergence may end. */
        double blur = b.options.form == TUG_FORM_TRUST_REGION ? 1e-3 : 1e-7;
        double before = INFINITY;
        for (double w = 1e-3; w > 1e-13; w *= 1e-3) {
            CHECK(set_last(&b, w) && solve(&b));
            double distance = pose_distance(&b.f, b.positions, without.positions);
            CHECK(distance <= 0.1 * before + blur);
            before = distance;
        }
        CHECK(before <= blur);
        CHECK(set_last(&b, 0.0) && solve(&b));
        CHECK(is_sound(&b) && b.info.converged == without.info.converged);
        CHECK(pose_distance(&b.f, b.positions, without.positions) <= blur);
        clear(&b);
        clear(&without);
    }
}

static void a_free_row_may_be_anywhere(void)
{
    uint64_t random = 44;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        double pose[MAX_COORDINATES];
        start(&b, i, &random, 0.05);
        CHECK(set_last(&b, 0.0) && solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        b.targets[b.f.rows * b.f.dimension - 1] = 1e9;
        CHECK(solve(&b));
        CHECK(same_pose(&b, pose));
        clear(&b);
    }
}

static void poses_are_continuous_in_the_firmness(void)
{
    uint64_t random = 45;
    for (int i = 0; i < 3; i++) {
        bench b;
        double pose[MAX_COORDINATES];
        start(&b, i, &random, 0.02);
        for (double w = 1e-4; w < 1e5; w *= 3.7) {
            CHECK(set_all(&b, w) && solve(&b));
            CHECK(b.info.converged && is_sound(&b));
            memcpy(pose, b.positions, sizeof pose);
            CHECK(set_all(&b, w * (1.0 + 1e-5)) && solve(&b));
            CHECK(pose_distance(&b.f, b.positions, pose) <= 1e-4);
        }
        clear(&b);
    }
}

static void examples_come_back_however_firm(void)
{
    uint64_t random = 46;
    for (int i = 0; i < 3 * FORM_COUNT * 4; i++) {
        bench b;
        double w[MAX_WEIGHTS];
        start(&b, i, &random, 0.0);
        for (int32_t r = 0; r < b.f.rows; r++) {
            w[r] = r == 1 && i % 2 ? 0.0 : pow(10.0, random_between(&random, -4.0, 4.0));
        }
        CHECK(tug_set_firmness(b.solver, w) == TUG_OK);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            apply_rows(&b.f, shape_of(&b.f, s), b.targets);
            CHECK(solve(&b));
            CHECK(b.info.converged && is_sound(&b));
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
            CHECK_NEAR(b.info.objective, 0.0, 1e-6 * diagonal_of(&b.f));
        }
        clear(&b);
    }
}

static void rigid_motions_carry_over(void)
{
    uint64_t random = 47;
    for (int i = 0; i < 6; i++) {
        bench b;
        double pose[MAX_COORDINATES], R[9], offset[3] = {5.0, -9.0, 2.0};
        start(&b, i, &random, 0.03);
        CHECK(set_all(&b, 0.7) && solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        random_rotation(&random, b.f.dimension, R);
        move_points(b.f.dimension, R, offset, b.f.vertices, pose);
        move_points(b.f.dimension, R, offset, b.f.rows, b.targets);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, pose, b.positions) <= 1e-7);
        clear(&b);
    }
}

/* 1/2 sum w s |Y' - Y|^2 with s as it is documented, in the fixture's units. */
static double energy_of_springs(const bench *b, const double *w, const double *Y,
                                const double *placed)
{
    int32_t k = b->f.dimension, h = b->f.rows;
    double sum = 0.0;
    for (int32_t i = 0; i < h * k; i++) {
        double s = b->model->energy.FLF[(i / k) * (h + 1)];
        sum += 0.5 * w[i / k] * s * (placed[i] - Y[i]) * (placed[i] - Y[i]);
    }
    return sum;
}

/* E + springs is what a pinned solve at Y' finds, plus the springs; and no Y' gives less. */
static void rows_rest_where_energy_and_springs_are_least(void)
{
    uint64_t random = 48;
    for (int i = 0; i < 9; i++) {
        bench b, pinned;
        double w[MAX_WEIGHTS], placed[3 * MAX_WEIGHTS];
        start(&b, i, &random, 0.05);
        b.options.prior = b.options.lambda = 0.0;
        b.options.squared = 1;
        restart(&b);
        pinned.f = b.f;
        prepare(&pinned, b.options.form);
        pinned.options = b.options;
        for (int32_t r = 0; r < b.f.rows; r++) {
            w[r] = pow(10.0, random_between(&random, -1.0, 2.0));
        }
        CHECK(tug_set_firmness(b.solver, w) == TUG_OK && solve(&b));
        apply_rows(&b.f, b.positions, placed);
        CHECK_NEAR(b.info.energy / energy_of(&b), 1.0, 1e-6);
        double least = b.info.energy + energy_of_springs(&b, w, b.targets, placed);
        CHECK_NEAR(b.info.objective / least, 1.0, 1e-4); /* but for s's trifle of the whole */
        for (int trial = 0; trial < 10 && b.options.form != TUG_FORM_PAPER; trial++) {
            double size = trial == 0 ? 0.0 : 1e-3 * diagonal_of(&b.f);
            for (int32_t e = 0; e < b.f.rows * b.f.dimension; e++) {
                pinned.targets[e] = placed[e] + random_between(&random, -size, size);
            }
            CHECK(solve(&pinned));
            double other = pinned.info.energy + energy_of_springs(&b, w, b.targets, pinned.targets);
            CHECK(trial == 0 ? fabs(other - least) <= 1e-4 * least : other > least);
        }
        clear(&b);
        clear(&pinned);
    }
}

static void costs_are_those_of_the_places_and_their_springs(void)
{
    uint64_t random = 49;
    for (int i = 0; i < 3; i++) {
        bench b;
        double w[MAX_WEIGHTS], Y[3 * MAX_WEIGHTS], soft = 0.0, springs = 0.0, pinned = 0.0;
        shape_costs costs;
        holding *held;
        start(&b, i, &random, 0.05);
        int32_t k = b.f.dimension, S = b.f.shapes;
        for (int32_t e = 0; e < b.f.rows * k; e++) {
            w[e / k] = 0.3 + e / k;
            Y[e] = b.targets[e] / b.model->header.unit;
        }
        CHECK(hold_rows(b.model, w, &held) == TUG_OK && costs_create(b.model, &costs));
        find_costs(b.model, held, NULL, Y, 1, &costs); /* the last shape's rows stay in `placed` */
        double placed[3 * MAX_WEIGHTS];
        memcpy(placed, costs.placed, (size_t)(b.f.rows * k) * sizeof *placed);
        for (int32_t g = 0; g < b.f.groups; g++) {
            soft += costs.D[g * S + S - 1];
        }
        for (int32_t r = 0; r < b.f.rows; r++) {
            springs += spring_energy(held, r, placed, Y, k);
        }
        find_costs(b.model, NULL, NULL, placed, 1, &costs);
        for (int32_t g = 0; g < b.f.groups; g++) {
            pinned += costs.D[g * S + S - 1];
        }
        CHECK(springs > 1e-3 * soft);
        CHECK_NEAR((pinned + springs) / soft, 1.0, 1e-9);
        costs_destroy(&costs);
        release_holding(held);
        clear(&b);
    }
}

static void a_mesh_that_nothing_holds_is_refused(void)
{
    uint64_t random = 50;
    const double loose[] = {0.0, 1e-12};
    for (int i = 0; i < 6; i++) {
        bench b;
        double pose[MAX_COORDINATES];
        start(&b, i % 3, &random, 0.05);
        CHECK(set_all(&b, 2.0) && solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        CHECK(!set_all(&b, loose[i / 3]));
        CHECK(strstr(tug_error_text(), i % 3 ? "rows 0, 1, 2, 3:" : "rows 0, 1, 2:") != NULL);
        CHECK(solve(&b) && same_pose(&b, pose)); /* as firm as before */
        clear(&b);
    }
}

static void one_row_holds_a_mesh(void)
{
    for (int i = 0; i < FORM_COUNT; i++) {
        bench b;
        make_strip(&b.f);
        prepare(&b, FORMS[i]);
        restart(&b);
        const double w[] = {0.0, 1e-3, 0.0};
        memcpy(b.targets, (double[]){0.0, 0.0, 3.0, 4.0, 0.0, 0.0}, 6 * sizeof(double));
        CHECK(tug_set_firmness(b.solver, w) == TUG_OK && solve(&b));
        CHECK(is_sound(&b) && b.info.converged);
        double values[3 * MAX_WEIGHTS];
        apply_rows(&b.f, b.positions, values);
        CHECK(hypot(values[2] - 3.0, values[3] - 4.0) <= 1e-9); /* nothing pulls against it */
        clear(&b);
    }
}

static void solving_allocates_nothing(void)
{
    uint64_t random = 51;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        start(&b, i, &random, 0.05);
        CHECK(set_all(&b, 1.0));
        long before = total_allocations();
        CHECK(solve(&b) && solve(&b));
        CHECK(total_allocations() == before);
        clear(&b);
    }
}

int main(int argc, char **argv)
{
    RUN(rows_are_pinned_until_told_otherwise);
    RUN(firm_rows_tend_to_pinned_ones);
    RUN(loose_rows_tend_to_none);
    RUN(a_free_row_may_be_anywhere);
    RUN(poses_are_continuous_in_the_firmness);
    RUN(examples_come_back_however_firm);
    RUN(rigid_motions_carry_over);
    RUN(rows_rest_where_energy_and_springs_are_least);
    RUN(costs_are_those_of_the_places_and_their_springs);
    RUN(a_mesh_that_nothing_holds_is_refused);
    RUN(one_row_holds_a_mesh);
    RUN(solving_allocates_nothing);
    return TEST_RESULT;
}
