/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The constants of a model against sums over the edges of the mesh. The reduced energy has to be
 * that of the pose it belongs to, and no other pose of the dictionary that keeps the handles may
 * have less. */
#include "dense/rotation.h"
#include "fixture.h"
#include "solver/contraction.h"
#include "solver/solver.h"
#include "test.h"

enum { MAX_COLUMNS = MAX_WEIGHTS * (1 + 3 * MAX_SHAPES) };

/* The fixtures of every test here: number i, and whether there is one. */
static int make_numbered(fixture *f, int i)
{
    switch (i) {
    case 0:
        make_strip(f);
        break;
    case 1:
        make_tube(f, 0);
        break;
    case 2:
        make_tube(f, 1);
        free_last_handle(f);
        break;
    case 3:
        make_strip(f);
        duplicate_shape(f, 1);
        break;
    case 4:
        make_tube(f, 1);
        duplicate_shape(f, 0);
        break;
    case 5:
        make_flat(f);
        break;
    default:
        return 0;
    }
    return 1;
}

/* A blend, rotations and targets out of the blue, and the pose the model finds for them. */
typedef struct state {
    double blend[MAX_PAIRS], rotations[9 * MAX_PAIRS], turned[9 * MAX_PAIRS];
    double targets[3 * MAX_WEIGHTS], Y[3 * MAX_WEIGHTS];
    double pull[9 * MAX_PAIRS], V[9 * MAX_PAIRS], T[3 * MAX_COLUMNS], placed_T[3 * MAX_COLUMNS];
    double recovery[3 * (2 * MAX_COLUMNS + MAX_WEIGHTS)];
    double positions[MAX_COORDINATES];
} state;

static void make_state(const fixture *f, const tug_model *model, uint64_t *random, state *x)
{
    int32_t k = f->dimension, kk = k * k, n = f->groups * f->shapes;
    random_blend(random, f->groups, f->shapes, x->blend);
    mix_targets(f, random, 0.2, x->targets);
    for (int32_t i = 0; i < f->rows * k; i++) {
        x->Y[i] = x->targets[i] / model->header.unit;
    }
    for (int32_t i = 0; i < n; i++) {
        double *R = x->turned + i * kk;
        random_rotation(random, k, R);
        multiply(k, R, model->align + i * kk, x->rotations + i * kk);
        for (int32_t e = 0; e < kk; e++) {
            x->V[i * kk + e] = x->blend[i] * R[e % k * k + e / k];
        }
    }
    find_pull(&model->energy, x->Y, k, x->pull);
    recover_transforms(&model->energy, x->V, x->Y, k, x->recovery, x->T);
    place_transforms(&model->dictionary, x->T, x->placed_T);
    find_positions(&(tug_solver){.model = model, .placed_T = x->placed_T}, x->positions);
}

/* 1/2 (B^T Q B + 2 c^T B + r), in the fixture's unit. */
static double reduced_energy(const fixture *f, const tug_model *model, const state *x)
{
    int32_t n = f->groups * f->shapes, k = f->dimension;
    double Q[MAX_PAIRS * MAX_PAIRS], sum = energy_of_rows(&model->energy, x->Y, k);
    coupling all = joint_coupling(&model->energy);
    contract_pair_rotations(&all, x->turned, Q);
    for (int32_t i = 0; i < n; i++) {
        sum -= 2.0 * x->blend[i] * trace_of_product(k, x->turned + i * k * k, x->pull + i * k * k);
        for (int32_t j = 0; j < n; j++) {
            sum += x->blend[i] * x->blend[j] * Q[i * n + j];
        }
    }
    return 0.5 * model->header.unit * model->header.unit * sum;
}

