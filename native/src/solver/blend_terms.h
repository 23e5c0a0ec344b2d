/* SPDX-License-Identifier: GPL-3.0-or-later */
/* (A 20) at the present rotations of a solve: all of it, or what the steady form looks at. */
#ifndef TUG_BLEND_TERMS_H
#define TUG_BLEND_TERMS_H

#include "solver/solver_state.h"

/* What (A 20) is made of beside the solver's Q: over `shapes` entries of each group. */
typedef struct blend_terms {
    int32_t shapes;
    const double *c, *d;    /* #G by shapes */
    const double *folded_d; /* #S, for a single blend, which has all shapes */
    double r;
    double *B; /* #G by shapes: where it starts, then the optimum */
} blend_terms;

/* Of all entries, with the solver's own c, d and r. */
static inline blend_terms all_terms(const tug_solver *solver)
{
    return (blend_terms){
        solver->model->header.shapes, solver->c, solver->d, solver->folded_d, solver->r, solver->B};
}

void solve_blend(tug_solver *solver, const blend_terms *terms);

#endif
