/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The smoothness energy (F 6): the squares of the eigenvalues for eigenfunctions, nothing for
 * examples and translations, and what it does to poses. */
#include "bench.h"
#include "memory.h"
#include "model/model.h"
#include "model/smoothness.h"
#include "test.h"

enum { FUNCTIONS = 6 };

static void eigenfunctions_have_the_squares_of_their_values(void)
{
    fixture f;
    make_tube(&f, 1);
    tug_mesh *mesh = make_mesh(&f);
    double values[FUNCTIONS], functions[FUNCTIONS * MAX_VERTICES], S[FUNCTIONS * FUNCTIONS];
    double columns[FUNCTIONS * MAX_VERTICES];
    CHECK(tug_compute_eigenfunctions(mesh, FUNCTIONS, NULL, NULL, values, functions, NULL) ==
          TUG_OK);
    for (int32_t i = 0; i < FUNCTIONS * f.vertices; i++) {
        columns[i] = functions[i % f.vertices * FUNCTIONS + i / f.vertices];
    }
    dictionary D = {.vertices = f.vertices, .weights = FUNCTIONS, .weight_columns = columns};
    CHECK(find_smoothness(mesh, &D, 0.3, S) == TUG_OK);
    double largest = 0.3 * values[FUNCTIONS - 1] * values[FUNCTIONS - 1];
    for (int32_t i = 0; i < FUNCTIONS; i++) {
        for (int32_t j = 0; j < FUNCTIONS; j++) {
            double expected = i == j ? 0.3 * values[i] * values[i] : 0.0;
            CHECK_NEAR(S[i * FUNCTIONS + j], expected, 1e-7 * largest);
        }
    }
    tug_destroy_mesh(mesh);
}

/* tr(T^T Lambda T) by its lower triangle. */
static double energy_of_transforms(const double *L, int32_t b, int32_t k, const double *T)
{
    double sum = 0.0;
    for (int32_t i = 0; i < b; i++) {
        for (int32_t j = 0; j <= i; j++) {
            for (int32_t a = 0; a < k; a++) {
                sum += (i == j ? 1.0 : 2.0) * L[i * b + j] * T[i * k + a] * T[j * k + a];
            }
        }
    }
    return sum;
}

/* Transforms that make an affine image of an example: the constant for its coordinates and for the
 * translation. */
static void examples_and_translations_have_none(void)
{
    uint64_t random = 5;
    for (int i = 0; i < 3; i++) {
        bench b;
        make_numbered(&b.f, i);
        b.f.smoothness = 2.0;
        prepare(&b, TUG_FORM_STEADY);
        const tug_model *model = b.model;
        int32_t k = b.f.dimension, S = b.f.shapes, m = b.f.weights, block = 1 + S * k;
        int32_t unknowns = m * block;
        double *L = allocate((size_t)(unknowns * unknowns), sizeof *L);
        double *T = allocate((size_t)(unknowns * k), sizeof *T);
        add_smoothness(&model->dictionary, model->smoothness, 0, S * k, L);
        for (int32_t e = 0; e < unknowns * k; e++) {
            T[e] = random_between(&random, -1.0, 1.0);
        }
        double some = energy_of_transforms(L, unknowns, k, T);
        CHECK(some > 0.0);
        for (int32_t a = 0; a < k; a++) { /* one affine map, the same at every weight function */
            double shift = random_between(&random, -1.0, 1.0), map[3 * MAX_SHAPES];
            for (int32_t c = 0; c < S * k; c++) {
                map[c] = random_between(&random, -1.0, 1.0);
            }
            for (int32_t h = 0; h < m; h++) {
                double *t = T + h * block * k + a;
                t[0] = shift * model->constant[h];
                for (int32_t c = 0; c < S * k; c++) {
                    t[(1 + c) * k] = map[c] * model->constant[h];
                    t[0] += map[c] * model->constant[h] * model->middles[h * S * k + c];
                }
            }
        }
        CHECK(fabs(energy_of_transforms(L, unknowns, k, T)) <= 1e-12 * some);
        release(L);
        release(T);
        clear(&b);
    }
}

