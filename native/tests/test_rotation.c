/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rotations against what defines them: maxima over many others, the exponential's series, finite
 * differences. Every test runs in the plane and in space. */
#include "dense/rotation.h"
#include "fixture.h"
#include "test.h"

static const double PI = 3.14159265358979323846;

static double determinant(int32_t k, const double *A)
{
    return k == 2 ? A[0] * A[3] - A[1] * A[2]
                  : A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) +
                        A[2] * (A[3] * A[7] - A[4] * A[6]);
}

static int is_rotation(int32_t k, const double *R)
{
    double product[9], I[9], largest = 0.0;
    multiply_nt(k, R, R, product);
    identity_matrix(k, I);
    for (int32_t i = 0; i < k * k; i++) {
        largest = fmax(largest, fabs(product[i] - I[i]));
        if (!isfinite(R[i])) {
            return 0;
        }
    }
    return largest < 1e-13 && fabs(determinant(k, R) - 1.0) < 1e-13;
}

static void random_matrix(uint64_t *state, int32_t k, double *M)
{
    for (int32_t i = 0; i < k * k; i++) {
        M[i] = random_between(state, -1.0, 1.0);
    }
}

/* A random matrix; one of determinant below zero; a reflection; one of rank one; zero. */
enum { ANY, TURNED_OVER, REFLECTION, RANK_ONE, ZERO, KINDS };

static void make_matrix(int kind, uint64_t *state, int32_t k, double *M)
{
    double x[3], y[3];
    random_matrix(state, k, M);
    if (kind == TURNED_OVER || kind == REFLECTION) {
        if (kind == REFLECTION) {
            random_rotation(state, k, M);
        }
        double sign = determinant(k, M) > 0.0 ? -1.0 : 1.0;
        for (int32_t i = 0; i < k; i++) {
            M[i] *= sign;
        }
    }
    if (kind == RANK_ONE || kind == ZERO) {
        for (int32_t a = 0; a < k; a++) {
            x[a] = kind == ZERO ? 0.0 : random_between(state, -1.0, 1.0);
            y[a] = random_between(state, -1.0, 1.0);
        }
        for (int32_t i = 0; i < k * k; i++) {
            M[i] = x[i / k] * y[i % k];
        }
    }
}

static int is_closest_rotation(uint64_t *state, int32_t k, const double *M, const double *R)
{
    double product[9], axis[3], other[9], best = trace_of_product(k, R, M);
    multiply(k, R, M, product);
    axial_vector(k, product, axis);
    int best_of_all = is_rotation(k, R);
    for (int32_t a = 0; a < tangent_size(k); a++) {
        best_of_all &= fabs(axis[a]) < 1e-12; /* stationary */
    }
    for (int i = 0; i < 200; i++) {
        random_rotation(state, k, other);
        best_of_all &= trace_of_product(k, other, M) <= best + 1e-13;
    }
    return best_of_all;
}

static void closest_rotation_beats_all_others(void)
{
    uint64_t state = 1;
    for (int32_t i = 0; i < 2 * KINDS * 100; i++) {
        int32_t k = 2 + i % 2;
        double M[9], R[9];
        make_matrix(i / 2 % KINDS, &state, k, M);
        closest_rotation(k, M, R);
        CHECK(is_closest_rotation(&state, k, M, R));
    }
}

/* Whatever their neighbours are, and in place. */
static void many_closest_rotations_are_those_of_each(void)
{
    enum { MOST = 11 };
    uint64_t state = 8;
    for (int32_t i = 0; i < 200; i++) {
        int32_t k = 2 + i % 2, count = 1 + i / 2 % MOST;
        double M[9 * MOST], R[9 * MOST];
        for (int32_t m = 0; m < count; m++) {
            make_matrix((i + m) % KINDS, &state, k, M + m * k * k);
        }
        memcpy(R, M, sizeof M);
        closest_rotations(k, count, R, R);
        for (int32_t m = 0; m < count; m++) {
            CHECK(is_closest_rotation(&state, k, M + m * k * k, R + m * k * k));
        }
    }
}

static void closest_rotation_does_not_depend_on_the_scale(void)
{
    uint64_t state = 2;
    for (int32_t i = 0; i < 200; i++) {
        int32_t k = 2 + i % 2;
        double M[9], R[9], scaled[9], same[9], scale = i % 4 < 2 ? 1e-120 : 1e120;
        make_matrix(i / 2 % 2, &state, k, M);
        closest_rotation(k, M, R);
        for (int32_t j = 0; j < k * k; j++) {
            scaled[j] = scale * M[j];
        }
        closest_rotation(k, scaled, same);
        CHECK(is_rotation(k, same));
        CHECK(angle_between(k, R, same) < 1e-7); /* the choice may be a close one */
    }
}

