/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "rotation.h"

#include "dense.h"
#include "vector.h"

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

static void quaternion_matrix(const double *q, double *R)
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

/* One Jacobi rotation that zeroes A[p][q] of a symmetric matrix; V collects the eigenvectors. */
static void jacobi_rotate(double A[4][4], double V[4][4], int p, int q)
{
    if (A[p][q] == 0.0) {
        return;
    }
    double theta = (A[q][q] - A[p][p]) / (2.0 * A[p][q]);
    double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int i = 0; i < 4; i++) {
        double ip = A[i][p], iq = A[i][q];
        A[i][p] = c * ip - s * iq;
        A[i][q] = s * ip + c * iq;
    }
    for (int i = 0; i < 4; i++) {
        double pi = A[p][i], qi = A[q][i];
        A[p][i] = c * pi - s * qi;
        A[q][i] = s * pi + c * qi;
        double vp = V[i][p], vq = V[i][q];
        V[i][p] = c * vp - s * vq;
        V[i][q] = s * vp + c * vq;
    }
}

/* The unit eigenvector of the largest eigenvalue of a symmetric 4 by 4 matrix, which is lost. */
static void largest_eigenvector(double A[4][4], double *vector)
{
    double V[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int sweep = 0; sweep < 12; sweep++) {
        double off = 0.0, on = 0.0;
        for (int p = 0; p < 4; p++) {
            on += A[p][p] * A[p][p];
            for (int q = p + 1; q < 4; q++) {
                off += A[p][q] * A[p][q];
            }
        }
        if (off <= 1e-34 * on) {
            break;
        }
        for (int p = 0; p < 4; p++) {
            for (int q = p + 1; q < 4; q++) {
                jacobi_rotate(A, V, p, q);
            }
        }
    }
    int best = 0;
    for (int i = 1; i < 4; i++) {
        best = A[i][i] > A[best][best] ? i : best;
    }
    for (int i = 0; i < 4; i++) {
        vector[i] = V[i][best];
    }
}

/* tr(R M) is a quadratic form in the unit quaternion of R: its maximiser is an eigenvector (Horn
 * 1987). Unlike the singular value decomposition it needs no repair for reflections. */
static void find_by_eigenvector(const double *M, double *R)
{
    double xx = M[0], xy = M[1], xz = M[2];
    double yx = M[3], yy = M[4], yz = M[5];
    double zx = M[6], zy = M[7], zz = M[8];
    double N[4][4] = {
        {xx + yy + zz, yz - zy, zx - xz, xy - yx},
        {yz - zy, xx - yy - zz, xy + yx, zx + xz},
        {zx - xz, xy + yx, yy - xx - zz, yz + zy},
        {xy - yx, zx + xz, yz + zy, zz - xx - yy},
    };
    double q[4];
    largest_eigenvector(N, q);
    quaternion_matrix(q, R);
}

PART void find_cofactors(const double *M, double *cofactors)
{
    for (int i = 0; i < 3; i++) {
        const double *next = M + (i + 1) % 3 * 3, *last = M + (i + 2) % 3 * 3;
        cofactors[i * 3] = next[1] * last[2] - next[2] * last[1];
        cofactors[i * 3 + 1] = next[2] * last[0] - next[0] * last[2];
        cofactors[i * 3 + 2] = next[0] * last[1] - next[1] * last[0];
    }
}

PART double sum_of_products(const double *A, const double *B)
{
    double sum = 0.0;
    for (int i = 0; i < 9; i++) {
        sum += A[i] * B[i];
    }
    return sum;
}

/* R^T S = M with S symmetric, of the singular values s_i of M; where the determinant of M is
 * negative, so is the least of them. Their sum x is the largest root of Horn's characteristic
 * polynomial, and is come to from above by Newton's method. From there the theorem of Cayley and
 * Hamilton for S makes R^T a polynomial in M, divided by the product of all s_i + s_j. Returns that
 * product: it is zero where the closest rotation is not unique. */