static void reduced_energy_is_that_of_the_pose(void)
{
    fixture f;
    uint64_t random = 1;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        CHECK(model != NULL);
        for (int trial = 0; trial < 5; trial++) {
            state x;
            make_state(&f, model, &random, &x);
            double energy = measure_energy(&f, x.positions, x.blend, x.rotations);
            CHECK_NEAR(reduced_energy(&f, model, &x) / energy, 1.0, 1e-7);
        }
        tug_destroy_model(model);
    }
}

static void pose_keeps_the_constraints(void)
{
    fixture f;
    uint64_t random = 2;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        for (int trial = 0; trial < 5; trial++) {
            state x;
            double values[3 * MAX_WEIGHTS];
            make_state(&f, model, &random, &x);
            apply_rows(&f, x.positions, values);
            for (int32_t e = 0; e < f.rows * f.dimension; e++) {
                CHECK_NEAR(values[e], x.targets[e], 1e-10 * diagonal_of(&f));
            }
        }
        tug_destroy_model(model);
    }
}

/* Some pose of the dictionary's span less what it does to the rows: X delta = 0. The pinned weight
 * functions alone undo it. */
static void make_variation(const fixture *f, uint64_t *random, double *delta)
{
    int32_t k = f->dimension, columns = f->weights * (1 + f->shapes * k);
    double X[MAX_WEIGHTS * MAX_WEIGHTS], values[3 * MAX_WEIGHTS];
    memset(delta, 0, (size_t)coordinate_count(f) * sizeof *delta);
    for (int32_t c = 0; c < columns * k; c++) {
        double factor = random_between(random, -1.0, 1.0);
        for (int32_t v = 0; v < f->vertices; v++) {
            delta[v * k + c % k] += factor * dictionary_column(f, c / k, v);
        }
    }
    apply_rows(f, delta, values);
    for (int32_t i = 0; i < f->rows * f->rows; i++) {
        X[i] = f->weight[f->row_vertices[i / f->rows] * f->weights + i % f->rows];
    }
    solve_dense(X, f->rows, values, k);
    for (int32_t i = 0; i < coordinate_count(f); i++) {
        for (int32_t h = 0; h < f->rows; h++) {
            delta[i] -= f->weight[i / k * f->weights + h] * values[h * k + i % k];
        }
    }
}

static double energy_beside(const fixture *f, const state *x, const double *delta, double t)
{
    double moved[MAX_COORDINATES];
    for (int32_t i = 0; i < coordinate_count(f); i++) {
        moved[i] = x->positions[i] + t * delta[i];
    }
    return measure_energy(f, moved, x->blend, x->rotations);
}

static void no_pose_with_the_same_constraints_has_less_energy(void)
{
    fixture f;
    uint64_t random = 3;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        for (int trial = 0; trial < 20; trial++) {
            state x;
            double delta[MAX_COORDINATES];
            make_state(&f, model, &random, &x);
            make_variation(&f, &random, delta);
            double energy = measure_energy(&f, x.positions, x.blend, x.rotations);
            double forth = energy_beside(&f, &x, delta, 0.1);
            double back = energy_beside(&f, &x, delta, -0.1);
            CHECK(forth > energy && back > energy);
            /* The energy is quadratic: at its minimum both sides rise by the same. */
            CHECK_NEAR((forth - back) / (forth + back - 2.0 * energy), 0.0, 1e-6);
        }
        tug_destroy_model(model);
    }
}

/* Take from x its part along an orthonormal basis. */
static void project_out(const double *basis, int32_t count, int32_t n, double *x)
{
    for (int32_t j = 0; j < 2 * count; j++) { /* twice is enough */
        const double *b = basis + j % count * n;
        double along = 0.0;
        for (int32_t v = 0; v < n; v++) {
            along += b[v] * x[v];
        }
        for (int32_t v = 0; v < n; v++) {
            x[v] -= along * b[v];
        }
    }
}

static double length_of(const double *x, int32_t n)
{
    double squares = 0.0;
    for (int32_t v = 0; v < n; v++) {
        squares += x[v] * x[v];
    }
    return sqrt(squares);
}

