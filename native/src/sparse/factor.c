/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "sparse/factor.h"

#include "dense/dense.h"

#include <string.h>

enum { PANEL_ROWS = 64 };

static int32_t rows_from(int32_t first, int32_t n)
{
    return n - first < PANEL_ROWS ? n - first : PANEL_ROWS;
}

/* Doubles before the panel whose first row is `first`, a multiple of PANEL_ROWS. */
static size_t panel_offset(int32_t first, int32_t n)
{
    size_t rows = (size_t)first;
    return rows * (size_t)n - rows * (rows - (first > 0 ? PANEL_ROWS : 0)) / 2;
}

size_t factor_size(int32_t n)
{
    int32_t last = n > 0 ? (n - 1) / PANEL_ROWS * PANEL_ROWS : 0;
    return panel_offset(last, n) + (size_t)(n - last) * (size_t)(n - last);
}

void pack_factor(const double *square, int32_t ld, int32_t n, double *factor)
{
    for (int32_t i = 0; i < n; i++) {
        int32_t first = i / PANEL_ROWS * PANEL_ROWS;
        size_t width = (size_t)(n - first);
        memcpy(factor + panel_offset(first, n) + (size_t)(i - first) * width + (i - first),
               square + (size_t)i * (size_t)ld + (size_t)i, (size_t)(n - i) * sizeof *factor);
    }
}

void unpack_factor(const double *factor, int32_t n, double *square)
{
    memset(square, 0, (size_t)n * (size_t)n * sizeof *square);
    for (int32_t i = 0; i < n; i++) {
        int32_t first = i / PANEL_ROWS * PANEL_ROWS;
        size_t width = (size_t)(n - first), offset = (size_t)(i - first);
        memcpy(square + (size_t)i * (size_t)(n + 1),
               factor + panel_offset(first, n) + offset * width + offset,
               (size_t)(n - i) * sizeof *square);
    }
}

void solve_factor(const double *factor, int32_t n, int32_t count, double *x)
{
    for (int32_t first = 0; first < n; first += PANEL_ROWS) {
        int32_t rows = rows_from(first, n), width = n - first, rest = width - rows;
        const double *panel = factor + panel_offset(first, n);
        solve_right_upper(x + first, count, n, panel, rows, width);
        if (rest > 0) {
            add_product(count, rest, rows, -1.0, x + first, n, panel + rows, width,
                        x + first + rows, n);
        }
    }
}

void solve_factor_transposed(const double *factor, int32_t n, int32_t count, double *x)
{
    int32_t last = n > 0 ? (n - 1) / PANEL_ROWS * PANEL_ROWS : -PANEL_ROWS;
    for (int32_t first = last; first >= 0; first -= PANEL_ROWS) {
        int32_t rows = rows_from(first, n), width = n - first, rest = width - rows;
        const double *panel = factor + panel_offset(first, n);
        if (rest > 0) {
            add_product_nt(count, rows, rest, -1.0, x + first + rows, n, panel + rows, width,
                           x + first, n);
        }
        solve_right_upper_transposed(x + first, count, n, panel, rows, width);
    }
}

/* Rows to columns: x is n by `columns`, y the other way round. */
static void turn_over(int32_t n, int32_t columns, const double *x, double *y)
{
    for (int32_t i = 0; i < n; i++) {
        for (int32_t c = 0; c < columns; c++) {
            y[c * n + i] = x[i * columns + c];
        }
    }
}

void solve_factored(const double *factor, int32_t n, int32_t columns, double *work, double *x)
{
    if (n <= PANEL_ROWS) { /* a single panel is a square */
        cholesky_solve(factor, n, x, columns);
        return;
    }
    turn_over(n, columns, x, work);
    solve_factor(factor, n, columns, work);
    solve_factor_transposed(factor, n, columns, work);
    turn_over(columns, n, work, x);
}
