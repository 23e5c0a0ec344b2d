/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/rotation_fit.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "dense/vector.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* A Newton step beyond this is cut: the quadratic model of a rotation ends there. */
static const double LONGEST_TURN = 0.8;

int rotation_workspace_create(int32_t groups, int32_t k, rotation_workspace *w)
{
    size_t G = (size_t)groups, size = G * (size_t)tangent_size(k), kk = (size_t)(k * k);
    size_t row = G * (size_t)k, bands = (size_t)(2 * k - 1);
    w->CR = allocate(G * kk, sizeof *w->CR);
    w->columns = allocate(G * kk, sizeof *w->columns);
    w->bands = allocate(bands * row, sizeof *w->bands);
    w->turned = allocate((size_t)k * (row + bands), sizeof *w->turned);
    w->gradient = allocate(size, sizeof *w->gradient);
    w->hessian = allocate(size * size, sizeof *w->hessian);
    w->factor = allocate(size * size, sizeof *w->factor);
    w->step = allocate(size, sizeof *w->step);
    w->trial = allocate(G * kk, sizeof *w->trial);
    return w->CR && w->columns && w->bands && w->turned && w->gradient && w->hessian && w->factor &&
           w->step && w->trial;
}

void rotation_workspace_destroy(rotation_workspace *w)
{
    release(w->CR);
    release(w->columns);
    release(w->bands);
    release(w->turned);
    release(w->gradient);
    release(w->hessian);
    release(w->factor);
    release(w->step);
    release(w->trial);
}

/* Entries i to i + 4 `width` of each of the k rows of `columns`, their sums in registers. */
PART void sum_columns(const rotation_energy *energy, int32_t k, const double *R, int32_t i,
                      int width, double *columns)
{
    int32_t size = energy->groups * k;
    const double *row = energy->C + i;
    packed sum[3][2] = {{{0.0}}};
    for (int32_t g = 0; g < energy->groups; g++, R += k * k) {
        for (int32_t b = 0; b < k; b++, row += size) {
            for (int v = 0; v < width; v++) {
                packed x = *packed_at(row + LANES * v);
                for (int32_t a = 0; a < k; a++) {
                    sum[a][v] += R[a * k + b] * x;
                }
            }
        }
    }
    for (int32_t a = 0; a < k; a++) {
        for (int v = 0; v < width; v++) {
            *writable_packed_at(columns + a * size + i + LANES * v) = sum[a][v];
        }
    }
}

/* The same for all entries of rows shorter than a vector: a single group. */
PART void sum_short_columns(const rotation_energy *energy, int32_t k, const double *R,
                            double *columns)
{
    for (int32_t i = 0; i < k; i++) {
        for (int32_t a = 0; a < k; a++) {
            columns[a * k + i] = 0.0;
            for (int32_t b = 0; b < k; b++) {
                columns[a * k + i] += R[a * k + b] * energy->C[b * k + i];
            }
        }
    }
}

/* CR_g = sum_h C_gh R_h^T. C is symmetric, so its rows serve as columns and every inner loop runs
 * along memory. */
PART void multiply_stacked(const rotation_energy *energy, int32_t k, const double *R,
                           rotation_workspace *w)
{
    int32_t size = energy->groups * k, i = 0;
    for (; i + 2 * LANES <= size; i += 2 * LANES) {
        sum_columns(energy, k, R, i, 2, w->columns);
    }
    for (; i < size && size >= LANES; i += LANES) { /* the last may do some a second time */
        sum_columns(energy, k, R, i + LANES <= size ? i : size - LANES, 1, w->columns);
    }
    if (size < LANES) {
        sum_short_columns(energy, k, R, w->columns);
    }
    for (int32_t j = 0; j < size; j++) {
        for (int32_t a = 0; a < k; a++) {
            w->CR[j * k + a] = w->columns[a * size + j];
        }
    }
}

DISPATCHED void couple_rotations(const rotation_energy *energy, const double *R,
                                 rotation_workspace *w)
{
    if (energy->k == 3) {
        multiply_stacked(energy, 3, R, w);
    } else {
        multiply_stacked(energy, 2, R, w);
    }
}

/* tr(C_gg): what is summed to `coupled` may cancel where rows give way. */
static double own_trace(const rotation_energy *energy, int32_t g)
{
    size_t k = (size_t)energy->k, size = (size_t)energy->groups * k;
    double sum = 0.0;
    for (size_t i = (size_t)g * k; i < (size_t)(g + 1) * k; i++) {
        sum += fabs(energy->C[i * (size + 1)]);
    }
    return sum;
}

double evaluate_rotations(const rotation_energy *energy, const double *R, rotation_workspace *w)
{
    int32_t k = energy->k, kk = k * k;
    couple_rotations(energy, R, w);
    double sum = 0.0;
    w->magnitude = 0.0;
    for (int32_t g = 0; g < energy->groups; g++) {
        double coupled = 0.5 * trace_of_product(k, R + g * kk, w->CR + g * kk);
        double pulled = trace_of_product(k, R + g * kk, energy->L + g * kk);
        sum += coupled - pulled;
        w->magnitude += fabs(coupled) + fabs(pulled) + own_trace(energy, g);
    }
    return sum;
}

