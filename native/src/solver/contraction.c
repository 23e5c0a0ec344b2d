/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/contraction.h"

#include "dense/rotation.h"
#include "dense/vector.h"

#include <string.h>

/* The S by S entries of component (a, b) of the blocks of groups g <= h. */
static const double *component(const coupling *from, int32_t g, int32_t h, int32_t ab)
{
    size_t G = (size_t)from->groups, S = (size_t)from->shapes, i = (size_t)g;
    size_t kk = (size_t)(from->k * from->k), block = i * G - i * (i + 1) / 2 + (size_t)h;
    return from->C + (block * kk + (size_t)ab) * S * S;
}

void gather_coupling(const coupling *all, const int32_t *shapes, int32_t width, double *out)
{
    int32_t kk = all->k * all->k, S = all->shapes;
    for (int32_t g = 0; g < all->groups; g++) {
        for (int32_t h = g; h < all->groups; h++) {
            for (int32_t ab = 0; ab < kk; ab++) {
                const double *entries = component(all, g, h, ab);
                for (int32_t s = 0; s < width; s++) {
                    const double *row = entries + shapes[g * width + s] * S;
                    for (int32_t t = 0; t < width; t++) {
                        *out++ = row[shapes[h * width + t]];
                    }
                }
            }
        }
    }
}

static void mirror_lower(double *Q, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            Q[i * n + j] = Q[j * n + i];
        }
    }
}

/* out_t = sum_ab P_ab C_ab[t] for the S entries of a row in every component. */
PART void contract_row(int32_t kk, const double *P, const double *C, size_t S, double *out)
{
    if (S < LANES) {
        for (size_t t = 0; t < S; t++) {
            out[t] = 0.0;
            for (int32_t ab = 0; ab < kk; ab++) {
                out[t] += P[ab] * C[(size_t)ab * S * S + t];
            }
        }
        return;
    }
    for (size_t t = 0; t < S; t += LANES) {
        size_t first = t + LANES <= S ? t : S - LANES; /* the last may do some a second time */
        packed sum = {0.0};
        for (int32_t ab = 0; ab < kk; ab++) {
            sum += P[ab] * *packed_at(C + (size_t)ab * S * S + first);
        }
        *writable_packed_at(out + first) = sum;
    }
}

/* tr(R_g C R_h^T) = sum_ab (R_g^T R_h)_ab C_ab */
PART void contract_upper(const coupling *from, int32_t k, const double *R, double *Q)
{
    int32_t kk = k * k, G = from->groups;
    size_t S = (size_t)from->shapes, n = (size_t)G * S;
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++) {
            const double *block = component(from, g, h, 0);
            double P[9], *corner = Q + (size_t)g * S * n + (size_t)h * S;
            multiply_tn(k, R + g * kk, R + h * kk, P);
            for (size_t s = 0; s < S; s++) {
                contract_row(kk, P, block + s * S, S, corner + s * n);
            }
        }
    }
}

DISPATCHED void contract_rotations(const coupling *from, const double *R, double *Q)
{
    if (from->k == 3) {
        contract_upper(from, 3, R, Q);
    } else {
        contract_upper(from, 2, R, Q);
    }
    mirror_lower(Q, (size_t)(from->groups * from->shapes));
}

void contract_pair_rotations(const coupling *from, const double *R, double *Q)
{
    int32_t k = from->k, kk = k * k, S = from->shapes;
    int32_t n = from->groups * S;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = i; j < n; j++) {
            const double *block = component(from, i / S, j / S, 0) + i % S * S + j % S;
            double P[9], sum = 0.0;
            multiply_tn(k, R + i * kk, R + j * kk, P);
            for (int32_t ab = 0; ab < kk; ab++) {
                sum += P[ab] * block[ab * S * S];
            }
            Q[(size_t)i * (size_t)n + (size_t)j] = sum;
        }
    }
    mirror_lower(Q, (size_t)n);
}

