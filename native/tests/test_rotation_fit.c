/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Newton's method on rotations: its derivatives by finite differences, and where it ends. */
#include "dense/rotation.h"
#include "fixture.h"
#include "solver/rotation_fit.h"
#include "test.h"

enum { MAX_GROUPS_HERE = 6, MAX_TURNED = 3 * MAX_GROUPS_HERE };

typedef struct problem {
    rotation_energy energy;
    int32_t size; /* tangent components */
    double C[MAX_TURNED * MAX_TURNED], L[9 * MAX_GROUPS_HERE], R[9 * MAX_GROUPS_HERE];
    rotation_workspace workspace;
} problem;

/* `pull`: how strong L is beside C; C is any symmetric matrix. */
static void make_problem(problem *p, uint64_t *state, int32_t k, int32_t groups, double pull)
{
    int32_t n = groups * k;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j <= i; j++) {
            p->C[i * n + j] = p->C[j * n + i] = random_between(state, -1.0, 1.0);
        }
    }
    for (int32_t i = 0; i < n * k; i++) {
        p->L[i] = random_between(state, -pull, pull);
    }
    for (int32_t g = 0; g < groups; g++) {
        random_rotation(state, k, p->R + g * k * k);
    }
    p->energy = (rotation_energy){groups, k, p->C, p->L};
    p->size = groups * tangent_size(k);
    rotation_workspace_create(groups, k, &p->workspace);
}

/* f with rotation g turned by w_g, straight from its definition. */
static double energy_at(const problem *p, const double *w)
{
    int32_t G = p->energy.groups, k = p->energy.k, n = G * k, t = tangent_size(k);
    double R[9 * MAX_GROUPS_HERE], sum = 0.0;
    memcpy(R, p->R, sizeof R);
    for (int32_t g = 0; g < G; g++) {
        turn(k, w + g * t, R + g * k * k);
        sum -= trace_of_product(k, R + g * k * k, p->L + g * k * k);
    }
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j < n; j++) { /* tr(R_g C_gh R_h^T) */
            for (int32_t a = 0; a < k; a++) {
                sum += 0.5 * R[i / k * k * k + a * k + i % k] * p->C[i * n + j] *
                       R[j / k * k * k + a * k + j % k];
            }
        }
    }
    return sum;
}

static double energy_along(const problem *p, int32_t i, double a, int32_t j, double b)
{
    double w[MAX_TURNED] = {0};
    w[i] += a;
    w[j] += b;
    return energy_at(p, w);
}

static double largest_entry(const double *values, int32_t count)
{
    double largest = 0.0;
    for (int32_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(values[i]));
    }
    return largest;
}

/* Problem number i: plane or space, one group to six. */
static void make_numbered(problem *p, uint64_t *state, int32_t i, double pull)
{
    make_problem(p, state, 2 + i % 2, 1 + i / 2 % MAX_GROUPS_HERE, pull);
}

static void value_gradient_and_hessian_are_those_of_the_energy(void)
{
    const double h = 1e-4;
    uint64_t state = 1;
    for (int32_t n = 0; n < 24; n++) {
        problem p;
        make_numbered(&p, &state, n, 1.0);
        double zero[MAX_TURNED] = {0};
        CHECK_NEAR(evaluate_rotations(&p.energy, p.R, &p.workspace), energy_at(&p, zero), 1e-12);
        differentiate_rotations(&p.energy, p.R, &p.workspace);
        for (int32_t i = 0; i < p.size; i++) {
            double slope = energy_along(&p, i, h, i, 0.0) - energy_along(&p, i, -h, i, 0.0);
            CHECK_NEAR(p.workspace.gradient[i], slope / (2.0 * h), 1e-6);
            for (int32_t j = i; j < p.size; j++) {
                double bend = energy_along(&p, i, h, j, h) - energy_along(&p, i, h, j, -h) -
                              energy_along(&p, i, -h, j, h) + energy_along(&p, i, -h, j, -h);
                CHECK_NEAR(p.workspace.hessian[i * p.size + j], bend / (4.0 * h * h), 1e-5);
            }
        }
        rotation_workspace_destroy(&p.workspace);
    }
}

