/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Models that differ in their rows alone: the same as bound anew, and with soft rows (F 5), as many
 * as one likes. */
#include "bench.h"
#include "memory.h"
#include "model/model.h"
#include "test.h"

enum { MANY = 60 };

/* Rows that pin one vertex each, spread over the numbers. */
typedef struct many_rows {
    int32_t starts[MANY + 1], vertices[MANY];
    double values[MANY], firmness[MANY], targets[3 * MANY];
    tug_rows rows;
} many_rows;

static void make_many(const bench *b, double firmness, many_rows *m)
{
    for (int32_t r = 0; r < MANY; r++) {
        m->starts[r + 1] = r + 1;
        m->vertices[r] = r * b->f.vertices / MANY;
        m->values[r] = 1.0;
        m->firmness[r] = firmness;
    }
    m->starts[0] = 0;
    m->rows = (tug_rows){m->starts, m->vertices, m->values, MANY};
}

static void aim_at(const bench *b, const double *positions, many_rows *m)
{
    int32_t k = b->f.dimension;
    for (int32_t i = 0; i < MANY * k; i++) {
        m->targets[i] = positions[m->vertices[i / k] * k + i % k];
    }
}

/* Let the bench work on another model of the same fixture. */
static void move_to(bench *b, tug_model *model)
{
    tug_destroy_solver(b->solver);
    tug_destroy_model(b->model);
    b->solver = NULL;
    b->model = model;
    b->info.struct_size = sizeof b->info;
}

static tug_rows rows_of(const fixture *f)
{
    return (tug_rows){f->row_starts, f->row_vertices, f->row_values, f->rows};
}

/* There, by way of other rows, and back. */
static void rows_can_be_changed_and_changed_back(void)
{
    uint64_t random = 3;
    for (int i = 0; i < 3 * FORM_COUNT * 2; i++) {
        bench b;
        many_rows m;
        double pose[MAX_COORDINATES];
        tug_model *other, *back;
        make_numbered(&b.f, i % 3);
        b.f.smoothness = i % 2 ? 1e-3 : 0.0;
        vary_stiffness(&b.f, &random);
        prepare(&b, FORMS[i / 3 % FORM_COUNT]);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        memcpy(pose, b.positions, sizeof pose);
        tug_rows rows = rows_of(&b.f);
        make_many(&b, 2.0, &m);
        CHECK(tug_change_rows(b.model, &m.rows, m.firmness, &other) == TUG_OK);
        CHECK(tug_change_rows(other, &rows, NULL, &back) == TUG_OK);
        tug_destroy_model(other);
        move_to(&b, back);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, b.positions, pose) <= 1e-6);
        clear(&b);
    }
}

/* A handle taken away and one put elsewhere: as bound with these. */
static void changed_rows_are_those_of_a_new_model(void)
{
    uint64_t random = 4;
    for (int i = 0; i < 3; i++) {
        bench b, fresh;
        make_numbered(&b.f, i);
        prepare(&b, TUG_FORM_STEADY);
        fresh.f = b.f;
        fresh.f.rows--;
        fresh.f.row_vertices[0] += 3;
        prepare(&fresh, TUG_FORM_STEADY);
        mix_targets(&fresh.f, &random, 0.05, fresh.targets);
        tug_rows rows = rows_of(&fresh.f);
        tug_model *changed;
        CHECK(tug_change_rows(b.model, &rows, NULL, &changed) == TUG_OK);
        move_to(&b, changed);
        memcpy(b.targets, fresh.targets, sizeof b.targets);
        CHECK(solve(&b) && solve(&fresh));
        CHECK(pose_distance(&b.f, b.positions, fresh.positions) <= 1e-6);
        CHECK_NEAR(b.info.objective / fresh.info.objective, 1.0, 1e-6);
        clear(&b);
        clear(&fresh);
    }
}

