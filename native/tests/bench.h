/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A solver on a fixture, and what may be asked of a pose without trusting the solver. */
#ifndef TUG_BENCH_H
#define TUG_BENCH_H

#include "fixture.h"

/* The forms that find every example again, those with rotations first, and the settings of
 * choose_settings. */
enum { FORM_COUNT = 5, TURNING_FORM_COUNT = 4, SETTING_COUNT = 20 };
extern const int32_t FORMS[FORM_COUNT];

/* A solver and all that it says about its last pose. */
typedef struct bench {
    fixture f;
    tug_model *model;
    tug_solver *solver;
    tug_solver_options options;
    tug_solve_info info;
    double targets[3 * MAX_WEIGHTS];
    double positions[MAX_COORDINATES], blend[MAX_PAIRS], costs[MAX_PAIRS], rotations[9 * MAX_PAIRS];
} bench;

/* Fixture number i: the strip, the tube, the closed tube. */
void make_numbered(fixture *f, int i);

/* With the fixture in place: its model, and the default options of a form. */
void prepare(bench *b, int32_t form);
void clear(bench *b);

/* Settings number i: of form, root, one blend or many. */
void choose_settings(bench *b, int i);

/* Whether the form has costs. */
int has_costs(int32_t form);

/* A new solver with the options as they are now. */
void restart(bench *b);

/* Solve for the targets and ask for everything; 0 where a call fails. Costs are zero in the forms
 * that have none. */
int solve(bench *b);

/* Whether the handles of every shape give that shape, to within a part of the diagonal, in sound
 * and converged solves. */
int finds_examples(bench *b, double tolerance);

/* Whether the rotations are rotations, and blends and costs are not negative; rows sum to one. */
int is_sound(const bench *b);

/* Largest distance of a handle from its target in one coordinate, in parts of the diagonal. */
double constraint_error(const bench *b);

/* E_d of the pose, from the edges. */
double energy_of(const bench *b);

/* lambda times what the blend costs: nothing in the minimal form. A single blend pays for whole
 * shapes. */
double price_of(const bench *b);

#endif
