/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The closest rotations of (A 22), four at a time. */
#include "dense/rotation.h"
#include "dense/vector.h"

#include <math.h>
#include <string.h>

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

PART void find_cofactors(const packed *M, packed *C)
{
    for (int i = 0; i < 3; i++) {
        const packed *next = M + (i + 1) % 3 * 3, *last = M + (i + 2) % 3 * 3;
        C[i * 3] = next[1] * last[2] - next[2] * last[1];
        C[i * 3 + 1] = next[2] * last[0] - next[0] * last[2];
        C[i * 3 + 2] = next[0] * last[1] - next[1] * last[0];
    }
}

/* C = A B^T */
PART void multiply_packed_nt(const packed *A, const packed *B, packed *C)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const packed *a = A + i * 3, *b = B + j * 3;
            C[i * 3 + j] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        }
    }
}

/* C = A B */
PART void multiply_packed(const packed *A, const packed *B, packed *C)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            C[i * 3 + j] = A[i * 3] * B[j] + A[i * 3 + 1] * B[3 + j] + A[i * 3 + 2] * B[6 + j];
        }
    }
}

PART void add_squares(const packed *A, packed *sum)
{
    for (int i = 0; i < 9; i++) {
        *sum += A[i] * A[i];
    }
}

PART void take_roots(packed *x)
{
    for (int l = 0; l < LANES; l++) {
        (*x)[l] = sqrt((*x)[l]);
    }
}

/* R^T S = M with S symmetric, of the singular values s_i of M; where the determinant of M is
 * negative, so is the least of them. Their sum x is the largest root of Horn's characteristic
 * polynomial, and is come to from above by Newton's method. From there the theorem of Cayley and
 * Hamilton for S makes R^T a polynomial in M, divided by the product of all s_i + s_j. That is
 * `gap`: it is zero where the closest rotation is not unique. */
PART void find_by_invariants(const packed *M, packed *R, packed *gap)
{
    packed C[9], MM[9], MMM[9], squares = {0.0}, products = {0.0};
    find_cofactors(M, C);
    add_squares(M, &squares);
    add_squares(C, &products);
    packed determinant = M[0] * C[0] + M[1] * C[1] + M[2] * C[2];
    packed constant = squares * squares - 4.0 * products, x = 12.0 * products;
    take_roots(&x);
    x += squares;
    take_roots(&x);
    for (int i = 0, moving = 1; i < 20 && moving; i++) {
        packed value = x * (x * (x * x - 2.0 * squares) - 8.0 * determinant) + constant;
        *gap = 0.5 * x * (x * x - squares) - determinant;
        packed next = x - value / (8.0 * *gap);
        moving = 0;
        for (int l = 0; l < LANES; l++) {
            moving |= x[l] - next[l] > 1e-15 * x[l];
        }
        x = next;
    }
    multiply_packed_nt(M, M, MM);
    multiply_packed(MM, M, MMM);
    packed inverse = 1.0 / *gap;
    for (int i = 0; i < 9; i++) {
        R[i % 3 * 3 + i / 3] = (0.5 * (x * x + squares) * M[i] + x * C[i] - MMM[i]) * inverse;
    }
}

/* The turn w that is one step of Newton's method for tr(R M). */
PART void find_turn(const packed *M, const packed *R, packed *w)
{
    packed A[9], B[9], C[9];
    multiply_packed(R, M, A);
    packed trace = A[0] + A[4] + A[8];
    for (int i = 0; i < 9; i++) {
        B[i] = -0.5 * (A[i] + A[i % 3 * 3 + i / 3]);
    }
    for (int i = 0; i < 9; i += 4) {
        B[i] += trace;
    }
    find_cofactors(B, C);
    packed inverse = 1.0 / (B[0] * C[0] + B[1] * C[1] + B[2] * C[2]);
    const packed a[3] = {A[5] - A[7], A[6] - A[2], A[1] - A[3]};
    for (int i = 0; i < 3; i++) {
        w[i] = (C[i * 3] * a[0] + C[i * 3 + 1] * a[1] + C[i * 3 + 2] * a[2]) * inverse;
    }
}

/* R <- R + W R, and one step of Newton's method for R R^T = I from there. */
PART void turn_little(const packed *w, packed *R)
{
    packed RR[9], RRR[9];
    for (int j = 0; j < 3; j++) {
        packed x = R[j], y = R[3 + j], z = R[6 + j];
        R[j] += w[1] * z - w[2] * y;
        R[3 + j] += w[2] * x - w[0] * z;
        R[6 + j] += w[0] * y - w[1] * x;
    }
    multiply_packed_nt(R, R, RR);
    multiply_packed(RR, R, RRR);
    for (int i = 0; i < 9; i++) {
        R[i] = 1.5 * R[i] - 0.5 * RRR[i];
    }
}

/* Entry i of every matrix, over the largest of its matrix. */
PART void load_matrices(const double *const *from, packed *M)
{
    for (int l = 0; l < LANES; l++) {
        double largest = 0.0;
        for (int i = 0; i < 9; i++) {
            double size = fabs(from[l][i]);
            largest = size > largest ? size : largest;
        }
        for (int i = 0; i < 9; i++) {
            M[i][l] = from[l][i] / largest;
        }
    }
}

/* The direct way loses the digits that the gap is small by, so that is where the slow one serves.
 * From and to may be the same. */
PART void find_four(const double *const *from, double *const *to)
{
    packed M[9], R[9], w[3], gap = {0.0};
    load_matrices(from, M);
    find_by_invariants(M, R, &gap);
    find_turn(M, R, w);
    turn_little(w, R);
    packed squares = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    for (int l = 0; l < LANES; l++) {
        if (!(gap[l] > 1e-5 && squares[l] < 1e-14)) {
            double slow[9];
            find_by_eigenvector(from[l], slow);
            for (int i = 0; i < 9; i++) {
                R[i][l] = slow[i];
            }
        }
    }
    for (int l = 0; l < LANES; l++) {
        for (int i = 0; i < 9; i++) {
            to[l][i] = R[i][l];
        }
    }
}

/* In the last four, the last matrix stands for those that are missing. */
DISPATCHED static void find_in_space(int32_t count, const double *M, double *R)
{
    for (int32_t first = 0; first < count; first += LANES) {
        const double *from[LANES];
        double *to[LANES];
        for (int32_t l = 0; l < LANES; l++) {
            int32_t i = first + l < count ? first + l : count - 1;
            from[l] = M + i * 9;
            to[l] = R + i * 9;
        }
        find_four(from, to);
    }
}

/* tr(R M) = c (M00 + M11) + s (M01 - M10) */
static void find_in_plane(const double *M, double *R)
{
    double c = M[0] + M[3], s = M[1] - M[2];
    double length = hypot(c, s);
    c = length > 0.0 ? c / length : 1.0;
    s = length > 0.0 ? s / length : 0.0;
    R[0] = c;
    R[1] = -s;
    R[2] = s;
    R[3] = c;
}

void closest_rotations(int32_t k, int32_t count, const double *M, double *R)
{
    if (k == 3) {
        find_in_space(count, M, R);
        return;
    }
    for (int32_t i = 0; i < count; i++) {
        find_in_plane(M + i * 4, R + i * 4);
    }
}

void closest_rotation(int32_t k, const double *M, double *R)
{
    closest_rotations(k, 1, M, R);
}
