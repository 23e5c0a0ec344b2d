/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a method is to the public calls: functions on a state of its own. */
#ifndef TUG_BASELINES_METHOD_H
#define TUG_BASELINES_METHOD_H

#include "baselines.h"
#include "mesh/mesh.h"

/* Lengths are in units of the rest shape's diagonal, from the middle of the rest shape. */
typedef struct baseline_method {
    /* The problem's arrays are the caller's: they are gone afterwards. */
    tug_status (*create)(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state);
    void (*destroy)(void *state); /* NULL is allowed */
    /* From the baseline's Y to its blend and the state's pose. All of info but struct_size is zero
     * before. */
    tug_status (*solve)(tug_baseline *baseline, tug_baseline_info *info);
    void (*find_positions)(const tug_baseline *baseline, double *positions);
    /* NULL where the method cannot. Changes nothing where it fails. */
    tug_status (*change_rows)(void *state, const tug_rows *rows, const double *firmness);
} baseline_method;

extern const baseline_method fast_method, energy_interpolation_method, nonlinear_shape_space_method,
    mesh_ik_method, reduced_deformable_method, blend_shapes_method;

struct tug_baseline {
    const baseline_method *method;
    void *state;
    tug_baseline_options options;
    int32_t shape_count, row_count; /* a row for each handle, until they are changed */
    double unit, middle[3];         /* the rest shape's diagonal and mean, the caller's units */
    tug_mesh *mesh;                 /* of the rest shape */
    double *shapes;                 /* #S by #V by k */
    int32_t *handles;               /* those of the problem */
    double *Y;                      /* #H by k */
    double *blend;                  /* #S */
    int solved;
};

static inline const double *shape_of_baseline(const tug_baseline *baseline, int32_t s)
{
    const tug_mesh *mesh = baseline->mesh;
    return baseline->shapes + (size_t)s * (size_t)mesh->vertex_count * (size_t)mesh->dimension;
}

#endif
