/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "fixture.h"

#include "dense/rotation.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* A point of the surface by its place t along the axis, 0 to 1, and its offset from the axis. */
typedef struct place {
    double t, y, z;
} place;

static const double TUBE_LENGTH = 4.0;

/* Shape s of the tube, and in the plane of the strip. Every shape differs from every other in every
 * slice by more than a rigid motion. */
static void deform(int32_t s, place p, double *x)
{
    double along = TUBE_LENGTH * (p.t - 0.5);
    double angle = 1.8 * (p.t - 0.5), turn_rate = 0.45;
    double bulge = 1.0 + 0.6 * exp(-8.0 * (p.t - 0.4) * (p.t - 0.4));
    switch (s) {
    case 0:
        x[0] = along, x[1] = p.y, x[2] = p.z;
        break;
    case 1: /* the axis becomes an arc */
        x[0] = (1.0 / turn_rate - p.y) * sin(turn_rate * along);
        x[1] = (1.0 - cos(turn_rate * along)) / turn_rate + p.y * cos(turn_rate * along);
        x[2] = p.z;
        break;
    case 2: /* longer, and thicker off its middle */
        x[0] = 1.25 * along + 0.15 * sin(6.0 * p.t);
        x[1] = bulge * p.y;
        x[2] = bulge * p.z;
        break;
    default:
        x[0] = along;
        x[1] = cos(angle) * p.y - sin(angle) * p.z;
        x[2] = sin(angle) * p.y + cos(angle) * p.z;
    }
}

static void divide_by_sum(double *values, int32_t count)
{
    double sum = 0.0;
    for (int32_t i = 0; i < count; i++) {
        sum += values[i];
    }
    for (int32_t i = 0; i < count; i++) {
        values[i] /= sum;
    }
}

static void place_vertex(fixture *f, place p)
{
    int32_t v = f->vertices++, k = f->dimension;
    for (int32_t s = 0; s < f->shapes; s++) {
        double x[3];
        deform(s, p, x);
        memcpy(f->shape + (size_t)((s * MAX_VERTICES + v) * k), x, (size_t)k * sizeof *x);
    }
    double *weight = f->weight + (size_t)(v * f->weights);
    for (int32_t h = 0; h < f->weights; h++) { /* smooth bumps around the handles' places */
        double distance = p.t * (f->weights - 1) - h;
        weight[h] = exp(-3.0 * distance * distance);
    }
    divide_by_sum(weight, f->weights);
}

/* Shapes are placed MAX_VERTICES apart while the mesh grows: close the gaps. */
static void pack_shapes(fixture *f)
{
    size_t size = (size_t)(f->vertices * f->dimension);
    for (int32_t s = 1; s < f->shapes; s++) {
        memmove(f->shape + (size_t)s * size, f->shape + (size_t)(s * MAX_VERTICES * f->dimension),
                size * sizeof(double));
    }
}

static void add_triangle(fixture *f, int32_t a, int32_t b, int32_t c, double t)
{
    int32_t *triangle = f->triangle + (size_t)(3 * f->triangles);
    triangle[0] = a, triangle[1] = b, triangle[2] = c;
    f->stiffness[f->triangles] = 1.0;
    f->group[f->triangles++] = (int32_t)(t * 0.999999 * f->groups);
}

static void pin(fixture *f, int32_t vertex)
{
    f->row_vertices[f->rows] = vertex;
    f->row_values[f->rows] = 1.0;
    f->rows++;
    f->row_starts[f->rows] = f->rows;
}

enum { RINGS = 24, AROUND = 10 };

static void make_rings(fixture *f)
{
    for (int32_t i = 0; i < RINGS * AROUND; i++) {
        double t = (double)(i / AROUND) / (RINGS - 1), angle = 2.0 * PI * (i % AROUND) / AROUND;
        double radius = 0.5 + 0.08 * sin(5.0 * t);
        place_vertex(f, (place){t, radius * cos(angle), 0.8 * radius * sin(angle)});
    }
    for (int32_t i = 0; i < (RINGS - 1) * AROUND; i++) {
        int32_t ring = i / AROUND, next = ring * AROUND + (i + 1) % AROUND;
        double t = (ring + 0.5) / (RINGS - 1);
        add_triangle(f, i, i + AROUND, next, t);
        add_triangle(f, next, i + AROUND, next + AROUND, t);
    }
}

