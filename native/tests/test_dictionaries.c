/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits in a dictionary and its reduction, against the dictionary's columns written out. */
#include "fixture.h"
#include "test.h"

enum { most_atoms = MAX_WEIGHTS * (1 + 3 * MAX_SHAPES) };

static int32_t block_of(const fixture *f)
{
    return 1 + f->shapes * f->dimension;
}

/* positions = D T */
static void pose(const fixture *f, const double *T, double *positions)
{
    int32_t k = f->dimension, atoms = f->weights * block_of(f);
    memset(positions, 0, (size_t)coordinate_count(f) * sizeof *positions);
    for (int32_t v = 0; v < f->vertices; v++) {
        for (int32_t b = 0; b < atoms; b++) {
            double value = dictionary_column(f, b, v);
            for (int32_t a = 0; a < k; a++) {
                positions[v * k + a] += value * T[b * k + a];
            }
        }
    }
}

/* Any positions, and two thirds of the coordinates' atoms: what the fit leaves is orthogonal to
 * each atom that it may use. */
static void a_fit_leaves_what_no_atom_has(void)
{
    uint64_t state = 17;
    for (int form = 0; form < 2; form++) {
        fixture f;
        form == 0 ? make_strip(&f) : make_tube(&f, 1);
        int32_t k = f.dimension, all = f.weights * block_of(&f), count = 0, atoms[most_atoms];
        double positions[MAX_COORDINATES], fitted[MAX_COORDINATES], again[MAX_COORDINATES];
        double T[3 * most_atoms];
        for (int32_t b = 0; b < all; b++) {
            if (b % block_of(&f) == 0 || b % 3 > 0) {
                atoms[count++] = b;
            }
        }
        for (int32_t i = 0; i < coordinate_count(&f); i++) {
            positions[i] = random_between(&state, -1.0, 1.0);
        }
        tug_dictionary D = dictionary_of(&f);
        CHECK(tug_fit_dictionary(&D, atoms, count, positions, NULL, NULL, T, fitted) == TUG_OK);
        pose(&f, T, again);
        CHECK(pose_distance(&f, fitted, again) < 1e-10);
        for (int32_t b = 0, next = 0; b < all; b++) {
            int used = next < count && atoms[next] == b;
            next += used;
            for (int32_t a = 0; a < k; a++) {
                double product = 0.0, square = 0.0;
                for (int32_t v = 0; v < f.vertices; v++) {
                    double value = dictionary_column(&f, b, v);
                    product += value * (positions[v * k + a] - fitted[v * k + a]);
                    square += value * value;
                }
                CHECK(!used || fabs(product) < 1e-8 * sqrt(square));
                CHECK(used || T[b * k + a] == 0.0);
            }
        }
    }
}

/* Far from the origin too, where a coordinate times a weight is nearly the weight. */
static void a_pose_of_the_dictionary_is_met(void)
{
    uint64_t state = 23;
    const double offsets[] = {0.0, 1e4};
    for (int form = 0; form < 4; form++) {
        fixture f;
        form % 2 == 0 ? make_strip(&f) : make_tube(&f, 0);
        rescale(&f, 3.0, offsets[form / 2]);
        double T[3 * most_atoms], positions[MAX_COORDINATES], fitted[MAX_COORDINATES];
        for (int32_t i = 0; i < f.weights * block_of(&f) * f.dimension; i++) {
            T[i] = random_between(&state, -1.0, 1.0);
        }
        pose(&f, T, positions);
        tug_dictionary D = dictionary_of(&f);
        CHECK(tug_fit_dictionary(&D, NULL, 0, positions, NULL, NULL, NULL, fitted) == TUG_OK);
        CHECK(pose_distance(&f, positions, fitted) < 1e-9 * (1.0 + offsets[form / 2]));
        for (int32_t s = 0; s < f.shapes; s++) { /* the weights' sum is one */
            CHECK(tug_fit_dictionary(&D, NULL, 0, shape_of(&f, s), NULL, NULL, NULL, fitted) ==
                  TUG_OK);
            CHECK(pose_distance(&f, shape_of(&f, s), fitted) < 1e-9);
        }
    }
}

