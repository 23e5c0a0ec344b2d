/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The state of a solve: the question, the answer, and room to work. */
#ifndef TUG_SOLVER_STATE_H
#define TUG_SOLVER_STATE_H

#include "model/model.h"
#include "solver/blend.h"
#include "solver/costs.h"
#include "solver/holding.h"
#include "solver/references.h"
#include "solver/rotation_fit.h"
#include "solver/trust_room.h"
#include "solver/working_set.h"

struct tug_solver {
    const tug_model *model;
    tug_solver_options options;
    holding *held;
    orientation oriented;
    int solved; /* costs and all else are those of the last solve */
    int posed;  /* there are blend, rotations and transforms */

    /* The question. Y is about its own mean, in units of the model. */
    double *Y;      /* #H by k */
    double *placed; /* #H by k: where rows that give way come to be */
    double middle[3];
    double *pull; /* #G #S by k by k: K F Y */
    double r;     /* tr(Y^T F^T L F Y) */
    shape_costs costs;

    /* The answer. */
    double *B;        /* #G by #S */
    double *R;        /* #G by #S by k by k, relative to the alignment */
    double scale;     /* of all shapes; one but where it is free */
    double *T;        /* unknowns by k */
    double *placed_T; /* T for shapes about their own origins: what positions are made with */

    /* (A 20) at the present rotations; for a single blend it is folded to one simplex. */
    double *Q, *c, *d;                      /* #G #S square, #G #S, #G #S */
    double *folded_Q, *folded_c, *folded_d; /* #S square, #S, #S */
    double *folded_B;                       /* #S */
    blend_workspace blending;
    blend_result blend;

    /* The steady form's own: one rotation per group. group_R, C, L and turning also serve rounds
     * with one shape by Newton's method. */
    double *group_R, *prior_R, *kept_R; /* #G by k by k */
    double *prior_B;                    /* #G by #S */
    working_set set;                    /* what the steady form looks at of the blend */
    double *C, *L;                      /* the energy of the rotations at the present blend */
    double *X;                          /* #G by k by k */
    double *J;                          /* #G #S by tangent components of all groups */
    double *face_J;                     /* face by the same: J on the blend's face */
    double *face_H;                     /* face by face */
    rotation_workspace turning;

    trust_room trust;          /* that form's own */
    reference_room references; /* that of the three forms of Shtern et al. */

    double *V;        /* #G #S k by k: blend weight times rotation, transposed */
    double *M;        /* #G #S by k by k: moments, (A 23) */
    double *recovery; /* recover_transforms' work */
};

tug_status solver_create(const tug_model *model, const tug_solver_options *options,
                         tug_solver **out);
void solver_destroy(tug_solver *solver);

/* The joint problem in terms of the targets. */
static inline const reduction *joint_energy(const tug_solver *solver)
{
    return held_energy(solver->model, solver->held, JOINT);
}

#endif
