/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From mesh, shapes, weights, rows and groups to the constants of a model. */
#include "model.h"

#include "dense.h"
#include "energy.h"
#include "memory.h"
#include "null_space.h"
#include "rotation.h"

#include <math.h>
#include <string.h>

typedef struct build {
    tug_model *model;
    const tug_rows *given_rows;
    energy_workspace *energies;
    group_energy group; /* of the group at hand; K points into all_K */
    double *all_L;      /* b by b */
    double *all_K;      /* #G #S k by b */
    double *X;          /* #H by b */
    double *shape_L, *shape_K, *shape_X;
    double *group_weights, *row_weights; /* #W */
} build;

static int allocate_build(build *w)
{
    const model_header *header = &w->model->header;
    size_t k = (size_t)header->dimension, S = (size_t)header->shapes, m = (size_t)header->weights;
    size_t h = (size_t)header->rows, G = (size_t)header->groups;
    size_t p = S * k, b = m * (1 + p), b_s = m * (1 + k);
    w->group.L = allocate(b * b, sizeof(double));
    w->group.H = allocate(p * p, sizeof(double));
    w->all_L = allocate(b * b, sizeof(double));
    w->all_K = allocate(G * p * b, sizeof(double));
    w->X = allocate(h * b, sizeof(double));
    w->shape_L = allocate(b_s * b_s, sizeof(double));
    w->shape_K = allocate(G * k * b_s, sizeof(double));
    w->shape_X = allocate(h * b_s, sizeof(double));
    w->group_weights = allocate(m, sizeof(double));
    w->row_weights = allocate(m, sizeof(double));
    return w->group.L && w->group.H && w->all_L && w->all_K && w->X && w->shape_L && w->shape_K &&
           w->shape_X && w->group_weights && w->row_weights;
}

static void free_build(build *w)
{
    energy_workspace_destroy(w->energies);
    release(w->group.L);
    release(w->group.H);
    release(w->all_L);
    release(w->all_K);
    release(w->X);
    release(w->shape_L);
    release(w->shape_K);
    release(w->shape_X);
    release(w->group_weights);
    release(w->row_weights);
}

/* The constant function as a combination of the weights, by least squares. */
static tug_status find_constant(tug_model *model)
{
    int32_t m = model->header.weights, n = model->header.vertices;
    double *products = allocate((size_t)m * (size_t)m, sizeof *products);
    if (products == NULL) {
        return fail_memory();
    }
    const double *W = model->weight_columns;
    add_product_nt(m, m, n, 1.0, W, n, W, n, products, m);
    for (int32_t h = 0; h < m; h++) {
        model->constant[h] = 0.0;
        for (int32_t i = 0; i < n; i++) {
            model->constant[h] += W[(size_t)h * (size_t)n + (size_t)i];
        }
    }
    int definite = cholesky_factor(products, m);
    if (definite) {
        cholesky_solve(products, m, model->constant, 1);
    }
    release(products);
    return definite ? TUG_OK
                    : fail(TUG_ERROR_ARGUMENT,
                           "tug_create_model: the weight functions depend on each other");
}

/* X = rows of D at the constraints, and the constrained values of each shape. */
static void find_rows(build *w)
{
    const tug_rows *rows = w->given_rows;
    const dictionary *D = &w->model->dictionary;
    size_t b = (size_t)dictionary_columns(D), k = (size_t)D->dimension, n = (size_t)D->vertices;
    for (int32_t r = 0; r < rows->count; r++) {
        for (int32_t e = rows->starts[r]; e < rows->starts[r + 1]; e++) {
            int32_t v = rows->vertices[e];
            add_dictionary_row(D, v, rows->values[e], w->X + (size_t)r * b);
            for (size_t c = 0; c < (size_t)D->shapes * k; c++) {
                w->model->shape[c / k].rows[(size_t)r * k + c % k] +=
                    rows->values[e] * D->shape_columns[c * n + (size_t)v];
            }
        }
    }
}

/* Q_gs: the rotation that best carries group g of shape s onto group g of the rest shape. */
static void align_group(build *w, int32_t g)
{
    int32_t k = w->model->header.dimension, S = w->model->header.shapes, p = S * k;
    for (int32_t s = 0; s < S; s++) {
        double M[9];
        for (int32_t i = 0; i < k * k; i++) {
            M[i] = w->group.H[(s * k + i / k) * p + i % k];
        }
        double *Q = w->model->align + (size_t)((g * S + s) * k * k);
        if (s == 0) {
            identity_matrix(k, Q);
        } else {
            closest_rotation(k, M, Q);
        }
    }
}

