/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/energy.h"

#include "dense/dense.h"
#include "memory.h"

#include <string.h>

enum { BLOCK_ROWS = 256 }; /* of L_g D held at a time: enough for full speed of the product */

struct energy_workspace {
    const tug_mesh *mesh;
    const dictionary *D;
    const double *stiffness;  /* #F or NULL */
    int32_t *group_starts;    /* #G + 1 into group_triangles */
    int32_t *group_triangles; /* #F */
    int32_t *local;           /* #V: number of the vertex in the present group, or -1 */
    int32_t *vertices;        /* of the present group; 3 #F at most, #V in fact */
    int32_t *corner_starts;   /* local vertices + 1 */
    int32_t *corners;         /* 3 #F: 3 t + c of the present group, by local vertex */
    const int32_t *functions; /* the present group's weight functions, `columns` in all */
    int32_t function_count, columns;
    double *D_rows, *LD_rows; /* BLOCK_ROWS by columns */
    double *P_rows, *LP_rows; /* BLOCK_ROWS by p */
};

void energy_workspace_destroy(energy_workspace *workspace)
{
    if (workspace == NULL) {
        return;
    }
    release(workspace->group_starts);
    release(workspace->group_triangles);
    release(workspace->local);
    release(workspace->vertices);
    release(workspace->corner_starts);
    release(workspace->corners);
    release(workspace->D_rows);
    release(workspace->LD_rows);
    release(workspace->P_rows);
    release(workspace->LP_rows);
    release(workspace);
}

static int allocate_workspace(energy_workspace *w, int32_t group_count)
{
    size_t n = (size_t)w->mesh->vertex_count, f = (size_t)w->mesh->triangle_count;
    size_t b = (size_t)dictionary_columns(w->D), p = (size_t)(block_columns(w->D) - 1);
    w->group_starts = allocate((size_t)group_count + 1, sizeof *w->group_starts);
    w->group_triangles = allocate(f, sizeof *w->group_triangles);
    w->local = allocate(n, sizeof *w->local);
    w->vertices = allocate(n, sizeof *w->vertices);
    w->corner_starts = allocate(n + 1, sizeof *w->corner_starts);
    w->corners = allocate(3 * f, sizeof *w->corners);
    w->D_rows = allocate(BLOCK_ROWS * b, sizeof *w->D_rows);
    w->LD_rows = allocate(BLOCK_ROWS * b, sizeof *w->LD_rows);
    w->P_rows = allocate(BLOCK_ROWS * p, sizeof *w->P_rows);
    w->LP_rows = allocate(BLOCK_ROWS * p, sizeof *w->LP_rows);
    return w->group_starts && w->group_triangles && w->local && w->vertices && w->corner_starts &&
           w->corners && w->D_rows && w->LD_rows && w->P_rows && w->LP_rows;
}

static void sort_triangles(energy_workspace *w, const int32_t *groups, int32_t group_count)
{
    for (int32_t t = 0; t < w->mesh->triangle_count; t++) {
        w->group_starts[groups[t] + 1]++;
    }
    for (int32_t g = 0; g < group_count; g++) {
        w->group_starts[g + 1] += w->group_starts[g];
    }
    for (int32_t t = w->mesh->triangle_count - 1; t >= 0; t--) {
        w->group_triangles[--w->group_starts[groups[t] + 1]] = t;
    }
    /* Filling from the back moved every start one place ahead. */
    memmove(w->group_starts, w->group_starts + 1, (size_t)group_count * sizeof *w->group_starts);
    w->group_starts[group_count] = w->mesh->triangle_count;
}

tug_status energy_workspace_create(const tug_mesh *mesh, const dictionary *D, const int32_t *groups,
                                   int32_t group_count, const double *stiffness,
                                   energy_workspace **out)
{
    energy_workspace *w = allocate(1, sizeof *w);
    if (w == NULL) {
        return fail_memory();
    }
    w->mesh = mesh;
    w->D = D;
    w->stiffness = stiffness;
    if (!allocate_workspace(w, group_count)) {
        energy_workspace_destroy(w);
        return fail_memory();
    }
    sort_triangles(w, groups, group_count);
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        w->local[v] = -1;
    }
    *out = w;
    return TUG_OK;
}

/* Number the group's vertices and list the corners around each. */
static int32_t gather_group(energy_workspace *w, int32_t group)
{
    int32_t first = w->group_starts[group], last = w->group_starts[group + 1], count = 0;
    for (int32_t i = 3 * first; i < 3 * last; i++) {
        int32_t v = w->mesh->triangles[3 * w->group_triangles[i / 3] + i % 3];
        if (w->local[v] < 0) {
            w->corner_starts[count] = 0;
            w->vertices[count] = v;
            w->local[v] = count++;
        }
        w->corner_starts[w->local[v]]++;
    }
    int32_t end = 0;
    for (int32_t i = 0; i < count; i++) {
        end += w->corner_starts[i];
        w->corner_starts[i] = end;
    }
    w->corner_starts[count] = end;
    for (int32_t i = 3 * last - 1; i >= 3 * first; i--) {
        int32_t corner = 3 * w->group_triangles[i / 3] + i % 3;
        w->corners[--w->corner_starts[w->local[w->mesh->triangles[corner]]]] = corner;
    }
    for (int32_t i = 0; i < count; i++) {
        w->local[w->vertices[i]] = -1;
    }
    return count;
}

