/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rounds with a single shape by Newton's method, for where local and global steps creep.
 *
 * With the transforms eliminated the energy of one shape is that of rotation_fit.h,
 *
 *     E = alpha^2 q(R) - alpha p(R) + r/2,   q = 1/2 tr(R C R^T),   p = tr(R K F Y)
 *
 * and with alpha eliminated as well its Hessian is that of E less v v^T / kappa, v being the
 * derivative of dE/dalpha in R and kappa = 2 q the one in alpha. */
#ifndef TUG_REFERENCE_NEWTON_H
#define TUG_REFERENCE_NEWTON_H

#include "solver/solver_state.h"

/* Steps downhill from a set of one shape that is settled, and leave it so, until one turns nothing
 * by more than the tolerance: at least one, since small turns of local and global steps do not say
 * how far the end is. Returns their number. */
int32_t descend_reference(tug_solver *solver, const reference_question *question,
                          int32_t max_rounds, reference_set *set);

#endif
