/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The Cholesky factor of a matrix to which rows are added, or from which they are dropped, without
 * the matrix: of A + X^T X or A - X^T X from that of A = G^T G.
 *
 * G: n by n, upper triangular, as from cholesky_factor; its lower part is not looked at. X: rows by
 * n; a row that counts `beta` times is multiplied by sqrt(beta). O(rows n^2): for more than
 * some n / 15 rows to add, or n / 30 to drop, cholesky_factor is faster. */
#ifndef TUG_CHOLESKY_UPDATE_H
#define TUG_CHOLESKY_UPDATE_H

#include <stdint.h>

/* X is overwritten. */
void cholesky_add_rows(double *G, int32_t n, double *X, int32_t rows);

/* Returns 0, with G as it was, where what is left would not be positive definite, or would have
 * lost all but four of its sixteen digits. The others have relative errors of some 1e-16 over the
 * least part of a direction's stiffness that is left. X is overwritten. work: rows by rows. */
int cholesky_drop_rows(double *G, int32_t n, double *X, int32_t rows, double *work);

#endif
