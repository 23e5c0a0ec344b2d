/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/references.h"

#include "dense/dense.h"
#include "dense/rotation.h"
#include "dense/vector.h"
#include "memory.h"
#include "solver/rotation_fit.h"

#include <math.h>
#include <string.h>

/* tr of H_ii over the groups, shape by shape. */
static void find_stiffness(const tug_model *model, double *stiffness)
{
    int32_t k = model->header.dimension, p = model->header.shapes * k;
    for (int32_t i = 0; i < model->header.groups * p; i++) {
        stiffness[i % p / k] += model->H[(size_t)i * (size_t)p + (size_t)(i % p)];
    }
}

int references_create(const tug_model *model, int all, reference_room *room)
{
    if (!couplings_create(model, all, &room->couplings)) {
        return 0;
    }
    size_t slice = (size_t)slice_size(&room->couplings), S = (size_t)model->header.shapes;
    room->X = allocate(S * slice, sizeof *room->X);
    room->W = allocate(S * slice, sizeof *room->W);
    room->AW = allocate(S * slice, sizeof *room->AW);
    room->pull = allocate(S * slice, sizeof *room->pull);
    room->prior = allocate(S * slice, sizeof *room->prior);
    room->blocks = allocate(slice, sizeof *room->blocks);
    room->stiffness = allocate(S, sizeof *room->stiffness);
    room->alone = allocate(S, sizeof *room->alone);
    size_t longest = (all ? S : 1) * slice;
    room->reached = allocate(2 * longest, sizeof *room->reached);
    room->ahead = allocate(2 * longest, sizeof *room->ahead);
    room->next = allocate(2 * longest, sizeof *room->next);
    room->kept = allocate(longest, sizeof *room->kept);
    int known = extrapolation_create((int32_t)(2 * longest), (int32_t)longest, &room->path);
    if (room->stiffness != NULL) {
        find_stiffness(model, room->stiffness);
    }
    return room->X && room->W && room->AW && room->pull && room->prior && room->blocks &&
           room->stiffness && room->alone && room->reached && room->ahead && room->next &&
           room->kept && known;
}

void references_destroy(reference_room *room)
{
    couplings_destroy(&room->couplings);
    release(room->X);
    release(room->W);
    release(room->AW);
    release(room->pull);
    release(room->prior);
    release(room->blocks);
    release(room->stiffness);
    release(room->alone);
    release(room->reached);
    release(room->ahead);
    release(room->next);
    release(room->kept);
    extrapolation_destroy(&room->path);
}

void take_references(const tug_model *model, const double *pull, const double *held,
                     const double *start, reference_room *room)
{
    int32_t kk = model->header.dimension * model->header.dimension, S = model->header.shapes;
    int32_t slice = slice_size(&room->couplings);
    for (int32_t s = 0; s < S; s++) {
        scatter_blocks(&room->couplings, pull + s * kk, S * kk, room->pull + s * slice);
        scatter_rotations(&room->couplings, held + s * kk, S * kk, room->prior + s * slice);
        scatter_rotations(&room->couplings, start + s * kk, S * kk, room->X + s * slice);
    }
}

/* The moments of one shape, times `scale` to have the least prior beside them, as blocks. */
PART void hold_moments(const tug_model *model, int32_t k, double scale, int32_t s,
                       reference_room *room)
{
    int32_t stride = room->couplings.stride, offset = s * slice_size(&room->couplings);
    for (int32_t i = 0; i < room->couplings.size; i++) {
        double least = LEAST_PRIOR * model->stiffness[i / k];
        for (int32_t a = 0; a < k; a++) {
            int32_t at = offset + a * stride + i;
            room->blocks[i * k + a] =
                scale * (room->pull[at] + room->AW[at]) + least * room->prior[at];
        }
    }
}

/* X <- the rotations in `blocks`. Returns the largest squared distance that one has moved. */
PART double take_rotations(const shape_couplings *c, int32_t k, const double *R, double *X)
{
    double largest = 0.0;
    for (int32_t first = 0; first < c->size; first += k, R += k * k) {
        double squares = 0.0;
        for (int32_t i = 0; i < k * k; i++) {
            double *x = X + i / k * c->stride + first + i % k, moved = R[i] - *x;
            squares += moved * moved;
            *x = R[i];
        }
        largest = squares > largest ? squares : largest;
    }
    return largest;
}

PART double turn_shape_in(const tug_model *model, int32_t k, double scale, int32_t s,
                          reference_room *room)
{
    const shape_couplings *c = &room->couplings;
    hold_moments(model, k, scale, s, room);
    closest_rotations(k, model->header.groups, room->blocks, room->blocks);
    return take_rotations(c, k, room->blocks, room->X + s * slice_size(c));
}

static double turn_shape(const tug_model *model, double scale, int32_t s, reference_room *room)
{
    return angle_of_distance(room->couplings.k == 3 ? turn_shape_in(model, 3, scale, s, room)
                                                    : turn_shape_in(model, 2, scale, s, room));
}