static void newton_step_leads_downhill(void)
{
    uint64_t state = 2;
    for (int32_t n = 0; n < 24; n++) {
        problem p;
        make_numbered(&p, &state, n, 1.0);
        differentiate_rotations(&p.energy, p.R, &p.workspace);
        find_newton_step(p.size, &p.workspace);
        double slope = 0.0;
        for (int32_t i = 0; i < p.size; i++) {
            slope += p.workspace.gradient[i] * p.workspace.step[i];
        }
        CHECK(slope < 0.0);
        double largest = largest_turn(&p.energy, &p.workspace), zero[MAX_TURNED] = {0};
        turn_all(&p.energy, p.R, 1e-6, &p.workspace);
        CHECK(largest > 0.0);
        double after = evaluate_rotations(&p.energy, p.workspace.trial, &p.workspace);
        CHECK(after < energy_at(&p, zero));
        rotation_workspace_destroy(&p.workspace);
    }
}

static void fit_ends_at_a_minimum(void)
{
    uint64_t state = 3;
    for (int32_t n = 0; n < 96; n++) {
        problem p;
        make_numbered(&p, &state, n, n % 3 == 0 ? 10.0 : 1.0);
        double zero[MAX_TURNED] = {0}, before = energy_at(&p, zero);
        int converged;
        int32_t steps = fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged);
        CHECK(converged && steps <= 60);
        CHECK(energy_at(&p, zero) <= before);
        differentiate_rotations(&p.energy, p.R, &p.workspace);
        CHECK(largest_entry(p.workspace.gradient, p.size) < 1e-9);
        double least = energy_at(&p, zero);
        for (int32_t trial = 0; trial < 100; trial++) {
            double w[MAX_TURNED];
            for (int32_t i = 0; i < p.size; i++) {
                w[i] = random_between(&state, -1e-2, 1e-2);
            }
            CHECK(energy_at(&p, w) >= least - 1e-12);
        }
        rotation_workspace_destroy(&p.workspace);
    }
}

/* A large constant hides the last decreases of f in its rounding; the fit has to end all the same.
 */
static void fit_ends_where_rounding_hides_the_decrease(void)
{
    uint64_t state = 11;
    for (int32_t n = 0; n < 96; n++) {
        problem p;
        make_numbered(&p, &state, n, 1.0);
        int32_t k = p.energy.k, turned = p.energy.groups * k;
        for (int32_t i = 0; i < turned; i++) {
            p.C[i * turned + i] += pow(10.0, n % 9); /* tr(R C_gg R^T) does not depend on R */
        }
        int converged;
        int32_t steps = fit_rotations(&p.energy, 1e-7, 200, &p.workspace, p.R, &converged);
        CHECK(converged && steps <= 60);
        rotation_workspace_destroy(&p.workspace);
    }
}

/* Where some rotations are as good as fixed the others still take few steps. */
static void stiff_groups_do_not_hold_up_the_others(void)
{
    uint64_t state = 12;
    for (int32_t n = 0; n < 96; n++) {
        problem p;
        make_numbered(&p, &state, n, 1.0);
        int32_t kk = p.energy.k * p.energy.k;
        for (int32_t g = 0; g < p.energy.groups; g += 2) {
            double R[9];
            random_rotation(&state, p.energy.k, R);
            for (int32_t i = 0; i < kk; i++) {
                p.L[g * kk + i] += 1e6 * R[i];
            }
        }
        int converged;
        int32_t steps = fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged);
        CHECK(converged && steps <= 60);
        rotation_workspace_destroy(&p.workspace);
    }
}

