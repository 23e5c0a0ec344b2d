/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The costs of shapes against single-shape problems solved anew, from sums over the edges of the
 * mesh. */
#include "bench.h"
#include "dense/rotation.h"
#include "solver/costs.h"
#include "test.h"

enum { MAX_ALONE = MAX_WEIGHTS * 4 };

/* Column of shape s's own dictionary. */
static double own_column(const fixture *f, int32_t s, int32_t column, int32_t vertex)
{
    int32_t k = f->dimension, h = column / (1 + k), c = column % (1 + k);
    int32_t block = 1 + f->shapes * k;
    return dictionary_column(f, h * block + (c == 0 ? 0 : s * k + c), vertex);
}

/* The pose of least energy of one shape with given rotations, from the normal equations of the sum
 * over edges with the rows beside them. */
static void find_single_pose(const fixture *f, int32_t s, const double *R, const double *targets,
                             double *positions)
{
    enum { MAX_SYSTEM = MAX_ALONE + MAX_WEIGHTS };
    int32_t k = f->dimension, kk = k * k, b = f->weights * (1 + k), n = b + f->rows;
    static double A[MAX_SYSTEM * MAX_SYSTEM], x[3 * MAX_SYSTEM], D[MAX_ALONE];
    memset(A, 0, sizeof A);
    memset(x, 0, sizeof x);
    for (int32_t i = 0; i < 3 * f->triangles; i++) {
        int32_t from = f->triangle[i / 3 * 3 + (i + 1) % 3],
                to = f->triangle[i / 3 * 3 + (i + 2) % 3];
        double weight = edge_weight(f, i), edge[3], none[3] = {0};
        for (int32_t a = 0; a < k; a++) {
            edge[a] = shape_of(f, s)[to * k + a] - shape_of(f, s)[from * k + a];
        }
        move_points(k, R + f->group[i / 3] * kk, none, 1, edge);
        for (int32_t c = 0; c < b; c++) {
            D[c] = own_column(f, s, c, to) - own_column(f, s, c, from);
        }
        for (int32_t c = 0; c < b; c++) {
            for (int32_t e = 0; e < b; e++) {
                A[c * n + e] += weight * D[c] * D[e];
            }
            for (int32_t a = 0; a < k; a++) {
                x[c * k + a] += weight * D[c] * edge[a];
            }
        }
    }
    for (int32_t r = 0; r < f->rows; r++) {
        for (int32_t c = 0; c < b; c++) {
            A[(b + r) * n + c] = A[c * n + b + r] = own_column(f, s, c, f->row_vertices[r]);
        }
        memcpy(x + (b + r) * k, targets + r * k, (size_t)k * sizeof *x);
    }
    solve_dense(A, n, x, k);
    memset(positions, 0, (size_t)coordinate_count(f) * sizeof *positions);
    for (int32_t i = 0; i < coordinate_count(f); i++) {
        for (int32_t c = 0; c < b; c++) {
            positions[i] += own_column(f, s, c, i / k) * x[c * k + i % k];
        }
    }
}

/* E_g of every group where shape s alone is at work. Returns their sum. */
static double measure_single(const fixture *f, int32_t s, const double *R, const double *positions,
                             double *energies)
{
    int32_t kk = f->dimension * f->dimension;
    double blend[MAX_PAIRS] = {0}, rotations[9 * MAX_PAIRS] = {0}, sum = 0.0;
    for (int32_t g = 0; g < f->groups; g++) {
        blend[g * f->shapes + s] = 1.0;
        memcpy(rotations + (g * f->shapes + s) * kk, R + g * kk, (size_t)kk * sizeof *R);
    }
    measure_groups(f, positions, blend, rotations, energies);
    for (int32_t g = 0; g < f->groups; g++) {
        sum += energies[g];
    }
    return sum;
}

/* What local/global steps reach from R, which becomes where they end. Returns the last turn. */
static double alternate(const fixture *f, int32_t s, const double *targets, int rounds, double *R,
                        double *positions)
{
    int32_t k = f->dimension, kk = k * k;
    double M[9 * MAX_GROUPS], next[9], turned = 0.0;
    for (int round = 0; round < rounds; round++) {
        find_single_pose(f, s, R, targets, positions);
        find_moments(f, s, positions, M);
        turned = 0.0;
        for (int32_t g = 0; g < f->groups; g++) {
            closest_rotation(k, M + g * kk, next);
            turned = fmax(turned, angle_between(k, next, R + g * kk));
            memcpy(R + g * kk, next, (size_t)kk * sizeof *next);
        }
    }
    find_single_pose(f, s, R, targets, positions);
    return turned;
}

