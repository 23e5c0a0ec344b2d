/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Room for the trust region's solves. A point is V, M, B and folded_B in one vector. */
#ifndef TUG_TRUST_ROOM_H
#define TUG_TRUST_ROOM_H

#include "dense/extrapolation.h"
#include "model/model.h"

typedef struct trust_room {
    double *kept, *reached, *ahead;    /* points: of the model, of its minimum, beyond it */
    double *R;                         /* #G #S by k by k: of the kept point */
    double *Q;                         /* #G #S square: the same */
    double *N, *slope, *slope_moments; /* #G #S by k by k: moments.h */
    double *d, *folded_d;              /* #G #S, #S: costs with the rotations' slope */
    extrapolation path;
} trust_room;

/* Returns 0 where memory is short; it can then be destroyed all the same. */
int trust_room_create(const tug_model *model, trust_room *trust);
void trust_room_destroy(trust_room *trust);

#endif
