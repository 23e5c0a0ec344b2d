/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What every edge group adds to a model. */
#include "model/model_build.h"

#include "dense/rotation.h"
#include "memory.h"
#include "model/energy.h"

#include <string.h>

typedef struct group_build {
    tug_model *model;
    energy_workspace *energies;
    group_energy group; /* of the group at hand; K is the model's own */
} group_build;

/* Q_gs: the rotation that best carries group g of shape s onto group g of the rest shape. */
static void align_group(group_build *w, int32_t g)
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
static void turn_group(group_build *w, int32_t g)
{
    int32_t k = w->model->header.dimension, S = w->model->header.shapes, p = S * k;
    int32_t b = group_columns(&w->model->energy, g);
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

/* A group's part in the single-shape problems, from its part in the joint one. Rotations stand for
 * themselves there too, after the alignment. */
static void store_shape_group(group_build *w, int32_t g, int32_t s)
{
    const model_header *header = &w->model->header;
    shape_model *shape = w->model->shape + s;
    int32_t k = header->dimension, columns = group_columns(&shape->energy, g);
    size_t joint = (size_t)group_columns(&w->model->energy, g);
    double *L = group_form(w->model, shape, g), *K = group_rows_of_K(&shape->energy, g);
    for (int32_t i = 0; i < columns; i++) {
        const double *row = w->group.L + (size_t)joint_column(header, s, i) * joint;
        for (int32_t j = 0; j < columns; j++) {
            *L++ = row[joint_column(header, s, j)];
        }
    }
    for (int32_t i = 0; i < k; i++) {
        const double *row = w->group.K + (size_t)(s * k + i) * joint;
        for (int32_t j = 0; j < columns; j++) {
            *K++ = row[joint_column(header, s, j)];
        }
    }
}

/* Add a group's form to the lower triangle of the whole. */
static void add_group_form(const tug_model *model, int32_t g, const double *form, double *L)
{
    size_t b = (size_t)model->energy.unknowns, columns = (size_t)group_columns(&model->energy, g);
    size_t block = (size_t)model->energy.block;
    const int32_t *functions = support_of(&model->support, g);
    for (size_t i = 0; i < columns; i++) {
        double *row = L + ((size_t)functions[i / block] * block + i % block) * b;
        for (size_t j = 0; j <= i; j++) {
            row[(size_t)functions[j / block] * block + j % block] += form[i * columns + j];
        }
    }
}

static void store_joint_group(group_build *w, int32_t g)
{
    tug_model *model = w->model;
    int32_t k = model->header.dimension, p = model->header.shapes * k;
    size_t block = (size_t)p * (size_t)p;
    memcpy(model->H + (size_t)g * block, w->group.H, block * sizeof(double));
    double sum = 0.0;
    for (int32_t c = 0; c < k; c++) {
        sum += w->group.H[c * p + c];
    }
    model->stiffness[g] = sum / k;
}

static int allocate_groups(group_build *w)
{
    size_t p = (size_t)w->model->energy.group_rows, most = 0;
    for (int32_t g = 0; g < w->model->header.groups; g++) {
        size_t columns = (size_t)group_columns(&w->model->energy, g);
        most = columns > most ? columns : most;
    }
    w->group.L = allocate(most * most, sizeof(double));
    w->group.H = allocate(p * p, sizeof(double));
    return w->group.L && w->group.H;
}

static tug_status find_all(group_build *w, const progress_range *range, double *L)
{
    tug_model *model = w->model;
    int32_t groups = model->header.groups;
    for (int32_t g = 0; g < groups; g++) {
        tug_status status = report(range, "measuring edge groups", (double)g / groups);
        if (status != TUG_OK) {
            return status;
        }
        w->group.K = group_rows_of_K(&model->energy, g);
        find_group_energy(w->energies, g, support_of(&model->support, g),
                          support_count(&model->support, g), &w->group);
        align_group(w, g);
        turn_group(w, g);
        for (int32_t s = 0; s < model->header.shapes; s++) {
            store_shape_group(w, g, s);
        }
        store_joint_group(w, g);
        add_group_form(model, g, w->group.L, L);
        find_group_weights(w->energies, g, model->group_weights + g * model->header.weights);
    }
    return TUG_OK;
}

tug_status find_group_constants(tug_model *model, const tug_mesh *mesh, const int32_t *groups,
                                const double *stiffness, const progress_range *range, double *L)
{
    group_build w = {.model = model};
    tug_status status = allocate_groups(&w) ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        status = energy_workspace_create(mesh, &model->dictionary, groups, model->header.groups,
                                         stiffness, &w.energies);
    }
    if (status == TUG_OK) {
        status = find_all(&w, range, L);
    }
    energy_workspace_destroy(w.energies);
    release(w.group.L);
    release(w.group.H);
    return status;
}