static void closest_rotation_finds_the_one_that_carried_the_points(void)
{
    uint64_t state = 3;
    for (int32_t i = 0; i < 200; i++) {
        int32_t k = 2 + i % 2;
        double R[9], found[9], M[9] = {0}, offset[3] = {0};
        random_rotation(&state, k, R);
        for (int p = 0; p < 5; p++) {
            double x[3], y[3];
            for (int32_t a = 0; a < k; a++) {
                y[a] = x[a] = random_between(&state, -1.0, 1.0);
            }
            move_points(k, R, offset, 1, y);
            for (int32_t j = 0; j < k * k; j++) {
                M[j] += x[j / k] * y[j % k];
            }
        }
        closest_rotation(k, M, found);
        CHECK(angle_between(k, R, found) < 1e-12);
    }
}

/* exp(W) by its series, W the skew matrix of w: W x = w cross x, or 90 degrees times w. */
static void exponential_series(int32_t k, const double *w, double *E)
{
    const double plane[] = {0, -w[0], w[0], 0};
    double space[9] = {0}, term[9], next[9];
    if (k == 3) {
        const double skew[] = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
        memcpy(space, skew, sizeof skew);
    }
    identity_matrix(k, E);
    identity_matrix(k, term);
    for (int n = 1; n < 60; n++) {
        multiply(k, k == 2 ? plane : space, term, next);
        for (int32_t i = 0; i < k * k; i++) {
            term[i] = next[i] / n;
            E[i] += term[i];
        }
    }
}

static void turning_is_the_exponential(void)
{
    const double sizes[] = {0.0, 1e-300, 1e-12, 1e-8, 2e-8, 1e-4, 0.3, 2.0, 6.0};
    uint64_t state = 4;
    for (int32_t i = 0; i < 180; i++) {
        int32_t k = 2 + i % 2;
        double w[3], R[9], turned[9], E[9], expected[9];
        for (int32_t a = 0; a < 3; a++) {
            w[a] = sizes[i / 2 % 9] * random_between(&state, -1.0, 1.0);
        }
        random_rotation(&state, k, R);
        memcpy(turned, R, sizeof R);
        turn(k, w, turned);
        exponential_series(k, w, E);
        multiply(k, E, R, expected);
        for (int32_t j = 0; j < k * k; j++) {
            CHECK_NEAR(turned[j], expected[j], 1e-13);
        }
        CHECK(is_rotation(k, turned));
    }
}

static void axial_vector_is_the_derivative_of_the_trace(void)
{
    const double step = 1e-5;
    uint64_t state = 5;
    for (int32_t i = 0; i < 100; i++) {
        int32_t k = 2 + i % 2;
        double M[9], axis[3];
        random_matrix(&state, k, M);
        axial_vector(k, M, axis);
        for (int32_t a = 0; a < tangent_size(k); a++) {
            double forth[9], back[9], w[3] = {0};
            identity_matrix(k, forth);
            identity_matrix(k, back);
            w[a] = step;
            turn(k, w, forth);
            w[a] = -step;
            turn(k, w, back);
            double slope = trace_of_product(k, forth, M) - trace_of_product(k, back, M);
            CHECK_NEAR(slope / (2.0 * step), axis[a], 1e-9);
        }
    }
}

static void skew_matrix_is_the_transpose_of_axial_vector(void)
{
    uint64_t state = 8;
    for (int32_t i = 0; i < 100; i++) {
        int32_t k = 2 + i % 2;
        double M[9], W[9], w[3], axis[3], sum = 0.0;
        random_matrix(&state, k, M);
        axial_vector(k, M, axis);
        for (int32_t a = 0; a < tangent_size(k); a++) {
            w[a] = random_between(&state, -1.0, 1.0);
            sum += w[a] * axis[a];
        }
        skew_matrix(k, w, W);
        CHECK_NEAR(trace_of_product(k, W, M), sum, 1e-15);
    }
}

