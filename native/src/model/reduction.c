/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/reduction.h"

#include "dense/dense.h"
#include "sparse/factor.h"

#include <string.h>

size_t coupling_offset(const reduction *r, int32_t g, int32_t h)
{
    size_t G = (size_t)r->groups, i = (size_t)g, p = (size_t)r->group_rows;
    return (i * G - i * (i + 1) / 2 + (size_t)h) * p * p;
}

size_t coupling_size(const reduction *r)
{
    size_t G = (size_t)r->groups, p = (size_t)r->group_rows;
    return r->shapes == 0 ? G * p * G * p : G * (G + 1) / 2 * p * p;
}

int32_t group_columns(const reduction *r, int32_t g)
{
    return support_count(r->support, g) * r->block;
}

double *group_rows_of_K(const reduction *r, int32_t g)
{
    return r->K + (size_t)r->support->starts[g] * (size_t)(r->block * r->group_rows);
}

/* Where a block has its entry (i, j): row i is component i % k of shape i / k. */
static size_t place_in_block(const reduction *r, int32_t i, int32_t j)
{
    int32_t S = r->shapes, k = r->group_rows / S;
    return (size_t)(((i % k * k + j % k) * S + i / k) * S + j / k);
}

static size_t place_in_square(const reduction *r, int32_t g, int32_t h, int32_t i, int32_t j)
{
    return (size_t)(g * r->group_rows + i) * (size_t)r->turned + (size_t)(h * r->group_rows + j);
}

void read_block(const reduction *r, int32_t g, int32_t h, double *block)
{
    int32_t p = r->group_rows;
    const double *C = r->C + (r->shapes == 0 ? 0 : coupling_offset(r, g, h));
    for (int32_t i = 0; i < p; i++) {
        for (int32_t j = 0; j < p; j++) {
            block[i * p + j] =
                C[r->shapes == 0 ? place_in_square(r, g, h, i, j) : place_in_block(r, i, j)];
        }
    }
}

void write_block(reduction *r, int32_t g, int32_t h, const double *block)
{
    int32_t p = r->group_rows;
    double *C = r->C + (r->shapes == 0 ? 0 : coupling_offset(r, g, h));
    for (int32_t i = 0; i < p; i++) {
        for (int32_t j = 0; j < p; j++) {
            double value = block[i * p + j];
            if (r->shapes == 0) {
                C[place_in_square(r, g, h, i, j)] = value;
                C[place_in_square(r, h, g, j, i)] = value;
            } else {
                C[place_in_block(r, i, j)] = value;
            }
        }
    }
}

void find_pull(const reduction *energy, const double *Y, int32_t k, double *pull)
{
    memset(pull, 0, (size_t)(energy->turned * k) * sizeof *pull);
    for (int32_t i = 0; i < energy->turned; i++) {
        for (int32_t r = 0; r < energy->rows; r++) {
            double factor = energy->KF[(size_t)i * (size_t)energy->rows + (size_t)r];
            for (int32_t a = 0; a < k; a++) {
                pull[i * k + a] += factor * Y[r * k + a];
            }
        }
    }
}

double energy_of_rows(const reduction *energy, const double *Y, int32_t k)
{
    double sum = 0.0;
    for (int32_t i = 0; i < energy->rows; i++) {
        for (int32_t j = 0; j < energy->rows; j++) {
            sum += energy->FLF[(size_t)i * (size_t)energy->rows + (size_t)j] *
                   dot(Y + i * k, Y + j * k, (size_t)k);
        }
    }
    return sum;
}

/* N = K^T V, unknowns by k; most blend weights are zero. work: unknowns k. */
static void apply_transposed_K(const reduction *r, const double *V, int32_t k, double *work,
                               double *N)
{
    size_t block = (size_t)(r->block * k);
    memset(N, 0, (size_t)(r->unknowns * k) * sizeof *N);
    for (int32_t g = 0; g < r->groups; g++) {
        const double *rows = group_rows_of_K(r, g);
        const int32_t *functions = support_of(r->support, g);
        int32_t columns = group_columns(r, g);
        memset(work, 0, (size_t)(columns * k) * sizeof *work);
        for (int32_t i = 0; i < r->group_rows; i += k, V += k * k, rows += k * columns) {
            if (dot(V, V, (size_t)(k * k)) != 0.0) {
                add_thin_product_tn(k, columns, k, rows, V, work);
            }
        }
        for (size_t i = 0; i < (size_t)(columns * k); i++) {
            N[(size_t)functions[i / block] * block + i % block] += work[i];
        }
    }
}

/* N <- M^-1 N, the dependent unknowns zero. work: twice unknowns k. */
static void solve_transforms(const reduction *r, int32_t k, double *work, double *N)
{
    int32_t rank = *r->rank;
    for (int32_t i = 0; i < rank; i++) {
        int32_t column = r->pivots[i];
        for (int32_t a = 0; a < k; a++) {
            work[i * k + a] = r->scale[column] * N[column * k + a];
        }
    }
    solve_factored(r->factor, rank, k, work + r->unknowns * k, work);
    memset(N, 0, (size_t)(r->unknowns * k) * sizeof *N);
    for (int32_t i = 0; i < rank; i++) {
        int32_t column = r->pivots[i];
        for (int32_t a = 0; a < k; a++) {
            N[column * k + a] = r->scale[column] * work[i * k + a];
        }
    }
}

/* (X T)_i. */
static void place_row(const reduction *r, int32_t i, const double *T, int32_t k, double *placed)
{
    const double *row = r->X + (size_t)i * (size_t)r->unknowns;
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t j = 0; j < r->unknowns; j++) {
        for (int32_t a = 0; a < k && row[j] != 0.0; a++) { /* most are zero */
            sum[a] += row[j] * T[j * k + a];
        }
    }
    memcpy(placed, sum, (size_t)k * sizeof *placed);
}

void recover_transforms(const reduction *r, const double *V, const double *Y, int32_t k,
                        double *work, double *T)
{
    size_t b = (size_t)r->unknowns;
    apply_transposed_K(r, V, k, work, T);
    solve_transforms(r, k, work, T);
    double *missing = work + b * (size_t)k; /* Y - X T; Z is M^-1 where rows are soft */
    memcpy(missing, Y, (size_t)(r->rows * k) * sizeof *missing);
    for (int32_t i = 0; i < r->rows && r->firmness == NULL; i++) {
        double placed[3];
        place_row(r, i, T, k, placed);
        for (int32_t a = 0; a < k; a++) {
            missing[i * k + a] -= placed[a];
        }
    }
    add_thin_product_tn(r->rows, r->unknowns, k, r->F, missing, T);
}

double soft_row_energy(const reduction *r, int32_t row, const double *T, const double *Y, int32_t k)
{
    double placed[3], squares = 0.0;
    if (r->firmness == NULL) {
        return 0.0;
    }
    place_row(r, row, T, k, placed);
    for (int32_t a = 0; a < k; a++) {
        squares += (placed[a] - Y[row * k + a]) * (placed[a] - Y[row * k + a]);
    }
    return r->firmness[row] * squares;
}
