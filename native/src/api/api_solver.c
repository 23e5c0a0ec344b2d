/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The public calls of solvers, and of the problems inside a solve on their own. */
#include "api/arguments.h"
#include "dense/rotation.h"
#include "solver/elastic_net.h"
#include "solver/forms.h"
#include "solver/solver.h"

#include <math.h>

void tug_default_solver_options(tug_solver_options *options)
{
    *options = (tug_solver_options){
        .struct_size = sizeof *options,
        .form = TUG_FORM_STEADY,
        .lambda = 0.5,
        .prior = 0.1,
        .tolerance = 1e-6,
    };
}

tug_status tug_create_solver(const tug_model *model, const tug_solver_options *options,
                             tug_solver **out)
{
    REQUIRE_POINTER("tug_create_solver", out);
    *out = NULL;
    REQUIRE_POINTER("tug_create_solver", model);
    REQUIRE_POINTER("tug_create_solver", options);
    REQUIRE_SIZE("tug_create_solver", options);
    REQUIRE(options->form >= TUG_FORM_STEADY && options->form <= TUG_FORM_CLOSEST,
            "tug_create_solver: there is no form %d", options->form);
    REQUIRE(options->lambda >= 0.0 && isfinite(options->lambda),
            "tug_create_solver: lambda is %g: it cannot be negative", options->lambda);
    REQUIRE(options->prior >= 0.0 && isfinite(options->prior),
            "tug_create_solver: the prior is %g: it cannot be negative", options->prior);
    REQUIRE(options->tolerance > 0.0, "tug_create_solver: the tolerance must be above zero");
    REQUIRE(options->max_rounds >= 0, "tug_create_solver: max_rounds cannot be negative");
    REQUIRE(!options->scale || compares_with_references(options->form),
            "tug_create_solver: form %d cannot scale the shapes: choose one of the average, the "
            "minimal and the closest, or set scale to 0",
            options->form);
    return solver_create(model, options, out);
}

void tug_destroy_solver(tug_solver *solver)
{
    solver_destroy(solver);
}

tug_status tug_set_firmness(tug_solver *solver, const double *firmness)
{
    REQUIRE_POINTER("tug_set_firmness", solver);
    REQUIRE_POINTER("tug_set_firmness", firmness);
    for (int32_t r = 0; r < solver->model->header.rows; r++) {
        REQUIRE(firmness[r] >= 0.0,
                "tug_set_firmness: the firmness of row %d is %g: it must be 0 or more", r,
                firmness[r]);
    }
    return solver_set_firmness(solver, firmness);
}

/* Up to the rounding of single precision. */
static int is_rotation(int32_t k, const double *R)
{
    double transposed[9] = {0}, closest[9];
    for (int32_t i = 0; i < k * k; i++) {
        transposed[i] = R[(i % k) * k + i / k];
    }
    closest_rotation(k, transposed, closest);
    for (int32_t i = 0; i < k * k; i++) {
        if (!(fabs(R[i] - closest[i]) <= 1e-5)) {
            return 0;
        }
    }
    return 1;
}

tug_status tug_set_orientations(tug_solver *solver, const double *orientations,
                                const double *firmness)
{
    REQUIRE_POINTER("tug_set_orientations", solver);
    REQUIRE_POINTER("tug_set_orientations", orientations);
    REQUIRE_POINTER("tug_set_orientations", firmness);
    int32_t k = solver->model->header.dimension, form = solver->options.form;
    for (int32_t r = 0; r < solver->model->header.rows; r++) {
        REQUIRE(firmness[r] >= 0.0,
                "tug_set_orientations: the firmness of row %d is %g: it must be 0 or more", r,
                firmness[r]);
        REQUIRE(firmness[r] == 0.0 || form == TUG_FORM_STEADY || form == TUG_FORM_PAPER,
                "tug_set_orientations: only the steady and the paper's form can follow the "
                "orientation of row %d: choose one of them",
                r);
        REQUIRE(firmness[r] == 0.0 || is_rotation(k, orientations + r * k * k),
                "tug_set_orientations: the orientation of row %d is not a rotation", r);
    }
    orient_groups(solver->model, orientations, firmness, &solver->oriented);
    return TUG_OK;
}