static void make_cap(fixture *f, double t)
{
    int32_t ring = t > 0.5 ? (RINGS - 1) * AROUND : 0, pole = f->vertices;
    place_vertex(f, (place){t, 0.0, 0.0});
    for (int32_t i = 0; i < AROUND; i++) {
        int32_t a = ring + i, b = ring + (i + 1) % AROUND;
        add_triangle(f, pole, t > 0.5 ? a : b, t > 0.5 ? b : a, t);
    }
}

void make_tube(fixture *f, int closed)
{
    *f = (fixture){.dimension = 3, .shapes = 4, .weights = 4, .groups = 8};
    make_rings(f);
    if (closed) {
        make_cap(f, 0.0);
        make_cap(f, 1.0);
    }
    pack_shapes(f);
    for (int32_t h = 0; h < f->weights; h++) { /* on no one line, so that twists are seen */
        pin(f, h * (RINGS - 1) / (f->weights - 1) * AROUND + 3 * h % AROUND);
    }
}

void make_strip(fixture *f)
{
    enum { ALONG = 25, ACROSS = 5 };
    *f = (fixture){.dimension = 2, .shapes = 3, .weights = 3, .groups = 6};
    for (int32_t i = 0; i < ALONG * ACROSS; i++) {
        double t = (double)(i / ACROSS) / (ALONG - 1);
        place_vertex(f, (place){t, 0.2 * (i % ACROSS - 2), 0.0});
    }
    for (int32_t i = 0; i < (ALONG - 1) * ACROSS; i++) {
        if (i % ACROSS < ACROSS - 1) {
            double t = (i / ACROSS + 0.5) / (ALONG - 1);
            add_triangle(f, i, i + ACROSS, i + 1, t);
            add_triangle(f, i + 1, i + ACROSS, i + ACROSS + 1, t);
        }
    }
    pack_shapes(f);
    for (int32_t h = 0; h < f->weights; h++) {
        pin(f, h * (ALONG - 1) / (f->weights - 1) * ACROSS + h % 2 * (ACROSS - 1));
    }
}

void make_flat(fixture *f)
{
    make_strip(f);
    f->dimension = 3;
    for (int32_t i = f->shapes * f->vertices - 1; i >= 0; i--) {
        double x = f->shape[2 * i], y = f->shape[2 * i + 1];
        f->shape[3 * i] = x, f->shape[3 * i + 1] = y, f->shape[3 * i + 2] = 0.0;
    }
}

void free_last_handle(fixture *f)
{
    f->rows--;
}

void broaden_weights(fixture *f)
{
    for (int32_t v = 0; v < f->vertices; v++) {
        double *weight = f->weight + (size_t)(v * f->weights);
        for (int32_t h = 0; h < f->weights; h++) {
            weight[h] = sqrt(weight[h]);
        }
        divide_by_sum(weight, f->weights);
    }
}

void duplicate_shape(fixture *f, int32_t s)
{
    size_t size = (size_t)coordinate_count(f);
    memcpy(f->shape + (size_t)f->shapes * size, shape_of(f, s), size * sizeof(double));
    f->shapes++;
}

void rescale(fixture *f, double factor, double offset)
{
    for (int32_t i = 0; i < f->shapes * coordinate_count(f); i++) {
        f->shape[i] = factor * f->shape[i] + offset;
    }
}

void vary_stiffness(fixture *f, uint64_t *state)
{
    for (int32_t t = 0; t < f->triangles; t++) {
        f->stiffness[t] = pow(10.0, random_between(state, -1.0, 1.0));
    }
}

const double *shape_of(const fixture *f, int32_t s)
{
    return f->shape + (size_t)(s * coordinate_count(f));
}

int32_t coordinate_count(const fixture *f)
{
    return f->vertices * f->dimension;
}

double diagonal_of(const fixture *f)
{
    double squares = 0.0;
    for (int32_t a = 0; a < f->dimension; a++) {
        double low = f->shape[a], high = f->shape[a];
        for (int32_t i = a; i < coordinate_count(f); i += f->dimension) {
            low = fmin(low, f->shape[i]);
            high = fmax(high, f->shape[i]);
        }
        squares += (high - low) * (high - low);
    }
    return sqrt(squares);
}

tug_mesh *make_mesh(const fixture *f)
{
    tug_mesh *mesh;
    tug_create_mesh(f->shape, f->vertices, f->dimension, f->triangle, f->triangles, &mesh);
    return mesh;
}

