/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rigidity energy of one edge group as a quadratic form in the transforms: the constants of
 * (A 13), (A 16) and (A 19), summed over the group's triangles. A triangle's three edges all belong
 * to its group, each with half the cotangent of its opposite angle, so that every group's form is a
 * Dirichlet energy: never negative, even where single cotangents are. */
#ifndef TUG_ENERGY_H
#define TUG_ENERGY_H

#include "mesh/mesh.h"
#include "model/dictionary.h"

/* Row-major; b columns, those of the weight functions that are asked for; p = #S k. */
typedef struct group_energy {
    double *L; /* b by b: D^T L_g D */
    double *K; /* p by b: P^T L_g D, the K~ of (A 16) for all shapes */
    double *H; /* p by p: P^T L_g P */
} group_energy;

/* Room to work in for the groups of one mesh, one after the other. */
typedef struct energy_workspace energy_workspace;

/* stiffness: #F, what each triangle's energy is multiplied by, or NULL for one. */
tug_status energy_workspace_create(const tug_mesh *mesh, const dictionary *D, const int32_t *groups,
                                   int32_t group_count, const double *stiffness,
                                   energy_workspace **out);
void energy_workspace_destroy(energy_workspace *workspace);

/* Overwrite `energy` with the constants of one group in the columns of `count` weight functions:
 * all that are not zero on it. O(vertices of the group times b^2). */
void find_group_energy(energy_workspace *workspace, int32_t group, const int32_t *functions,
                       int32_t count, group_energy *energy);

/* middle[h]: the mean of weight function h over the area of the group, which is returned. */
double find_group_weights(const energy_workspace *workspace, int32_t group, double *middle);

#endif