/* (A 29-30) against finite differences, for matrices that are turned over as well. */
static void closest_rotation_turns_as_its_derivative_says(void)
{
    const double step = 1e-6;
    uint64_t state = 9;
    for (int32_t i = 0; i < 400; i++) {
        int32_t k = 2 + i % 2;
        double M[9], dM[9], R[9], moved[9], there[9], axis[3], product[9], w[3];
        make_matrix(i / 2 % 2, &state, k, M);
        random_matrix(&state, k, dM);
        closest_rotation(k, M, R);
        multiply(k, R, dM, product);
        axial_vector(k, product, axis);
        solve_for_turn(k, R, M, axis, w);
        double size = 1.0;
        for (int32_t a = 0; a < tangent_size(k); a++) {
            size += w[a] * w[a];
        }
        for (int32_t a = 0; a < tangent_size(k); a++) {
            w[a] *= step / size;
        }
        for (int32_t j = 0; j < k * k; j++) {
            moved[j] = M[j] + step / size * dM[j];
        }
        closest_rotation(k, moved, there);
        turn(k, w, R);
        CHECK_NEAR(angle_between(k, R, there) / step, 0.0, 1e-4);
    }
}

static void open_rotations_do_not_turn(void)
{
    const double zero[9] = {0}, axis[] = {1.0, -2.0, 3.0};
    for (int32_t k = 2; k <= 3; k++) {
        double R[9], w[3] = {7.0, 7.0, 7.0};
        identity_matrix(k, R);
        solve_for_turn(k, R, zero, axis, w);
        for (int32_t a = 0; a < tangent_size(k); a++) {
            CHECK(w[a] == 0.0);
        }
    }
}

static void angles_are_right_from_tiny_to_half_a_turn(void)
{
    const double angles[] = {0.0, 1e-12, 1e-9, 1e-6, 0.1, 1.0, PI - 1e-3, PI - 1e-7, PI};
    uint64_t state = 6;
    for (int32_t i = 0; i < 180; i++) {
        int32_t k = 2 + i % 2;
        double angle = angles[i / 2 % 9], R[9], turned[9], w[3] = {angle}, length = 0.0;
        if (k == 3) {
            for (int32_t a = 0; a < 3; a++) {
                w[a] = random_between(&state, -1.0, 1.0);
                length += w[a] * w[a];
            }
            for (int32_t a = 0; a < 3; a++) {
                w[a] *= angle / sqrt(length);
            }
        }
        random_rotation(&state, k, R);
        memcpy(turned, R, sizeof R);
        turn(k, w, turned);
        /* Entries are exact to a few 1e-16; near half a turn the angle is a square root of that. */
        CHECK_NEAR(angle_between(k, R, turned), angle, angle < 3.0 ? 2e-15 : 1e-7);
        CHECK_NEAR(angle_between(k, turned, R), angle, angle < 3.0 ? 2e-15 : 1e-7);
    }
}

static void products_agree_with_each_other(void)
{
    uint64_t state = 7;
    for (int32_t i = 0; i < 20; i++) {
        int32_t k = 2 + i % 2;
        double A[9], B[9], At[9], Bt[9], AB[9], from_nt[9], from_tn[9], trace = 0.0;
        random_matrix(&state, k, A);
        random_matrix(&state, k, B);
        for (int32_t j = 0; j < k * k; j++) {
            At[j] = A[j % k * k + j / k];
            Bt[j] = B[j % k * k + j / k];
        }
        multiply(k, A, B, AB);
        multiply_nt(k, A, Bt, from_nt);
        multiply_tn(k, At, B, from_tn);
        for (int32_t j = 0; j < k * k; j++) {
            double sum = 0.0;
            for (int32_t c = 0; c < k; c++) {
                sum += A[j / k * k + c] * B[c * k + j % k];
            }
            CHECK_NEAR(AB[j], sum, 1e-15);
            CHECK_NEAR(from_nt[j], sum, 1e-15);
            CHECK_NEAR(from_tn[j], sum, 1e-15);
            trace += j % (k + 1) == 0 ? sum : 0.0;
        }
        CHECK_NEAR(trace_of_product(k, A, B), trace, 1e-15);
    }
}

int main(int argc, char **argv)
{
    RUN(closest_rotation_beats_all_others);
    RUN(many_closest_rotations_are_those_of_each);
    RUN(closest_rotation_does_not_depend_on_the_scale);
    RUN(closest_rotation_finds_the_one_that_carried_the_points);
    RUN(turning_is_the_exponential);
    RUN(axial_vector_is_the_derivative_of_the_trace);
    RUN(skew_matrix_is_the_transpose_of_axial_vector);
    RUN(closest_rotation_turns_as_its_derivative_says);
    RUN(open_rotations_do_not_turn);
    RUN(angles_are_right_from_tiny_to_half_a_turn);
    RUN(products_agree_with_each_other);
    return TEST_RESULT;
}