tug_dictionary dictionary_of(const fixture *f)
{
    return (tug_dictionary){.shapes = f->shape,
                            .weights = f->weight,
                            .vertex_count = f->vertices,
                            .dimension = f->dimension,
                            .shape_count = f->shapes,
                            .weight_count = f->weights};
}

tug_model *make_model(const fixture *f)
{
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    tug_mesh *mesh = make_mesh(f);
    tug_model *model;
    tug_create_model(mesh, f->shape, f->shapes, f->weight, f->weights, &rows, f->group, f->groups,
                     f->stiffness, f->smoothness, NULL, NULL, &model);
    tug_destroy_mesh(mesh);
    return model;
}

void apply_rows(const fixture *f, const double *positions, double *values)
{
    int32_t k = f->dimension;
    memset(values, 0, (size_t)(f->rows * k) * sizeof *values);
    for (int32_t r = 0; r < f->rows; r++) {
        for (int32_t e = f->row_starts[r]; e < f->row_starts[r + 1]; e++) {
            for (int32_t a = 0; a < k; a++) {
                values[r * k + a] += f->row_values[e] * positions[f->row_vertices[e] * k + a];
            }
        }
    }
}

void mix_targets(const fixture *f, uint64_t *state, double noise, double *targets)
{
    double mixture[MAX_SHAPES], values[3 * MAX_WEIGHTS], size = noise * diagonal_of(f);
    memset(targets, 0, (size_t)(f->rows * f->dimension) * sizeof *targets);
    random_blend(state, 1, f->shapes, mixture);
    for (int32_t s = 0; s < f->shapes; s++) {
        apply_rows(f, shape_of(f, s), values);
        for (int32_t i = 0; i < f->rows * f->dimension; i++) {
            targets[i] += mixture[s] * values[i];
        }
    }
    for (int32_t i = 0; i < f->rows * f->dimension; i++) {
        targets[i] += random_between(state, -size, size);
    }
}

double dictionary_column(const fixture *f, int32_t column, int32_t vertex)
{
    int32_t block = 1 + f->shapes * f->dimension, h = column / block, c = column % block - 1;
    double weight = f->weight[vertex * f->weights + h];
    return c < 0 ? weight
                 : weight * shape_of(f, c / f->dimension)[vertex * f->dimension + c % f->dimension];
}

double edge_weight(const fixture *f, int32_t corner)
{
    int32_t k = f->dimension;
    const int32_t *triangle = f->triangle + (size_t)(corner / 3 * 3);
    const double *at = f->shape + (size_t)(triangle[corner % 3] * k);
    const double *left = f->shape + (size_t)(triangle[(corner + 1) % 3] * k);
    const double *right = f->shape + (size_t)(triangle[(corner + 2) % 3] * k);
    double uu = 0.0, uv = 0.0, vv = 0.0;
    for (int32_t a = 0; a < k; a++) {
        double u = left[a] - at[a], v = right[a] - at[a];
        uu += u * u, uv += u * v, vv += v * v;
    }
    return 0.5 * f->stiffness[corner / 3] * uv / sqrt(uu * vv - uv * uv);
}

void find_moments(const fixture *f, int32_t s, const double *positions, double *M)
{
    int32_t k = f->dimension, kk = k * k;
    const double *p = shape_of(f, s);
    memset(M, 0, (size_t)(f->groups * kk) * sizeof *M);
    for (int32_t i = 0; i < 3 * f->triangles; i++) {
        int32_t from = f->triangle[i / 3 * 3 + (i + 1) % 3],
                to = f->triangle[i / 3 * 3 + (i + 2) % 3];
        double weight = edge_weight(f, i);
        for (int32_t e = 0; e < kk; e++) {
            M[f->group[i / 3] * kk + e] +=
                weight * (p[to * k + e / k] - p[from * k + e / k]) *
                (positions[to * k + e % k] - positions[from * k + e % k]);
        }
    }
}

/* |q_e - sum_s B_gs R_gs p_se|^2 of the edge from vertex i to vertex j. */
static double edge_misfit(const fixture *f, int32_t g, int32_t i, int32_t j,
                          const double *positions, const double *blend, const double *rotations)
{
    int32_t k = f->dimension;
    double squares = 0.0;
    for (int32_t a = 0; a < k; a++) {
        double wanted = 0.0;
        for (int32_t s = 0; s < f->shapes; s++) {
            const double *p = shape_of(f, s);
            const double *R = rotations + (size_t)((g * f->shapes + s) * k * k);
            for (int32_t c = 0; c < k; c++) {
                wanted += blend[g * f->shapes + s] * R[a * k + c] * (p[j * k + c] - p[i * k + c]);
            }
        }
        double difference = positions[j * k + a] - positions[i * k + a] - wanted;
        squares += difference * difference;
    }
    return squares;
}

