/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/smoothness.h"

#include "dense/dense.h"
#include "memory.h"
#include "weights/laplacian.h"

#include <math.h>
#include <string.h>

static const double STEEPEST_HALF_COTANGENT = 1e3; /* as for the eigenfunctions */

static tug_status bend_weights(const tug_mesh *mesh, const dictionary *D, double weight, double *U)
{
    laplacian L;
    tug_status status = laplacian_create(mesh, STEEPEST_HALF_COTANGENT, &L);
    size_t n = (size_t)D->vertices;
    for (size_t h = 0; h < (size_t)D->weights && status == TUG_OK; h++) {
        laplacian_bend(&L, D->weight_columns + h * n, U + h * n);
        for (size_t v = 0; v < n; v++) {
            U[h * n + v] *= sqrt(weight * L.mass[v]);
        }
    }
    laplacian_free(&L);
    return status;
}

tug_status find_smoothness(const tug_mesh *mesh, const dictionary *D, double weight, double *S)
{
    int32_t m = D->weights, n = D->vertices;
    memset(S, 0, (size_t)m * (size_t)m * sizeof *S);
    if (weight == 0.0) {
        return TUG_OK;
    }
    double *U = allocate((size_t)m * (size_t)n, sizeof *U); /* M^-1/2 L W, transposed */
    tug_status status = U != NULL ? bend_weights(mesh, D, weight, U) : fail_memory();
    if (status == TUG_OK) {
        add_product_nt(m, m, n, 1.0, U, n, U, n, S, m);
    }
    release(U);
    return status;
}

void add_smoothness(const dictionary *D, const double *S, int32_t first, int32_t count, double *L)
{
    size_t m = (size_t)D->weights, block = (size_t)(1 + count), b = m * block;
    size_t coordinates = (size_t)(D->shapes * D->dimension);
    for (size_t h = 0; h < m; h++) {
        const double *own = D->middles + h * coordinates + first;
        for (size_t j = 0; j <= h; j++) {
            const double *other = D->middles + j * coordinates + first;
            for (size_t r = 0; r < block; r++) {
                double *row = L + (h * block + r) * b + j * block;
                /* The columns' coordinates are about their middles: a translation of W_h takes
                 * these back. */
                double row_shift = r == 0 ? 1.0 : -own[r - 1];
                for (size_t c = 0; c < (j == h ? r + 1 : block); c++) {
                    double shift = c == 0 ? 1.0 : -other[c - 1];
                    row[c] += S[h * m + j] * (row_shift * shift + (r == c && r > 0 ? 1.0 : 0.0));
                }
            }
        }
    }
}