static void weights_of_nothing_have_no_pose(void)
{
    fixture f;
    double T[3 * most_atoms], fitted[MAX_COORDINATES];
    make_strip(&f);
    memset(f.weight, 0, sizeof f.weight);
    tug_dictionary D = dictionary_of(&f);
    CHECK(tug_fit_dictionary(&D, NULL, 0, f.shape, NULL, NULL, T, fitted) == TUG_OK);
    for (int32_t i = 0; i < coordinate_count(&f); i++) {
        CHECK(fitted[i] == 0.0);
    }
}

/* A dictionary of the constant alone, into one of more weights, whose sum is one, and back. */
static void a_pose_changes_its_dictionary(void)
{
    uint64_t state = 31;
    fixture f, small;
    double T[3 * most_atoms], positions[MAX_COORDINATES], fitted[MAX_COORDINATES];
    make_tube(&f, 1);
    small = f;
    small.weights = 1;
    for (int32_t v = 0; v < f.vertices; v++) {
        small.weight[v] = 1.0;
    }
    for (int i = 0; i < 3 * most_atoms; i++) {
        T[i] = random_between(&state, -1.0, 1.0);
    }
    pose(&small, T, positions);
    tug_dictionary rich = dictionary_of(&f), poor = dictionary_of(&small);
    CHECK(tug_fit_dictionary(&rich, NULL, 0, positions, NULL, NULL, T, fitted) == TUG_OK);
    CHECK(pose_distance(&f, positions, fitted) < 1e-9);
    pose(&f, T, positions);
    CHECK(tug_fit_dictionary(&poor, NULL, 0, positions, NULL, NULL, NULL, positions) == TUG_OK);
    CHECK(pose_distance(&f, positions, fitted) < 1e-9);
}

/* Sum over all atoms of what they have besides a multiple of the nearest chosen one; coordinates
 * are taken without their part along their weight function. */
static double cost_of(const fixture *f, const int32_t *atoms, int32_t count)
{
    static double column[most_atoms][MAX_VERTICES];
    int32_t block = block_of(f), all = f->weights * block;
    double square[most_atoms] = {0}, sum = 0.0;
    for (int32_t b = 0; b < all; b++) {
        const double *weight = column[b / block * block];
        double along = 0.0;
        for (int32_t v = 0; v < f->vertices; v++) {
            column[b][v] = dictionary_column(f, b, v) / (b % block == 0 ? 1.0 : diagonal_of(f));
            along += column[b][v] * weight[v];
        }
        for (int32_t v = 0; v < f->vertices; v++) {
            column[b][v] -= b % block == 0 ? 0.0 : along / square[b / block * block] * weight[v];
            square[b] += column[b][v] * column[b][v];
        }
    }
    for (int32_t b = 0; b < all; b++) {
        double least = INFINITY;
        for (int32_t i = 0; i < count; i++) {
            double product = 0.0;
            for (int32_t v = 0; v < f->vertices; v++) {
                product += column[b][v] * column[atoms[i]][v];
            }
            double left = square[b] - product * product / square[atoms[i]];
            least = fmin(least, left);
        }
        sum += least;
    }
    return sum;
}

