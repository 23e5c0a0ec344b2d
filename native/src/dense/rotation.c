/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dense/rotation.h"

#include "dense/dense.h"

#include <math.h>
#include <string.h>

void axial_vector(int32_t k, const double *M, double *a)
{
    if (k == 2) {
        a[0] = M[1] - M[2];
        return;
    }
    a[0] = M[5] - M[7];
    a[1] = M[6] - M[2];
    a[2] = M[1] - M[3];
}

void quaternion_matrix(const double *q, double *R)
{
    double w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1.0 - 2.0 * (y * y + z * z);
    R[1] = 2.0 * (x * y - w * z);
    R[2] = 2.0 * (x * z + w * y);
    R[3] = 2.0 * (x * y + w * z);
    R[4] = 1.0 - 2.0 * (x * x + z * z);
    R[5] = 2.0 * (y * z - w * x);
    R[6] = 2.0 * (x * z - w * y);
    R[7] = 2.0 * (y * z + w * x);
    R[8] = 1.0 - 2.0 * (x * x + y * y);
}

void skew_matrix(int32_t k, const double *w, double *W)
{
    if (k == 2) {
        memcpy(W, (double[]){0.0, -w[0], w[0], 0.0}, 4 * sizeof *W);
        return;
    }
    memcpy(W, (double[]){0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0}, 9 * sizeof *W);
}

void solve_for_turn(int32_t k, const double *R, const double *M, const double *a, double *w)
{
    double S[9], J[9], trace = trace_of_product(k, R, M);
    int32_t t = tangent_size(k);
    multiply(k, R, M, S);
    for (int32_t i = 0; i < t * t; i++) {
        J[i] = k == 2 ? trace : (i % 4 == 0 ? trace : 0.0) - 0.5 * (S[i] + S[i % 3 * 3 + i / 3]);
    }
    memset(w, 0, (size_t)t * sizeof *w);
    if (cholesky_factor(J, t)) {
        memcpy(w, a, (size_t)t * sizeof *w);
        cholesky_solve(J, t, w, 1);
    }
}

static void exponential(int32_t k, const double *w, double *E)
{
    if (k == 2) {
        E[0] = E[3] = cos(w[0]);
        E[2] = sin(w[0]);
        E[1] = -E[2];
        return;
    }
    double half = 0.5 * sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    double scale = half > 1e-8 ? 0.5 * sin(half) / half : 0.5;
    double q[4] = {cos(half), scale * w[0], scale * w[1], scale * w[2]};
    quaternion_matrix(q, E);
}

void turn(int32_t k, const double *w, double *R)
{
    double E[9], product[9];
    exponential(k, w, E);
    multiply(k, E, R, product);
    memcpy(R, product, (size_t)(k * k) * sizeof *R);
}

double angle_of_distance(double squares)
{
    double sine = sqrt(squares / 8.0);
    return 2.0 * asin(sine < 1.0 ? sine : 1.0);
}

double angle_between(int32_t k, const double *A, const double *B)
{
    /* |A - B|^2 = 2 k - 2 tr(A B^T): exact for small angles, where the trace is not. */
    double squares = 0.0;
    for (int32_t i = 0; i < k * k; i++) {
        squares += (A[i] - B[i]) * (A[i] - B[i]);
    }
    return angle_of_distance(squares);
}
