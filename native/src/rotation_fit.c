/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "rotation_fit.h"

#include "dense.h"
#include "dispatch.h"
#include "memory.h"
#include "rotation.h"

#include <math.h>
#include <string.h>

/* A Newton step beyond this is cut: the quadratic model of a rotation ends there. */
static const double LONGEST_TURN = 0.8;

int rotation_workspace_create(int32_t groups, int32_t k, rotation_workspace *w)
{
    size_t G = (size_t)groups, size = G * (size_t)tangent_size(k), kk = (size_t)(k * k);
    w->CR = allocate(G * kk, sizeof *w->CR);
    w->columns = allocate(G * kk, sizeof *w->columns);
    w->gradient = allocate(size, sizeof *w->gradient);
    w->hessian = allocate(size * size, sizeof *w->hessian);
    w->factor = allocate(size * size, sizeof *w->factor);
    w->step = allocate(size, sizeof *w->step);
    w->trial = allocate(G * kk, sizeof *w->trial);
    return w->CR && w->columns && w->gradient && w->hessian && w->factor && w->step && w->trial;
}

void rotation_workspace_destroy(rotation_workspace *w)
{
    release(w->CR);
    release(w->columns);
    release(w->gradient);
    release(w->hessian);
    release(w->factor);
    release(w->step);
    release(w->trial);
}

/* y_a += factor_a x for the k vectors y_a that follow each other. */
DISPATCHED static void add_multiples(int32_t k, int32_t size, const double *factor, const double *x,
                                     double *y)
{
    double *first = y, *second = y + size, *third = y + (k - 1) * size;
    if (k == 2) {
        for (int32_t i = 0; i < size; i++) {
            first[i] += factor[0] * x[i];
            second[i] += factor[1] * x[i];
        }
        return;
    }
    for (int32_t i = 0; i < size; i++) {
        first[i] += factor[0] * x[i];
        second[i] += factor[1] * x[i];
        third[i] += factor[2] * x[i];
    }
}

/* CR_g = sum_h C_gh R_h^T. C is symmetric, so its rows serve as columns and every inner loop runs
 * along memory. */
static void multiply_stacked(const rotation_energy *energy, const double *R, rotation_workspace *w)
{
    int32_t k = energy->k, kk = k * k, size = energy->groups * k;
    memset(w->columns, 0, (size_t)(size * k) * sizeof *w->columns);
    for (int32_t j = 0; j < size; j++) {
        double factor[3];
        for (int32_t a = 0; a < k; a++) {
            factor[a] = R[j / k * kk + a * k + j % k];
        }
        add_multiples(k, size, factor, energy->C + (size_t)j * (size_t)size, w->columns);
    }
    for (int32_t i = 0; i < size * k; i++) {
        w->CR[i] = w->columns[i % k * size + i / k];
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
    multiply_stacked(energy, R, w);
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

/* The second derivative in w_g and w_h of tr(exp(W_g) M exp(W_h)^T) is tr(M) - M^T. */
static void add_coupling(int32_t k, const double *M, double *hessian, size_t size)
{
    if (k == 2) {
        hessian[0] += M[0] + M[3];
        return;
    }
    double trace = M[0] + M[4] + M[8];
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++) {
            hessian[i * size + j] += (i == j ? trace : 0.0) - M[j * 3 + i];
        }
    }
}

/* And the one in w_g of -tr(exp(W_g) A) is tr(A) minus the symmetric part of A. */
static void add_own(int32_t k, const double *A, double *hessian, size_t size)
{
    if (k == 2) {
        hessian[0] += A[0] + A[3];
        return;
    }
    double trace = A[0] + A[4] + A[8];
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++) {
            hessian[i * size + j] += (i == j ? trace : 0.0) - 0.5 * (A[i * 3 + j] + A[j * 3 + i]);
        }
    }
}

