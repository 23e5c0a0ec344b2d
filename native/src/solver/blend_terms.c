/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/blend_terms.h"

#include <string.h>

/* One simplex for all groups: sums over them. */
static void fold(const tug_solver *solver, const double *c)
{
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes, n = G * S;
    memset(solver->folded_Q, 0, (size_t)(S * S) * sizeof(double));
    memset(solver->folded_c, 0, (size_t)S * sizeof(double));
    for (int32_t i = 0; i < n; i++) {
        solver->folded_c[i % S] += c[i];
        for (int32_t j = 0; j < n; j++) {
            solver->folded_Q[(i % S) * S + j % S] += solver->Q[(size_t)i * (size_t)n + (size_t)j];
        }
    }
}

void solve_blend(tug_solver *solver, const blend_terms *terms)
{
    int32_t G = solver->model->header.groups, S = terms->shapes;
    int32_t squared = solver->options.squared;
    if (!solver->options.single_blend) {
        blend_problem problem = {G, S, solver->Q, terms->c, terms->r, terms->d, squared};
        solver->blend = minimise_blend(&problem, &solver->blending, terms->B);
        return;
    }
    fold(solver, terms->c);
    blend_problem problem = {
        1, S, solver->folded_Q, solver->folded_c, terms->r, terms->folded_d, squared};
    solver->blend = minimise_blend(&problem, &solver->blending, solver->folded_B);
    for (int32_t i = 0; i < G * S; i++) {
        terms->B[i] = solver->folded_B[i % S];
    }
}