/* Soft rows of the model and springs of the solver are the same thing. */
static void soft_rows_are_springs(void)
{
    uint64_t random = 5;
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        double pose[MAX_COORDINATES], springs[MAX_WEIGHTS], firmness[MAX_WEIGHTS];
        tug_model *soft;
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3]);
        b.options.max_rounds = 2000;
        mix_targets(&b.f, &random, 0.05, b.targets);
        for (int32_t r = 0; r < b.f.rows; r++) {
            firmness[r] = random_between(&random, 0.1, 2.0);
            springs[r] = firmness[r] / b.model->energy.FLF[r * (b.f.rows + 1)];
        }
        restart(&b);
        CHECK(tug_set_firmness(b.solver, springs) == TUG_OK);
        CHECK(solve(&b));
        double energy = b.info.energy, objective = b.info.objective;
        memcpy(pose, b.positions, sizeof pose);
        tug_rows rows = rows_of(&b.f);
        CHECK(tug_change_rows(b.model, &rows, firmness, &soft) == TUG_OK);
        move_to(&b, soft);
        CHECK(solve(&b));
        CHECK(pose_distance(&b.f, b.positions, pose) <= 1e-4);
        CHECK_NEAR(b.info.objective / objective, 1.0, 1e-4);
        CHECK_NEAR(b.info.energy / energy, 1.0, 1e-3);
        clear(&b);
    }
}

static void firm_rows_are_pins(void)
{
    uint64_t random = 6;
    for (int i = 0; i < 3; i++) {
        bench b, soft;
        double firmness[MAX_WEIGHTS], before = INFINITY;
        make_numbered(&b.f, i);
        prepare(&b, TUG_FORM_STEADY);
        mix_targets(&b.f, &random, 0.05, b.targets);
        CHECK(solve(&b));
        tug_rows rows = rows_of(&b.f);
        for (double beta = 1.0; beta <= 1e3; beta *= 10.0) {
            soft = b;
            soft.solver = NULL;
            for (int32_t r = 0; r < b.f.rows; r++) {
                firmness[r] = beta;
            }
            CHECK(tug_change_rows(b.model, &rows, firmness, &soft.model) == TUG_OK);
            CHECK(solve(&soft));
            double distance = pose_distance(&b.f, b.positions, soft.positions);
            CHECK(distance < 0.3 * before);
            before = distance;
            clear(&soft);
        }
        CHECK(before <= 1e-4);
        clear(&b);
    }
}

/* Far more rows than unknowns, some of them twice. */
static void many_rows_find_examples(void)
{
    for (int i = 0; i < 3 * FORM_COUNT; i++) {
        bench b;
        many_rows m;
        tug_model *soft;
        make_numbered(&b.f, i % 3);
        prepare(&b, FORMS[i / 3]);
        make_many(&b, 3.0, &m);
        m.vertices[1] = m.vertices[0];
        CHECK(tug_change_rows(b.model, &m.rows, m.firmness, &soft) == TUG_OK);
        move_to(&b, soft);
        restart(&b);
        for (int32_t s = 0; s < b.f.shapes; s++) {
            aim_at(&b, shape_of(&b.f, s), &m);
            CHECK(tug_solve(b.solver, m.targets, &b.info) == TUG_OK);
            CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
            CHECK(b.info.converged);
            CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, s)) <= 1e-6);
        }
        clear(&b);
    }
}

/* Targets with noise: the pose lies nearer to what they are of than they do. */
static void many_rows_even_out_noise(void)
{
    uint64_t random = 7;
    bench b;
    many_rows m;
    tug_model *soft;
    make_tube(&b.f, 1);
    prepare(&b, TUG_FORM_MINIMAL);
    make_many(&b, 1.0, &m);
    CHECK(tug_change_rows(b.model, &m.rows, m.firmness, &soft) == TUG_OK);
    move_to(&b, soft);
    restart(&b);
    aim_at(&b, shape_of(&b.f, 1), &m);
    double noise = 0.02 * diagonal_of(&b.f);
    for (int32_t c = 0; c < 3 * MANY; c++) {
        m.targets[c] += random_between(&random, -noise, noise);
    }
    CHECK(tug_solve(b.solver, m.targets, &b.info) == TUG_OK);
    CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
    CHECK(pose_distance(&b.f, b.positions, shape_of(&b.f, 1)) <= 0.02);
    CHECK(b.info.energy > 0.0 && b.info.energy < b.info.objective);
    clear(&b);
}