static tug_status require_targets(const char *call, const tug_solver *solver, const double *targets)
{
    int32_t k = solver->model->header.dimension;
    ptrdiff_t bad = find_not_finite(targets, (size_t)solver->model->header.rows * (size_t)k);
    REQUIRE(bad < 0, "%s: the target of row %td is not finite", call, bad / k);
    return TUG_OK;
}

static tug_status require_rotations(const char *call, const tug_solver *solver,
                                    const double *rotations)
{
    int32_t kk = solver->model->header.dimension * solver->model->header.dimension;
    int32_t S = solver->model->header.shapes;
    for (int32_t i = 0; i < solver->model->header.groups * S; i++) {
        REQUIRE(is_rotation(solver->model->header.dimension, rotations + i * kk),
                "%s: what is given for shape %d in group %d is not a rotation", call, i % S, i / S);
    }
    return TUG_OK;
}

tug_status tug_solve(tug_solver *solver, const double *targets, tug_solve_info *info)
{
    REQUIRE_POINTER("tug_solve", solver);
    REQUIRE_POINTER("tug_solve", targets);
    REQUIRE_INFO("tug_solve", info);
    tug_solve_info own = {.struct_size = sizeof own};
    tug_status status = require_targets("tug_solve", solver, targets);
    if (status == TUG_OK) {
        solver_solve(solver, targets, NULL, info != NULL ? info : &own);
    }
    return status;
}

tug_status tug_solve_from(tug_solver *solver, const double *targets, const double *rotations,
                          tug_solve_info *info)
{
    REQUIRE_POINTER("tug_solve_from", solver);
    REQUIRE_POINTER("tug_solve_from", targets);
    REQUIRE_POINTER("tug_solve_from", rotations);
    REQUIRE_INFO("tug_solve_from", info);
    REQUIRE(!solver->options.warm_start,
            "tug_solve_from: a solver with warm_start starts from its last pose: set it to 0");
    tug_solve_info own = {.struct_size = sizeof own};
    tug_status status = require_targets("tug_solve_from", solver, targets);
    if (status == TUG_OK) {
        status = require_rotations("tug_solve_from", solver, rotations);
    }
    if (status == TUG_OK) {
        solver_solve(solver, targets, rotations, info != NULL ? info : &own);
    }
    return status;
}

tug_status tug_pose(tug_solver *solver, const double *targets, const double *blend,
                    const double *rotations)
{
    REQUIRE_POINTER("tug_pose", solver);
    REQUIRE_POINTER("tug_pose", targets);
    REQUIRE_POINTER("tug_pose", blend);
    REQUIRE_POINTER("tug_pose", rotations);
    tug_status status = require_targets("tug_pose", solver, targets);
    if (status == TUG_OK) {
        status = require_rotations("tug_pose", solver, rotations);
    }
    if (status != TUG_OK) {
        return status;
    }
    REQUIRE(is_on_simplices(blend, solver->model->header.groups, solver->model->header.shapes),
            "tug_pose: the blend has a negative weight or a row that does not sum to one");
    solver_pose(solver, targets, blend, rotations);
    return TUG_OK;
}

#define REQUIRE_SOLVED(call)                                                                       \
    do {                                                                                           \
        REQUIRE_POINTER(call, solver);                                                             \
        REQUIRE(solver->solved, call ": nothing has been solved yet");                             \
    } while (0)

#define REQUIRE_POSED(call)                                                                        \
    do {                                                                                           \
        REQUIRE_POINTER(call, solver);                                                             \
        REQUIRE(solver->posed, call ": nothing has been solved yet");                              \
    } while (0)

tug_status tug_get_positions(const tug_solver *solver, double *positions)
{
    REQUIRE_POSED("tug_get_positions");
    REQUIRE_POINTER("tug_get_positions", positions);
    find_positions(solver, positions);
    return TUG_OK;
}

tug_status tug_get_blend(const tug_solver *solver, double *blend)
{
    REQUIRE_POSED("tug_get_blend");
    REQUIRE_POINTER("tug_get_blend", blend);
    copy_blend(solver, blend);
    return TUG_OK;
}