/* R_g C_gh R_h^T */
static void turned_block(const rotation_energy *energy, const double *R, int32_t g, int32_t h,
                         double *M)
{
    int32_t k = energy->k, kk = k * k;
    size_t row = (size_t)(energy->groups * k);
    double block[9], half[9];
    for (int32_t i = 0; i < kk; i++) {
        block[i] = energy->C[(size_t)(g * k + i / k) * row + (size_t)(h * k + i % k)];
    }
    multiply(k, R + g * kk, block, half);
    multiply_nt(k, half, R + h * kk, M);
}

/* Gradient of one group, and its own block of the Hessian. */
static void differentiate_group(const rotation_energy *energy, const double *R, int32_t g,
                                rotation_workspace *w)
{
    int32_t k = energy->k, kk = k * k, t = tangent_size(k);
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
    /* A group's coupling with itself, tr(R C R^T), does not depend on R. */
    turned_block(energy, R, g, g, own);
    for (int32_t i = 0; i < kk; i++) {
        A[i] += own[i];
    }
    add_own(k, A, w->hessian + (size_t)(g * t) * (size + 1), size);
}

void differentiate_rotations(const rotation_energy *energy, const double *R, rotation_workspace *w)
{
    int32_t k = energy->k, t = tangent_size(k);
    size_t size = (size_t)(energy->groups * t);
    multiply_stacked(energy, R, w);
    memset(w->hessian, 0, size * size * sizeof *w->hessian);
    for (int32_t g = 0; g < energy->groups; g++) {
        differentiate_group(energy, R, g, w);
        for (int32_t h = g + 1; h < energy->groups; h++) {
            double coupling[9];
            turned_block(energy, R, g, h, coupling);
            add_coupling(k, coupling, w->hessian + (size_t)(g * t) * size + (size_t)(h * t), size);
        }
    }
    for (size_t i = 0; i < size; i++) {
        for (size_t j = 0; j < i; j++) {
            w->hessian[i * size + j] = w->hessian[j * size + i];
        }
    }
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

double turn_all(const rotation_energy *energy, const double *R, double t, rotation_workspace *w)
{
    int32_t k = energy->k, kk = k * k, size = tangent_size(k);
    double largest = 0.0;
    memcpy(w->trial, R, (size_t)(energy->groups * kk) * sizeof *R);
    for (int32_t g = 0; g < energy->groups; g++) {
        double turning[3], squares = 0.0;
        for (int32_t i = 0; i < size; i++) {
            turning[i] = t * w->step[g * size + i];
            squares += turning[i] * turning[i];
        }
        largest = fmax(largest, sqrt(squares));
        turn(k, turning, w->trial + g * kk);
    }
    return largest;
}

/* One step downhill. Returns the angle of the full step, or 0 where rounding leaves none. */
static double descend(const rotation_energy *energy, rotation_workspace *w, double *R)
{
    int32_t size = energy->groups * tangent_size(energy->k);
    size_t bytes = (size_t)(energy->groups * energy->k * energy->k) * sizeof *R;
    double before = evaluate_rotations(energy, R, w);
    double rounding = 1e-15 * w->magnitude; /* near the optimum the decrease drowns in it */
    differentiate_rotations(energy, R, w);
    find_newton_step(size, w);
    double slope = dot(w->gradient, w->step, (size_t)size);
    double full = turn_all(energy, R, 1.0, w);
    double t = full > LONGEST_TURN ? LONGEST_TURN / full : 1.0;
    for (int halvings = 0; halvings < 40; halvings++, t *= 0.5) {
        turn_all(energy, R, t, w);
        double after = evaluate_rotations(energy, w->trial, w);
        if (after <= before + 1e-4 * t * slope + rounding) {
            memcpy(R, w->trial, bytes);
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
    while (steps < max_steps && !*converged) {
        double turned = descend(energy, workspace, R);
        steps++;
        *converged = turned <= tolerance;
    }
    return steps;
}
