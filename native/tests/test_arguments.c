/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Models and solvers with every argument that cannot be: a status, words that name the call, and
 * nothing changed. */
#include "fixture.h"
#include "memory.h"
#include "refusal.h"
#include "test.h"

/* The fixture's model, its mesh given. */
static tug_status tug_create_model_of(const fixture *f, const tug_mesh *mesh, tug_model **out)
{
    tug_rows rows = {f->row_starts, f->row_vertices, f->row_values, f->rows};
    return tug_create_model(mesh, f->shape, f->shapes, f->weight, f->weights, &rows, f->group,
                            f->groups, f->stiffness, f->smoothness, NULL, NULL, out);
}

static void tug_create_model_refuses_null(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    tug_rows rows = {f.row_starts, f.row_vertices, f.row_values, f.rows}, bare = {0};
    const void *given[] = {mesh, f.shape, f.weight, &rows, f.group};
    for (int i = 0; i < 5; i++) {
        const void *a[5];
        tug_model *model = RUBBISH;
        memcpy(a, given, sizeof a);
        a[i] = NULL;
        CHECK(REFUSED(tug_create_model, a[0], a[1], f.shapes, a[2], f.weights, a[3], a[4], f.groups,
                      f.stiffness, 0.0, NULL, NULL, &model));
        CHECK(model == NULL);
    }
    CHECK(REFUSED(tug_create_model, mesh, f.shape, f.shapes, f.weight, f.weights, &rows, f.group,
                  f.groups, f.stiffness, 0.0, NULL, NULL, NULL));
    for (int i = 0; i < 3; i++) {
        tug_model *model = RUBBISH;
        bare = (tug_rows){i == 0 ? NULL : f.row_starts, i == 1 ? NULL : f.row_vertices,
                          i == 2 ? NULL : f.row_values, f.rows};
        CHECK(REFUSED(tug_create_model, mesh, f.shape, f.shapes, f.weight, f.weights, &bare,
                      f.group, f.groups, f.stiffness, 0.0, NULL, NULL, &model));
        CHECK(model == NULL);
    }
    tug_destroy_mesh(mesh);
}

static void spoil_fixture(fixture *f, int i)
{
    switch (i) {
    case 0:
        f->shapes = 0;
        break;
    case 1:
        f->weights = 0;
        break;
    case 2:
        f->groups = 0;
        break;
    case 3:
        f->rows = 0;
        break;
    case 4:
        f->row_starts[0] = 1;
        break;
    case 5:
        f->row_starts[1] = 0;
        break;
    case 6:
        f->row_starts[2] = -3;
        break;
    case 7:
        f->row_vertices[1] = f->vertices;
        break;
    case 8:
        f->row_vertices[1] = -1;
        break;
    case 9:
        f->row_values[2] = INFINITY;
        break;
    case 10:
        f->group[3] = f->groups;
        break;
    case 11:
        f->group[3] = -1;
        break;
    case 12:
        f->groups++; /* the last is then empty */
        break;
    case 13:
        f->shape[9] = NAN;
        break;
    case 14:
        f->shape[f->shapes * coordinate_count(f) - 1] = -INFINITY;
        break;
    case 15:
        f->weight[f->vertices * f->weights - 1] = NAN;
        break;
    case 16:
        f->shapes = -1;
        break;
    case 17:
        f->stiffness[5] = 0.0;
        break;
    case 18:
        f->stiffness[0] = NAN;
        break;
    case 19:
        f->stiffness[f->triangles - 1] = INFINITY;
        break;
    case 20:
        f->smoothness = -1e-9;
        break;
    case 21:
        f->smoothness = NAN;
        break;
    default:
        memset(f->shape, 0, sizeof f->shape); /* all vertices in one place */
    }
}

static void tug_create_model_refuses(void)
{
    for (int i = 0; i <= 22; i++) {
        fixture f;
        make_strip(&f);
        tug_mesh *mesh = make_mesh(&f);
        tug_model *model = RUBBISH;
        spoil_fixture(&f, i);
        spoil_error_text();
        CHECK(
            refused(tug_create_model_of(&f, mesh, &model), TUG_ERROR_ARGUMENT, "tug_create_model"));
        CHECK(model == NULL);
        tug_destroy_mesh(mesh);
    }
}

