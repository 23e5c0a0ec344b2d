/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Handles that say how the surface is turned: the group nearest to them follows, as firmly as it is
 * asked to, and examples and rigid motions are seen as before. */
#include "bench.h"
#include "dense/rotation.h"
#include "memory.h"
#include "model/model.h"
#include "test.h"

typedef struct oriented_bench {
    bench b;
    double O[9 * MAX_WEIGHTS], firmness[MAX_WEIGHTS];
} oriented_bench;

static int orient(oriented_bench *x)
{
    return tug_set_orientations(x->b.solver, x->O, x->firmness) == TUG_OK && solve(&x->b);
}

/* Random targets; orientations up to `angle` from the rest shape in each axis, all of `firmness`.
 */
static void start(oriented_bench *x, int i, uint64_t *random, double angle, double firmness)
{
    make_numbered(&x->b.f, i % 3);
    prepare(&x->b, i / 3 % 2 ? TUG_FORM_PAPER : TUG_FORM_STEADY);
    restart(&x->b);
    mix_targets(&x->b.f, random, 0.02, x->b.targets);
    int32_t k = x->b.f.dimension;
    for (int32_t r = 0; r < x->b.f.rows; r++) {
        double w[3];
        for (int a = 0; a < 3; a++) {
            w[a] = random_between(random, -angle, angle);
        }
        identity_matrix(k, x->O + r * k * k);
        turn(k, w, x->O + r * k * k);
        x->firmness[r] = firmness;
    }
}

/* Of the group nearest to a row, from the rest shape. */
static const double *rotation_at(const oriented_bench *x, int32_t r)
{
    int32_t pair = nearest_group(x->b.model, r) * x->b.f.shapes;
    return x->b.rotations + pair * x->b.f.dimension * x->b.f.dimension;
}

static double largest_miss(const oriented_bench *x)
{
    int32_t k = x->b.f.dimension;
    double largest = 0.0;
    for (int32_t r = 0; r < x->b.f.rows; r++) {
        largest = fmax(largest, angle_between(k, rotation_at(x, r), x->O + r * k * k));
    }
    return largest;
}

static void no_orientation_is_none(void)
{
    uint64_t random = 61;
    for (int i = 0; i < 6; i++) {
        oriented_bench x;
        double pose[MAX_COORDINATES];
        start(&x, i, &random, 1.0, 1.0);
        CHECK(solve(&x.b));
        memcpy(pose, x.b.positions, sizeof pose);
        CHECK(orient(&x));
        CHECK(pose_distance(&x.b.f, x.b.positions, pose) > 1e-3);
        memset(x.firmness, 0, sizeof x.firmness);
        x.O[0] = NAN; /* not looked at */
        CHECK(orient(&x));
        CHECK(memcmp(x.b.positions, pose, (size_t)coordinate_count(&x.b.f) * sizeof *pose) == 0);
        clear(&x.b);
    }
}

static void fixed_orientations_are_met(void)
{
    uint64_t random = 62;
    for (int i = 0; i < 60; i++) {
        oriented_bench x;
        start(&x, i, &random, 1.0, INFINITY);
        CHECK(orient(&x));
        CHECK(is_sound(&x.b) && constraint_error(&x.b) <= 1e-9);
        CHECK(x.b.info.converged || x.b.options.form == TUG_FORM_PAPER);
        CHECK(largest_miss(&x) <= 1e-5);
        CHECK_NEAR(x.b.info.energy / energy_of(&x.b), 1.0, 1e-5);
        clear(&x.b);
    }
}