/* An orthonormal basis of the papers' dictionary, #V values after #V values. */
static int32_t find_basis(const fixture *f, double *basis)
{
    int32_t count = 0, n = f->vertices;
    for (int32_t c = 0; c < f->weights * (1 + f->shapes * f->dimension); c++) {
        double *column = basis + count * n, before;
        for (int32_t v = 0; v < n; v++) {
            column[v] = dictionary_column(f, c, v);
        }
        before = length_of(column, n);
        project_out(basis, count, n, column);
        double left = length_of(column, n);
        if (left > 1e-8 * before) {
            for (int32_t v = 0; v < n; v++) {
                column[v] /= left;
            }
            count++;
        }
    }
    return count;
}

static void pose_is_in_the_span_of_the_dictionary(void)
{
    static double basis[MAX_COLUMNS * MAX_VERTICES];
    fixture f;
    uint64_t random = 4;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        int32_t count = find_basis(&f, basis), k = f.dimension;
        for (int trial = 0; trial < 3 * k; trial++) {
            state x;
            double column[MAX_VERTICES];
            make_state(&f, model, &random, &x);
            for (int32_t v = 0; v < f.vertices; v++) {
                column[v] = x.positions[v * k + trial % k];
            }
            project_out(basis, count, f.vertices, column);
            CHECK(length_of(column, f.vertices) < 1e-8 * diagonal_of(&f));
        }
        tug_destroy_model(model);
    }
}

static void rank_counts_the_independent_columns(void)
{
    fixture f;
    tug_model_sizes sizes = {.struct_size = sizeof sizes};
    make_strip(&f);
    tug_model *model = make_model(&f);
    CHECK(tug_get_model_sizes(model, &sizes) == TUG_OK);
    tug_destroy_model(model);
    CHECK(sizes.vertices == f.vertices && sizes.dimension == 2 && sizes.shapes == 3);
    CHECK(sizes.weights == 3 && sizes.rows == 3 && sizes.groups == f.groups);
    CHECK(sizes.unknowns == 3 * (1 + 3 * 2) && sizes.rank == sizes.unknowns);

    duplicate_shape(&f, 2);
    model = make_model(&f);
    CHECK(tug_get_model_sizes(model, &sizes) == TUG_OK);
    tug_destroy_model(model);
    CHECK(sizes.unknowns == 3 * (1 + 4 * 2) && sizes.rank == 3 * (1 + 3 * 2));

    make_flat(&f);
    model = make_model(&f);
    CHECK(tug_get_model_sizes(model, &sizes) == TUG_OK);
    tug_destroy_model(model);
    CHECK(sizes.unknowns == 3 * (1 + 3 * 3) && sizes.rank == 3 * (1 + 3 * 2));
}

static void shapes_are_aligned_to_the_rest_shape(void)
{
    fixture f;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        int32_t k = f.dimension, kk = k * k;
        for (int32_t s = 0; s < f.shapes; s++) {
            double M[9 * MAX_GROUPS], R[9];
            find_moments(&f, s, f.shape, M);
            for (int32_t g = 0; g < f.groups; g++) {
                closest_rotation(k, M + g * kk, R);
                CHECK(angle_between(k, R, model->align + (g * f.shapes + s) * kk) < 1e-7);
            }
        }
        tug_destroy_model(model);
    }
}