/* out_s += factor sum_ab P_ab C_ab of pairs (s, t), with step 1 along t or S along s. */
static void add_column(const coupling *from, const double *entries, const double *P, double factor,
                       int32_t step, double *out)
{
    size_t SS = (size_t)from->shapes * (size_t)from->shapes;
    for (int32_t ab = 0; ab < from->k * from->k; ab++, entries += SS) {
        for (int32_t s = 0; s < from->shapes; s++) {
            out[s] += factor * P[ab] * entries[s * step];
        }
    }
}

void apply_rotated_coupling(const coupling *from, const double *R, const double *B, double *out)
{
    int32_t k = from->k, kk = k * k, S = from->shapes, G = from->groups;
    memset(out, 0, (size_t)(G * S) * sizeof *out);
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++) {
            double P[9];
            const double *entries = component(from, g, h, 0);
            multiply_tn(k, R + g * kk, R + h * kk, P);
            for (int32_t i = 0; i < S; i++) {
                if (B[h * S + i] != 0.0) {
                    add_column(from, entries + i, P, B[h * S + i], S, out + g * S);
                }
                if (h > g && B[g * S + i] != 0.0) {
                    add_column(from, entries + i * S, P, B[g * S + i], 1, out + h * S);
                }
            }
        }
    }
}

/* sum += sum_st B_s B_t C_ab[s][t] of one pair of groups. Zeros are skipped: most of B. */
static void add_blended_block(int32_t kk, int32_t S, const double *B_g, const double *B_h,
                              const double *C, double *sum)
{
    for (int32_t s = 0; s < S; s++) {
        for (int32_t t = 0; t < S && B_g[s] != 0.0; t++) {
            double factor = B_g[s] * B_h[t];
            for (int32_t ab = 0; ab < kk && factor != 0.0; ab++) {
                sum[ab] += factor * C[(ab * S + s) * S + t];
            }
        }
    }
}

void contract_blend(const coupling *from, const double *B, double *out)
{
    int32_t k = from->k, G = from->groups, S = from->shapes;
    size_t size = (size_t)(G * k);
    for (int32_t g = 0; g < G; g++) {
        for (int32_t h = g; h < G; h++) {
            double sum[9] = {0.0};
            add_blended_block(k * k, S, B + g * S, B + h * S, component(from, g, h, 0), sum);
            for (int32_t ab = 0; ab < k * k; ab++) {
                out[(size_t)(g * k + ab / k) * size + (size_t)(h * k + ab % k)] = sum[ab];
            }
        }
    }
    mirror_lower(out, size);
}

/* X += sum_t B_t C_t of one pair, its entries t `step` apart. */
static void add_entries(const coupling *from, const double *entries, int32_t step, const double *B,
                        double *X)
{
    int32_t SS = from->shapes * from->shapes;
    for (int32_t t = 0; t < from->shapes; t++, entries += step) {
        for (int32_t ab = 0; ab < from->k * from->k && B[t] != 0.0; ab++) {
            X[ab] += B[t] * entries[ab * SS];
        }
    }
}

void contract_blend_row(const coupling *from, int32_t pair, const double *B, double *X)
{
    int32_t k = from->k, kk = k * k, S = from->shapes, g = pair / S, s = pair % S;
    memset(X, 0, (size_t)(from->groups * kk) * sizeof *X);
    for (int32_t h = 0; h < g; h++) { /* stored the other way round: transposed */
        double transposed[9] = {0.0};
        add_entries(from, component(from, h, g, 0) + s, S, B + h * S, transposed);
        for (int32_t ab = 0; ab < kk; ab++) {
            X[h * kk + ab] = transposed[ab % k * k + ab / k];
        }
    }
    for (int32_t h = g; h < from->groups; h++) {
        add_entries(from, component(from, g, h, 0) + s * S, 1, B + h * S, X + h * kk);
    }
}
