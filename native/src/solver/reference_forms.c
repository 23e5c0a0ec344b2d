/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The forms of Shtern et al.: the average energy (their algorithm 1), the minimal one (algorithm
 * 2), and the shape that a round of each finds closest. */
#include "solver/forms.h"
#include "solver/reference_newton.h"

/* Rounds of the alternation with one shape, after which Newton's method goes on. */
enum { ALTERNATING_ROUNDS = 10 };

static reference_question question_of(const tug_solver *solver)
{
    return (reference_question){solver->model, solver->r, solver->options.scale};
}

static reference_set open_set(tug_solver *solver, int32_t first, int32_t count)
{
    reference_set set = {.first = first, .count = count};
    for (int32_t s = first; s < first + count; s++) {
        set.start_scale += solver->costs.scale[s] / count;
    }
    return set;
}

static int32_t alternate(tug_solver *solver, int32_t max_rounds, reference_set *set)
{
    reference_question question = question_of(solver);
    int creeps = set->count == 1 && max_rounds > ALTERNATING_ROUNDS;
    int32_t most = creeps ? ALTERNATING_ROUNDS : max_rounds;
    int32_t rounds =
        alternate_references(&question, most, solver->options.tolerance, set, &solver->references);
    return creeps ? rounds + descend_reference(solver, &question, max_rounds - rounds, set)
                  : rounds;
}

/* The pose of a set is the answer. The rotations of all shapes are, whether they count or not. */
static void answer_with(tug_solver *solver, const reference_set *set, tug_solve_info *info)
{
    const shape_couplings *c = &solver->references.couplings;
    int32_t G = solver->model->header.groups, S = solver->model->header.shapes, kk = c->k * c->k;
    for (int32_t s = 0; s < S; s++) {
        int counts = s >= set->first && s < set->first + set->count;
        for (int32_t g = 0; g < G; g++) {
            solver->B[g * S + s] = counts ? 1.0 / set->count : 0.0;
        }
        gather_rotations(c, solver->references.X + s * slice_size(c), S * kk, solver->R + s * kk);
    }
    solver->scale = set->scale;
    solver->blend = (blend_result){.objective = value_of(set)};
    info->energy = set->energy;
    info->residual = set->residual;
    info->converged = set->residual <= solver->options.tolerance;
}

static void start_references(tug_solver *solver)
{
    int warm = solver->options.warm_start && solver->solved;
    take_references(solver->model, solver->pull, solver->costs.rotations,
                    warm ? solver->R : solver->costs.rotations, &solver->references);
}

void solve_average(tug_solver *solver, tug_solve_info *info)
{
    reference_question question = question_of(solver);
    reference_set all = open_set(solver, 0, solver->model->header.shapes);
    start_references(solver);
    settle_references(&question, &all, &solver->references);
    info->rounds = alternate(solver, solver->options.max_rounds, &all);
    answer_with(solver, &all, info);
}

static const reference_set *least_of(const tug_solver *solver)
{
    const reference_set *alone = solver->references.alone, *least = alone;
    for (int32_t s = 1; s < solver->model->header.shapes; s++) {
        least = value_of(alone + s) < value_of(least) ? alone + s : least;
    }
    return least;
}

void solve_minimal(tug_solver *solver, tug_solve_info *info)
{
    reference_question question = question_of(solver);
    int converged = 1;
    start_references(solver);
    for (int32_t s = 0; s < solver->model->header.shapes; s++) {
        reference_set *set = solver->references.alone + s;
        *set = open_set(solver, s, 1);
        settle_references(&question, set, &solver->references);
        int32_t rounds = alternate(solver, solver->options.max_rounds, set);
        info->rounds = rounds > info->rounds ? rounds : info->rounds;
        converged &= set->residual <= solver->options.tolerance;
    }
    answer_with(solver, least_of(solver), info);
    info->converged = converged;
}

/* One round of the minimal energy, every shape beginning with the transforms of the average. */
static const reference_set *find_closest(tug_solver *solver, const reference_set *all)
{
    reference_question question = question_of(solver);
    for (int32_t s = 0; s < solver->model->header.shapes; s++) {
        reference_set *set = solver->references.alone + s;
        *set = open_set(solver, s, 1);
        set->scale = all->scale;
        turn_references(&question, set, &solver->references);
        settle_references(&question, set, &solver->references);
    }
    return least_of(solver);
}

void solve_closest(tug_solver *solver, tug_solve_info *info)
{
    int32_t max_rounds = solver->options.max_rounds;
    reference_question question = question_of(solver);
    reference_set set = open_set(solver, 0, solver->model->header.shapes);
    start_references(solver);
    settle_references(&question, &set, &solver->references);
    info->rounds = alternate(solver, 1, &set);
    if (max_rounds > 1) {
        set = *find_closest(solver, &set);
        info->rounds++;
    }
    if (max_rounds > 2) {
        info->rounds += alternate(solver, max_rounds - 2, &set);
    }
    answer_with(solver, &set, info);
}