/* The blocks M_gh = R_g C_gh R_h^T of one g follow each other in k rows, and are made along them:
 * first R_g C_gh, then, as R_h^T mixes the k entries of a row's block, a sum of multiples of the
 * row and of itself moved to the left and to the right. Band d of R has what the entry moved by
 * d - (k - 1) is multiplied with: zero where that one is of another block. */
PART void find_bands(int32_t k, int32_t groups, const double *R, double *bands)
{
    for (int32_t h = 0; h < groups; h++) {
        for (int32_t b = 0; b < k; b++) {
            for (int32_t c = 0; c < k; c++) {
                bands[(c - b + k - 1) * groups * k + h * k + b] = R[(h * k + b) * k + c];
            }
        }
    }
}

/* Row g from block g + 1 on; so that it is whole vectors up to the end, perhaps from before that.
 */
PART void find_couplings(const rotation_energy *energy, int32_t k, const double *R, int32_t g,
                         rotation_workspace *w)
{
    double *turned = w->turned, *coupled = w->columns;
    const double *bands = w->bands;
    int32_t size = energy->groups * k, length = size + 2 * k - 1;
    int32_t first = size - (size - (g + 1) * k + LANES - 1) / LANES * LANES;
    const double *C = energy->C + (size_t)(g * k) * (size_t)size, *R_g = R + g * k * k;
    for (int32_t j = first; j < size; j += LANES) {
        for (int32_t a = 0; a < k; a++) {
            packed sum = {0.0};
            for (int32_t b = 0; b < k; b++) {
                sum += R_g[a * k + b] * *packed_at(C + b * size + j);
            }
            *writable_packed_at(turned + a * length + j + k - 1) = sum;
        }
    }
    for (int32_t j = first; j < size; j += LANES) {
        for (int32_t a = 0; a < k; a++) {
            packed sum = {0.0};
            for (int32_t d = 0; d < 2 * k - 1; d++) {
                sum += *packed_at(turned + a * length + j + d) * *packed_at(bands + d * size + j);
            }
            *writable_packed_at(coupled + a * size + j) = sum;
        }
    }
}

/* The second derivative in w_g and w_h of tr(exp(W_g) M exp(W_h)^T) is tr(M) - M^T. M and the
 * Hessian's block are parts of longer rows. */
PART void put_coupling(int32_t k, const double *M, size_t row, double *hessian, size_t size)
{
    if (k == 2) {
        hessian[0] = M[0] + M[row + 1];
        return;
    }
    double trace = M[0] + M[row + 1] + M[2 * row + 2];
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++) {
            hessian[i * size + j] = (i == j ? trace : 0.0) - M[j * row + i];
        }
    }
}

/* And the one in w_g of -tr(exp(W_g) A) is tr(A) minus the symmetric part of A. */
PART void put_own(int32_t k, const double *A, double *hessian, size_t size)
{
    if (k == 2) {
        hessian[0] = A[0] + A[3];
        return;
    }
    double trace = A[0] + A[4] + A[8];
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++) {
            hessian[i * size + j] = (i == j ? trace : 0.0) - 0.5 * (A[i * 3 + j] + A[j * 3 + i]);
        }
    }
}

/* A group's coupling with itself, R C R^T. */
PART void find_own_coupling(const rotation_energy *energy, int32_t k, const double *R, int32_t g,
                            double *M)
{
    int32_t size = energy->groups * k;
    const double *C = energy->C + (size_t)(g * k) * (size_t)(size + 1);
    double half[9];
    multiply_strided(k, R + g * k * k, k, 1, C, size, 1, half);
    multiply_nt(k, half, R + g * k * k, M);
}

/* Gradient of one group, and its own block of the Hessian. */
PART void differentiate_group(const rotation_energy *energy, int32_t k, const double *R, int32_t g,
                              rotation_workspace *w)
{
    int32_t kk = k * k, t = tangent_size(k);
    size_t size = (size_t)(energy->groups * t);
    double pull[9], A[9], own[9];
    for (int32_t i = 0; i < kk; i++) {
        pull[i] = energy->L[g * kk + i] - w->CR[g * kk + i];
    }
    multiply(k, R + g * kk, pull, A);
    axial_vector(k, A, w->gradient + g * t);
    for (int32_t i = 0; i < t; i++) {
        w->gradient[g * t + i] *= -1.0;
    }
    /* tr(R C R^T) of a single group does not depend on R. */
    find_own_coupling(energy, k, R, g, own);
    for (int32_t i = 0; i < kk; i++) {
        A[i] += own[i];
    }
    put_own(k, A, w->hessian + (size_t)(g * t) * (size + 1), size);
}