void turn_references(const reference_question *question, reference_set *set, reference_room *room)
{
    set->residual = 0.0;
    for (int32_t s = set->first; s < set->first + set->count; s++) {
        set->residual = fmax(set->residual, turn_shape(question->model, set->scale, s, room));
    }
}

/* tr of H_ii over the pairs of the set. */
static double stiffness_of(const reference_set *set, const reference_room *room)
{
    double sum = 0.0;
    for (int32_t s = set->first; s < set->first + set->count; s++) {
        sum += room->stiffness[s];
    }
    return sum;
}

/* sum_i w_i |R_i - prior_i|^2, w_i being the stiffness of the pair's group in the rest shape. */
static double distance_from_prior(const tug_model *model, const reference_set *set,
                                  const reference_room *room)
{
    const shape_couplings *c = &room->couplings;
    double sum = 0.0;
    for (int32_t row = set->first * c->k; row < (set->first + set->count) * c->k; row++) {
        const double *X = room->X + row * c->stride, *prior = room->prior + row * c->stride;
        for (int32_t g = 0; g < model->header.groups; g++) {
            double squares = 0.0;
            for (int32_t i = g * c->k; i < (g + 1) * c->k; i++) {
                squares += (X[i] - prior[i]) * (X[i] - prior[i]);
            }
            sum += model->stiffness[g] * squares;
        }
    }
    return sum;
}

void settle_references(const reference_question *question, reference_set *set, reference_room *room)
{
    int32_t slice = slice_size(&room->couplings), offset = set->first * slice;
    size_t size = (size_t)(set->count * slice);
    double *X = room->X + offset, *W = room->W + offset, *AW = room->AW + offset;
    couple_shapes(&room->couplings, set->first, set->count, room->X, room->AW);
    double count = set->count, h = stiffness_of(set, room);
    double own = dot(X, AW, size) / count, pulled = dot(X, room->pull + offset, size);
    set->scale = set->start_scale;
    if (question->scaled) {
        double least = LEAST_PRIOR * h;
        set->scale = fmax((pulled + least * set->start_scale) / (h - own + least), 0.0);
    }
    double scale = set->scale, away = scale - set->start_scale;
    set->energy = 0.5 * (scale * (scale * (h - own) - 2.0 * pulled) / count + question->r);
    set->energy = fmax(set->energy, 0.0);
    set->magnitude = scale * (scale * (h + own) + fabs(pulled)) / count + question->r;
    set->prior = 0.5 * LEAST_PRIOR / count *
                 (h * away * away + distance_from_prior(question->model, set, room));
    for (size_t i = 0; i < size; i++) {
        W[i] = scale / count * X[i];
        AW[i] *= scale / count;
    }
}

double value_of(const reference_set *set)
{
    return set->energy + set->prior;
}

/* W and AW of a set as one point of its path. */
static void keep_point(const reference_room *room, const reference_set *set, double *point)
{
    size_t slice = (size_t)slice_size(&room->couplings), size = (size_t)set->count * slice;
    memcpy(point, room->W + (size_t)set->first * slice, size * sizeof *point);
    memcpy(point + size, room->AW + (size_t)set->first * slice, size * sizeof *point);
}

static void go_to_point(const reference_room *room, const reference_set *set, const double *point)
{
    size_t slice = (size_t)slice_size(&room->couplings), size = (size_t)set->count * slice;
    memcpy(room->W + (size_t)set->first * slice, point, size * sizeof *point);
    memcpy(room->AW + (size_t)set->first * slice, point + size, size * sizeof *point);
}

/* A round from a point of the transforms. */
static void go_round(const reference_question *question, const double *from, reference_set *set,
                     reference_room *room)
{
    go_to_point(room, set, from);
    turn_references(question, set, room);
    settle_references(question, set, room);
}

/* A round from where the last ones are heading or, where that did not lead lower, from where they
 * are. */
static void advance(const reference_question *question, reference_set *set, reference_room *room)
{
    size_t offset = (size_t)set->first * (size_t)slice_size(&room->couplings);
    size_t size = (size_t)room->path.measured;
    const reference_set before = *set;
    const double *from = room->ahead;
    keep_point(room, set, room->reached);
    memcpy(room->kept, room->X + offset, size * sizeof *room->X);
    int heading = extrapolate(&room->path, room->ahead);
    if (heading) {
        go_round(question, room->ahead, set, room);
    }
    if (!heading || value_of(set) > value_of(&before)) {
        *set = before;
        memcpy(room->X + offset, room->kept, size * sizeof *room->X);
        from = room->reached;
        go_round(question, from, set, room);
    }
    keep_point(room, set, room->next);
    record_step(&room->path, from, room->next);
}

int32_t alternate_references(const reference_question *question, int32_t max_rounds,
                             double tolerance, reference_set *set, reference_room *room)
{
    int32_t rounds = 0;
    room->path.measured = set->count * slice_size(&room->couplings);
    room->path.size = 2 * room->path.measured;
    forget_steps(&room->path);
    do {
        advance(question, set, room);
        rounds++;
    } while (rounds < max_rounds && set->residual > tolerance);
    return rounds;
}
