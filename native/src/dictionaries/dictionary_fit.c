/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Normal equations with the columns scaled to length one, as far as they are independent; what
 * their rounding leaves is taken out by fitting the rest once more. */
#include "dictionaries/dictionary_fit.h"

#include "dense/dense.h"
#include "dictionaries/dictionary_gram.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { passes = 3 };

/* Columns whose squared distance from the span of the others is relatively below this are left
 * out. */
static const double rank_tolerance = 1e-12;

typedef struct dictionary_fit {
    own_dictionary own;
    int32_t atoms, rank;
    int32_t *atom;    /* their columns */
    double *gram;     /* b by b */
    double *G;        /* atoms by atoms: D^T D of them, scaled; then its factor */
    double *scale;    /* atoms */
    int32_t *pivots;  /* atoms */
    double *work;     /* 2 atoms */
    double *right;    /* k by rank */
    double *T, *step; /* b by k: so far, and what is to be added */
    double *sums;     /* b by k: D^T of what is left */
    double *left;     /* #V by k: positions less D T, units of the diagonal */
} dictionary_fit;

static void free_fit(dictionary_fit *f)
{
    own_dictionary_free(&f->own);
    release(f->atom);
    release(f->gram);
    release(f->G);
    release(f->scale);
    release(f->pivots);
    release(f->work);
    release(f->right);
    release(f->step);
    release(f->T);
    release(f->sums);
    release(f->left);
}

static int allocate_fit(dictionary_fit *f)
{
    const dictionary *D = &f->own.D;
    size_t b = (size_t)dictionary_columns(D), a = (size_t)f->atoms, k = (size_t)D->dimension;
    f->atom = allocate(a, sizeof(int32_t));
    f->gram = allocate(b * b, sizeof(double));
    f->G = allocate(a * a, sizeof(double));
    f->scale = allocate(a, sizeof(double));
    f->pivots = allocate(a, sizeof(int32_t));
    f->work = allocate(2 * a, sizeof(double));
    f->right = allocate(k * a, sizeof(double));
    f->step = allocate(b * k, sizeof(double));
    f->T = allocate(b * k, sizeof(double));
    f->sums = allocate(b * k, sizeof(double));
    f->left = allocate((size_t)D->vertices * k, sizeof(double));
    return f->atom && f->gram && f->G && f->scale && f->pivots && f->work && f->right && f->step &&
           f->T && f->sums && f->left;
}

static void factorise(dictionary_fit *f)
{
    size_t b = (size_t)dictionary_columns(&f->own.D), atoms = (size_t)f->atoms;
    for (size_t i = 0; i < atoms; i++) {
        double square = f->gram[(size_t)f->atom[i] * (b + 1)];
        f->scale[i] = square > 0.0 ? 1.0 / sqrt(square) : 0.0;
    }
    for (size_t i = 0; i < atoms; i++) {
        const double *row = f->gram + (size_t)f->atom[i] * b;
        for (size_t j = 0; j < atoms; j++) {
            f->G[i * atoms + j] = f->scale[i] * f->scale[j] * row[f->atom[j]];
        }
    }
    f->rank = pivoted_cholesky(f->G, f->atoms, rank_tolerance, f->pivots, f->work);
}

/* left -= D step, and then sums += D^T left, of some vertices. */
static void fit_rows(void *context, int32_t first, int32_t count, const double *rows)
{
    dictionary_fit *f = context;
    int32_t b = dictionary_columns(&f->own.D), k = f->own.D.dimension;
    double *left = f->left + (size_t)first * (size_t)k;
    add_product(count, k, b, -1.0, rows, b, f->step, k, left, k);
    add_product_tn(b, k, count, 1.0, rows, b, left, k, f->sums, k);
}

