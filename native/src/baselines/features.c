/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "features.h"

#include "dense/rotation.h"
#include "memory.h"

#include <math.h>
#include <string.h>

int features_create(int32_t k, int32_t elements, int32_t shapes, feature_set *out)
{
    size_t pairs = (size_t)elements * (size_t)shapes;
    *out = (feature_set){.k = k, .elements = elements, .shapes = shapes};
    out->turn = allocate(pairs * (size_t)tangent_size(k), sizeof *out->turn);
    out->stretch = allocate(pairs * (size_t)(k * k), sizeof *out->stretch);
    return out->turn != NULL && out->stretch != NULL;
}

void features_destroy(feature_set *features)
{
    release(features->turn);
    release(features->stretch);
}

/* The axis of a turn by nearly pi: its square is R's symmetric part less the cosine. The column of
 * its largest component, with the sign of the little that R - R^T still says. */
static void find_half_turn_axis(const double *R, double cosine, const double *sine, double *axis)
{
    int best = 0;
    for (int i = 1; i < 3; i++) {
        best = R[4 * i] > R[4 * best] ? i : best;
    }
    double squares = 0.0, sign = 0.0;
    for (int i = 0; i < 3; i++) {
        axis[i] = 0.5 * (R[3 * i + best] + R[3 * best + i]) - (i == best ? cosine : 0.0);
        squares += axis[i] * axis[i];
        sign += axis[i] * sine[i];
    }
    double scale = (sign < 0.0 ? -1.0 : 1.0) / sqrt(squares);
    for (int i = 0; i < 3; i++) {
        axis[i] *= scale;
    }
}

void rotation_logarithm(int32_t k, const double *R, double *w)
{
    if (k == 2) {
        w[0] = atan2(R[2] - R[1], R[0] + R[3]);
        return;
    }
    double sine[3] = {0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1])};
    double length = sqrt(sine[0] * sine[0] + sine[1] * sine[1] + sine[2] * sine[2]);
    double cosine = 0.5 * (R[0] + R[4] + R[8] - 1.0), angle = atan2(length, cosine);
    double scale = length > 1e-12 ? angle / length : 1.0;
    if (cosine < -0.99) {
        find_half_turn_axis(R, cosine, sine, w);
        scale = angle;
        memcpy(sine, w, sizeof sine);
    }
    for (int i = 0; i < 3; i++) {
        w[i] = scale * sine[i];
    }
}

void set_feature(feature_set *features, int32_t element, int32_t shape, const double *F)
{
    int32_t k = features->k;
    size_t pair = (size_t)element * (size_t)features->shapes + (size_t)shape;
    double transposed[9], R[9];
    for (int32_t i = 0; i < k * k; i++) {
        transposed[i] = F[i % k * k + i / k];
    }
    closest_rotation(k, transposed, R);
    multiply_tn(k, R, F, features->stretch + pair * (size_t)(k * k));
    rotation_logarithm(k, R, features->turn + pair * (size_t)tangent_size(k));
}

/* exp(sum w log R) and sum w S. */
static void sum_features(const feature_set *features, int32_t element, const double *w,
                         double *turning, double *R, double *S)
{
    int32_t k = features->k, t = tangent_size(k);
    memset(turning, 0, (size_t)t * sizeof *turning);
    memset(S, 0, (size_t)(k * k) * sizeof *S);
    for (int32_t s = 0; s < features->shapes; s++) {
        size_t pair = (size_t)element * (size_t)features->shapes + (size_t)s;
        for (int32_t i = 0; i < t; i++) {
            turning[i] += w[s] * features->turn[pair * (size_t)t + (size_t)i];
        }
        for (int32_t i = 0; i < k * k; i++) {
            S[i] += w[s] * features->stretch[pair * (size_t)(k * k) + (size_t)i];
        }
    }
    identity_matrix(k, R);
    turn(k, turning, R);
}

void blend_features(const feature_set *features, int32_t element, const double *w, double *M)
{
    double turning[3], R[9], S[9];
    sum_features(features, element, w, turning, R, S);
    multiply(features->k, R, S, M);
}

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* exp(v + d) = exp(J d) exp(v) to first order, with J = I + (1 - cos a) / a^2 [v] +
 * (a - sin a) / a^3 [v]^2 and a = |v|. */