/* Rows s k to s k + k of a matrix <- Q_gs times them. */
static void turn_rows(const double *Q, int32_t k, double *rows, int32_t columns)
{
    for (int32_t j = 0; j < columns; j++) {
        double old[3], *entry = rows + j;
        for (int32_t a = 0; a < k; a++) {
            old[a] = entry[(size_t)a * (size_t)columns];
        }
        for (int32_t a = 0; a < k; a++) {
            double sum = 0.0;
            for (int32_t c = 0; c < k; c++) {
                sum += Q[a * k + c] * old[c];
            }
            entry[(size_t)a * (size_t)columns] = sum;
        }
    }
}

static void transpose(double *A, int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j < i; j++) {
            double swap = A[i * n + j];
            A[i * n + j] = A[j * n + i];
            A[j * n + i] = swap;
        }
    }
}

/* K <- Q K and H <- Q H Q^T for the shapes of a group. */
static void turn_group(build *w, int32_t g)
{
    int32_t k = w->model->header.dimension, S = w->model->header.shapes, p = S * k;
    int32_t b = w->model->energy.unknowns;
    for (int32_t s = 0; s < S; s++) {
        const double *Q = w->model->align + (size_t)((g * S + s) * k * k);
        turn_rows(Q, k, w->group.K + (size_t)(s * k) * (size_t)b, b);
    }
    for (int side = 0; side < 2; side++) {
        for (int32_t s = 0; s < S; s++) {
            const double *Q = w->model->align + (size_t)((g * S + s) * k * k);
            turn_rows(Q, k, w->group.H + s * k * p, p);
        }
        transpose(w->group.H, p);
    }
}

/* Column of the joint dictionary that is column j of shape s alone. */
static int32_t joint_column(const model_header *header, int32_t s, int32_t j)
{
    int32_t k = header->dimension, block = 1 + header->shapes * k;
    int32_t within = j % (1 + k);
    return (j / (1 + k)) * block + (within == 0 ? 0 : s * k + within);
}

/* A group's part in the single-shape problems, from its part in the joint one. Rotations stand for
 * themselves there too, after the alignment. */
static void store_shape_groups(build *w, int32_t g)
{
    const model_header *header = &w->model->header;
    int32_t k = header->dimension, p = header->shapes * k, b = w->model->energy.unknowns;
    int32_t b_s = header->weights * (1 + k);
    for (int32_t s = 0; s < header->shapes; s++) {
        shape_model *shape = w->model->shape + s;
        double *L = shape->L + (size_t)g * (size_t)b_s * (size_t)b_s;
        for (int32_t i = 0; i < b_s; i++) {
            const double *row = w->group.L + (size_t)joint_column(header, s, i) * (size_t)b;
            for (int32_t j = 0; j < b_s; j++) {
                L[i * b_s + j] = row[joint_column(header, s, j)];
            }
        }
        int32_t turned = header->groups * k;
        for (int32_t i = 0; i < k * k; i++) {
            double value = w->group.H[(s * k + i / k) * p + s * k + i % k];
            shape->energy.C[(size_t)(g * k + i / k) * (size_t)turned + (size_t)(g * k + i % k)] =
                value;
        }
    }
}

static void store_joint_group(build *w, int32_t g)
{
    const model_header *header = &w->model->header;
    int32_t k = header->dimension, p = header->shapes * k;
    size_t b = (size_t)w->model->energy.unknowns, turned = (size_t)w->model->energy.turned;
    for (size_t i = 0; i < b * b; i++) {
        w->all_L[i] += w->group.L[i];
    }
    for (int32_t i = 0; i < p; i++) {
        memcpy(w->model->energy.C + (size_t)(g * p + i) * turned + (size_t)(g * p),
               w->group.H + i * p, (size_t)p * sizeof(double));
    }
    size_t block = (size_t)p * (size_t)p;
    memcpy(w->model->H + (size_t)g * block, w->group.H, block * sizeof(double));
    double sum = 0.0;
    for (int32_t c = 0; c < k; c++) {
        sum += w->group.H[c * p + c];
    }
    w->model->stiffness[g] = sum / k;
}

/* How much a row says about a group: inverse to their squared distance as the weights measure it,
 * floored so that no single row decides. */