PART double find_by_invariants(const double *M, double *R)
{
    double C[9], MM[9], MMM[9];
    find_cofactors(M, C);
    double squares = sum_of_products(M, M), products = sum_of_products(C, C);
    double determinant = M[0] * C[0] + M[1] * C[1] + M[2] * C[2];
    double constant = squares * squares - 4.0 * products;
    double x = sqrt(squares + sqrt(12.0 * products)), gap = 0.0, step = INFINITY;
    for (int i = 0; i < 20 && step > 1e-15 * x; i++) {
        double value = x * (x * (x * x - 2.0 * squares) - 8.0 * determinant) + constant;
        gap = 0.5 * x * (x * x - squares) - determinant;
        step = value / (8.0 * gap);
        x -= step;
    }
    multiply_nt(3, M, M, MM);
    multiply(3, MM, M, MMM);
    double inverse = 1.0 / gap;
    for (int i = 0; i < 9; i++) {
        double turned = 0.5 * (x * x + squares) * M[i] + x * C[i] - MMM[i];
        R[i % 3 * 3 + i / 3] = turned * inverse;
    }
    return gap;
}

/* One step of Newton's method for tr(R M) and one for R R^T = I. Returns the square of the turn. */
PART double refine(const double *M, double *R)
{
    double A[9], B[9], C[9], a[3], w[3], RRR[9], squares = 0.0;
    multiply(3, R, M, A);
    axial_vector(3, A, a);
    double trace = A[0] + A[4] + A[8];
    for (int i = 0; i < 9; i++) {
        B[i] = (i % 4 == 0 ? trace : 0.0) - 0.5 * (A[i] + A[i % 3 * 3 + i / 3]);
    }
    find_cofactors(B, C);
    double determinant = B[0] * C[0] + B[1] * C[1] + B[2] * C[2];
    for (int i = 0; i < 3; i++) {
        w[i] = (C[i * 3] * a[0] + C[i * 3 + 1] * a[1] + C[i * 3 + 2] * a[2]) / determinant;
        squares += w[i] * w[i];
    }
    for (int j = 0; j < 3; j++) {
        double x = R[j], y = R[3 + j], z = R[6 + j];
        R[j] += w[1] * z - w[2] * y;
        R[3 + j] += w[2] * x - w[0] * z;
        R[6 + j] += w[0] * y - w[1] * x;
    }
    multiply_nt(3, R, R, A);
    multiply(3, A, R, RRR);
    for (int i = 0; i < 9; i++) {
        R[i] = 1.5 * R[i] - 0.5 * RRR[i];
    }
    return squares;
}

/* The direct way, which takes a tenth of the time, loses the digits that the gap is small by. */
DISPATCHED static void closest_rotation_3d(const double *M, double *R)
{
    double scaled[9], largest = 0.0;
    for (int i = 0; i < 9; i++) {
        largest = fabs(M[i]) > largest ? fabs(M[i]) : largest;
    }
    for (int i = 0; i < 9; i++) {
        scaled[i] = M[i] / largest;
    }
    if (!(find_by_invariants(scaled, R) > 1e-5 && refine(scaled, R) < 1e-14)) {
        find_by_eigenvector(M, R);
    }
}

void closest_rotation(int32_t k, const double *M, double *R)
{
    if (k == 3) {
        closest_rotation_3d(M, R);
        return;
    }
    /* tr(R M) = c (M00 + M11) + s (M01 - M10). */
    double c = M[0] + M[3], s = M[1] - M[2];
    double length = hypot(c, s);
    c = length > 0.0 ? c / length : 1.0;
    s = length > 0.0 ? s / length : 0.0;
    R[0] = c;
    R[1] = -s;
    R[2] = s;
    R[3] = c;
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

double angle_between(int32_t k, const double *A, const double *B)
{
    /* |A - B|^2 = 2 k - 2 tr(A B^T): exact for small angles, where the trace is not. */
    double squares = 0.0;
    for (int32_t i = 0; i < k * k; i++) {
        squares += (A[i] - B[i]) * (A[i] - B[i]);
    }
    double sine = sqrt(squares / 8.0);
    return 2.0 * asin(sine < 1.0 ? sine : 1.0);
}