static void firmer_orientations_are_met_better(void)
{
    uint64_t random = 63;
    for (int i = 0; i < 3; i++) {
        oriented_bench x;
        double before = INFINITY, fixed[MAX_COORDINATES];
        start(&x, i, &random, 0.5, INFINITY);
        CHECK(orient(&x));
        memcpy(fixed, x.b.positions, sizeof fixed);
        for (double o = 0.1; o < 1e6; o *= 10.0) {
            for (int32_t r = 0; r < x.b.f.rows; r++) {
                x.firmness[r] = o;
            }
            CHECK(orient(&x) && x.b.info.converged);
            CHECK(largest_miss(&x) <= 0.95 * before);
            CHECK_NEAR(x.b.info.energy / energy_of(&x.b), 1.0, 1e-6);
            before = largest_miss(&x);
        }
        CHECK(pose_distance(&x.b.f, x.b.positions, fixed) <= 1e-4);
        clear(&x.b);
    }
}

static void poses_are_continuous_in_orientation_and_firmness(void)
{
    uint64_t random = 64;
    for (int i = 0; i < 3; i++) {
        oriented_bench x;
        double pose[MAX_COORDINATES];
        start(&x, i, &random, 0.3, 1.0);
        for (double o = 1e-6; o < 1e9; o *= 7.0) {
            double w[3] = {1e-6, -1e-6, 1e-6};
            for (int32_t r = 0; r < x.b.f.rows; r++) {
                x.firmness[r] = o;
            }
            CHECK(orient(&x) && x.b.info.converged && is_sound(&x.b));
            memcpy(pose, x.b.positions, sizeof pose);
            for (int32_t r = 0; r < x.b.f.rows; r++) {
                turn(x.b.f.dimension, w, x.O + r * x.b.f.dimension * x.b.f.dimension);
                x.firmness[r] = o * (1.0 + 1e-6);
            }
            CHECK(orient(&x));
            CHECK(pose_distance(&x.b.f, x.b.positions, pose) <= 1e-4);
        }
        clear(&x.b);
    }
}

static void examples_come_back_with_their_own_rotations(void)
{
    uint64_t random = 65;
    for (int i = 0; i < 36; i++) {
        oriented_bench x;
        start(&x, i, &random, 0.0, 0.0);
        int32_t k = x.b.f.dimension, kk = k * k, S = x.b.f.shapes;
        for (int32_t s = 0; s < S; s++) {
            for (int32_t r = 0; r < x.b.f.rows; r++) {
                int32_t pair = nearest_group(x.b.model, r) * S + s;
                for (int32_t e = 0; e < kk; e++) { /* the inverse of the alignment */
                    x.O[r * kk + e] = x.b.model->align[pair * kk + e % k * k + e / k];
                }
                x.firmness[r] =
                    (r + i) % 3 == 0 ? INFINITY : pow(10.0, random_between(&random, -2.0, 3.0));
            }
            apply_rows(&x.b.f, shape_of(&x.b.f, s), x.b.targets);
            CHECK(orient(&x));
            CHECK(is_sound(&x.b) && x.b.info.converged);
            CHECK(pose_distance(&x.b.f, x.b.positions, shape_of(&x.b.f, s)) <= 1e-6);
            for (int32_t g = 0; g < x.b.f.groups; g++) {
                CHECK(x.b.blend[g * S + s] >= 0.99);
            }
        }
        clear(&x.b);
    }
}

static void turning_handles_and_orientations_turns_the_pose(void)
{
    uint64_t random = 66;
    for (int i = 0; i < 12; i++) {
        oriented_bench x;
        double pose[MAX_COORDINATES], R[9], O[9], offset[3] = {3.0, 1.0, -6.0};
        start(&x, i, &random, 0.4, i % 2 ? INFINITY : 0.7);
        int32_t k = x.b.f.dimension;
        CHECK(orient(&x));
        memcpy(pose, x.b.positions, sizeof pose);
        random_rotation(&random, k, R);
        move_points(k, R, offset, x.b.f.vertices, pose);
        move_points(k, R, offset, x.b.f.rows, x.b.targets);
        for (int32_t r = 0; r < x.b.f.rows; r++) {
            multiply(k, R, x.O + r * k * k, O);
            memcpy(x.O + r * k * k, O, (size_t)(k * k) * sizeof *O);
        }
        CHECK(orient(&x));
        CHECK(pose_distance(&x.b.f, x.b.positions, pose) <= (i % 2 ? 1e-5 : 1e-6));
        clear(&x.b);
    }
}