static void find_nearness(build *w, int32_t g)
{
    const tug_rows *rows = w->given_rows;
    int32_t m = w->model->header.weights;
    size_t n = (size_t)w->model->header.vertices;
    find_group_weights(w->energies, g, w->group_weights);
    for (int32_t r = 0; r < rows->count; r++) {
        double distance = 0.0, scale = 0.0;
        for (int32_t h = 0; h < m; h++) {
            double value = 0.0;
            for (int32_t e = rows->starts[r]; e < rows->starts[r + 1]; e++) {
                value += rows->values[e] *
                         w->model->weight_columns[(size_t)h * n + (size_t)rows->vertices[e]];
            }
            double difference = value - w->group_weights[h];
            distance += difference * difference;
            scale += value * value;
        }
        w->model->nearness[g * rows->count + r] = 1.0 / (distance + 0.1 * scale + 1e-12);
    }
}

static tug_status find_group_constants(build *w, const progress_range *range)
{
    const model_header *header = &w->model->header;
    size_t block = (size_t)header->shapes * (size_t)header->dimension;
    for (int32_t g = 0; g < header->groups; g++) {
        tug_status status = report(range, "measuring edge groups", (double)g / header->groups);
        if (status != TUG_OK) {
            return status;
        }
        w->group.K = w->all_K + (size_t)g * block * (size_t)w->model->energy.unknowns;
        find_group_energy(w->energies, g, &w->group);
        align_group(w, g);
        turn_group(w, g);
        store_shape_groups(w, g);
        store_joint_group(w, g);
        find_nearness(w, g);
    }
    return TUG_OK;
}

/* Columns of shape s in (V, Y): the example itself, V_gs = Q_gs and Y its own rows. */
static void store_example(const tug_model *model, int32_t s, int32_t block, int32_t first,
                          double *N, int32_t columns, int32_t column)
{
    int32_t k = model->header.dimension, S = model->header.shapes, G = model->header.groups;
    for (int32_t g = 0; g < G; g++) {
        const double *Q = model->align + (g * S + s) * k * k;
        for (int32_t i = 0; i < k * k; i++) {
            int32_t row = g * block + first + i / k;
            N[(size_t)row * (size_t)columns + (size_t)(column + i % k)] = Q[i];
        }
    }
    for (int32_t i = 0; i < model->header.rows * k; i++) {
        size_t row = (size_t)(G * block + i / k);
        N[row * (size_t)columns + (size_t)(column + i % k)] = model->shape[s].rows[i];
    }
}

static void store_translation(const reduction *energy, double *N, int32_t columns)
{
    for (int32_t r = 0; r < energy->rows; r++) {
        N[(size_t)(energy->turned + r + 1) * (size_t)columns - 1] = 1.0;
    }
}

/* Shapes first to last of the joint energy, or one shape of its own. */
static tug_status restore_examples(const tug_model *model, reduction *energy, int32_t first,
                                   int32_t last)
{
    int32_t k = model->header.dimension, block = (last - first + 1) * k, columns = block + 1;
    double *N = allocate((size_t)(energy->turned + energy->rows) * (size_t)columns, sizeof *N);
    if (N == NULL) {
        return fail_memory();
    }
    for (int32_t s = first; s <= last; s++) {
        store_example(model, s, block, (s - first) * k, N, columns, (s - first) * k);
    }
    store_translation(energy, N, columns);
    tug_status status = restore_null_space(energy, N, columns);
    release(N);
    return status;
}

static tug_status eliminate_shape(build *w, int32_t s)
{
    const model_header *header = &w->model->header;
    int32_t k = header->dimension, G = header->groups, b_s = header->weights * (1 + k);
    size_t b = (size_t)w->model->energy.unknowns, size = (size_t)b_s * (size_t)b_s;
    shape_model *shape = w->model->shape + s;
    memset(w->shape_L, 0, size * sizeof(double));
    for (int32_t g = 0; g < G; g++) {
        for (size_t i = 0; i < size; i++) {
            w->shape_L[i] += shape->L[(size_t)g * size + i];
        }
    }
    for (int32_t j = 0; j < b_s; j++) {
        size_t column = (size_t)joint_column(header, s, j);
        for (int32_t i = 0; i < G * k; i++) {
            size_t row = (size_t)((i / k) * header->shapes * k + s * k + i % k);
            w->shape_K[i * b_s + j] = w->all_K[row * b + column];
        }
        for (int32_t r = 0; r < header->rows; r++) {
            w->shape_X[r * b_s + j] = w->X[(size_t)r * b + column];
        }
    }
    int32_t rank;
    tug_status status =
        eliminate_transforms(w->shape_L, w->shape_X, w->shape_K, &shape->energy, &rank);
    return status == TUG_OK ? restore_examples(w->model, &shape->energy, s, s) : status;
}