void measure_groups(const fixture *f, const double *positions, const double *blend,
                    const double *rotations, double *energies)
{
    memset(energies, 0, (size_t)f->groups * sizeof *energies);
    for (int32_t i = 0; i < 3 * f->triangles; i++) {
        const int32_t *triangle = f->triangle + (size_t)(i / 3 * 3);
        energies[f->group[i / 3]] +=
            edge_weight(f, i) * edge_misfit(f, f->group[i / 3], triangle[(i + 1) % 3],
                                            triangle[(i + 2) % 3], positions, blend, rotations);
    }
}

double measure_energy(const fixture *f, const double *positions, const double *blend,
                      const double *rotations)
{
    double energies[MAX_GROUPS], sum = 0.0;
    measure_groups(f, positions, blend, rotations, energies);
    for (int32_t g = 0; g < f->groups; g++) {
        sum += 0.5 * energies[g];
    }
    return sum;
}

double pose_distance(const fixture *f, const double *positions, const double *others)
{
    double largest = 0.0;
    for (int32_t v = 0; v < f->vertices; v++) {
        double squares = 0.0;
        for (int32_t a = v * f->dimension; a < (v + 1) * f->dimension; a++) {
            squares += (positions[a] - others[a]) * (positions[a] - others[a]);
        }
        if (!(squares <= largest)) { /* NaN is far */
            largest = squares;
        }
    }
    return sqrt(largest) / diagonal_of(f);
}

/* Marsaglia's xorshift. */
double random_between(uint64_t *state, double low, double high)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return low + (high - low) * (double)(*state >> 11) * 0x1p-53;
}

void random_rotation(uint64_t *state, int32_t k, double *R)
{
    double w[3];
    identity_matrix(k, R);
    for (int i = 0; i < 4; i++) {
        for (int32_t a = 0; a < tangent_size(k); a++) {
            w[a] = random_between(state, -PI, PI);
        }
        turn(k, w, R);
    }
}

void random_blend(uint64_t *state, int32_t groups, int32_t shapes, double *blend)
{
    for (int32_t i = 0; i < groups * shapes; i++) {
        blend[i] = -log(random_between(state, 1e-12, 1.0));
    }
    for (int32_t g = 0; g < groups; g++) {
        divide_by_sum(blend + g * shapes, shapes);
    }
}

void move_points(int32_t k, const double *R, const double *offset, int32_t count, double *points)
{
    for (int32_t i = 0; i < count; i++) {
        double x[3], *point = points + (size_t)(i * k);
        memcpy(x, point, (size_t)k * sizeof *x);
        for (int32_t a = 0; a < k; a++) {
            point[a] = offset[a];
            for (int32_t c = 0; c < k; c++) {
                point[a] += R[a * k + c] * x[c];
            }
        }
    }
}

static void exchange_rows(double *A, int32_t columns, int32_t i, int32_t j)
{
    for (int32_t c = 0; c < columns; c++) {
        double kept = A[i * columns + c];
        A[i * columns + c] = A[j * columns + c];
        A[j * columns + c] = kept;
    }
}

static void subtract_row(double *A, int32_t columns, int32_t from, int32_t row, double factor)
{
    for (int32_t c = 0; c < columns; c++) {
        A[from * columns + c] -= factor * A[row * columns + c];
    }
}

void solve_dense(double *A, int32_t n, double *x, int32_t columns)
{
    for (int32_t j = 0; j < n; j++) {
        int32_t best = j;
        for (int32_t i = j + 1; i < n; i++) {
            best = fabs(A[i * n + j]) > fabs(A[best * n + j]) ? i : best;
        }
        exchange_rows(A, n, j, best);
        exchange_rows(x, columns, j, best);
        for (int32_t i = 0; i < n; i++) {
            if (i != j) {
                double factor = A[i * n + j] / A[j * n + j];
                subtract_row(A, n, i, j, factor);
                subtract_row(x, columns, i, j, factor);
            }
        }
    }
    for (int32_t j = 0; j < n; j++) {
        for (int32_t c = 0; c < columns; c++) {
            x[j * columns + c] /= A[j * n + j];
        }
    }
}
