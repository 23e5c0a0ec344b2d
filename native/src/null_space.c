/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "null_space.h"

#include "dense.h"
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

static void gather_form(const reduction *energy, double *M)
{
    size_t t = (size_t)energy->turned, h = (size_t)energy->rows, size = t + h;
    for (size_t i = 0; i < t; i++) {
        memcpy(M + i * size, energy->C + i * t, t * sizeof *M);
        for (size_t r = 0; r < h; r++) {
            M[i * size + t + r] = M[(t + r) * size + i] = -energy->KF[i * h + r];
        }
    }
    for (size_t r = 0; r < h; r++) {
        for (size_t q = 0; q < h; q++) { /* symmetric but for its own rounding */
            M[(t + r) * size + t + q] = 0.5 * (energy->FLF[r * h + q] + energy->FLF[q * h + r]);
        }
    }
}

static void scatter_form(const double *M, reduction *energy)
{
    size_t t = (size_t)energy->turned, h = (size_t)energy->rows, size = t + h;
    for (size_t i = 0; i < t; i++) {
        memcpy(energy->C + i * t, M + i * size, t * sizeof *M);
        for (size_t r = 0; r < h; r++) {
            energy->KF[i * h + r] = -M[i * size + t + r];
        }
    }
    for (size_t r = 0; r < h; r++) {
        memcpy(energy->FLF + r * h, M + (t + r) * size + t, h * sizeof *M);
    }
}

/* M <- (I - N N^T) M (I - N N^T), symmetric. */
static void project(double *M, const double *N, double *MN, double *NMN, int32_t size,
                    int32_t columns)
{
    add_product(size, columns, size, 1.0, M, size, N, columns, MN, columns);
    add_product_tn(columns, columns, size, 1.0, N, columns, MN, columns, NMN, columns);
    /* With G = M N - N (N^T M N) / 2, it is M - G N^T - N G^T. */
    add_product(size, columns, columns, -0.5, N, columns, NMN, columns, MN, columns);
    add_product_nt(size, size, columns, -1.0, MN, columns, N, columns, M, size);
    add_product_nt(size, size, columns, -1.0, N, columns, MN, columns, M, size);
}

tug_status restore_null_space(reduction *energy, double *N, int32_t columns)
{
    size_t size = (size_t)(energy->turned + energy->rows), count = (size_t)columns;
    double *M = allocate(size * size, sizeof *M), *MN = allocate(size * count, sizeof *MN);
    double *NMN = allocate(count * count, sizeof *NMN);
    int room = M && MN && NMN;
    if (room) {
        make_orthonormal(N, size, count);
        gather_form(energy, M);
        project(M, N, MN, NMN, (int32_t)size, columns);
        scatter_form(M, energy);
    }
    release(M);
    release(MN);
    release(NMN);
    return room ? TUG_OK : fail_memory();
}