PART void differentiate(const rotation_energy *energy, int32_t k, const double *R,
                        rotation_workspace *w)
{
    int32_t t = tangent_size(k);
    size_t size = (size_t)(energy->groups * t), row = (size_t)(energy->groups * k);
    find_bands(k, energy->groups, R, w->bands);
    for (int32_t g = 0; g < energy->groups; g++) {
        differentiate_group(energy, k, R, g, w);
        find_couplings(energy, k, R, g, w);
        double *hessian = w->hessian + (size_t)(g * t) * size;
        for (int32_t h = g + 1; h < energy->groups; h++) {
            put_coupling(k, w->columns + h * k, row, hessian + h * t, size);
        }
    }
}

/* With CR as it is at R. */
DISPATCHED static void differentiate_here(const rotation_energy *energy, const double *R,
                                          rotation_workspace *w)
{
    if (energy->k == 3) {
        differentiate(energy, 3, R, w);
    } else {
        differentiate(energy, 2, R, w);
    }
}

void differentiate_rotations(const rotation_energy *energy, const double *R, rotation_workspace *w)
{
    couple_rotations(energy, R, w);
    differentiate_here(energy, R, w);
}

/* The lower quartile of the diagonal: some unknowns may be stiffer than the others by far, and a
 * shift that is small for those would leave the others no step. w->step is overwritten. */
static double shift_scale(int32_t size, rotation_workspace *w)
{
    for (int32_t i = 0; i < size; i++) {
        double entry = fabs(w->hessian[(size_t)i * (size_t)size + (size_t)i]);
        int32_t at = i;
        for (; at > 0 && w->step[at - 1] > entry; at--) {
            w->step[at] = w->step[at - 1];
        }
        w->step[at] = entry;
    }
    return w->step[size / 4];
}

void find_newton_step(int32_t size, rotation_workspace *w)
{
    double shift = 0.0, scale = 0.0;
    for (int attempt = 0; attempt < 40; attempt++) {
        memcpy(w->factor, w->hessian, (size_t)size * (size_t)size * sizeof *w->factor);
        for (int32_t i = 0; i < size; i++) {
            w->factor[(size_t)i * (size_t)size + (size_t)i] += shift;
        }
        if (cholesky_factor(w->factor, size)) {
            break;
        }
        if (shift == 0.0) {
            scale = shift_scale(size, w);
        }
        shift = fmax(4.0 * shift, 1e-3 * scale);
    }
    for (int32_t i = 0; i < size; i++) {
        w->step[i] = -w->gradient[i];
    }
    cholesky_solve(w->factor, size, w->step, 1);
}

double largest_turn(const rotation_energy *energy, const rotation_workspace *w)
{
    int32_t t = tangent_size(energy->k);
    double largest = 0.0;
    for (int32_t g = 0; g < energy->groups; g++) {
        largest = fmax(largest, dot(w->step + g * t, w->step + g * t, (size_t)t));
    }
    return sqrt(largest);
}

void turn_all(const rotation_energy *energy, const double *R, double t, rotation_workspace *w)
{
    int32_t k = energy->k, kk = k * k, size = tangent_size(k);
    memcpy(w->trial, R, (size_t)(energy->groups * kk) * sizeof *R);
    for (int32_t g = 0; g < energy->groups; g++) {
        double turning[3];
        for (int32_t i = 0; i < size; i++) {
            turning[i] = t * w->step[g * size + i];
        }
        turn(k, turning, w->trial + g * kk);
    }
}

double longest_part(double turned)
{
    return turned > LONGEST_TURN ? LONGEST_TURN / turned : 1.0;
}

/* One step downhill from R, where f is *value and CR is up to date, to where they are so again.
 * Returns the angle of the full step, or 0 where rounding leaves none. */
static double descend(const rotation_energy *energy, rotation_workspace *w, double *R,
                      double *value)
{
    int32_t size = energy->groups * tangent_size(energy->k);
    size_t bytes = (size_t)(energy->groups * energy->k * energy->k) * sizeof *R;
    double rounding = 1e-15 * w->magnitude; /* near the optimum the decrease drowns in it */
    differentiate_here(energy, R, w);
    find_newton_step(size, w);
    double slope = dot(w->gradient, w->step, (size_t)size);
    double full = largest_turn(energy, w);
    double t = longest_part(full);
    for (int halvings = 0; halvings < 40; halvings++, t *= 0.5) {
        turn_all(energy, R, t, w);
        double after = evaluate_rotations(energy, w->trial, w);
        if (after <= *value + 1e-4 * t * slope + rounding) {
            memcpy(R, w->trial, bytes);
            *value = after;
            return -slope > rounding ? full : 0.0;
        }
    }
    return 0.0;
}

int32_t fit_rotations(const rotation_energy *energy, double tolerance, int32_t max_steps,
                      rotation_workspace *workspace, double *R, int *converged)
{
    *converged = 0;
    int32_t steps = 0;
    double value = evaluate_rotations(energy, R, workspace);
    while (steps < max_steps && !*converged) {
        double turned = descend(energy, workspace, R, &value);
        steps++;
        *converged = turned <= tolerance;
    }
    return steps;
}
