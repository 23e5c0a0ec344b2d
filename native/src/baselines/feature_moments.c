/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "feature_moments.h"

#include "dense/dense.h"
#include "memory.h"

#include <string.h>

enum { BLOCK_ROWS = 128 };

int feature_moments_create(const tug_mesh *mesh, const dictionary *D, const int32_t *groups,
                           int32_t group_count, int32_t shapes, feature_moments *out)
{
    size_t k = (size_t)mesh->dimension, S = (size_t)shapes, G = (size_t)group_count;
    size_t n = (size_t)mesh->vertex_count, b = (size_t)dictionary_columns(D), rows = (1 + S) * k;
    *out = (feature_moments){.mesh = mesh, .D = D, .group_count = group_count};
    out->groups = allocate((size_t)mesh->triangle_count, sizeof *out->groups);
    out->K = allocate(G * k * b, sizeof *out->K);
    out->H = allocate(G * k * k, sizeof *out->H);
    out->dK = allocate(S * G * k * b, sizeof *out->dK);
    out->dH = allocate(S * G * k * k, sizeof *out->dH);
    out->gram = allocate(S * S, sizeof *out->gram);
    out->M = allocate(rows * k, sizeof *out->M);
    out->divergence = allocate(n * rows, sizeof *out->divergence);
    out->D_rows = allocate(BLOCK_ROWS * b, sizeof *out->D_rows);
    out->field_rows = allocate(BLOCK_ROWS * rows, sizeof *out->field_rows);
    out->product = allocate(rows * b, sizeof *out->product);
    out->seen = allocate(n, sizeof *out->seen);
    int room = features_create(mesh->dimension, mesh->triangle_count, shapes, &out->features);
    if (out->groups != NULL) {
        memcpy(out->groups, groups, (size_t)mesh->triangle_count * sizeof *groups);
    }
    return room && out->groups && out->K && out->H && out->dK && out->dH && out->gram && out->M &&
           out->divergence && out->D_rows && out->field_rows && out->product && out->seen;
}

void feature_moments_destroy(feature_moments *m)
{
    features_destroy(&m->features);
    release(m->groups);
    release(m->K);
    release(m->H);
    release(m->dK);
    release(m->dH);
    release(m->gram);
    release(m->M);
    release(m->divergence);
    release(m->D_rows);
    release(m->field_rows);
    release(m->product);
    release(m->seen);
}

/* An edge of the rest shape as every field has it: fields by k. */
static void find_edges(const feature_moments *m, int32_t fields, int32_t a, int32_t b,
                       double *edges)
{
    int32_t k = m->mesh->dimension;
    const double *p = m->mesh->vertices;
    for (int32_t i = 0; i < fields * k; i++) {
        edges[i] = 0.0;
        for (int32_t c = 0; c < k; c++) {
            edges[i] += m->M[i * k + c] * (p[b * k + c] - p[a * k + c]);
        }
    }
}

/* H, dH and the gram matrix of one edge. */
static void add_squares(feature_moments *m, int32_t group, int32_t fields, double weight,
                        const double *edges)
{
    int32_t k = m->mesh->dimension, kk = k * k, S = fields - 1;
    for (int32_t i = 0; i < kk; i++) {
        double scaled = weight * edges[i / k];
        m->H[group * kk + i] += scaled * edges[i % k];
        for (int32_t s = 0; s < S; s++) {
            const double *moved = edges + (1 + s) * k;
            m->dH[(s * m->group_count + group) * kk + i] +=
                scaled * moved[i % k] + weight * moved[i / k] * edges[i % k];
        }
    }
    for (int32_t i = 0; i < S * S; i++) {
        m->gram[i] += weight * dot(edges + (1 + i / S) * k, edges + (1 + i % S) * k, (size_t)k);
    }
}