static void examples_come_back_from_smooth_models(void)
{
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        make_numbered(&b.f, i % 3);
        b.f.smoothness = 1e-3;
        prepare(&b, FORMS[i / 3]);
        CHECK(finds_examples(&b, 1e-6));
        clear(&b);
    }
}

/* Distance of a pose from the nearest one whose influences are constant: its coordinates as linear
 * functions of the shapes', by least squares. */
static double distance_from_affine(const bench *b)
{
    int32_t k = b->f.dimension, c = 1 + b->f.shapes * k;
    double A[16 * 16] = {0}, x[16 * 3] = {0}, row[16], squares = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t v = 0; v < b->f.vertices; v++) {
            row[0] = 1.0;
            for (int32_t j = 1; j < c; j++) {
                row[j] = shape_of(&b->f, (j - 1) / k)[v * k + (j - 1) % k];
            }
            for (int32_t a = 0; a < k; a++) {
                double left = b->positions[v * k + a];
                for (int32_t j = 0; j < c; j++) {
                    if (pass == 0) {
                        x[j * k + a] += row[j] * left;
                    } else {
                        left -= row[j] * x[j * k + a];
                    }
                }
                squares += pass * left * left;
            }
            for (int32_t j = 0; j < c * c && pass == 0; j++) {
                A[j] += row[j / c] * row[j % c];
            }
        }
        for (int32_t j = 0; j < c && pass == 0; j++) {
            A[j * c + j] += 1e-10;
        }
        if (pass == 0) {
            solve_dense(A, c, x, k);
        }
    }
    return sqrt(squares / b->f.vertices) / diagonal_of(&b->f);
}

static void much_of_it_leaves_affine_influences(void)
{
    uint64_t random = 6;
    for (int i = 0; i < 3; i++) {
        double distance[2];
        bench b;
        make_numbered(&b.f, i);
        for (int much = 0; much < 2; much++) {
            b.f.smoothness = much ? 1e4 : 0.0;
            prepare(&b, TUG_FORM_MINIMAL);
            uint64_t same = random + 1;
            mix_targets(&b.f, &same, 0.1, b.targets);
            CHECK(solve(&b));
            CHECK(constraint_error(&b) <= 1e-9);
            distance[much] = distance_from_affine(&b);
            clear(&b);
        }
        CHECK(distance[0] > 1e-3);
        CHECK(distance[1] < 1e-2 * distance[0]);
        random += 7;
    }
}

/* It has no unit of length. */
static void the_unit_does_not_matter(void)
{
    bench b, large;
    uint64_t random = 9;
    make_tube(&b.f, 0);
    b.f.smoothness = 1e-2;
    large.f = b.f;
    rescale(&large.f, 1e3, 0.0);
    prepare(&b, TUG_FORM_STEADY);
    prepare(&large, TUG_FORM_STEADY);
    mix_targets(&b.f, &random, 0.05, b.targets);
    for (int32_t i = 0; i < b.f.rows * 3; i++) {
        large.targets[i] = 1e3 * b.targets[i];
    }
    CHECK(solve(&b) && solve(&large));
    for (int32_t i = 0; i < coordinate_count(&b.f); i++) {
        large.positions[i] /= 1e3;
    }
    CHECK(pose_distance(&b.f, b.positions, large.positions) <= 1e-6);
    clear(&b);
    clear(&large);
}

int main(int argc, char **argv)
{
    RUN(eigenfunctions_have_the_squares_of_their_values);
    RUN(examples_and_translations_have_none);
    RUN(examples_come_back_from_smooth_models);
    RUN(much_of_it_leaves_affine_influences);
    RUN(the_unit_does_not_matter);
    return TEST_RESULT;
}