static void models_that_cannot_be_are_named(void)
{
    fixture f;
    make_strip(&f);
    f.row_vertices[1] = f.row_vertices[0];
    tug_mesh *mesh = make_mesh(&f);
    tug_model *model = RUBBISH;
    spoil_error_text();
    CHECK(tug_create_model_of(&f, mesh, &model) == TUG_ERROR_HANDLES);
    CHECK(strstr(tug_error_text(), "no two may hold the same place") != NULL);
    CHECK(model == NULL);
    tug_destroy_mesh(mesh);

    make_strip(&f);
    f.triangle[1] = f.triangle[0];
    mesh = make_mesh(&f);
    model = RUBBISH;
    spoil_error_text();
    CHECK(tug_create_model_of(&f, mesh, &model) == TUG_ERROR_MESH);
    CHECK(strstr(tug_error_text(), "no area") != NULL);
    CHECK(model == NULL);
    int32_t sample = -7;
    CHECK(tug_spread_vertices(mesh, 0, 1, &sample) == TUG_ERROR_MESH);
    CHECK(sample == -7);
    tug_destroy_mesh(mesh);
}

static void model_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f), *other = RUBBISH;
    tug_model_sizes sizes = {.struct_size = sizeof sizes, .vertices = -7};
    char blob[8] = "before";
    CHECK(REFUSED(tug_get_model_sizes, NULL, &sizes));
    CHECK(REFUSED(tug_get_model_sizes, model, NULL));
    sizes.struct_size = sizeof sizes + 4;
    CHECK(REFUSED(tug_get_model_sizes, model, &sizes));
    CHECK(sizes.vertices == -7 && sizes.struct_size == sizeof sizes + 4);
    CHECK(tug_model_blob_size(NULL) == 0);
    CHECK(REFUSED(tug_save_model, NULL, blob, sizeof blob));
    CHECK(REFUSED(tug_save_model, model, NULL, tug_model_blob_size(model)));
    CHECK(REFUSED(tug_save_model, model, blob, sizeof blob));
    CHECK(strcmp(blob, "before") == 0);
    CHECK(REFUSED(tug_load_model, NULL, 8, &other) && other == NULL);
    CHECK(REFUSED(tug_load_model, blob, sizeof blob, NULL));
    other = RUBBISH;
    CHECK(REFUSED_WITH(TUG_ERROR_BLOB, tug_load_model, blob, sizeof blob, &other));
    CHECK(other == NULL);
    tug_destroy_model(model);
}

static void spoil_options(tug_solver_options *options, int i)
{
    switch (i) {
    case 0:
        options->struct_size = 0;
        break;
    case 1:
        options->struct_size++;
        break;
    case 2:
        options->form = -1;
        break;
    case 3:
        options->form = 7;
        break;
    case 4:
        options->lambda = -0.1;
        break;
    case 5:
        options->lambda = NAN;
        break;
    case 6:
        options->lambda = INFINITY;
        break;
    case 7:
        options->prior = -1.0;
        break;
    case 8:
        options->prior = NAN;
        break;
    case 9:
        options->tolerance = 0.0;
        break;
    case 10:
        options->tolerance = NAN;
        break;
    case 11:
        options->scale = 1; /* in the steady form */
        break;
    default:
        options->max_rounds = -1;
    }
}

static void tug_create_solver_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f);
    tug_solver_options options;
    tug_solver *solver = RUBBISH;
    tug_default_solver_options(&options);
    CHECK(REFUSED(tug_create_solver, model, &options, NULL));
    CHECK(REFUSED(tug_create_solver, NULL, &options, &solver) && solver == NULL);
    solver = RUBBISH;
    CHECK(REFUSED(tug_create_solver, model, NULL, &solver) && solver == NULL);
    for (int i = 0; i <= 12; i++) {
        tug_default_solver_options(&options);
        spoil_options(&options, i);
        solver = RUBBISH;
        CHECK(REFUSED(tug_create_solver, model, &options, &solver));
        CHECK(solver == NULL);
    }
    tug_destroy_model(model);
}

