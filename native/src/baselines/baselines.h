/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparison systems: other methods that pose a mesh from handle positions, on the same meshes,
 * handles, weights and edge groups as libtug, in a library of their own. The conventions are those
 * of tug.h. Every solve starts cold. */
#ifndef TUG_BASELINES_H
#define TUG_BASELINES_H

#include "tug.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tug_baseline_method {
    /* Jacobson et al. 2012: as rigid as possible, the rest shape alone. */
    TUG_BASELINE_FAST = 0,
    /* Chao et al. 2010, (A 2): the shape of least energy alone. */
    TUG_BASELINE_ENERGY_INTERPOLATION = 1,
    /* Schumacher et al. 2012: the distance from a nonlinear blend of the shapes' features. */
    TUG_BASELINE_NONLINEAR_SHAPE_SPACE = 2,
    /* Sumner et al. 2005, in the space of all vertices. */
    TUG_BASELINE_MESH_IK = 3,
    /* Der et al. 2006: MeshIK on a skinned model of the rest shape. */
    TUG_BASELINE_REDUCED_DEFORMABLE = 4,
    /* Linear blend shapes, what they miss of the handles spread by the weights. */
    TUG_BASELINE_BLEND_SHAPES = 5
} tug_baseline_method;

/* What every method is made from; a method takes of it what it needs. */
typedef struct tug_baseline_problem {
    const double *shapes;     /* #S by #V by k; shape 0 is the rest shape */
    const int32_t *triangles; /* #F by 3 */
    const int32_t *handles;   /* #H: the vertex that each target is for */
    const double *weights;    /* #V by #W, whose span holds the constant */
    const int32_t *groups;    /* #F, every number below group_count used */
    int32_t shape_count, vertex_count, dimension, triangle_count;
    int32_t handle_count, weight_count, group_count;
} tug_baseline_problem;

typedef struct tug_baseline_options {
    size_t struct_size;
    /* 1: TUG_BASELINE_FAST and _ENERGY_INTERPOLATION by the local and global steps of their paper
     * in place of Newton's method. */
    int32_t local_global;
    int32_t max_rounds; /* default 200; 100,000 with local_global would not be too many */
    /* A solve has converged when a round moves no weight and turns no rotation (radians) by more;
     * default 1e-6. */
    double tolerance;
} tug_baseline_options;

typedef struct tug_baseline_info {
    size_t struct_size;
    int32_t converged;
    int32_t rounds;
    double objective; /* the method's own energy, in units of length squared */
    double residual;  /* how far the last round would have moved a weight or turned a rotation */
    double increase;  /* largest rise of the objective in a round */
} tug_baseline_info;

/* One method on one mesh: its constants, and the last pose. */
typedef struct tug_baseline tug_baseline;

TUG_API void tug_baseline_default_options(tug_baseline_options *options);

/* method: a tug_baseline_method. Fails with TUG_ERROR_MESH where the mesh is not sound, with
 * TUG_ERROR_HANDLES where two handles are the same vertex. */
TUG_API tug_status tug_baseline_create(int32_t method, const tug_baseline_problem *problem,
                                       const tug_baseline_options *options, tug_baseline **out);

/* Hold the method by these rows from here on, softly, in place of its handles: see tug_change_rows.
 * TUG_BASELINE_REDUCED_DEFORMABLE alone; the others know pinned vertices only. firmness: #H. A call
 * that fails changes nothing. */
TUG_API tug_status tug_baseline_change_rows(tug_baseline *baseline, const tug_rows *rows,
                                            const double *firmness);

/* NULL is allowed. */
TUG_API void tug_baseline_destroy(tug_baseline *baseline);

/* Find the pose for positions of the handles or rows. targets: #H by k. */
TUG_API tug_status tug_baseline_solve(tug_baseline *baseline, const double *targets,
                                      tug_baseline_info *info);

/* What the last solve found; TUG_ERROR_ARGUMENT before the first. positions: #V by k. blend: #S,
 * the weights of the shapes, which sum to one. */
TUG_API tug_status tug_baseline_get_positions(const tug_baseline *baseline, double *positions);
TUG_API tug_status tug_baseline_get_blend(const tug_baseline *baseline, double *blend);

#ifdef __cplusplus
}
#endif

#endif
