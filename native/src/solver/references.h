/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energies of Shtern et al.: how far the pose is from being rigid, seen from some of the shapes
 * and divided by their number c, with a rotation R_i for each of their pairs i = (g, s) and a
 * common scale alpha:
 *
 *     E = 1/(2c) sum_i sum_(e in g) c_ge |q_e - alpha R_i p_se|^2
 *
 * The average (F 9) has all shapes, each of the energies in the minimum of (F 12) one. With the
 * transforms eliminated (reduction.h, moments.h)
 *
 *     2 c E = -alpha^2/c tr(R A R^T) - 2 alpha tr(R K F Y) + c r + alpha^2 h,   h = sum_i tr(H_ii)
 *
 * A round takes the rotations closest to the moments K T, then scale and transforms at once, which
 * are T = Z K^T W + F Y, W_i = alpha/c R_i^T. Both minimise E, so that it never rises. What it
 * leaves open is held at its start by priors of LEAST_PRIOR. */
#ifndef TUG_REFERENCES_H
#define TUG_REFERENCES_H

#include "dense/extrapolation.h"
#include "solver/shape_couplings.h"

/* The shapes of one energy, and where its alternation is. */
typedef struct reference_set {
    int32_t first, count;
    double scale, start_scale;
    double energy;    /* E */
    double prior;     /* what the priors add to it */
    double magnitude; /* of the terms that E is summed from: its rounding is relative to it */
    double residual;  /* the largest angle of the last turn */
} reference_set;

/* Stacks are those of shape_couplings.h. */
typedef struct reference_room {
    shape_couplings couplings;
    double *X, *W, *AW; /* stacks: the rotations; the transforms', and their moments but for Y's */
    double *pull, *prior; /* stacks: K F Y, and where the priors hold the rotations */
    double *blocks;       /* of one shape: #G by k by k */
    double *stiffness;    /* #S: tr(H_ii) over the groups */
    /* Of one set: W and AW where a round starts, where the rounds are heading, where it ends. */
    double *reached, *ahead, *next;
    double *kept;         /* of one set: X */
    extrapolation path;   /* of W, with AW */
    reference_set *alone; /* #S: each shape by itself */
} reference_room;

/* all: 0 where no set has more than one shape. Returns 0 where memory is short; it can then be
 * destroyed all the same. */
int references_create(const tug_model *model, int all, reference_room *room);
void references_destroy(reference_room *room);

/* The pull of the targets, where the priors hold the rotations and the rotations to start from: all
 * #G by #S by k by k. */
void take_references(const tug_model *model, const double *pull, const double *held,
                     const double *start, reference_room *room);

/* The question of (F 11): what E and a round need beside the stacks. */
typedef struct reference_question {
    const tug_model *model;
    double r;
    int scaled; /* whether alpha is free, or start_scale */
} reference_question;

/* What the rounds lower: the energy and the priors. */
double value_of(const reference_set *set);

/* The local step: the set's rotations become those closest to the moments of the present
 * transforms, which the set's scale belongs to. */
void turn_references(const reference_question *question, reference_set *set, reference_room *room);

/* The scale step and the global step at once: scale and transforms that suit the set's rotations
 * best, and their energy. */
void settle_references(const reference_question *question, reference_set *set,
                       reference_room *room);

/* At least one round of both, until no rotation turns by more than the tolerance. Each starts from
 * where the last ones are heading, or from where they are if that did not help. Returns their
 * number. */
int32_t alternate_references(const reference_question *question, int32_t max_rounds,
                             double tolerance, reference_set *set, reference_room *room);

#endif
