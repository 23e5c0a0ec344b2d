/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dense/cholesky_update.h"

#include "dense/dense.h"
#include "dense/dispatch.h"

#include <math.h>
#include <string.h>

/* Columns reflected at a time, so that what is summed up over the rows stays in the cache. */
enum { STRIP = 64 };

/* The least part of a direction's stiffness that dropped rows have to leave. */
static const double LEAST_LEFT = 1e-12;

/* Columns `from` to `to` of row g of G and of the rows of X are reflected along (1, u), where u
 * stands in column i of X: (g, X) <- w (1, u) - (g, X) for g, (g, X) - w (1, u) for X, with w the
 * reflection's share of the column. */
DISPATCHED static void reflect(double *g, double *X, int32_t n, int32_t rows, int32_t i,
                               double factor, int32_t from, int32_t to)
{
    double w[STRIP];
    int32_t width = to - from;
    memcpy(w, g + from, (size_t)width * sizeof *w);
    for (int32_t l = 0; l < rows; l++) {
        const double *x = X + (size_t)l * (size_t)n;
        double u = x[i];
        for (int32_t j = 0; j < width; j++) {
            w[j] += u * x[from + j];
        }
    }
    for (int32_t j = 0; j < width; j++) {
        w[j] *= factor;
        g[from + j] = w[j] - g[from + j];
    }
    for (int32_t l = 0; l < rows; l++) {
        double *x = X + (size_t)l * (size_t)n;
        double u = x[i];
        for (int32_t j = 0; j < width; j++) {
            x[from + j] -= u * w[j];
        }
    }
}

/* [G; X] is made triangular by a Householder reflection for each row of G. That of row i takes
 * (g_ii, X_i) to (-norm, 0): of the two reflections that would do, the one without cancellation.
 * The row of G then changes its sign, so that the diagonal stays positive. */
void cholesky_add_rows(double *G, int32_t n, double *X, int32_t rows)
{
    for (int32_t i = 0; i < n; i++) {
        double *g = G + (size_t)i * (size_t)n;
        double squares = g[i] * g[i];
        for (int32_t l = 0; l < rows; l++) {
            double x = X[(size_t)l * (size_t)n + (size_t)i];
            squares += x * x;
        }
        double norm = sqrt(squares), reach = g[i] + norm;
        for (int32_t l = 0; l < rows; l++) {
            X[(size_t)l * (size_t)n + (size_t)i] /= reach;
        }
        g[i] = norm;
        for (int32_t j = i + 1; j < n; j += STRIP) {
            reflect(g, X, n, rows, i, reach / norm, j, j + STRIP < n ? j + STRIP : n);
        }
    }
}

/* (g, z) <- (c g - s z, s g + c z) */
DISPATCHED static void rotate(double *restrict g, double *restrict z, int32_t count, double c,
                              double s)
{
    for (int32_t j = 0; j < count; j++) {
        double before = g[j];
        g[j] = c * before - s * z[j];
        z[j] = s * before + c * z[j];
    }
}

/* Q of P P^T + Q^T Q = I; 0 where there is none to speak of. */
static int find_remainder(const double *P, int32_t n, int32_t rows, double *Q)
{
    size_t size = (size_t)rows;
    memset(Q, 0, size * size * sizeof *Q);
    add_product_nt(rows, rows, n, -1.0, P, n, P, n, Q, rows);
    for (size_t l = 0; l < size; l++) {
        Q[l * size + l] += 1.0;
    }
    int left = cholesky_factor(Q, rows);
    for (size_t l = 0; l < size && left; l++) {
        left = Q[l * size + l] * Q[l * size + l] >= LEAST_LEFT;
    }
    return left;
}

/* With P = X G^-1 the columns of [P^T; Q] are orthonormal, so that there are rotations which take
 * them to [0; I]. The same rotations take [G; 0] to a triangle and rows Z with
 * X = P G = [P^T; Q]^T [G; 0] = [0; I]^T [G'; Z] = Z: G' is G without X. From the last row up they
 * turn row i of G against each row of Q, and that fills the triangle and no more. Z takes the room
 * of P from the right, column by column as P is used up. */
int cholesky_drop_rows(double *G, int32_t n, double *X, int32_t rows, double *work)
{
    double *P = X, *Q = work;
    solve_right_upper(P, rows, n, G, n, n);
    if (!find_remainder(P, n, rows, Q)) {
        return 0;
    }
    for (int32_t i = n - 1; i >= 0; i--) {
        for (int32_t l = 0; l < rows; l++) {
            double *z = P + (size_t)l * (size_t)n + (size_t)i, *q = Q + (size_t)l * (size_t)rows;
            double p = z[0], norm = sqrt(p * p + q[l] * q[l]), c = q[l] / norm, s = p / norm;
            q[l] = norm;
            for (int32_t m = l + 1; m < rows; m++) {
                double *other = P + (size_t)m * (size_t)n + (size_t)i, before = *other;
                *other = c * before - s * q[m];
                q[m] = s * before + c * q[m];
            }
            z[0] = 0.0;
            rotate(G + (size_t)i * (size_t)n + (size_t)i, z, n - i, c, s);
        }
    }
    return 1;
}
