/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The constants of every solve: whole numbers in one block, `indices`, and doubles in another,
 * `data`, whose layouts follow from the sizes. A model is saved and loaded as sizes and blocks.
 *
 * Lengths are in units of the rest shape's diagonal. Shapes are turned to the rest shape group by
 * group at bind time: where group g of shape s stands for rotation R in the papers, it is R Q_gs
 * here, and R is the identity for a pose that agrees with the rest shape's directions. */
#ifndef TUG_MODEL_H
#define TUG_MODEL_H

#include "mesh/mesh.h"
#include "model/dictionary.h"
#include "model/reduction.h"

typedef struct model_header {
    int32_t vertices, dimension, shapes, weights, rows, groups;
    int32_t seen; /* weight functions that groups see, summed over the groups */
    int32_t soft; /* 1: the rows are soft */
    double unit;  /* the rest shape's diagonal */
} model_header;

/* One shape alone (the single-shape problems of section 5.2): its dictionary has k + 1 columns a
 * weight function. */
typedef struct shape_model {
    reduction energy; /* one rotation per group */
    double *L;        /* each group's own quadratic form in the columns it sees, see group_form */
    double *rows;     /* #H by k: the constraint rows' values in this shape */
} shape_model;

struct tug_model {
    model_header header;
    size_t index_count, data_count;
    int32_t *indices;
    double *data;

    support support;
    size_t *form_offsets; /* #G: see group_form */

    dictionary dictionary;
    double *shape_columns, *weight_columns, *middles;
    double *constant;   /* #W: sum_h constant_h W_h = 1 */
    double *smoothness; /* #W square: S of smoothness.h */

    double *firmness; /* #H: beta of soft rows */

    /* The joint problem: V has a block for each pair (g, s). */
    reduction energy;
    double *align;         /* Q_gs: #G by #S by k by k */
    double *H;             /* #G by #S k by #S k: (A 19), aligned */
    double *stiffness;     /* #G: tr(H_g00) / k, the weight of the rotation prior */
    double *nearness;      /* #G by #H: how much a row says about a group's rotation */
    double *group_weights; /* #G by #W: the weight functions' means over the groups */

    shape_model *shape; /* #S */
};

tug_status model_create(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                        const double *weights, int32_t weight_count, const tug_rows *rows,
                        const int32_t *groups, int32_t group_count, const double *stiffness,
                        double smoothness, const progress_range *range, tug_model **out);
void model_destroy(tug_model *model);

/* The same with other rows, soft where firmness, #H, is not NULL. */
tug_status model_change_rows(const tug_model *model, const tug_rows *rows, const double *firmness,
                             tug_model **out);

/* The group that a row says most about. */
int32_t nearest_group(const tug_model *model, int32_t row);

/* A model of these sizes with its data zero. seen: the groups' weight functions, header.seen in
 * all. */
tug_status model_allocate(const model_header *header, const support *seen, tug_model **out);

/* The form of group g of one shape: group_columns(&shape->energy, g) square. */
static inline double *group_form(const tug_model *model, const shape_model *shape, int32_t g)
{
    return shape->L + model->form_offsets[g];
}

/* Column of the joint dictionary that is column j of shape s alone, both counted from the first of
 * their weight functions that are looked at. */
static inline int32_t joint_column(const model_header *header, int32_t s, int32_t j)
{
    int32_t k = header->dimension, block = 1 + header->shapes * k;
    int32_t within = j % (1 + k);
    return (j / (1 + k)) * block + (within == 0 ? 0 : s * k + within);
}

/* The group's part of all stiffness. The shares sum to one. */
double stiffness_share(const tug_model *model, int32_t group);

/* TUG_ERROR_NUMERIC where a number of the model is none. */
tug_status require_finite(const tug_model *model);

size_t model_blob_size(const tug_model *model);
tug_status model_save(const tug_model *model, void *blob, size_t size);
tug_status model_load(const void *blob, size_t size, tug_model **out);

#endif
