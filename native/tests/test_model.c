/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The constants of a model against sums over the edges of the mesh. The reduced energy has to be
 * that of the pose it belongs to, and no other pose of the dictionary that keeps the handles may
 * have less. */
#include "contraction.h"
#include "costs.h"
#include "fixture.h"
#include "rotation.h"
#include "solver.h"
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
    double pull[9 * MAX_PAIRS], V[9 * MAX_PAIRS], T[3 * MAX_COLUMNS];
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
    recover_transforms(&model->energy, x->V, x->Y, k, x->T);
    find_positions(&(tug_solver){.model = model, .T = x->T}, x->positions);
}

/* 1/2 (B^T Q B + 2 c^T B + r), in the fixture's unit. */
static double reduced_energy(const fixture *f, const tug_model *model, const state *x)
{
    int32_t n = f->groups * f->shapes, k = f->dimension;
    double Q[MAX_PAIRS * MAX_PAIRS], sum = energy_of_rows(&model->energy, x->Y, k);
    contract_pair_rotations(model, x->turned, Q);
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

/* Column `column` of the papers' dictionary: W_h, or W_h times a coordinate of a shape. */
static double raw_column(const fixture *f, int32_t column, int32_t vertex)
{
    int32_t block = 1 + f->shapes * f->dimension, h = column / block, c = column % block - 1;
    double weight = f->weight[vertex * f->weights + h];
    return c < 0 ? weight
                 : weight * shape_of(f, c / f->dimension)[vertex * f->dimension + c % f->dimension];
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
            delta[v * k + c % k] += factor * raw_column(f, c / k, v);
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
            column[v] = raw_column(f, c, v);
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

/* M_g = sum of half cotangents times p_e q_e^T, from the edges of shape s to those of a pose. */
static void find_moments(const fixture *f, int32_t s, const double *positions, double *M)
{
    int32_t k = f->dimension, kk = k * k;
    const double *p = shape_of(f, s);
    memset(M, 0, (size_t)(f->groups * kk) * sizeof *M);
    for (int32_t i = 0; i < 3 * f->triangles; i++) {
        int32_t from = f->triangle[i / 3 * 3 + (i + 1) % 3],
                to = f->triangle[i / 3 * 3 + (i + 2) % 3];
        double weight = half_cotangent(f, i);
        for (int32_t e = 0; e < kk; e++) {
            M[f->group[i / 3] * kk + e] +=
                weight * (p[to * k + e / k] - p[from * k + e / k]) *
                (positions[to * k + e % k] - positions[from * k + e % k]);
        }
    }
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
        random_blend(&random, f.groups, S, B);
        for (int32_t j = 0; j < n; j++) {
            if (j % S == 0) {
                random_rotation(&random, k, R + j / S * kk);
            }
            memcpy(pairs + j * kk, R + j / S * kk, (size_t)kk * sizeof *R);
        }
        contract_rotations(model, R, Q);
        contract_pair_rotations(model, pairs, pair_Q);
        for (int32_t j = 0; j < n * n; j++) {
            CHECK_NEAR(Q[j], pair_Q[j], 1e-12);
            quadratic += B[j / n] * B[j % n] * Q[j];
        }
        contract_blend(model, B, C);
        for (int32_t j = 0; j < size * size; j++) { /* sum of tr(R_g C_gh R_h^T) */
            const double *left = R + j / size / k * kk, *right = R + j % size / k * kk;
            for (int32_t a = 0; a < k; a++) {
                through_C += left[a * k + j / size % k] * C[j] * right[a * k + j % k];
            }
        }
        CHECK_NEAR(through_C / quadratic, 1.0, 1e-10);
        for (int32_t s = 0; s < S; s++) { /* group 1's rows of C, shape by shape */
            contract_blend_row(model, S + s, B, X);
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

enum { MAX_ALONE = MAX_WEIGHTS * 4 };

/* Column of shape s's own dictionary. */
static double own_column(const fixture *f, int32_t s, int32_t column, int32_t vertex)
{
    int32_t k = f->dimension, h = column / (1 + k), c = column % (1 + k);
    int32_t block = 1 + f->shapes * k;
    return raw_column(f, h * block + (c == 0 ? 0 : s * k + c), vertex);
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
        double weight = half_cotangent(f, i), edge[3], none[3] = {0};
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
    find_costs(model, Y, turning, &x->costs);
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

static tug_status try_model(const fixture *f)
{
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    tug_mesh *mesh = make_mesh(f);
    tug_model *model = (tug_model *)&rows;
    tug_status status = tug_create_model(mesh, f->shape, f->shapes, f->weight, f->weights, &rows,
                                         f->group, f->groups, NULL, NULL, &model);
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
    RUN(costs_are_the_energies_of_single_shapes);
    RUN(single_shapes_are_at_their_optimum);
    RUN(without_turning_every_rotation_is_the_identity);
    RUN(handles_in_one_place_are_refused);
    RUN(unsound_meshes_are_refused);
    return TEST_RESULT;
}