tug_status tug_get_costs(const tug_solver *solver, double *costs)
{
    REQUIRE_SOLVED("tug_get_costs");
    REQUIRE_POINTER("tug_get_costs", costs);
    REQUIRE(!compares_with_references(solver->options.form),
            "tug_get_costs: the average, minimal and closest forms have no costs: choose another");
    copy_costs(solver, costs);
    return TUG_OK;
}

tug_status tug_get_rotations(const tug_solver *solver, double *rotations)
{
    REQUIRE_POSED("tug_get_rotations");
    REQUIRE_POINTER("tug_get_rotations", rotations);
    copy_rotations(solver, rotations);
    return TUG_OK;
}

tug_status tug_get_scale(const tug_solver *solver, double *scale)
{
    REQUIRE_POSED("tug_get_scale");
    REQUIRE_POINTER("tug_get_scale", scale);
    *scale = solver->scale;
    return TUG_OK;
}

tug_status tug_minimise_blend(int32_t group_count, int32_t shape_count, const double *Q,
                              const double *c, double r, const double *d, double lambda,
                              int32_t squared, double *blend, tug_blend_info *info)
{
    REQUIRE_POINTER("tug_minimise_blend", Q);
    REQUIRE_POINTER("tug_minimise_blend", c);
    REQUIRE_POINTER("tug_minimise_blend", d);
    REQUIRE_POINTER("tug_minimise_blend", blend);
    REQUIRE_INFO("tug_minimise_blend", info);
    REQUIRE(group_count > 0 && shape_count > 0, "tug_minimise_blend: there is nothing to blend");
    REQUIRE(lambda >= 0.0 && isfinite(lambda),
            "tug_minimise_blend: lambda is %g: it cannot be negative", lambda);
    size_t n = (size_t)group_count * (size_t)shape_count;
    REQUIRE(find_not_finite(Q, n * n) < 0 && find_not_finite(c, n) < 0 && isfinite(r) &&
                find_not_finite(d, n) < 0,
            "tug_minimise_blend: a coefficient is not finite");
    return minimise_blend_alone(group_count, shape_count, Q, c, r, d, lambda, squared, blend, info);
}

tug_status tug_solve_elastic_net(int32_t rows, int32_t unknowns, int32_t columns, const double *X,
                                 const double *Y, const double *Lambda, double fit,
                                 double smoothness, double sparsity, double *T,
                                 tug_elastic_net_info *info)
{
    REQUIRE_POINTER("tug_solve_elastic_net", X);
    REQUIRE_POINTER("tug_solve_elastic_net", Y);
    REQUIRE_POINTER("tug_solve_elastic_net", T);
    REQUIRE_INFO("tug_solve_elastic_net", info);
    REQUIRE(rows > 0 && unknowns > 0 && columns > 0,
            "tug_solve_elastic_net: X is %d by %d and Y has %d columns: there is nothing to solve",
            rows, unknowns, columns);
    REQUIRE(fit > 0.0 && isfinite(fit), "tug_solve_elastic_net: fit is %g: it must be above zero",
            fit);
    REQUIRE(smoothness >= 0.0 && isfinite(smoothness),
            "tug_solve_elastic_net: smoothness is %g: it cannot be negative", smoothness);
    REQUIRE(sparsity >= 0.0 && isfinite(sparsity),
            "tug_solve_elastic_net: sparsity is %g: it cannot be negative", sparsity);
    size_t h = (size_t)rows, b = (size_t)unknowns, k = (size_t)columns;
    ptrdiff_t bad = find_not_finite(X, h * b);
    REQUIRE(bad < 0, "tug_solve_elastic_net: row %td of X has a value that is not finite",
            bad / unknowns);
    bad = find_not_finite(Y, h * k);
    REQUIRE(bad < 0, "tug_solve_elastic_net: row %td of Y has a value that is not finite",
            bad / columns);
    bad = Lambda != NULL ? find_not_finite(Lambda, b * b) : -1;
    REQUIRE(bad < 0, "tug_solve_elastic_net: row %td of Lambda has a value that is not finite",
            bad / unknowns);
    elastic_net_problem problem = {rows, unknowns, X, Lambda, fit, smoothness, sparsity};
    tug_elastic_net_info own;
    return solve_elastic_net(&problem, Y, columns, T, info != NULL ? info : &own);
}