static void medoids_stand_for_all_atoms_better_than_chance(void)
{
    uint64_t state = 41;
    fixture f;
    int32_t atoms[most_atoms], others[most_atoms], wanted = 16;
    make_strip(&f);
    int32_t block = block_of(&f), all = f.weights * block;
    tug_dictionary D = dictionary_of(&f);
    CHECK(tug_reduce_dictionary(&D, wanted, NULL, NULL, atoms) == TUG_OK);
    for (int32_t i = 0; i < wanted; i++) {
        CHECK(atoms[i] >= 0 && atoms[i] < all && (i == 0 || atoms[i] > atoms[i - 1]));
    }
    double cost = cost_of(&f, atoms, wanted);
    for (int trial = 0; trial < 100; trial++) {
        int32_t count = 0;
        for (int32_t h = 0; h < f.weights; h++) {
            others[count++] = h * block;
        }
        while (count < wanted) {
            others[count++] = (int32_t)random_between(&state, 0.0, all - 1e-9);
        }
        CHECK(cost <= cost_of(&f, others, wanted));
    }
}

/* One of them moved to any other place is no better than what was found, within a cluster. */
static void one_medoid_for_each_weight_is_the_best_one(void)
{
    fixture f;
    int32_t atoms[most_atoms], moved[most_atoms];
    make_strip(&f);
    f.weights = 1;
    for (int32_t v = 0; v < f.vertices; v++) {
        f.weight[v] = 1.0;
    }
    tug_dictionary D = dictionary_of(&f);
    CHECK(tug_reduce_dictionary(&D, 2, NULL, NULL, atoms) == TUG_OK && atoms[0] == 0);
    double cost = cost_of(&f, atoms, 2);
    for (int32_t b = 1; b < block_of(&f); b++) {
        moved[0] = 0, moved[1] = b;
        CHECK(cost <= cost_of(&f, moved, 2) + 1e-12);
    }
}

/* A shape that is there twice is kept once, and nothing is lost. */
static void copies_are_dropped_first(void)
{
    fixture f;
    double fitted[MAX_COORDINATES];
    int32_t atoms[most_atoms], kept[most_atoms] = {0};
    make_strip(&f);
    int32_t wanted = f.weights * block_of(&f);
    duplicate_shape(&f, 1);
    int32_t block = block_of(&f), k = f.dimension;
    tug_dictionary D = dictionary_of(&f);
    CHECK(tug_reduce_dictionary(&D, wanted, NULL, NULL, atoms) == TUG_OK);
    for (int32_t i = 0; i < wanted; i++) {
        kept[atoms[i]] = 1;
    }
    for (int32_t h = 0; h < f.weights; h++) {
        CHECK(kept[h * block]);
        for (int32_t c = 0; c < k; c++) {
            int32_t first = h * block + 1 + k + c, copy = h * block + 1 + 3 * k + c;
            CHECK(kept[first] + kept[copy] == 1);
        }
    }
    CHECK(tug_fit_dictionary(&D, atoms, wanted, shape_of(&f, 1), NULL, NULL, NULL, fitted) ==
          TUG_OK);
    CHECK(pose_distance(&f, fitted, shape_of(&f, 1)) < 1e-9);
}

static void all_atoms_may_stay(void)
{
    fixture f;
    int32_t atoms[most_atoms];
    make_tube(&f, 0);
    int32_t all = f.weights * block_of(&f);
    tug_dictionary D = dictionary_of(&f);
    CHECK(tug_reduce_dictionary(&D, all, NULL, NULL, atoms) == TUG_OK);
    for (int32_t b = 0; b < all; b++) {
        CHECK(atoms[b] == b);
    }
    CHECK(tug_reduce_dictionary(&D, f.weights, NULL, NULL, atoms) == TUG_OK);
    for (int32_t h = 0; h < f.weights; h++) {
        CHECK(atoms[h] == h * block_of(&f));
    }
}

int main(int argc, char **argv)
{
    RUN(a_fit_leaves_what_no_atom_has);
    RUN(a_pose_of_the_dictionary_is_met);
    RUN(weights_of_nothing_have_no_pose);
    RUN(a_pose_changes_its_dictionary);
    RUN(medoids_stand_for_all_atoms_better_than_chance);
    RUN(one_medoid_for_each_weight_is_the_best_one);
    RUN(copies_are_dropped_first);
    RUN(all_atoms_may_stay);
    return TEST_RESULT;
}
