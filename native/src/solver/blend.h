/* SPDX-License-Identifier: GPL-3.0-or-later */
/* (A 20) with the transforms eliminated: the convex part of every solve.
 *
 *     f(B) = sqrt(u(B)) + d^T B,    u(B) = 1/2 (B^T Q B + 2 c^T B + r),    B in G simplices,
 *
 * or u(B) + d^T B where `squared`. By an active-set method on f itself: on a face of the simplices
 * the minimisers of u + tau d^T B are a line in tau, so f's own minimiser there has a closed form.
 */
#ifndef TUG_BLEND_H
#define TUG_BLEND_H

#include "status.h"

typedef struct blend_problem {
    int32_t groups, shapes;
    const double *Q; /* n by n, n = groups shapes */
    const double *c; /* n */
    double r;        /* such that u is not negative on the simplices */
    const double *d; /* n: costs times lambda */
    int32_t squared;
} blend_problem;

typedef struct blend_workspace {
    double *gradient;  /* n: Q B + c, of u at B */
    double *direction; /* n */
    double *reduced;   /* n by n: Hessian of u on the face */
    double *to_u;      /* n: the step to the face's minimiser of u, */
    double *along_d;   /* n: and how that moves with the weight of d */
    double *reduced_d; /* n */
    double *kept;      /* n: B before a step */
    double *best;      /* n: B of the least gap so far */
    int32_t *free;     /* n: whether B_i may move */
    int32_t *list;     /* n: the free ones that are no group's pivot; q of them */
    int32_t *pivot;    /* G: the entry that gives way so that a row sums to one */
    int32_t face;      /* q */
} blend_workspace;

/* What is left in the workspace after minimise_blend: gradient, free, list, pivot and face of the
 * optimum. */
typedef struct blend_result {
    int32_t pivots;
    double objective;
    double u;
    double gap; /* f(B) is at most this far above its minimum, but for the rounding of u */
} blend_result;

/* u as the root takes it: not below the rounding of terms of the size of r, nor below zero. */
double raise_to_rounding(double u, double r);

/* Returns 0 where memory is short; the workspace can then be freed all the same. */
int blend_workspace_create(int32_t groups, int32_t shapes, blend_workspace *workspace);
void blend_workspace_destroy(blend_workspace *workspace);

/* Whether no weight is negative and the rows sum to one. */
int is_on_simplices(const double *B, int32_t groups, int32_t shapes);

/* B: a point of the simplices, then the minimiser. f never rises. */
blend_result minimise_blend(const blend_problem *problem, blend_workspace *workspace, double *B);

/* tug_minimise_blend, its arguments checked but for the point. */
tug_status minimise_blend_alone(int32_t groups, int32_t shapes, const double *Q, const double *c,
                                double r, const double *d, double lambda, int32_t squared,
                                double *B, tug_blend_info *info);

#endif