static void apply_left_jacobian(int32_t k, const double *v, const double *d, double *Jd)
{
    if (k == 2) {
        Jd[0] = d[0];
        return;
    }
    double squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], a = sqrt(squared);
    double half = 0.5 * a, first = 0.5, second = 1.0 / 6.0 - squared / 120.0;
    if (a > 1e-2) {
        first = 0.5 * (sin(half) / half) * (sin(half) / half);
        second = (a - sin(a)) / (squared * a);
    } else if (a > 0.0) {
        first = 0.5 * (sin(half) / half) * (sin(half) / half);
    }
    double once[3], twice[3];
    cross(v, d, once);
    cross(v, once, twice);
    for (int i = 0; i < 3; i++) {
        Jd[i] = d[i] + first * once[i] + second * twice[i];
    }
}

/* out = [w] A, the skew matrix of w times A. */
static void multiply_skew(int32_t k, const double *w, const double *A, double *out)
{
    double W2[4] = {0.0, -w[0], w[0], 0.0};
    if (k == 2) {
        multiply(2, W2, A, out);
        return;
    }
    double W3[9] = {0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0};
    multiply(3, W3, A, out);
}

void differentiate_features(const feature_set *features, int32_t element, const double *w,
                            double *dM)
{
    int32_t k = features->k, kk = k * k, t = tangent_size(k);
    double turning[3], R[9], S[9], M[9];
    sum_features(features, element, w, turning, R, S);
    multiply(k, R, S, M);
    for (int32_t s = 0; s < features->shapes; s++) {
        size_t pair = (size_t)element * (size_t)features->shapes + (size_t)s;
        double spin[3], turned[9], stretched[9];
        apply_left_jacobian(k, turning, features->turn + pair * (size_t)t, spin);
        multiply_skew(k, spin, M, turned);
        multiply(k, R, features->stretch + pair * (size_t)kk, stretched);
        for (int32_t i = 0; i < kk; i++) {
            dM[s * kk + i] = turned[i] + stretched[i];
        }
    }
}

/* The columns of `frame` are two edges of a triangle and, in space, its unit normal. */
static void find_frame(int32_t k, const double *positions, const int32_t *corners, double *frame)
{
    double edges[6], normal[3];
    for (int32_t a = 0; a < k; a++) {
        double origin = positions[(size_t)corners[0] * (size_t)k + (size_t)a];
        for (int32_t c = 0; c < 2; c++) {
            edges[c * k + a] = positions[(size_t)corners[c + 1] * (size_t)k + (size_t)a] - origin;
            frame[a * k + c] = edges[c * k + a];
        }
    }
    if (k == 3) {
        cross(edges, edges + 3, normal);
        double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (int32_t a = 0; a < 3; a++) {
            frame[3 * a + 2] = length > 0.0 ? normal[a] / length : 0.0;
        }
    }
}

static void invert(int32_t k, const double *A, double *inverse)
{
    if (k == 2) {
        double determinant = A[0] * A[3] - A[1] * A[2];
        inverse[0] = A[3] / determinant;
        inverse[1] = -A[1] / determinant;
        inverse[2] = -A[2] / determinant;
        inverse[3] = A[0] / determinant;
        return;
    }
    double columns[9], rows[9];
    for (int32_t i = 0; i < 9; i++) {
        columns[i] = A[i % 3 * 3 + i / 3];
    }
    cross(columns + 3, columns + 6, rows);
    cross(columns + 6, columns, rows + 3);
    cross(columns, columns + 3, rows + 6);
    double determinant = columns[0] * rows[0] + columns[1] * rows[1] + columns[2] * rows[2];
    for (int32_t i = 0; i < 9; i++) {
        inverse[i] = rows[i] / determinant;
    }
}

void find_gradient(const tug_mesh *mesh, const double *positions, int32_t triangle, double *F)
{
    int32_t k = mesh->dimension;
    const int32_t *corners = mesh->triangles + 3 * (size_t)triangle;
    double from[9], to[9], inverse[9];
    find_frame(k, mesh->vertices, corners, from);
    find_frame(k, positions, corners, to);
    invert(k, from, inverse);
    multiply(k, to, inverse, F);
}
