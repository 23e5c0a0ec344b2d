/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Weights of shapes, which sum to one, that minimise half a sum of squares: Gauss-Newton, with a
 * secant correction of its Hessian, damped where a step does not lead downhill. */
#ifndef TUG_BASELINES_GAUSS_NEWTON_H
#define TUG_BASELINES_GAUSS_NEWTON_H

#include "baselines.h"
#include "solver/blend.h"

typedef struct weight_problem {
    int32_t shapes;
    int simplex; /* 0: weights of any sign */
    void *state;
    /* The energy at w. */
    tug_status (*evaluate)(void *state, const double *w, double *energy);
    /* Its gradient, #S, and the Gauss-Newton Hessian, #S by #S, at w, which is where the energy was
     * found to be least so far, but not always where it was found last. */
    tug_status (*differentiate)(void *state, const double *w, double *gradient, double *hessian);
} weight_problem;

typedef struct weight_workspace {
    double *gradient, *hessian; /* #S, #S by #S */
    double *correction;         /* #S by #S: what the Gauss-Newton Hessian has been found to lack */
    double *last_gradient;      /* #S: at the w before */
    double *moved;              /* #S: from there */
    double *damped;             /* #S by #S */
    double *linear, *step;      /* #S */
    double *trial;              /* #S */
    blend_workspace blending;
} weight_workspace;

/* Returns 0 where memory is short; the workspace can then be freed all the same. */
int weight_workspace_create(int32_t shapes, weight_workspace *workspace);
void weight_workspace_destroy(weight_workspace *workspace);

/* w: where to start, then the minimum. The last w evaluated need not be it. Fills info; its
 * objective holds a regulariser of the weights as well. */
tug_status minimise_weights(const weight_problem *problem, const tug_baseline_options *options,
                            weight_workspace *workspace, double *w, tug_baseline_info *info);

#endif
