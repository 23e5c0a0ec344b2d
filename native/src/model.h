/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The constants of every solve. All of them are doubles in one block, `data`, whose layout follows
 * from the sizes: a model is saved and loaded as sizes and block.
 *
 * Lengths are in units of the rest shape's diagonal. Shapes are turned to the rest shape group by
 * group at bind time: where group g of shape s stands for rotation R in the papers, it is R Q_gs
 * here, and R is the identity for a pose that agrees with the rest shape's directions. */
#ifndef TUG_MODEL_H
#define TUG_MODEL_H

#include "dictionary.h"
#include "mesh.h"
#include "reduction.h"

typedef struct model_header {
    int32_t vertices, dimension, shapes, weights, rows, groups;
    int32_t rank;
    int32_t reserved; /* zero: keeps the doubles aligned without padding */
    double unit;      /* the rest shape's diagonal */
} model_header;

/* One shape alone (the single-shape problems of section 5.2): its dictionary has k + 1 columns a
 * weight function. */
typedef struct shape_model {
    reduction energy; /* one rotation per group; C holds H */
    double *L;        /* #G by b_s by b_s: each group's own quadratic form */
    double *rows;     /* #H by k: the constraint rows' values in this shape */
} shape_model;

struct tug_model {
    model_header header;
    size_t data_count;
    double *data;

    dictionary dictionary;
    double *shape_columns, *weight_columns, *middles;
    double *constant; /* #W: sum_h constant_h W_h = 1 */

    /* The joint problem: V has a block for each pair (g, s). `energy.C` is laid out in blocks,
     * #G by #G by k by k by #S by #S, the order in which blends and rotations contract it. */
    reduction energy;
    double *align;     /* Q_gs: #G by #S by k by k */
    double *H;         /* #G by #S k by #S k: (A 19), aligned */
    double *stiffness; /* #G: tr(H_g00) / k, the weight of the rotation prior */
    double *nearness;  /* #G by #H: how much a row says about a group's rotation */

    shape_model *shape; /* #S */
};

tug_status model_create(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                        const double *weights, int32_t weight_count, const tug_rows *rows,
                        const int32_t *groups, int32_t group_count, const double *stiffness,
                        const progress_range *range, tug_model **out);
void model_destroy(tug_model *model);

/* The group that a row says most about. */
int32_t nearest_group(const tug_model *model, int32_t row);

/* A model of these sizes with its data zero. */
tug_status model_allocate(const model_header *header, tug_model **out);

size_t model_blob_size(const tug_model *model);
tug_status model_save(const tug_model *model, void *blob, size_t size);
tug_status model_load(const void *blob, size_t size, tug_model **out);

#endif
