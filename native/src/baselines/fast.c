/* SPDX-License-Identifier: GPL-3.0-or-later */
/* FAST: Jacobson, Baran, Kavan, Popovic and Sorkine 2012, "Fast Automatic Skinning
 * Transformations": the as-rigid-as-possible pose of the rest shape in its skinning subspace, with
 * rotation clusters and handles that hold exactly.
 *
 * Against the paper: Newton's method in place of the local and global steps unless these are asked
 * for; surface energy only; no free handles beyond what the weights have. */
#include "memory.h"
#include "single_shape.h"

static void destroy(void *state)
{
    if (state != NULL) {
        single_shape_destroy(state);
        release(state);
    }
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    single_shape *shape = *state = allocate(1, sizeof *shape);
    return shape != NULL ? single_shape_create(baseline, problem, 0, shape) : fail_memory();
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    single_shape_solve(baseline, baseline->state, info);
    baseline->blend[0] = 1.0;
    return TUG_OK;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    single_shape_positions(baseline->state, positions);
}

const baseline_method fast_method = {create, destroy, solve, find_positions, NULL};