/* One triangle into H, dH, the gram matrix and the fields' divergence. */
static void add_triangle(feature_moments *m, int32_t t, const double *w, int32_t fields)
{
    int32_t k = m->mesh->dimension, rows = fields * k;
    const int32_t *corners = m->mesh->triangles + 3 * t;
    double *edges = m->field_rows; /* free until the rows are gathered */
    blend_features(&m->features, t, w, m->M);
    if (fields > 1) {
        differentiate_features(&m->features, t, w, m->M + k * k);
    }
    for (int32_t c = 0; c < 3; c++) {
        int32_t a = corners[(c + 1) % 3], b = corners[(c + 2) % 3];
        double weight = m->mesh->half_cotangent[3 * t + c];
        find_edges(m, fields, a, b, edges);
        add_squares(m, m->groups[t], fields, weight, edges);
        double *at_a = m->divergence + (size_t)a * (size_t)rows;
        double *at_b = m->divergence + (size_t)b * (size_t)rows;
        for (int32_t i = 0; i < rows; i++) {
            at_a[i] -= weight * edges[i];
            at_b[i] += weight * edges[i];
        }
    }
}

/* product += divergence^T D over the rows gathered so far. */
static void flush_rows(feature_moments *m, int32_t rows, int32_t *gathered)
{
    int32_t b = dictionary_columns(m->D);
    add_product_tn(rows, b, *gathered, 1.0, m->field_rows, rows, m->D_rows, b, m->product, b);
    *gathered = 0;
}

/* A vertex' row of the divergence, which is zero again afterwards, and of the dictionary. */
static void gather_row(feature_moments *m, int32_t v, int32_t rows, int32_t at)
{
    size_t b = (size_t)dictionary_columns(m->D), size = (size_t)rows;
    double *from = m->divergence + (size_t)v * size, *row = m->D_rows + (size_t)at * b;
    memcpy(m->field_rows + (size_t)at * size, from, size * sizeof *from);
    memset(from, 0, size * sizeof *from);
    memset(row, 0, b * sizeof *row);
    add_dictionary_row(m->D, v, 1.0, row);
}

static void contract_group(feature_moments *m, int32_t group, int32_t rows)
{
    int32_t gathered = 0;
    memset(m->product, 0, (size_t)rows * (size_t)dictionary_columns(m->D) * sizeof *m->product);
    for (int32_t i = 0; i < 3 * m->mesh->triangle_count; i++) {
        int32_t v = m->mesh->triangles[i];
        if (m->groups[i / 3] == group && m->seen[v] != group + 1) {
            m->seen[v] = group + 1;
            gather_row(m, v, rows, gathered++);
        }
        if (gathered == BLOCK_ROWS) {
            flush_rows(m, rows, &gathered);
        }
    }
    flush_rows(m, rows, &gathered);
}

static void store_group(feature_moments *m, int32_t group, int32_t fields)
{
    size_t size = (size_t)m->mesh->dimension * (size_t)dictionary_columns(m->D);
    size_t G = (size_t)m->group_count, g = (size_t)group;
    memcpy(m->K + g * size, m->product, size * sizeof *m->K);
    for (size_t s = 0; s + 1 < (size_t)fields; s++) {
        memcpy(m->dK + (s * G + g) * size, m->product + (1 + s) * size, size * sizeof *m->K);
    }
}

void find_feature_moments(feature_moments *m, const double *w, int derivatives)
{
    int32_t k = m->mesh->dimension, S = m->features.shapes, fields = derivatives ? 1 + S : 1;
    size_t size = (size_t)(m->group_count * k * k);
    memset(m->seen, 0, (size_t)m->mesh->vertex_count * sizeof *m->seen);
    memset(m->H, 0, size * sizeof *m->H);
    if (derivatives) {
        memset(m->dH, 0, (size_t)S * size * sizeof *m->dH);
        memset(m->gram, 0, (size_t)(S * S) * sizeof *m->gram);
    }
    for (int32_t g = 0; g < m->group_count; g++) {
        for (int32_t t = 0; t < m->mesh->triangle_count; t++) {
            if (m->groups[t] == g) {
                add_triangle(m, t, w, fields);
            }
        }
        contract_group(m, g, fields * k);
        store_group(m, g, fields);
    }
}