static void every_step_lowers_the_energy(void)
{
    uint64_t state = 4;
    for (int32_t n = 0; n < 24; n++) {
        problem p;
        make_numbered(&p, &state, n, 1.0);
        double zero[MAX_TURNED] = {0}, before = energy_at(&p, zero);
        int converged = 0;
        for (int step = 0; step < 50 && !converged; step++) {
            CHECK(fit_rotations(&p.energy, 1e-8, 1, &p.workspace, p.R, &converged) == 1);
            double after = energy_at(&p, zero);
            CHECK(after <= before + 1e-13);
            before = after;
        }
        CHECK(converged);
        rotation_workspace_destroy(&p.workspace);
    }
}

static void one_group_ends_at_the_closest_rotation(void)
{
    uint64_t state = 5;
    for (int32_t n = 0; n < 40; n++) {
        problem p;
        double best[9];
        int converged;
        int32_t k = 2 + n % 2;
        make_problem(&p, &state, k, 1, 1.0);
        closest_rotation(k, p.L, best);
        double w[3] = {random_between(&state, -1, 1), random_between(&state, -1, 1), 0.3};
        memcpy(p.R, best, sizeof best);
        turn(k, w, p.R); /* tr(R C R^T) does not see it */
        fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged);
        CHECK(converged);
        CHECK(angle_between(k, p.R, best) < 1e-7);
        rotation_workspace_destroy(&p.workspace);
    }
}

/* Half a turn, less an angle, away from where L pulls. */
static void start_near_the_top(problem *p, int32_t k, double angle)
{
    uint64_t state = 6;
    make_problem(p, &state, k, 1, 1.0);
    identity_matrix(k, p->L);
    identity_matrix(k, p->R);
    double w[3] = {0};
    w[tangent_size(k) - 1] = 3.14159265358979323846 - angle;
    turn(k, w, p->R);
}

static void start_at_a_saddle_comes_to_an_end(void)
{
    for (int32_t k = 2; k <= 3; k++) {
        problem p;
        int converged;
        start_near_the_top(&p, k, 0.0);
        double zero[MAX_TURNED] = {0}, before = energy_at(&p, zero);
        CHECK(fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged) <= 200);
        CHECK(energy_at(&p, zero) <= before);
        rotation_workspace_destroy(&p.workspace);
    }
}

static void start_near_a_saddle_leaves_it(void)
{
    for (int32_t k = 2; k <= 3; k++) {
        problem p;
        double I[9];
        int converged;
        start_near_the_top(&p, k, 1e-3);
        identity_matrix(k, I);
        fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged);
        CHECK(converged);
        CHECK(angle_between(k, p.R, I) < 1e-7);
        rotation_workspace_destroy(&p.workspace);
    }
}

static void steps_are_counted_and_limited(void)
{
    uint64_t state = 7;
    problem p;
    int converged;
    make_problem(&p, &state, 3, 4, 1.0);
    CHECK(fit_rotations(&p.energy, 1e-8, 2, &p.workspace, p.R, &converged) == 2);
    CHECK(!converged);
    fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged);
    CHECK(converged);
    CHECK(fit_rotations(&p.energy, 1e-8, 200, &p.workspace, p.R, &converged) == 1);
    CHECK(converged);
    rotation_workspace_destroy(&p.workspace);
}

int main(int argc, char **argv)
{
    RUN(value_gradient_and_hessian_are_those_of_the_energy);
    RUN(newton_step_leads_downhill);
    RUN(fit_ends_at_a_minimum);
    RUN(fit_ends_where_rounding_hides_the_decrease);
    RUN(stiff_groups_do_not_hold_up_the_others);
    RUN(every_step_lowers_the_energy);
    RUN(one_group_ends_at_the_closest_rotation);
    RUN(start_at_a_saddle_comes_to_an_end);
    RUN(start_near_a_saddle_leaves_it);
    RUN(steps_are_counted_and_limited);
    return TEST_RESULT;
}