/* The step that fits what is left, from D^T left. */
static void find_step(dictionary_fit *f)
{
    int32_t k = f->own.D.dimension, rank = f->rank;
    size_t entries = (size_t)(dictionary_columns(&f->own.D) * k);
    for (int32_t i = 0; i < rank * k; i++) {
        int32_t axis = i / rank, atom = f->pivots[i % rank];
        f->right[i] = f->scale[atom] * f->sums[f->atom[atom] * k + axis];
    }
    if (rank > 0) {
        solve_right_upper(f->right, k, rank, f->G, rank, f->atoms);
        solve_right_upper_transposed(f->right, k, rank, f->G, rank, f->atoms);
    }
    memset(f->step, 0, entries * sizeof(double));
    for (int32_t i = 0; i < rank * k; i++) {
        int32_t axis = i / rank, atom = f->pivots[i % rank];
        f->step[f->atom[atom] * k + axis] = f->scale[atom] * f->right[i];
    }
    for (size_t i = 0; i < entries; i++) {
        f->T[i] += f->step[i];
    }
}

static tug_status run_passes(dictionary_fit *f, const progress_range *range)
{
    size_t entries = (size_t)(dictionary_columns(&f->own.D) * f->own.D.dimension);
    for (int pass = 0; pass <= passes; pass++) {
        progress_range part =
            progress_part(range, pass / (passes + 1.0), (pass + 1) / (passes + 1.0));
        memset(f->sums, 0, entries * sizeof(double));
        tug_status status = visit_rows(&f->own.D, fit_rows, f, &part, "fitting the dictionary");
        if (status != TUG_OK) {
            return status;
        }
        if (pass < passes) { /* the last only brings `left` up to date */
            find_step(f);
        }
    }
    return TUG_OK;
}

/* From coordinates about the weights' middles of each shape, in units of the diagonal, to plain
 * ones. */
static void hand_over_transforms(const dictionary_fit *f, double *transforms)
{
    const dictionary *D = &f->own.D;
    int32_t k = D->dimension, coordinates = D->shapes * k, block = block_columns(D);
    memcpy(transforms, f->T, (size_t)(dictionary_columns(D) * k) * sizeof *transforms);
    for (int32_t h = 0; h < D->weights; h++) {
        double *T = transforms + h * block * k;
        for (int32_t axis = 0; axis < k; axis++) {
            T[axis] *= f->own.unit;
            for (int32_t c = 0; c < coordinates; c++) {
                double middle = f->own.means[c] + f->own.unit * D->middles[h * coordinates + c];
                T[axis] -= middle * T[(1 + c) * k + axis];
            }
        }
    }
}

static tug_status fit(dictionary_fit *f, const progress_range *range)
{
    progress_range first = progress_part(range, 0.0, 0.7), second = progress_part(range, 0.7, 1.0);
    tug_status status = find_gram(&f->own.D, &first, f->gram);
    if (status != TUG_OK) {
        return status;
    }
    factorise(f);
    return run_passes(f, &second);
}

tug_status fit_dictionary(const tug_dictionary *given, const int32_t *atoms, int32_t atom_count,
                          const double *positions, const progress_range *range, double *transforms,
                          double *fitted)
{
    dictionary_fit f = {0};
    tug_status status = own_dictionary_create(given, &f.own);
    f.atoms = atoms != NULL ? atom_count : dictionary_columns(&f.own.D);
    if (status == TUG_OK && !allocate_fit(&f)) {
        status = fail_memory();
    }
    for (int32_t i = 0; i < f.atoms && status == TUG_OK; i++) {
        f.atom[i] = atoms != NULL ? atoms[i] : i;
    }
    size_t entries = (size_t)given->vertex_count * (size_t)given->dimension;
    for (size_t i = 0; i < entries && status == TUG_OK; i++) {
        f.left[i] = positions[i] / f.own.unit;
    }
    if (status == TUG_OK) {
        status = fit(&f, range);
    }
    if (status == TUG_OK && transforms != NULL) {
        hand_over_transforms(&f, transforms);
    }
    for (size_t i = 0; i < entries && status == TUG_OK && fitted != NULL; i++) {
        fitted[i] = positions[i] - f.own.unit * f.left[i];
    }
    free_fit(&f);
    return status;
}
