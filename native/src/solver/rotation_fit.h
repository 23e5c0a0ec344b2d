/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rotations of least rigidity energy, one per group, with the transforms eliminated:
 *
 *     f(R) = 1/2 sum_gh tr(R_g C_gh R_h^T) - sum_g tr(R_g L_g)
 *
 * by Newton's method on the rotations themselves, R_g <- exp(w_g) R_g. */
#ifndef TUG_ROTATION_FIT_H
#define TUG_ROTATION_FIT_H

#include <stddef.h>
#include <stdint.h>

typedef struct rotation_energy {
    int32_t groups, k;
    const double *C; /* G k by G k, symmetric */
    const double *L; /* G by k by k */
} rotation_energy;

/* Some rotations are left open by the energy: a part with a single handle may turn about it, a mesh
 * with two about their line. A prior of this weight, relative to a group's stiffness, decides those
 * and moves no other visibly. */
static const double LEAST_PRIOR = 1e-7;

/* Room for fits of `groups` rotations. */
typedef struct rotation_workspace {
    double *CR;       /* G k by k: C times the stacked R^T */
    double *columns;  /* k by G k: the columns of CR, or of one group's couplings */
    double *bands;    /* 2 k - 1 by G k: the R_g^T as one banded matrix */
    double *turned;   /* k by G k, with room to either side */
    double *gradient; /* G tangent components */
    double *hessian;  /* of f in the tangent components, square, upper triangle */
    double *factor;   /* the same, factored */
    double *step;
    double *trial;    /* G by k by k */
    double magnitude; /* of the terms that f was last summed from: its rounding is relative to it */
} rotation_workspace;

/* Returns 0 where memory is short; the workspace can then be freed all the same. */
int rotation_workspace_create(int32_t groups, int32_t k, rotation_workspace *workspace);
void rotation_workspace_destroy(rotation_workspace *workspace);

/* The workspace's CR at R. */
void couple_rotations(const rotation_energy *energy, const double *R,
                      rotation_workspace *workspace);

double evaluate_rotations(const rotation_energy *energy, const double *R,
                          rotation_workspace *workspace);

/* Gradient and Hessian of f at R in the workspace; its CR is up to date after it. */
void differentiate_rotations(const rotation_energy *energy, const double *R,
                             rotation_workspace *workspace);

/* step <- - (hessian + shift)^-1 gradient with the least shift found that makes it definite, so
 * that it leads downhill. */
void find_newton_step(int32_t size, rotation_workspace *workspace);

/* The largest angle by which the step turns a group. */
double largest_turn(const rotation_energy *energy, const rotation_workspace *workspace);

/* How much of a step to try first, by its largest turn. */
double longest_part(double turned);

/* trial <- the rotations R turned by t times the step. */
void turn_all(const rotation_energy *energy, const double *R, double t,
              rotation_workspace *workspace);

/* Newton from R, in place, downhill in every step, until a full step turns nothing by more than
 * `tolerance`. Returns the number of steps; *converged says whether it got there. */
int32_t fit_rotations(const rotation_energy *energy, double tolerance, int32_t max_steps,
                      rotation_workspace *workspace, double *R, int *converged);

#endif
