/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/solver_state.h"

#include "dense/rotation.h"
#include "memory.h"
#include "solver/forms.h"

#include <string.h>

void solver_destroy(tug_solver *solver)
{
    if (solver == NULL) {
        return;
    }
    double *arrays[] = {solver->Y,        solver->placed,   solver->pull,     solver->B,
                        solver->R,        solver->T,        solver->placed_T, solver->Q,
                        solver->c,        solver->d,        solver->folded_Q, solver->folded_c,
                        solver->folded_d, solver->folded_B, solver->group_R,  solver->prior_R,
                        solver->prior_B,  solver->kept_R,   solver->C,        solver->L,
                        solver->X,        solver->J,        solver->face_J,   solver->face_H,
                        solver->V,        solver->M,        solver->recovery};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        release(arrays[i]);
    }
    release_holding(solver->held);
    orientation_destroy(&solver->oriented);
    costs_destroy(&solver->costs);
    blend_workspace_destroy(&solver->blending);
    rotation_workspace_destroy(&solver->turning);
    trust_room_destroy(&solver->trust);
    working_set_destroy(&solver->set);
    references_destroy(&solver->references);
    release(solver);
}

typedef struct array_request {
    double **array;
    size_t count;
} array_request;

static int allocate_arrays(const array_request *requests, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        *requests[i].array = allocate(requests[i].count, sizeof(double));
        if (*requests[i].array == NULL) {
            return 0;
        }
    }
    return 1;
}

static int allocate_solver(tug_solver *s)
{
    const model_header *header = &s->model->header;
    size_t k = (size_t)header->dimension, kk = k * k, S = (size_t)header->shapes;
    size_t G = (size_t)header->groups, h = (size_t)header->rows, n = G * S;
    size_t size = G * (size_t)tangent_size(header->dimension);
    /* The rows of J beyond the first S serve as scratch for a single blend. */
    const array_request requests[] = {
        {&s->Y, h * k},
        {&s->placed, h * k},
        {&s->pull, n * kk},
        {&s->B, n},
        {&s->R, n * kk},
        {&s->T, (size_t)s->model->energy.unknowns * k},
        {&s->placed_T, (size_t)s->model->energy.unknowns * k},
        {&s->Q, n * n},
        {&s->c, n},
        {&s->d, n},
        {&s->folded_Q, S * S},
        {&s->folded_c, S},
        {&s->folded_d, S},
        {&s->folded_B, S},
        {&s->group_R, G * kk},
        {&s->prior_R, G * kk},
        {&s->prior_B, n},
        {&s->kept_R, G * kk},
        {&s->C, G * k * G * k},
        {&s->L, G * kk},
        {&s->X, G * kk},
        {&s->J, (n + 1) * size},
        {&s->face_J, n * size},
        {&s->face_H, n * n},
        {&s->V, n * kk},
        {&s->M, n * kk},
        {&s->recovery, recovery_size(&s->model->energy, header->dimension)},
    };
    return allocate_arrays(requests, sizeof requests / sizeof *requests);
}

static void take_options(const tug_solver_options *given, tug_solver_options *options)
{
    *options = *given;
    if (given->max_rounds == 0) {
        options->max_rounds = given->form == TUG_FORM_CLOSEST ? 10 : 200;
    }
    if (compares_with_references(given->form)) {
        options->squared = 1; /* their energies have no root */
    }
}

tug_status solver_create(const tug_model *model, const tug_solver_options *options,
                         tug_solver **out)
{
    tug_solver *solver = allocate(1, sizeof *solver);
    if (solver == NULL) {
        return fail_memory();
    }
    solver->model = model;
    take_options(options, &solver->options);
    int32_t groups = model->header.groups, shapes = model->header.shapes;
    int room =
        allocate_solver(solver) && orientation_create(model, &solver->oriented) &&
        costs_create(model, &solver->costs) &&
        blend_workspace_create(options->single_blend ? 1 : groups, shapes, &solver->blending) &&
        rotation_workspace_create(groups, model->header.dimension, &solver->turning) &&
        (options->form != TUG_FORM_TRUST_REGION || trust_room_create(model, &solver->trust)) &&
        working_set_create(model, options->single_blend, &solver->set) &&
        (!compares_with_references(options->form) ||
         references_create(model, options->form != TUG_FORM_MINIMAL, &solver->references));
    if (!room) {
        solver_destroy(solver);
        return fail_memory();
    }
    if (compares_with_references(options->form)) {
        find_couplings(model, &model->energy, &solver->references.couplings);
    }
    *out = solver;
    return TUG_OK;
}
