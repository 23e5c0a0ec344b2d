/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Positions against the rows of the dictionary, on meshes of every size around that of a tile. */
#include "fixture.h"
#include "solver/solver.h"
#include "test.h"

enum { MOST = 40, SHAPES = 2, WEIGHTS = 3, MOST_COLUMNS = WEIGHTS * (1 + 3 * SHAPES) };

static void random_numbers(uint64_t *state, int32_t count, double *values)
{
    for (int32_t i = 0; i < count; i++) {
        values[i] = random_between(state, -1.0, 1.0);
    }
}

static void positions_are_rows_of_the_dictionary_times_transforms(void)
{
    uint64_t state = 1;
    for (int32_t n = 1; n <= MOST; n++) {
        for (int32_t k = 2; k <= 3; k++) {
            double shapes[SHAPES * 3 * MOST], weights[WEIGHTS * MOST], T[3 * MOST_COLUMNS];
            double middles[WEIGHTS * SHAPES * 3] = {0.0}, positions[3 * MOST];
            random_numbers(&state, SHAPES * k * n, shapes);
            random_numbers(&state, WEIGHTS * n, weights);
            random_numbers(&state, 3 * MOST_COLUMNS, T);
            tug_model model = {.header = {.vertices = n, .dimension = k, .unit = 2.0},
                               .dictionary = {n, k, SHAPES, WEIGHTS, shapes, weights, middles}};
            tug_solver solver = {.model = &model, .placed_T = T, .middle = {1.0, 2.0, 3.0}};
            find_positions(&solver, positions);
            for (int32_t i = 0; i < n * k; i++) {
                double row[MOST_COLUMNS] = {0.0}, sum = 0.0;
                add_dictionary_row(&model.dictionary, i / k, 1.0, row);
                for (int32_t c = 0; c < dictionary_columns(&model.dictionary); c++) {
                    sum += row[c] * T[c * k + i % k];
                }
                CHECK_NEAR(positions[i], 1.0 + i % k + 2.0 * sum, 1e-14);
            }
        }
    }
}

int main(int argc, char **argv)
{
    RUN(positions_are_rows_of_the_dictionary_times_transforms);
    return TEST_RESULT;
}