static void solver_calls_refuse(void)
{
    fixture f;
    make_strip(&f);
    tug_model *model = make_model(&f);
    tug_solver_options options;
    tug_solver *solver, *warm;
    tug_solve_info info = {.struct_size = sizeof info, .rounds = -7};
    double targets[2 * MAX_WEIGHTS] = {0}, out[9 * MAX_VERTICES] = {-7.0};
    double blend[MAX_PAIRS] = {0}, rotations[4 * MAX_PAIRS] = {0};
    for (int32_t i = 0; i < f.groups * f.shapes; i++) {
        blend[i] = i % f.shapes == 0;
        rotations[4 * i] = rotations[4 * i + 3] = 1.0;
    }
    double firmness[MAX_WEIGHTS] = {0}, turned[4 * MAX_WEIGHTS] = {0};
    tug_default_solver_options(&options);
    CHECK(tug_create_solver(model, &options, &solver) == TUG_OK);
    options.warm_start = 1;
    CHECK(tug_create_solver(model, &options, &warm) == TUG_OK);
    for (int solved = 0; solved < 2; solved++) { /* before the first pose there is none to get */
        CHECK(solved || REFUSED(tug_get_positions, solver, out));
        CHECK(solved || REFUSED(tug_get_blend, solver, out));
        CHECK(solved || REFUSED(tug_get_costs, solver, out));
        CHECK(solved || REFUSED(tug_get_rotations, solver, out));
        CHECK(solved || REFUSED(tug_get_scale, solver, out));
        CHECK(REFUSED(tug_get_scale, NULL, out) && REFUSED(tug_get_scale, solver, NULL));
        CHECK(REFUSED(tug_get_positions, NULL, out) && REFUSED(tug_get_positions, solver, NULL));
        CHECK(REFUSED(tug_get_blend, NULL, out) && REFUSED(tug_get_blend, solver, NULL));
        CHECK(REFUSED(tug_get_costs, NULL, out) && REFUSED(tug_get_costs, solver, NULL));
        CHECK(REFUSED(tug_get_rotations, NULL, out) && REFUSED(tug_get_rotations, solver, NULL));
        CHECK(REFUSED(tug_solve, NULL, targets, &info) && REFUSED(tug_solve, solver, NULL, &info));
        targets[3] = NAN;
        CHECK(REFUSED(tug_solve, solver, targets, &info));
        targets[3] = 0.0;
        info.struct_size--;
        CHECK(REFUSED(tug_solve, solver, targets, &info));
        info.struct_size++;
        CHECK(REFUSED(tug_set_firmness, NULL, firmness));
        CHECK(REFUSED(tug_set_firmness, solver, NULL));
        firmness[1] = solved ? -1e-30 : NAN;
        CHECK(REFUSED(tug_set_firmness, solver, firmness));
        CHECK(strstr(tug_error_text(), "row 1") != NULL);
        CHECK(REFUSED(tug_set_orientations, NULL, targets, targets));
        CHECK(REFUSED(tug_set_orientations, solver, NULL, targets));
        CHECK(REFUSED(tug_set_orientations, solver, targets, NULL));
        CHECK(REFUSED(tug_set_orientations, solver, turned, firmness));
        firmness[1] = INFINITY;
        for (int i = 0; i < 4; i++) { /* sheared, mirrored, not finite, zero */
            const double spoiled[4][4] = {{1, 1e-3, 0, 1}, {1, 0, 0, -1}, {1, NAN, 0, 1}, {0}};
            memcpy(turned + 4, spoiled[i], sizeof spoiled[i]);
            CHECK(REFUSED(tug_set_orientations, solver, turned, firmness));
            CHECK(strstr(tug_error_text(), "row 1") != NULL);
        }
        CHECK(REFUSED(tug_pose, NULL, targets, blend, rotations));
        CHECK(REFUSED(tug_pose, solver, NULL, blend, rotations));
        CHECK(REFUSED(tug_pose, solver, targets, NULL, rotations));
        CHECK(REFUSED(tug_pose, solver, targets, blend, NULL));
        CHECK(REFUSED(tug_pose, solver, targets, out, rotations)); /* no blend */
        CHECK(REFUSED(tug_pose, solver, targets, blend, out));     /* no rotations */
        CHECK(REFUSED(tug_solve_from, NULL, targets, rotations, &info));
        CHECK(REFUSED(tug_solve_from, solver, NULL, rotations, &info));
        CHECK(REFUSED(tug_solve_from, solver, targets, NULL, &info));
        CHECK(REFUSED(tug_solve_from, solver, targets, out, &info)); /* no rotations */
        CHECK(strstr(tug_error_text(), "shape 0 in group 0") != NULL);
        CHECK(REFUSED(tug_solve_from, warm, targets, rotations, &info));
        targets[3] = INFINITY;
        CHECK(REFUSED(tug_solve_from, solver, targets, rotations, &info));
        CHECK(REFUSED(tug_pose, solver, targets, blend, rotations));
        targets[3] = 0.0;
        CHECK(out[0] == -7.0 && info.rounds == -7);
        CHECK(tug_solve(solver, targets, NULL) == TUG_OK);
    }
    tug_destroy_solver(warm);
    tug_destroy_solver(solver);
    tug_destroy_model(model);
}