/* Targets and the library's costs for them. */
typedef struct priced {
    double targets[3 * MAX_WEIGHTS];
    shape_costs costs;
} priced;

static void price(const fixture *f, const tug_model *model, uint64_t *random, int turning,
                  priced *x)
{
    double Y[3 * MAX_WEIGHTS];
    mix_targets(f, random, 0.05, x->targets);
    for (int32_t i = 0; i < f->rows * f->dimension; i++) {
        Y[i] = x->targets[i] / model->header.unit;
    }
    costs_create(model, &x->costs);
    find_costs(model, NULL, NULL, Y, turning, &x->costs);
}

/* The rotations of one shape's optimum, from the shape as it is given. */
static void take_rotations(const fixture *f, const tug_model *model, const priced *x, int32_t s,
                           double *R)
{
    int32_t k = f->dimension, kk = k * k;
    for (int32_t g = 0; g < f->groups; g++) {
        int32_t pair = g * f->shapes + s;
        multiply(k, x->costs.rotations + pair * kk, model->align + pair * kk, R + g * kk);
    }
}

static void costs_are_the_energies_of_single_shapes(void)
{
    fixture f;
    uint64_t random = 6;
    for (int i = 0; i < 12; i++) {
        make_numbered(&f, i % 3);
        if (i % 4 == 3) {
            free_last_handle(&f);
        }
        tug_model *model = make_model(&f);
        double scale = model->header.unit * model->header.unit;
        priced x;
        price(&f, model, &random, i < 6, &x);
        for (int32_t s = 0; s < f.shapes; s++) {
            double R[9 * MAX_GROUPS], positions[MAX_COORDINATES], E[MAX_GROUPS];
            take_rotations(&f, model, &x, s, R);
            find_single_pose(&f, s, R, x.targets, positions);
            double sum = measure_single(&f, s, R, positions, E);
            for (int32_t g = 0; g < f.groups; g++) {
                CHECK_NEAR(scale * x.costs.D[g * f.shapes + s], E[g], 1e-9 * sum);
            }
        }
        costs_destroy(&x.costs);
        tug_destroy_model(model);
    }
}

static void single_shapes_are_at_their_optimum(void)
{
    fixture f;
    uint64_t random = 7;
    for (int i = 0; i < 6; i++) {
        make_numbered(&f, i % 3);
        tug_model *model = make_model(&f);
        priced x;
        price(&f, model, &random, 1, &x);
        CHECK(x.costs.converged);
        for (int32_t s = 0; s < f.shapes; s++) {
            double R[9 * MAX_GROUPS], positions[MAX_COORDINATES], E[MAX_GROUPS];
            take_rotations(&f, model, &x, s, R);
            find_single_pose(&f, s, R, x.targets, positions);
            double sum = measure_single(&f, s, R, positions, E);
            CHECK(alternate(&f, s, x.targets, 1, R, positions) < 1e-7); /* nothing moves */
            for (int32_t g = 0; g < f.groups; g++) {
                identity_matrix(f.dimension, R + g * f.dimension * f.dimension);
            }
            alternate(&f, s, x.targets, 30, R, positions);
            CHECK(sum <= measure_single(&f, s, R, positions, E) * (1.0 + 1e-9));
        }
        costs_destroy(&x.costs);
        tug_destroy_model(model);
    }
}

static void without_turning_every_rotation_is_the_identity(void)
{
    fixture f;
    uint64_t random = 8;
    double R[9 * MAX_GROUPS], I[9];
    priced x;
    make_tube(&f, 1);
    tug_model *model = make_model(&f);
    price(&f, model, &random, 0, &x);
    identity_matrix(3, I);
    for (int32_t s = 0; s < f.shapes; s++) {
        take_rotations(&f, model, &x, s, R);
        for (int32_t g = 0; g < f.groups; g++) {
            CHECK(angle_between(3, R + 9 * g, I) < 1e-14);
        }
    }
    costs_destroy(&x.costs);
    tug_destroy_model(model);
}

int main(int argc, char **argv)
{
    RUN(costs_are_the_energies_of_single_shapes);
    RUN(single_shapes_are_at_their_optimum);
    RUN(without_turning_every_rotation_is_the_identity);
    return TEST_RESULT;
}
