/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Generated meshes with shapes, weights, constraint rows and groups, and the energies of the papers
 * written straight from their sums over edges: what the tests hold the library against. */
#ifndef TUG_FIXTURE_H
#define TUG_FIXTURE_H

#include "tug.h"

enum {
    MAX_VERTICES = 256,
    MAX_TRIANGLES = 512,
    MAX_SHAPES = 5,
    MAX_WEIGHTS = 5,
    MAX_GROUPS = 8,
    MAX_COORDINATES = 3 * MAX_VERTICES,
    MAX_PAIRS = MAX_GROUPS * MAX_SHAPES
};

/* Everything tug_create_model asks for. Shape 0 is the mesh. */
typedef struct fixture {
    int32_t dimension, vertices, triangles, shapes, weights, rows, groups;
    double shape[MAX_SHAPES * MAX_COORDINATES]; /* #S by #V by k */
    double weight[MAX_WEIGHTS * MAX_VERTICES];  /* #V by #W */
    int32_t triangle[3 * MAX_TRIANGLES];        /* #F by 3 */
    int32_t group[MAX_TRIANGLES];               /* #F */
    double stiffness[MAX_TRIANGLES];            /* #F, all one at first */
    double smoothness;                          /* zero at first */
    int32_t row_starts[MAX_WEIGHTS + 1];
    int32_t row_vertices[3 * MAX_WEIGHTS];
    double row_values[3 * MAX_WEIGHTS];
} fixture;

/* A tube in space: rest, bent, bulged and stretched, twisted; 4 handles, 8 groups. */
void make_tube(fixture *f, int closed);

/* A flat strip in the plane: rest, bent, stretched with waves; 3 handles, 6 groups. */
void make_strip(fixture *f);

/* The strip in space: every third coordinate is zero. */
void make_flat(fixture *f);

/* The last handle keeps its weight function and loses its row. */
void free_last_handle(fixture *f);

/* Weights that overlap more: their square roots, divided by their sum. Columns of the dictionary
 * then nearly depend on each other. */
void broaden_weights(fixture *f);

/* Triangles of stiffness 0.1 to 10. */
void vary_stiffness(fixture *f, uint64_t *state);

/* One more shape, a copy of shape s. */
void duplicate_shape(fixture *f, int32_t s);

/* Every coordinate of every shape times `factor`, and then moved by `offset`. */
void rescale(fixture *f, double factor, double offset);

const double *shape_of(const fixture *f, int32_t s);
int32_t coordinate_count(const fixture *f);
double diagonal_of(const fixture *f);

/* NULL where it fails. */
tug_mesh *make_mesh(const fixture *f);
tug_model *make_model(const fixture *f);

/* Borrows the fixture's shapes and weights. */
tug_dictionary dictionary_of(const fixture *f);

/* The constraint rows' values at some positions: #H by k. */
void apply_rows(const fixture *f, const double *positions, double *values);

/* A mixture of the shapes' handle positions, one mixture for each handle, plus noise in parts of
 * the diagonal. */
void mix_targets(const fixture *f, uint64_t *state, double noise, double *targets);

/* Column `column` of the papers' dictionary at a vertex: W_h, or W_h times a coordinate of a shape.
 */
double dictionary_column(const fixture *f, int32_t column, int32_t vertex);

/* Half the cotangent of the rest shape's angle at corner i % 3 of triangle i / 3, times the
 * triangle's stiffness: the weight of the edge opposite of it. */
double edge_weight(const fixture *f, int32_t corner);

/* M_g = sum of half cotangents times p_e q_e^T, from the edges of shape s to those of a pose: #G by
 * k by k. */
void find_moments(const fixture *f, int32_t s, const double *positions, double *M);

/* E_g of (A 7) and (A 9) without the one half, for every group: the sum over the edges of its
 * triangles of half cotangent times |q_e - sum_s B_gs R_gs p_se|^2. */
void measure_groups(const fixture *f, const double *positions, const double *blend,
                    const double *rotations, double *energies);

/* E_d of (A 9): half their sum. */
double measure_energy(const fixture *f, const double *positions, const double *blend,
                      const double *rotations);

/* Largest distance of a vertex, in parts of the diagonal. */
double pose_distance(const fixture *f, const double *positions, const double *others);

/* Random numbers: the state is any number but zero. */
double random_between(uint64_t *state, double low, double high);
void random_rotation(uint64_t *state, int32_t k, double *R);

/* #G rows of #S weights that sum to one. */
void random_blend(uint64_t *state, int32_t groups, int32_t shapes, double *blend);

/* Each point x becomes R x + offset. */
void move_points(int32_t k, const double *R, const double *offset, int32_t count, double *points);

/* x <- A^-1 x by elimination with row exchanges; A n by n is lost, x n by columns. */
void solve_dense(double *A, int32_t n, double *x, int32_t columns);

#endif
