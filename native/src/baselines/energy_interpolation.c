/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Energy interpolation: Chao, Pinkall, Sanan and Schroeder 2010, "A Simple Geometric Model for
 * Elastic Deformations", as AMRAP poses meshes with it: min over q and the simplex of
 * sum_s b_s E(q, p_s), (A 2). It is linear in b, so the optimum is the shape of least energy alone.
 *
 * Against the paper: the as-rigid-as-possible energy of edge groups in each shape's own skinning
 * subspace, in place of every triangle's own rotation. */
#include "memory.h"
#include "single_shape.h"

#include <math.h>
#include <string.h>

typedef struct interpolation {
    single_shape *shapes;
    int32_t count, best;
} interpolation;

static void destroy(void *state)
{
    interpolation *all = state;
    if (all == NULL) {
        return;
    }
    for (int32_t s = 0; s < all->count; s++) {
        single_shape_destroy(all->shapes + s);
    }
    release(all->shapes);
    release(all);
}

static tug_status create(const tug_baseline *baseline, const tug_baseline_problem *problem,
                         void **state)
{
    interpolation *all = *state = allocate(1, sizeof *all);
    if (all == NULL) {
        return fail_memory();
    }
    all->shapes = allocate((size_t)problem->shape_count, sizeof *all->shapes);
    if (all->shapes == NULL) {
        return fail_memory();
    }
    tug_status status = TUG_OK;
    for (int32_t s = 0; s < problem->shape_count && status == TUG_OK; s++) {
        all->count++;
        status = single_shape_create(baseline, problem, s, all->shapes + s);
    }
    return status;
}

static tug_status solve(tug_baseline *baseline, tug_baseline_info *info)
{
    interpolation *all = baseline->state;
    all->best = 0;
    info->converged = 1;
    for (int32_t s = 0; s < all->count; s++) {
        tug_baseline_info own = {.struct_size = sizeof own};
        single_shape_solve(baseline, all->shapes + s, &own);
        all->best = all->shapes[s].energy < all->shapes[all->best].energy ? s : all->best;
        info->converged &= own.converged;
        info->rounds = own.rounds > info->rounds ? own.rounds : info->rounds;
        info->residual = fmax(info->residual, own.residual);
        info->increase = fmax(info->increase, own.increase);
    }
    memset(baseline->blend, 0, (size_t)all->count * sizeof *baseline->blend);
    baseline->blend[all->best] = 1.0;
    info->objective = all->shapes[all->best].energy;
    return TUG_OK;
}

static void find_positions(const tug_baseline *baseline, double *positions)
{
    const interpolation *all = baseline->state;
    single_shape_positions(all->shapes + all->best, positions);
}

const baseline_method energy_interpolation_method = {create, destroy, solve, find_positions, NULL};
