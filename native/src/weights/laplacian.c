/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "weights/laplacian.h"

#include "memory.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

/* Room for every entry before those of the same place are added up: a row gets its diagonal and two
 * entries of each triangle around the vertex. */
static void count_entries(const tug_mesh *mesh, int32_t *starts)
{
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        starts[v + 1] = 1;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        starts[mesh->triangles[i] + 1] += 2;
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        starts[v + 1] += starts[v];
    }
}

static void put_entry(laplacian *L, int32_t *end, int32_t row, int32_t column, double weight)
{
    int32_t k = end[row]++;
    L->columns[k] = column;
    L->values[k] = -weight;
    L->values[L->starts[row]] += weight;
}

static double scale_of(const double *half_cotangent, double steepest)
{
    double largest = steepest;
    for (int c = 0; c < 3; c++) {
        largest = fmax(largest, fabs(half_cotangent[c]));
    }
    return steepest / largest;
}

static void put_entries(const tug_mesh *mesh, double steepest, laplacian *L, int32_t *end)
{
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        L->columns[L->starts[v]] = v;
        end[v] = L->starts[v] + 1;
    }
    for (size_t t = 0; t < (size_t)mesh->triangle_count; t++) {
        const int32_t *corner = mesh->triangles + 3 * t;
        double scale = scale_of(mesh->half_cotangent + 3 * t, steepest);
        for (size_t c = 0; c < 3; c++) {
            int32_t a = corner[(c + 1) % 3], b = corner[(c + 2) % 3];
            double weight = scale * mesh->half_cotangent[3 * t + c];
            put_entry(L, end, a, b, weight);
            put_entry(L, end, b, a, weight);
        }
    }
}

/* Add up the entries of the same place. place: for each column the last entry made of it. */
static void merge_entries(laplacian *L, int32_t *place)
{
    int32_t kept = 0;
    memset(place, -1, (size_t)L->size * sizeof *place);
    for (int32_t row = 0; row < L->size; row++) {
        int32_t first = kept, from = L->starts[row];
        L->starts[row] = first;
        for (int32_t k = from; k < L->starts[row + 1]; k++) {
            int32_t column = L->columns[k];
            if (place[column] >= first) {
                L->values[place[column]] += L->values[k];
            } else {
                place[column] = kept;
                L->columns[kept] = column;
                L->values[kept++] = L->values[k];
            }
        }
    }
    L->starts[L->size] = kept;
}

static tug_status fill_laplacian(const tug_mesh *mesh, double steepest, laplacian *L)
{
    size_t size = (size_t)mesh->vertex_count;
    size_t entries = size + 6 * (size_t)mesh->triangle_count;
    L->size = mesh->vertex_count;
    L->starts = allocate(size + 1, sizeof(int32_t));
    L->columns = allocate(entries, sizeof(int32_t));
    L->values = allocate(entries, sizeof(double));
    L->mass = allocate(size, sizeof(double));
    int32_t *work = allocate(size, sizeof(int32_t));
    if (!L->starts || !L->columns || !L->values || !L->mass || !work) {
        release(work);
        return fail_memory();
    }
    count_entries(mesh, L->starts);
    put_entries(mesh, steepest, L, work);
    merge_entries(L, work);
    release(work);
    double area = 0.0;
    for (size_t v = 0; v < size; v++) {
        area += mesh->mass[v];
    }
    for (size_t v = 0; v < size; v++) {
        L->mass[v] = mesh->mass[v] / area;
    }
    return TUG_OK;
}

tug_status laplacian_create(const tug_mesh *mesh, double steepest, laplacian *out)
{
    memset(out, 0, sizeof *out);
    if (mesh->triangle_count > (INT32_MAX - mesh->vertex_count) / 6) {
        return fail(TUG_ERROR_ARGUMENT, "%d triangles are too many for weights",
                    mesh->triangle_count);
    }
    tug_status status = fill_laplacian(mesh, steepest, out);
    if (status != TUG_OK) {
        laplacian_free(out);
    }
    return status;
}

