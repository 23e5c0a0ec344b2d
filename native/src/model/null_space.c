/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/null_space.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

static double column_product(const double *N, size_t size, size_t columns, size_t a, size_t b)
{
    double sum = 0.0;
    for (size_t i = 0; i < size; i++) {
        sum += N[i * columns + a] * N[i * columns + b];
    }
    return sum;
}

/* Gram-Schmidt, twice each; a column that depends on those before it becomes zero. */
static void make_orthonormal(double *N, size_t size, size_t columns)
{
    for (size_t b = 0; b < columns; b++) {
        double before = column_product(N, size, columns, b, b);
        for (int pass = 0; pass < 2; pass++) {
            for (size_t a = 0; a < b; a++) {
                double share = column_product(N, size, columns, a, b);
                for (size_t i = 0; i < size; i++) {
                    N[i * columns + b] -= share * N[i * columns + a];
                }
            }
        }
        double squares = column_product(N, size, columns, b, b);
        double scale = squares > 1e-20 * before ? 1.0 / sqrt(squares) : 0.0;
        for (size_t i = 0; i < size; i++) {
            N[i * columns + b] *= scale;
        }
    }
}

/* Room for the products of the form with N. */
typedef struct projection {
    double *N, *MN; /* turned + rows by columns */
    double *NMN;    /* columns square */
    double *block;  /* group_rows square */
    int32_t columns;
} projection;

/* MN <- the form times N. */
static void multiply_form(const reduction *r, projection *w)
{
    int32_t p = r->group_rows, h = r->rows, t = r->turned, c = w->columns;
    const double *N_rows = w->N + (size_t)t * (size_t)c;
    double *MN_rows = w->MN + (size_t)t * (size_t)c;
    for (int32_t g = 0; g < r->groups; g++) {
        size_t first = (size_t)(g * p) * (size_t)c;
        for (int32_t other = g; other < r->groups; other++) {
            size_t second = (size_t)(other * p) * (size_t)c;
            read_block(r, g, other, w->block);
            add_product(p, c, p, 1.0, w->block, p, w->N + second, c, w->MN + first, c);
            if (other > g) {
                add_product_tn(p, c, p, 1.0, w->block, p, w->N + first, c, w->MN + second, c);
            }
        }
    }
    add_product(t, c, h, -1.0, r->KF, h, N_rows, c, w->MN, c);
    add_product_tn(h, c, t, -1.0, r->KF, h, w->N, c, MN_rows, c);
    add_product(h, c, h, 1.0, r->FLF, h, N_rows, c, MN_rows, c);
}

/* A += factor (G N^T + N G^T) for the rows of G and N that belong to A's rows and columns. */
static void add_update(double factor, const double *G, const double *N, int32_t rows,
                       const double *G_columns, const double *N_columns, int32_t columns,
                       int32_t inner, double *A)
{
    add_product_nt(rows, columns, inner, factor, G, inner, N_columns, inner, A, columns);
    add_product_nt(rows, columns, inner, factor, N, inner, G_columns, inner, A, columns);
}

/* The form less G N^T + N G^T. */
static void update_form(reduction *r, projection *w)
{
    int32_t p = r->group_rows, h = r->rows, t = r->turned, c = w->columns;
    const double *N = w->N, *G = w->MN;
    size_t rows = (size_t)t * (size_t)c;
    for (int32_t g = 0; g < r->groups; g++) {
        size_t first = (size_t)(g * p) * (size_t)c;
        for (int32_t other = g; other < r->groups; other++) {
            size_t second = (size_t)(other * p) * (size_t)c;
            read_block(r, g, other, w->block);
            add_update(-1.0, G + first, N + first, p, G + second, N + second, p, c, w->block);
            write_block(r, g, other, w->block);
        }
    }
    add_update(1.0, G, N, t, G + rows, N + rows, h, c, r->KF);
    add_update(-1.0, G + rows, N + rows, h, G + rows, N + rows, h, c, r->FLF);
}

/* M <- (I - N N^T) M (I - N N^T), symmetric: with G = M N - N (N^T M N) / 2 it is M - G N^T - N
 * G^T. */
static void project(reduction *r, projection *w)
{
    int32_t size = r->turned + r->rows, c = w->columns;
    multiply_form(r, w);
    add_product_tn(c, c, size, 1.0, w->N, c, w->MN, c, w->NMN, c);
    add_product(size, c, c, -0.5, w->N, c, w->NMN, c, w->MN, c);
    update_form(r, w);
}

tug_status restore_null_space(reduction *energy, double *N, int32_t columns)
{
    size_t size = (size_t)(energy->turned + energy->rows), count = (size_t)columns;
    size_t p = (size_t)energy->group_rows;
    projection w = {.N = N, .columns = columns};
    w.MN = allocate(size * count, sizeof *w.MN);
    w.NMN = allocate(count * count, sizeof *w.NMN);
    w.block = allocate(p * p, sizeof *w.block);
    int room = w.MN && w.NMN && w.block;
    if (room) {
        make_orthonormal(N, size, count);
        project(energy, &w);
    }
    release(w.MN);
    release(w.NMN);
    release(w.block);
    return room ? TUG_OK : fail_memory();
}
