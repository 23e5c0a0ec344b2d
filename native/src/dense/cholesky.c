/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Cholesky factorisations A = G^T G of the matrices of a solve. They have 5 to 100 rows, where
 * LAPACK's call costs more than the work, and its thread-dependent blocking would make results
 * depend on the machine.
 *
 * Rows come in blocks of four. So that what is right of a block's first column is a multiple of
 * four wide, the rows that are left over come first, one by one. */
#include "dense/dense.h"

#include "dense/vector.h"

#include <math.h>

enum { ROWS = LANES, WIDEST = 3 };

/* The factor of a block's own columns: its upper triangle, and one over its diagonal. */
typedef struct corner {
    double G[ROWS][ROWS], inverse[ROWS];
} corner;

/* Four rows by some vectors: as many as stay in registers. */
typedef packed tile[ROWS][WIDEST];

/* Columns j and on of rows i to i + 3 of A, less what the rows of G above take from them. */
PART void begin_tile(const double *A, size_t n, size_t i, size_t j, int width, tile t)
{
    for (int r = 0; r < ROWS; r++) {
        for (int v = 0; v < width; v++) {
            t[r][v] = *packed_at(A + (i + (size_t)r) * n + j + (size_t)(LANES * v));
        }
    }
    for (size_t l = 0; l < i; l++) {
        const double *row = A + l * n;
        packed x[WIDEST];
        for (int v = 0; v < width; v++) {
            x[v] = *packed_at(row + j + (size_t)(LANES * v));
        }
        for (int r = 0; r < ROWS; r++) {
            for (int v = 0; v < width; v++) {
                t[r][v] -= row[i + (size_t)r] * x[v];
            }
        }
    }
}

/* From there to rows of G. */
PART void end_tile(double *A, size_t n, size_t i, size_t j, int width, const corner *own, tile t)
{
    for (int r = 0; r < ROWS; r++) {
        for (int v = 0; v < width; v++) {
            for (int l = 0; l < r; l++) {
                t[r][v] -= own->G[l][r] * t[l][v];
            }
            t[r][v] *= own->inverse[r];
            *writable_packed_at(A + (i + (size_t)r) * n + j + (size_t)(LANES * v)) = t[r][v];
        }
    }
}

/* Returns 0 where the corner at the head of a tile is not positive definite. */
PART int factor_corner(tile t, corner *own)
{
    for (int r = 0; r < ROWS; r++) {
        for (int c = r; c < ROWS; c++) {
            own->G[r][c] = t[r][0][c];
            for (int l = 0; l < r; l++) {
                own->G[r][c] -= own->G[l][r] * own->G[l][c];
            }
        }
        if (!(own->G[r][r] > 0.0)) {
            return 0;
        }
        own->inverse[r] = 1.0 / sqrt(own->G[r][r]);
        for (int c = r; c < ROWS; c++) {
            own->G[r][c] *= own->inverse[r];
        }
    }
    return 1;
}

/* The tile with the block's corner. */
PART int factor_first_tile(double *A, size_t n, size_t i, int width, corner *own)
{
    tile t;
    begin_tile(A, n, i, i, width, t);
    int definite = factor_corner(t, own);
    end_tile(A, n, i, i, width, own, t);
    return definite;
}

PART int factor_rows(double *A, size_t n, size_t i)
{
    corner own;
    size_t vectors = (n - i) / LANES, first = vectors == 1 ? 1 : 2 + vectors % 2;
    int definite = first == 1   ? factor_first_tile(A, n, i, 1, &own)
                   : first == 2 ? factor_first_tile(A, n, i, 2, &own)
                                : factor_first_tile(A, n, i, 3, &own);
    for (size_t j = i + first * LANES; j < n && definite; j += 2 * LANES) {
        tile t;
        begin_tile(A, n, i, j, 2, t);
        end_tile(A, n, i, j, 2, &own, t);
    }
    return definite;
}

PART int factor_row(double *A, size_t n, size_t i)
{
    double *row = A + i * n;
    for (size_t l = 0; l < i; l++) {
        const double *above = A + l * n;
        double factor = above[i];
        for (size_t j = i; j < n; j++) {
            row[j] -= factor * above[j];
        }
    }
    int definite = row[i] > 0.0;
    double inverse = 1.0 / sqrt(row[i]);
    for (size_t j = i; j < n; j++) {
        row[j] *= inverse;
    }
    return definite;
}