static void add_shape_row(const dictionary *D, int32_t vertex, double factor, double *row)
{
    int32_t p = block_columns(D) - 1;
    for (int32_t c = 0; c < p; c++) {
        row[c] += factor * D->shape_columns[(size_t)c * (size_t)D->vertices + (size_t)vertex];
    }
}

/* Row i of D, P, L_g D and L_g P: L_g sums, for the two edges of each corner, weight times the
 * difference along the edge. */
static void make_rows(energy_workspace *w, int32_t i, int32_t row)
{
    size_t b = (size_t)w->columns, p = (size_t)(block_columns(w->D) - 1);
    double *LD = w->LD_rows + (size_t)row * b, *LP = w->LP_rows + (size_t)row * p;
    double own = 0.0;
    for (int32_t e = w->corner_starts[i]; e < w->corner_starts[i + 1]; e++) {
        int32_t t = w->corners[e] / 3, c = w->corners[e] % 3;
        double stiffness = w->stiffness != NULL ? w->stiffness[t] : 1.0;
        for (int32_t step = 1; step <= 2; step++) {
            int32_t other = w->mesh->triangles[3 * t + (c + step) % 3];
            double weight = stiffness * w->mesh->half_cotangent[3 * t + (c + 3 - step) % 3];
            add_partial_row(w->D, w->functions, w->function_count, other, -weight, LD);
            add_shape_row(w->D, other, -weight, LP);
            own += weight;
        }
    }
    int32_t v = w->vertices[i];
    add_partial_row(w->D, w->functions, w->function_count, v, own, LD);
    add_shape_row(w->D, v, own, LP);
    add_partial_row(w->D, w->functions, w->function_count, v, 1.0, w->D_rows + (size_t)row * b);
    add_shape_row(w->D, v, 1.0, w->P_rows + (size_t)row * p);
}

static void clear_rows(energy_workspace *w)
{
    size_t b = (size_t)w->columns, p = (size_t)(block_columns(w->D) - 1);
    memset(w->D_rows, 0, BLOCK_ROWS * b * sizeof *w->D_rows);
    memset(w->LD_rows, 0, BLOCK_ROWS * b * sizeof *w->LD_rows);
    memset(w->P_rows, 0, BLOCK_ROWS * p * sizeof *w->P_rows);
    memset(w->LP_rows, 0, BLOCK_ROWS * p * sizeof *w->LP_rows);
}

void find_group_energy(energy_workspace *w, int32_t group, const int32_t *functions,
                       int32_t function_count, group_energy *energy)
{
    int32_t b = function_count * block_columns(w->D), p = block_columns(w->D) - 1;
    w->functions = functions;
    w->function_count = function_count;
    w->columns = b;
    memset(energy->L, 0, (size_t)b * (size_t)b * sizeof *energy->L);
    memset(energy->K, 0, (size_t)p * (size_t)b * sizeof *energy->K);
    memset(energy->H, 0, (size_t)p * (size_t)p * sizeof *energy->H);
    int32_t count = gather_group(w, group);
    for (int32_t start = 0; start < count; start += BLOCK_ROWS) {
        int32_t rows = count - start < BLOCK_ROWS ? count - start : BLOCK_ROWS;
        clear_rows(w);
        for (int32_t row = 0; row < rows; row++) {
            make_rows(w, start + row, row);
        }
        add_product_tn(b, b, rows, 1.0, w->D_rows, b, w->LD_rows, b, energy->L, b);
        add_product_tn(p, b, rows, 1.0, w->P_rows, p, w->LD_rows, b, energy->K, b);
        add_product_tn(p, p, rows, 1.0, w->P_rows, p, w->LP_rows, p, energy->H, p);
    }
}

double find_group_weights(const energy_workspace *w, int32_t group, double *middle)
{
    size_t n = (size_t)w->mesh->vertex_count;
    double area = 0.0;
    memset(middle, 0, (size_t)w->D->weights * sizeof *middle);
    for (int32_t i = w->group_starts[group]; i < w->group_starts[group + 1]; i++) {
        int32_t t = w->group_triangles[i];
        area += w->mesh->area[t];
        for (int32_t h = 0; h < w->D->weights; h++) {
            const double *W = w->D->weight_columns + (size_t)h * n;
            const int32_t *corner = w->mesh->triangles + 3 * t;
            middle[h] += w->mesh->area[t] * (W[corner[0]] + W[corner[1]] + W[corner[2]]) / 3.0;
        }
    }
    for (int32_t h = 0; h < w->D->weights; h++) {
        middle[h] /= area;
    }
    return area;
}