/* Positions of one shape, orientations of none: what the shape costs in the groups that are
 * turned. */
static void costs_see_orientations(void)
{
    uint64_t random = 67;
    for (int i = 0; i < 3; i++) {
        oriented_bench x;
        double before = 0.0;
        start(&x, i, &random, 1.0, 1.0);
        apply_rows(&x.b.f, shape_of(&x.b.f, 1), x.b.targets);
        for (double o = 1e-3; o < 1e4; o *= 10.0) {
            for (int32_t r = 0; r < x.b.f.rows; r++) {
                x.firmness[r] = o;
            }
            CHECK(orient(&x));
            double whole = 0.0;
            for (int32_t g = 0; g < x.b.f.groups; g++) {
                double cost = x.b.costs[g * x.b.f.shapes + 1];
                whole += cost * cost;
            }
            CHECK(whole > before); /* the least of energy and orientations only grows */
            before = whole;
        }
        clear(&x.b);
    }
}

static void orientations_of_one_group_add_up(void)
{
    uint64_t random = 68;
    for (int i = 0; i < 6; i++) {
        oriented_bench x;
        double pose[MAX_COORDINATES];
        make_numbered(&x.b.f, i % 3);
        int32_t k = x.b.f.dimension, kk = k * k;
        x.b.f.groups = 1;
        memset(x.b.f.group, 0, sizeof x.b.f.group);
        prepare(&x.b, i / 3 ? TUG_FORM_PAPER : TUG_FORM_STEADY);
        restart(&x.b);
        mix_targets(&x.b.f, &random, 0.02, x.b.targets);
        random_rotation(&random, k, x.O);
        memset(x.firmness, 0, sizeof x.firmness);
        x.firmness[0] = 3.0;
        CHECK(orient(&x));
        memcpy(pose, x.b.positions, sizeof pose);
        memcpy(x.O + 2 * kk, x.O, (size_t)kk * sizeof *x.O);
        x.firmness[0] = 1.0;
        x.firmness[2] = 2.0;
        CHECK(orient(&x));
        CHECK(pose_distance(&x.b.f, x.b.positions, pose) <= 1e-9);
        clear(&x.b);
    }
}

static void the_other_forms_refuse(void)
{
    const int32_t forms[] = {TUG_FORM_NO_ROTATIONS, TUG_FORM_TRUST_REGION};
    for (int i = 0; i < 2; i++) {
        bench b;
        double O[4 * MAX_WEIGHTS] = {1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0};
        make_strip(&b.f);
        prepare(&b, forms[i]);
        restart(&b);
        CHECK(tug_set_orientations(b.solver, O, (double[]){0.0, 1.0, 0.0}) == TUG_ERROR_ARGUMENT);
        CHECK(strstr(tug_error_text(), "row 1") != NULL);
        CHECK(tug_set_orientations(b.solver, O, (double[]){0.0, 0.0, 0.0}) == TUG_OK);
        clear(&b);
    }
}

static void orienting_allocates_nothing(void)
{
    uint64_t random = 69;
    oriented_bench x;
    start(&x, 1, &random, 0.3, 2.0);
    long before = total_allocations();
    CHECK(orient(&x));
    CHECK(total_allocations() == before);
    clear(&x.b);
}

int main(int argc, char **argv)
{
    RUN(no_orientation_is_none);
    RUN(fixed_orientations_are_met);
    RUN(firmer_orientations_are_met_better);
    RUN(poses_are_continuous_in_orientation_and_firmness);
    RUN(examples_come_back_with_their_own_rotations);
    RUN(turning_handles_and_orientations_turns_the_pose);
    RUN(costs_see_orientations);
    RUN(orientations_of_one_group_add_up);
    RUN(the_other_forms_refuse);
    RUN(orienting_allocates_nothing);
    return TEST_RESULT;
}