DISPATCHED int cholesky_factor(double *A, int32_t order)
{
    size_t n = (size_t)order, i = 0;
    int definite = 1;
    for (; i < n % ROWS && definite; i++) {
        definite = factor_row(A, n, i);
    }
    for (; i < n && definite; i += ROWS) {
        definite = factor_rows(A, n, i);
    }
    return definite;
}

/* x <- G^-T x */
PART void solve_forward(const double *G, size_t n, double *x)
{
    size_t i = 0;
    for (; i < n % ROWS; i++) {
        const double *row = G + i * n;
        x[i] /= row[i];
        for (size_t j = i + 1; j < n; j++) {
            x[j] -= row[j] * x[i];
        }
    }
    for (; i < n; i += ROWS) {
        const double *row = G + i * n;
        double y[ROWS];
        for (size_t r = 0; r < ROWS; r++) {
            double inverse = 1.0 / row[r * n + i + r];
            y[r] = x[i + r];
            for (size_t l = 0; l < r; l++) {
                y[r] -= row[l * n + i + r] * y[l];
            }
            x[i + r] = y[r] *= inverse;
        }
        for (size_t j = i + ROWS; j < n; j += LANES) {
            packed *rest = writable_packed_at(x + j);
            for (size_t r = 0; r < ROWS; r++) {
                *rest -= y[r] * *packed_at(row + r * n + j);
            }
        }
    }
}

/* x <- G^-1 x */
PART void solve_backward(const double *G, size_t n, double *x)
{
    size_t single = n % ROWS;
    for (size_t i = n; i > single;) {
        i -= ROWS;
        const double *row = G + i * n;
        packed sum[ROWS] = {{0.0}};
        for (size_t j = i + ROWS; j < n; j += LANES) {
            for (size_t r = 0; r < ROWS; r++) {
                sum[r] += *packed_at(row + r * n + j) * *packed_at(x + j);
            }
        }
        for (size_t r = ROWS; r-- > 0;) {
            double inverse = 1.0 / row[r * n + i + r];
            x[i + r] -= sum_of_lanes(sum + r);
            for (size_t l = r + 1; l < ROWS; l++) {
                x[i + r] -= row[r * n + i + l] * x[i + l];
            }
            x[i + r] *= inverse;
        }
    }
    for (size_t i = single; i-- > 0;) {
        const double *row = G + i * n;
        for (size_t j = i + 1; j < n; j++) {
            x[i] -= row[j] * x[j];
        }
        x[i] /= row[i];
    }
}

/* X <- G^-T X, row by row. */
PART void solve_rows_forward(const double *G, size_t n, double *X, size_t width)
{
    for (size_t i = 0; i < n; i++) {
        double *x = X + i * width, inverse = 1.0 / G[i * n + i];
        for (size_t c = 0; c < width; c++) {
            x[c] *= inverse;
        }
        for (size_t j = i + 1; j < n; j++) {
            for (size_t c = 0; c < width; c++) {
                X[j * width + c] -= G[i * n + j] * x[c];
            }
        }
    }
}

/* X <- G^-1 X */
PART void solve_rows_backward(const double *G, size_t n, double *X, size_t width)
{
    for (size_t i = n; i-- > 0;) {
        double *x = X + i * width, inverse = 1.0 / G[i * n + i];
        for (size_t j = i + 1; j < n; j++) {
            for (size_t c = 0; c < width; c++) {
                x[c] -= G[i * n + j] * X[j * width + c];
            }
        }
        for (size_t c = 0; c < width; c++) {
            x[c] *= inverse;
        }
    }
}

DISPATCHED void cholesky_solve_half(const double *G, int32_t n, double *B, int32_t columns)
{
    solve_rows_forward(G, (size_t)n, B, (size_t)columns);
}

DISPATCHED void cholesky_solve(const double *G, int32_t n, double *B, int32_t columns)
{
    if (columns == 1) {
        solve_forward(G, (size_t)n, B);
        solve_backward(G, (size_t)n, B);
    } else {
        solve_rows_forward(G, (size_t)n, B, (size_t)columns);
        solve_rows_backward(G, (size_t)n, B, (size_t)columns);
    }
}
