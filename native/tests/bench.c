/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

#include "dense/rotation.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const int32_t FORMS[] = {TUG_FORM_STEADY, TUG_FORM_PAPER, TUG_FORM_TRUST_REGION, TUG_FORM_MINIMAL,
                         TUG_FORM_NO_ROTATIONS};

void make_numbered(fixture *f, int i)
{
    if (i == 0) {
        make_strip(f);
    } else {
        make_tube(f, i == 2);
    }
}

void prepare(bench *b, int32_t form)
{
    b->model = make_model(&b->f);
    b->solver = NULL;
    tug_default_solver_options(&b->options);
    b->options.form = form;
}

void clear(bench *b)
{
    tug_destroy_solver(b->solver);
    tug_destroy_model(b->model);
}

void choose_settings(bench *b, int i)
{
    b->options.form = FORMS[i % FORM_COUNT];
    b->options.squared = i / FORM_COUNT % 2;
    b->options.single_blend = i / FORM_COUNT / 2 % 2;
}

void restart(bench *b)
{
    tug_destroy_solver(b->solver);
    tug_create_solver(b->model, &b->options, &b->solver);
}

int has_costs(int32_t form)
{
    return form != TUG_FORM_AVERAGE && form != TUG_FORM_MINIMAL && form != TUG_FORM_CLOSEST;
}

int solve(bench *b)
{
    memset(b->costs, 0, sizeof b->costs);
    if (b->solver == NULL) {
        restart(b);
    }
    b->info = (tug_solve_info){.struct_size = sizeof b->info};
    return tug_solve(b->solver, b->targets, &b->info) == TUG_OK &&
           tug_get_positions(b->solver, b->positions) == TUG_OK &&
           tug_get_blend(b->solver, b->blend) == TUG_OK &&
           (!has_costs(b->options.form) || tug_get_costs(b->solver, b->costs) == TUG_OK) &&
           tug_get_rotations(b->solver, b->rotations) == TUG_OK;
}

int is_sound(const bench *b)
{
    const fixture *f = &b->f;
    int32_t k = f->dimension;
    double product[9], I[9];
    identity_matrix(k, I);
    for (int32_t i = 0; i < f->groups * f->shapes; i++) {
        const double *R = b->rotations + i * k * k;
        multiply_nt(k, R, R, product);
        for (int32_t e = 0; e < k * k; e++) {
            if (!(fabs(product[e] - I[e]) < 1e-12)) {
                return 0;
            }
        }
        if (!(b->blend[i] >= 0.0 && b->costs[i] >= 0.0)) {
            return 0;
        }
    }
    for (int32_t g = 0; g < f->groups; g++) {
        double sum = 0.0;
        for (int32_t s = 0; s < f->shapes; s++) {
            sum += b->blend[g * f->shapes + s];
        }
        if (!(fabs(sum - 1.0) < 1e-12)) {
            return 0;
        }
    }
    return 1;
}

int finds_examples(bench *b, double tolerance)
{
    for (int32_t s = 0; s < b->f.shapes; s++) {
        const double *shape = shape_of(&b->f, s);
        apply_rows(&b->f, shape, b->targets);
        if (!solve(b) || !is_sound(b) || !b->info.converged ||
            !(pose_distance(&b->f, b->positions, shape) <= tolerance)) {
            printf("shape %d is not found again\n", (int)s);
            return 0;
        }
    }
    return 1;
}

double constraint_error(const bench *b)
{
    double values[3 * MAX_WEIGHTS], largest = 0.0;
    apply_rows(&b->f, b->positions, values);
    for (int32_t i = 0; i < b->f.rows * b->f.dimension; i++) {
        largest = fmax(largest, fabs(values[i] - b->targets[i]));
    }
    return largest / diagonal_of(&b->f);
}

double energy_of(const bench *b)
{
    return measure_energy(&b->f, b->positions, b->blend, b->rotations);
}

/* Roots of the groups' parts of the rest shape's energy against nothing: what the steady form
 * weighs its costs with. Others' are one. */
static void find_share_roots(const bench *b, double *roots)
{
    static const double nothing[9 * MAX_PAIRS];
    int shared = b->options.form == TUG_FORM_STEADY && !b->options.squared;
    double energies[MAX_GROUPS], sum = 0.0;
    measure_groups(&b->f, shape_of(&b->f, 0), nothing, nothing, energies);
    for (int32_t g = 0; g < b->f.groups; g++) {
        sum += energies[g];
    }
    for (int32_t g = 0; g < b->f.groups; g++) {
        roots[g] = shared ? sqrt(energies[g] / sum) : 1.0;
    }
}

double price_of(const bench *b)
{
    int32_t S = b->f.shapes, n = b->f.groups * S;
    double sum = 0.0, roots[MAX_GROUPS];
    if (!has_costs(b->options.form)) {
        return 0.0;
    }
    find_share_roots(b, roots);
    for (int32_t i = 0; i < n && !b->options.single_blend; i++) {
        sum += roots[i / S] * b->blend[i] * b->costs[i];
    }
    for (int32_t s = 0; s < S && b->options.single_blend; s++) {
        double whole = 0.0;
        for (int32_t i = s; i < n; i += S) {
            whole += b->options.squared ? b->costs[i] : b->costs[i] * b->costs[i];
        }
        sum += b->blend[s] * (b->options.squared ? whole : sqrt(whole));
    }
    return b->options.lambda * sum;
}