/* From rows (g, s, a) and columns (g', s', b) to #G by #G by k by k by #S by #S. */
static tug_status block_joint_matrix(tug_model *model)
{
    size_t S = (size_t)model->header.shapes, k = (size_t)model->header.dimension;
    size_t G = (size_t)model->header.groups, turned = (size_t)model->energy.turned;
    double *plain = allocate(turned * turned, sizeof *plain);
    if (plain == NULL) {
        return fail_memory();
    }
    memcpy(plain, model->energy.C, turned * turned * sizeof *plain);
    for (size_t i = 0; i < turned; i++) {
        size_t g = i / (S * k), s = i / k % S, a = i % k;
        for (size_t j = 0; j < turned; j++) {
            size_t other_g = j / (S * k), other_s = j / k % S, c = j % k;
            model->energy.C[(((g * G + other_g) * k * k + a * k + c) * S + s) * S + other_s] =
                plain[i * turned + j];
        }
    }
    release(plain);
    return TUG_OK;
}

static tug_status eliminate_all(build *w, const progress_range *range)
{
    tug_model *model = w->model;
    int32_t shapes = model->header.shapes;
    for (int32_t s = 0; s < shapes; s++) {
        tug_status status = report(range, "solving for transforms", 0.5 * s / shapes);
        if (status == TUG_OK) {
            status = eliminate_shape(w, s);
        }
        if (status != TUG_OK) {
            return status;
        }
    }
    tug_status status = report(range, "solving for transforms", 0.5);
    if (status == TUG_OK) {
        status =
            eliminate_transforms(w->all_L, w->X, w->all_K, &model->energy, &model->header.rank);
    }
    if (status == TUG_OK) {
        status = restore_examples(model, &model->energy, 0, shapes - 1);
    }
    return status == TUG_OK ? block_joint_matrix(model) : status;
}

static tug_status require_finite(const tug_model *model)
{
    for (size_t i = 0; i < model->data_count; i++) {
        if (!isfinite(model->data[i])) {
            return fail(TUG_ERROR_NUMERIC, "the model is not finite: look for coordinates or "
                                           "weights that are not numbers");
        }
    }
    return TUG_OK;
}

static tug_status build_model(build *w, const tug_mesh *mesh, const int32_t *groups,
                              const double *stiffness, const progress_range *range)
{
    tug_model *model = w->model;
    find_middles(&model->dictionary, mesh->mass, model->middles);
    tug_status status = energy_workspace_create(mesh, &model->dictionary, groups,
                                                model->header.groups, stiffness, &w->energies);
    if (status == TUG_OK) {
        status = find_constant(model);
    }
    if (status == TUG_OK) {
        find_rows(w);
        progress_range part = progress_part(range, 0.0, 0.8);
        status = find_group_constants(w, &part);
    }
    if (status == TUG_OK) {
        progress_range part = progress_part(range, 0.8, 1.0);
        status = eliminate_all(w, &part);
    }
    return status == TUG_OK ? require_finite(model) : status;
}

tug_status model_create(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                        const double *weights, int32_t weight_count, const tug_rows *rows,
                        const int32_t *groups, int32_t group_count, const double *stiffness,
                        const progress_range *range, tug_model **out)
{
    tug_status status = require_sound_mesh(mesh);
    if (status != TUG_OK) {
        return status;
    }
    use_one_blas_thread();
    model_header header = {
        .vertices = mesh->vertex_count,
        .dimension = mesh->dimension,
        .shapes = shape_count,
        .weights = weight_count,
        .rows = rows->count,
        .groups = group_count,
        .unit = bounding_diagonal(shapes, mesh->vertex_count, mesh->dimension),
    };
    if (!(header.unit > 0.0)) {
        return fail(TUG_ERROR_ARGUMENT,
                    "tug_create_model: all vertices of shape 0 are in one place");
    }
    build w = {.given_rows = rows};
    status = model_allocate(&header, &w.model);
    if (status != TUG_OK) {
        return status;
    }
    store_shape_columns(&w.model->dictionary, shapes, header.unit, w.model->shape_columns, NULL);
    store_weight_columns(&w.model->dictionary, weights, w.model->weight_columns);
    status = allocate_build(&w) ? build_model(&w, mesh, groups, stiffness, range) : fail_memory();
    free_build(&w);
    if (status != TUG_OK) {
        model_destroy(w.model);
        return status;
    }
    *out = w.model;
    return TUG_OK;
}