static void tug_find_rotations_refuses(void)
{
    fixture f;
    make_strip(&f);
    tug_mesh *mesh = make_mesh(&f);
    double R[4 * MAX_PAIRS] = {-7.0};
    double *x = f.shape;
    int32_t *g = f.group, S = f.shapes, G = f.groups;
    CHECK(REFUSED(tug_find_rotations, NULL, x, S, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, NULL, S, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, NULL, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, NULL, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, x, NULL));
    CHECK(REFUSED(tug_find_rotations, mesh, x, 0, g, G, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, 0, x, R));
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G - 1, x, R));
    x[coordinate_count(&f) + 1] = NAN;
    CHECK(REFUSED(tug_find_rotations, mesh, x, S, g, G, x, R));
    x[coordinate_count(&f) + 1] = 0.0;
    x[1] = INFINITY;
    CHECK(REFUSED(tug_find_rotations, mesh, x + coordinate_count(&f), 1, g, G, x, R));
    CHECK(R[0] == -7.0);
    tug_destroy_mesh(mesh);
}

static void tug_minimise_blend_refuses(void)
{
    double Q[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, c[4] = {0}, d[4] = {0};
    double B[4] = {0.5, 0.5, 1.0, 0.0};
    tug_blend_info info = {.struct_size = sizeof info, .pivots = -7};
    CHECK(REFUSED(tug_minimise_blend, 2, 2, NULL, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, NULL, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, NULL, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, NULL, &info));
    CHECK(REFUSED(tug_minimise_blend, 0, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 0, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, -2, -2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, -0.5, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, NAN, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, INFINITY, 0, B, &info));
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, NAN, d, 0.5, 0, B, &info));
    double *coefficients[] = {Q + 15, c + 3, d + 3};
    for (int i = 0; i < 3; i++) {
        *coefficients[i] = NAN;
        CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
        *coefficients[i] = 1.0;
    }
    const double starts[][4] = {
        {0.5, 0.5, 1.0, 0.1}, {1.5, -0.5, 1.0, 0.0}, {NAN, 0.5, 1.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    for (int i = 0; i < 4; i++) {
        double bad[4];
        memcpy(bad, starts[i], sizeof bad);
        CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, bad, &info));
        CHECK(memcmp(bad, starts[i], sizeof bad) == 0);
    }
    info.struct_size = 1;
    CHECK(REFUSED(tug_minimise_blend, 2, 2, Q, c, 1.0, d, 0.5, 0, B, &info));
    CHECK(B[0] == 0.5 && B[2] == 1.0 && info.pivots == -7);
}

static void destroying_nothing_is_allowed(void)
{
    long live = live_allocations();
    tug_destroy_mesh(NULL);
    tug_destroy_model(NULL);
    tug_destroy_solver(NULL);
    tug_destroy_points(NULL);
    CHECK(live_allocations() == live);
}

static void library_tells_its_version(void)
{
    int major, minor, patch;
    CHECK(tug_abi() == TUG_ABI);
    CHECK(sscanf(tug_version(), "%d.%d.%d", &major, &minor, &patch) == 3);
}

int main(int argc, char **argv)
{
    RUN(tug_create_model_refuses_null);
    RUN(tug_create_model_refuses);
    RUN(models_that_cannot_be_are_named);
    RUN(model_calls_refuse);
    RUN(tug_create_solver_refuses);
    RUN(solver_calls_refuse);
    RUN(tug_find_rotations_refuses);
    RUN(tug_minimise_blend_refuses);
    RUN(destroying_nothing_is_allowed);
    RUN(library_tells_its_version);
    return TEST_RESULT;
}