void laplacian_free(laplacian *L)
{
    release(L->starts);
    release(L->columns);
    release(L->values);
    release(L->mass);
    memset(L, 0, sizeof *L);
}

void laplacian_apply(const laplacian *L, const double *u, double *y)
{
    for (int32_t row = 0; row < L->size; row++) {
        double sum = 0.0;
        for (int32_t k = L->starts[row]; k < L->starts[row + 1]; k++) {
            sum += L->values[k] * u[L->columns[k]];
        }
        y[row] = sum;
    }
}

double laplacian_bend(const laplacian *L, const double *w, double *u)
{
    double energy = 0.0;
    laplacian_apply(L, w, u);
    for (int32_t v = 0; v < L->size; v++) {
        double strain = u[v];
        u[v] = strain / L->mass[v];
        energy += strain * u[v];
    }
    return 0.5 * energy;
}

tug_status shifted_laplacian(const laplacian *L, double shift, sparse_matrix *out)
{
    size_t size = (size_t)L->size, entries = ((size_t)L->starts[L->size] + size) / 2;
    *out = (sparse_matrix){.size = L->size,
                           .starts = allocate(size + 1, sizeof(int32_t)),
                           .rows = allocate(entries, sizeof(int32_t)),
                           .values = allocate(entries, sizeof(double))};
    if (out->starts == NULL || out->rows == NULL || out->values == NULL) {
        sparse_matrix_free(out);
        return fail_memory();
    }
    int32_t end = 0;
    for (int32_t column = 0; column < L->size; column++) {
        for (int32_t k = L->starts[column]; k < L->starts[column + 1]; k++) {
            int32_t row = L->columns[k];
            if (row >= column) {
                out->rows[end] = row;
                out->values[end++] = L->values[k] + (row == column ? shift * L->mass[row] : 0.0);
            }
        }
        out->starts[column + 1] = end;
    }
    return TUG_OK;
}

/* Column `column` of Q, without what lies above the diagonal: values at rows, and their number.
 * Where rows is NULL, only the number. place: for each row the last entry made of it. */
static int32_t bilaplacian_column(const laplacian *L, const int32_t *vertices,
                                  const int32_t *row_of, int32_t column, int32_t first,
                                  int32_t *place, int32_t *rows, double *values)
{
    int32_t vertex = vertices[column], end = first;
    for (int32_t a = L->starts[vertex]; a < L->starts[vertex + 1]; a++) {
        int32_t between = L->columns[a];
        double factor = L->values[a] / L->mass[between];
        for (int32_t b = L->starts[between]; b < L->starts[between + 1]; b++) {
            int32_t row = row_of[L->columns[b]];
            if (row < column) {
                continue;
            }
            if (place[row] < first) {
                place[row] = end++;
                if (rows != NULL) {
                    rows[place[row]] = row;
                }
            }
            if (values != NULL) {
                values[place[row]] += factor * L->values[b];
            }
        }
    }
    return end;
}

tug_status bilaplacian_part(const laplacian *L, const int32_t *vertices, int32_t count,
                            const int32_t *row_of, sparse_matrix *out)
{
    memset(out, 0, sizeof *out);
    size_t size = (size_t)count;
    int32_t *place = allocate(size, sizeof *place);
    out->size = count;
    out->starts = allocate(size + 1, sizeof(int32_t));
    if (place != NULL && out->starts != NULL) {
        memset(place, -1, size * sizeof *place);
        for (int32_t c = 0; c < count; c++) {
            out->starts[c + 1] =
                bilaplacian_column(L, vertices, row_of, c, out->starts[c], place, NULL, NULL);
        }
        out->rows = allocate((size_t)out->starts[count], sizeof(int32_t));
        out->values = allocate((size_t)out->starts[count], sizeof(double));
    }
    if (out->rows == NULL || out->values == NULL) {
        release(place);
        sparse_matrix_free(out);
        return fail_memory();
    }
    memset(place, -1, size * sizeof *place);
    for (int32_t c = 0; c < count; c++) {
        bilaplacian_column(L, vertices, row_of, c, out->starts[c], place, out->rows, out->values);
    }
    release(place);
    return TUG_OK;
}