static void contractions_agree(void)
{
    fixture f;
    uint64_t random = 5;
    for (int i = 0; make_numbered(&f, i); i++) {
        tug_model *model = make_model(&f);
        int32_t k = f.dimension, kk = k * k, S = f.shapes, n = f.groups * S, size = f.groups * k;
        static double Q[MAX_PAIRS * MAX_PAIRS], pair_Q[MAX_PAIRS * MAX_PAIRS];
        double C[9 * MAX_GROUPS * MAX_GROUPS], R[9 * MAX_GROUPS], pairs[9 * MAX_PAIRS];
        double B[MAX_PAIRS], X[9 * MAX_GROUPS], quadratic = 0.0, through_C = 0.0;
        coupling all = joint_coupling(&model->energy);
        random_blend(&random, f.groups, S, B);
        for (int32_t j = 0; j < n; j++) {
            if (j % S == 0) {
                random_rotation(&random, k, R + j / S * kk);
            }
            memcpy(pairs + j * kk, R + j / S * kk, (size_t)kk * sizeof *R);
        }
        contract_rotations(&all, R, Q);
        contract_pair_rotations(&all, pairs, pair_Q);
        for (int32_t j = 0; j < n * n; j++) {
            CHECK_NEAR(Q[j], pair_Q[j], 1e-12);
            quadratic += B[j / n] * B[j % n] * Q[j];
        }
        contract_blend(&all, B, C);
        for (int32_t j = 0; j < size * size; j++) { /* sum of tr(R_g C_gh R_h^T) */
            const double *left = R + j / size / k * kk, *right = R + j % size / k * kk;
            for (int32_t a = 0; a < k; a++) {
                through_C += left[a * k + j / size % k] * C[j] * right[a * k + j % k];
            }
        }
        CHECK_NEAR(through_C / quadratic, 1.0, 1e-10);
        for (int32_t s = 0; s < S; s++) { /* group 1's rows of C, shape by shape */
            contract_blend_row(&all, S + s, B, X);
            for (int32_t j = 0; j < k * size; j++) {
                int32_t a = j / size, h = j % size / k, b = j % k;
                C[(k + a) * size + h * k + b] -= B[S + s] * X[h * kk + a * k + b];
            }
        }
        for (int32_t j = k * size; j < 2 * k * size; j++) {
            CHECK_NEAR(C[j], 0.0, 1e-12);
        }
        tug_destroy_model(model);
    }
}

static tug_status try_model(const fixture *f)
{
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    tug_mesh *mesh = make_mesh(f);
    tug_model *model = (tug_model *)&rows;
    tug_status status =
        tug_create_model(mesh, f->shape, f->shapes, f->weight, f->weights, &rows, f->group,
                         f->groups, f->stiffness, f->smoothness, NULL, NULL, &model);
    tug_destroy_mesh(mesh);
    if (status != TUG_OK && model != NULL) {
        return TUG_OK; /* it has to be NULL then: any other status would hide it */
    }
    tug_destroy_model(model);
    return status;
}

static void handles_in_one_place_are_refused(void)
{
    fixture f;
    make_tube(&f, 1);
    CHECK(try_model(&f) == TUG_OK);
    f.row_vertices[2] = f.row_vertices[1];
    CHECK(try_model(&f) == TUG_ERROR_HANDLES);
    CHECK(strstr(tug_error_text(), "handles") != NULL);
    make_strip(&f);
    f.row_values[0] = 0.0; /* a row that holds nothing */
    CHECK(try_model(&f) == TUG_ERROR_HANDLES);
}

static void unsound_meshes_are_refused(void)
{
    fixture f;
    make_strip(&f);
    f.triangle[1] = f.triangle[0];
    CHECK(try_model(&f) == TUG_ERROR_MESH);
    CHECK(strstr(tug_error_text(), "no area") != NULL);
}

int main(int argc, char **argv)
{
    RUN(reduced_energy_is_that_of_the_pose);
    RUN(pose_keeps_the_constraints);
    RUN(no_pose_with_the_same_constraints_has_less_energy);
    RUN(pose_is_in_the_span_of_the_dictionary);
    RUN(rank_counts_the_independent_columns);
    RUN(shapes_are_aligned_to_the_rest_shape);
    RUN(contractions_agree);
    RUN(handles_in_one_place_are_refused);
    RUN(unsound_meshes_are_refused);
    return TEST_RESULT;
}
