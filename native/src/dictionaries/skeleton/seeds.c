/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dictionaries/skeleton/seeds.h"

#include "dense/dense.h"
#include "dictionaries/skeleton/motions.h"
#include "memory.h"

#include <string.h>

enum { most_rounds = 30 };

/* A patch that starts a bone has this part of the area that each bone would have. */
static const double patch_share = 0.25;

/* Squared distance, in units of the diagonal: what is carried better than that is carried. */
static const double least_error = 1e-12;

typedef struct planting {
    skinning *s;
    double *error;     /* #V: squared distance from where the bone carries the vertex */
    int32_t *owner;    /* #V: its bone */
    int32_t *queue;    /* #V: a patch, in the order in which it was reached */
    int32_t *reached;  /* #V: by the patch of which bone, at last */
    motion_sums *sums; /* wanted by poses */
    double *places;    /* poses by k */
} planting;

static int allocate_planting(planting *p, int32_t wanted)
{
    size_t size = (size_t)p->s->vertices, poses = (size_t)p->s->poses;
    p->error = allocate(size, sizeof(double));
    p->owner = allocate(size, sizeof(int32_t));
    p->queue = allocate(size, sizeof(int32_t));
    p->reached = allocate(size, sizeof(int32_t));
    p->sums = allocate((size_t)wanted * poses, sizeof *p->sums);
    p->places = allocate(poses * (size_t)p->s->dimension, sizeof(double));
    return p->error && p->owner && p->queue && p->reached && p->sums && p->places;
}

static void free_planting(planting *p)
{
    release(p->error);
    release(p->owner);
    release(p->queue);
    release(p->reached);
    release(p->sums);
    release(p->places);
}

static void add_vertex(planting *p, int32_t bone, int32_t v)
{
    const skinning *s = p->s;
    size_t k = (size_t)s->dimension, poses = (size_t)s->poses;
    const double *from = s->rest + (size_t)v * k, *to = s->posed + (size_t)v * poses * k;
    motion_sums *sums = p->sums + (size_t)bone * poses;
    for (size_t i = 0; i < poses; i++) {
        add_to_motion(sums + i, s->dimension, s->L.mass[v], 1.0, from, to + i * k);
    }
}

static void fit_bone(planting *p, int32_t bone)
{
    size_t k = (size_t)p->s->dimension, first = (size_t)(bone * p->s->poses);
    for (size_t i = first; i < first + (size_t)p->s->poses; i++) {
        if (p->sums[i].weight > 0.0) {
            fit_motion(p->sums + i, p->s->dimension, p->s->motion + i * (k + 1) * k);
        }
    }
}

static double error_of(planting *p, int32_t bone, int32_t v)
{
    const skinning *s = p->s;
    int32_t width = s->poses * s->dimension;
    const double *posed = s->posed + (size_t)v * (size_t)width;
    double error = 0.0;
    carry_vertex(s, bone, v, p->places);
    for (int32_t i = 0; i < width; i++) {
        error += (p->places[i] - posed[i]) * (p->places[i] - posed[i]);
    }
    return error;
}

/* Every vertex that the bone carries better than its own one becomes the bone's. Returns how many.
 */
static int32_t offer_bone(planting *p, int32_t bone)
{
    int32_t taken = 0;
    for (int32_t v = 0; v < p->s->vertices; v++) {
        double error = error_of(p, bone, v);
        if (error < p->error[v]) {
            p->owner[v] = bone;
            p->error[v] = error;
            taken++;
        }
    }
    return taken;
}

/* A bone from the vertices around `first`, breadth first. */
static void start_bone(planting *p, int32_t bone, int32_t first, double area)
{
    const laplacian *L = &p->s->L;
    int32_t end = 0;
    double reached = 0.0;
    p->queue[end++] = first;
    p->reached[first] = bone;
    for (int32_t i = 0; i < end && reached < area; i++) {
        int32_t v = p->queue[i];
        reached += L->mass[v];
        add_vertex(p, bone, v);
        for (int32_t e = L->starts[v]; e < L->starts[v + 1]; e++) {
            int32_t other = L->columns[e];
            if (p->reached[other] != bone) {
                p->reached[other] = bone;
                p->queue[end++] = other;
            }
        }
    }
    fit_bone(p, bone);
    offer_bone(p, bone);
}

/* The first bone carries everything. */
static void start_with_one(planting *p)
{
    skinning *s = p->s;
    s->bones = 1;
    for (int32_t v = 0; v < s->vertices; v++) {
        add_vertex(p, 0, v);
        p->reached[v] = 0;
    }
    fit_bone(p, 0);
    for (int32_t v = 0; v < s->vertices; v++) {
        p->error[v] = error_of(p, 0, v);
    }
}

static tug_status start_bones(planting *p, int32_t wanted, const progress_range *range)
{
    skinning *s = p->s;
    int32_t worst = 0;
    for (start_with_one(p); s->bones < wanted; s->bones++) {
        tug_status status = report(range, "looking for bones", 0.5 * s->bones / wanted);
        if (status != TUG_OK) {
            return status;
        }
        for (int32_t v = 0; v < s->vertices; v++) {
            worst = p->error[v] > p->error[worst] ? v : worst;
        }
        if (!(p->error[worst] > least_error)) {
            break;
        }
        start_bone(p, s->bones, worst, patch_share / wanted);
    }
    return TUG_OK;
}

static void refit_bones(planting *p)
{
    skinning *s = p->s;
    memset(p->sums, 0, (size_t)(s->bones * s->poses) * sizeof *p->sums);
    for (int32_t v = 0; v < s->vertices; v++) {
        add_vertex(p, p->owner[v], v);
    }
    for (int32_t bone = 0; bone < s->bones; bone++) {
        fit_bone(p, bone);
    }
    for (int32_t v = 0; v < s->vertices; v++) {
        p->error[v] = error_of(p, p->owner[v], v);
    }
}

static tug_status run_rounds(planting *p, const progress_range *range)
{
    int32_t moved = 1;
    for (int32_t round = 0; round < most_rounds && moved > 0; round++) {
        tug_status status = report(range, "looking for bones", 0.5 + 0.5 * round / most_rounds);
        if (status != TUG_OK) {
            return status;
        }
        refit_bones(p);
        moved = 0;
        for (int32_t bone = 0; bone < p->s->bones; bone++) {
            moved += offer_bone(p, bone);
        }
    }
    return TUG_OK;
}

tug_status plant_bones(skinning *s, int32_t wanted, const progress_range *range)
{
    planting p = {.s = s};
    tug_status status =
        allocate_planting(&p, wanted) ? start_bones(&p, wanted, range) : fail_memory();
    if (status == TUG_OK) {
        status = run_rounds(&p, range);
    }
    for (int32_t v = 0; status == TUG_OK && v < s->vertices; v++) {
        for (int32_t i = 0; i < most_influences; i++) {
            s->bone[v * most_influences + i] = i == 0 ? p.owner[v] : no_bone;
            s->weight[v * most_influences + i] = i == 0 ? 1.0 : 0.0;
        }
    }
    free_planting(&p);
    return status;
}