static void soft_models_are_saved(void)
{
    bench b;
    many_rows m;
    tug_model *soft, *loaded;
    static char blob[1 << 22];
    double pose[MAX_COORDINATES];
    make_strip(&b.f);
    prepare(&b, TUG_FORM_STEADY);
    make_many(&b, 1.0, &m);
    CHECK(tug_change_rows(b.model, &m.rows, m.firmness, &soft) == TUG_OK);
    move_to(&b, soft);
    restart(&b);
    aim_at(&b, shape_of(&b.f, 2), &m);
    m.targets[0] += 0.1;
    CHECK(tug_solve(b.solver, m.targets, NULL) == TUG_OK);
    CHECK(tug_get_positions(b.solver, pose) == TUG_OK);
    CHECK(tug_model_blob_size(soft) <= sizeof blob);
    CHECK(tug_save_model(soft, blob, sizeof blob) == TUG_OK);
    CHECK(tug_load_model(blob, tug_model_blob_size(soft), &loaded) == TUG_OK);
    move_to(&b, loaded);
    restart(&b);
    CHECK(tug_solve(b.solver, m.targets, NULL) == TUG_OK);
    CHECK(tug_get_positions(b.solver, b.positions) == TUG_OK);
    CHECK(memcmp(pose, b.positions, (size_t)coordinate_count(&b.f) * sizeof *pose) == 0);
    clear(&b);
}

static void rows_that_cannot_be_are_refused(void)
{
    bench b;
    many_rows m;
    make_strip(&b.f);
    prepare(&b, TUG_FORM_STEADY);
    for (int i = 0; i < 8; i++) {
        tug_model *out = b.model;
        make_many(&b, 1.0, &m);
        const double spoiled[] = {0.0, -1.0, NAN, 1001.0};
        if (i < 4) {
            m.firmness[7] = spoiled[i];
        } else if (i == 4) {
            m.rows.count = 0;
        } else if (i == 5) {
            m.vertices[7] = b.f.vertices;
        } else if (i == 6) {
            m.values[7] = INFINITY;
        } else {
            m.rows.values = NULL;
        }
        CHECK(tug_change_rows(b.model, &m.rows, m.firmness, &out) == TUG_ERROR_ARGUMENT);
        CHECK(out == NULL && strstr(tug_error_text(), "tug_change_rows") != NULL);
        CHECK(i == 4 || i == 7 || strstr(tug_error_text(), "row 7") != NULL);
    }
    make_many(&b, 1.0, &m);
    tug_model *out = b.model;
    CHECK(tug_change_rows(b.model, &m.rows, NULL, &out) == TUG_ERROR_HANDLES && out == NULL);
    CHECK(tug_change_rows(NULL, &m.rows, NULL, &out) == TUG_ERROR_ARGUMENT);
    CHECK(tug_change_rows(b.model, NULL, NULL, &out) == TUG_ERROR_ARGUMENT);
    CHECK(tug_change_rows(b.model, &m.rows, NULL, NULL) == TUG_ERROR_ARGUMENT);
    clear(&b);
}

int main(int argc, char **argv)
{
    RUN(rows_can_be_changed_and_changed_back);
    RUN(changed_rows_are_those_of_a_new_model);
    RUN(soft_rows_are_springs);
    RUN(firm_rows_are_pins);
    RUN(many_rows_find_examples);
    RUN(many_rows_even_out_noise);
    RUN(soft_models_are_saved);
    RUN(rows_that_cannot_be_are_refused);
    return TEST_RESULT;
}
