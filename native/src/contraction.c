/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "contraction.h"

#include "rotation.h"

#include <string.h>

/* The S by S entries of component (a, b) of the blocks of groups g and h. */
static const double *component(const tug_model *model, const double *C, int32_t g, int32_t h,
                               int32_t ab)
{
    size_t G = (size_t)model->header.groups, kk = (size_t)model->header.dimension;
    size_t SS = (size_t)model->header.shapes;
    kk *= kk;
    SS *= SS;
    return C + (((size_t)g * G + (size_t)h) * kk + (size_t)ab) * SS;
}

static void mirror_lower(double *Q, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            Q[i * n + j] = Q[j * n + i];
        }
    }
}

void contract_rotations(const tug_model *model, const double *C, const double *R, double *Q)
{
    int32_t k = model->header.dimension, kk = k * k, G = model->header.groups;
    size_t S = (size_t)model->header.shapes, n = (size_t)G * S;
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++) {
            double P[9]; /* tr(R_g C R_h^T) = sum_ab (R_g^T R_h)_ab C_ab */
            multiply_tn(k, R + g * kk, R + h * kk, P);
            double *corner = Q + (size_t)g * S * n + (size_t)h * S;
            for (size_t s = 0; s < S; s++) {
                memset(corner + s * n, 0, S * sizeof *Q);
            }
            for (int32_t ab = 0; ab < kk; ab++) {
                const double *part = component(model, C, g, h, ab);
                for (size_t s = 0; s < S; s++) {
                    for (size_t t = 0; t < S; t++) {
                        corner[s * n + t] += P[ab] * part[s * S + t];
                    }
                }
            }
        }
    }
    mirror_lower(Q, n);
}

void contract_pair_rotations(const tug_model *model, const double *C, const double *R, double *Q)
{
    int32_t k = model->header.dimension, kk = k * k, S = model->header.shapes;
    int32_t n = model->header.groups * S;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = i; j < n; j++) {
            double P[9], sum = 0.0;
            multiply_tn(k, R + i * kk, R + j * kk, P);
            for (int32_t ab = 0; ab < kk; ab++) {
                sum += P[ab] * component(model, C, i / S, j / S, ab)[(i % S) * S + j % S];
            }
            Q[(size_t)i * (size_t)n + (size_t)j] = sum;
        }
    }
    mirror_lower(Q, (size_t)n);
}

void contract_blend(const tug_model *model, const double *C, const double *B, double *out)
{
    int32_t k = model->header.dimension, G = model->header.groups, S = model->header.shapes;
    size_t size = (size_t)(G * k);
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++) {
            for (int32_t ab = 0; ab < k * k; ab++) {
                const double *block = component(model, C, g, h, ab);
                double sum = 0.0;
                for (int32_t s = 0; s < S; s++) {
                    double row = 0.0;
                    for (int32_t t = 0; t < S; t++) {
                        row += block[s * S + t] * B[h * S + t];
                    }
                    sum += B[g * S + s] * row;
                }
                out[(size_t)(g * k + ab / k) * size + (size_t)(h * k + ab % k)] = sum;
            }
        }
    }
    mirror_lower(out, size);
}

void contract_blend_row(const tug_model *model, const double *C, int32_t pair, const double *B,
                        double *X)
{
    int32_t kk = model->header.dimension * model->header.dimension;
    int32_t G = model->header.groups, S = model->header.shapes;
    for (int32_t h = 0; h < G; h++) {
        for (int32_t ab = 0; ab < kk; ab++) {
            const double *row = component(model, C, pair / S, h, ab) + (pair % S) * S;
            double sum = 0.0;
            for (int32_t t = 0; t < S; t++) {
                sum += row[t] * B[h * S + t];
            }
            X[h * kk + ab] = sum;
        }
    }
}
