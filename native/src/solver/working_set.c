/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/working_set.h"

#include "memory.h"

#include <string.h>

/* Models with fewer pairs than this look at all of them. */
enum { FEW_PAIRS = 800 };

/* A group's shapes at first; never more than half of them short of all. */
enum { FIRST_WIDTH = 4 };

static int is_small(const tug_model *model)
{
    return model->header.groups * model->header.shapes <= FEW_PAIRS ||
           model->header.shapes <= 2 * FIRST_WIDTH;
}

int working_set_create(const tug_model *model, int single_blend, working_set *set)
{
    size_t G = (size_t)model->header.groups, S = (size_t)model->header.shapes, n = G * S;
    size_t k = (size_t)model->header.dimension;
    int small = single_blend || is_small(model);
    set->shapes = allocate(n, sizeof *set->shapes);
    set->C = small ? NULL : allocate(partial_coupling_size(G, k, S / 2), sizeof *set->C);
    set->form = allocate(n * S, sizeof *set->form);
    set->B = allocate(n, sizeof *set->B);
    set->c = allocate(n, sizeof *set->c);
    set->d = allocate(n, sizeof *set->d);
    set->pull = allocate(n * k * k, sizeof *set->pull);
    set->prior_B = allocate(n, sizeof *set->prior_B);
    set->slopes = allocate(n, sizeof *set->slopes);
    return set->shapes && (small || set->C) && set->form && set->B && set->c && set->d &&
           set->pull && set->prior_B && set->slopes;
}

void working_set_destroy(working_set *set)
{
    release(set->shapes);
    release(set->C);
    release(set->form);
    release(set->B);
    release(set->c);
    release(set->d);
    release(set->pull);
    release(set->prior_B);
    release(set->slopes);
}

/* The best entry that is not yet in: one that is kept, or the one of least slope. */
static int32_t next_entry(const double *keep, const double *slopes, int32_t S,
                          const int32_t *chosen, int32_t count)
{
    int32_t best = -1;
    for (int32_t s = 0; s < S; s++) {
        int in = 0;
        for (int32_t i = 0; i < count; i++) {
            in |= chosen[i] == s;
        }
        if (in) {
            continue;
        }
        if (keep[s] != 0.0) {
            return s;
        }
        best = best < 0 || slopes[s] < slopes[best] ? s : best;
    }
    return best;
}

static void sort(int32_t *numbers, int32_t count)
{
    for (int32_t i = 1; i < count; i++) {
        for (int32_t j = i; j > 0 && numbers[j] < numbers[j - 1]; j--) {
            int32_t swap = numbers[j];
            numbers[j] = numbers[j - 1];
            numbers[j - 1] = swap;
        }
    }
}

static void gather_form(const tug_model *model, working_set *set)
{
    int32_t k = model->header.dimension, p = k * model->header.shapes, w = set->width;
    for (int32_t i = 0; i < model->header.groups * w * w; i++) {
        int32_t g = i / (w * w), s = set->shapes[i / w], t = set->shapes[g * w + i % w];
        double trace = 0.0;
        for (int32_t a = 0; a < k; a++) {
            trace += model->H[(size_t)(g * p + s * k + a) * (size_t)p + (size_t)(t * k + a)];
        }
        set->form[i] = trace;
    }
}

void choose_entries(const tug_model *model, const coupling *all, const double *keep,
                    const double *slopes, int32_t wanted, working_set *set)
{
    int32_t G = model->header.groups, S = model->header.shapes;
    int32_t width = wanted > FIRST_WIDTH ? wanted : FIRST_WIDTH;
    set->width = set->C == NULL || width > S / 2 ? S : width;
    for (int32_t g = 0; g < G; g++) {
        int32_t *chosen = set->shapes + g * set->width;
        for (int32_t i = 0; i < set->width; i++) {
            chosen[i] =
                set->width == S ? i : next_entry(keep + g * S, slopes + g * S, S, chosen, i);
        }
        sort(chosen, set->width);
    }
    set->coupling = *all;
    if (set->width < S) {
        set->coupling.shapes = set->width;
        set->coupling.C = set->C;
        gather_coupling(all, set->shapes, set->width, set->C);
    }
    gather_form(model, set);
}

void gather_entries(const tug_model *model, const working_set *set, int32_t size,
                    const double *whole, double *part)
{
    for (int32_t i = 0; i < model->header.groups * set->width; i++) {
        int32_t pair = i / set->width * model->header.shapes + set->shapes[i];
        memcpy(part + i * size, whole + pair * size, (size_t)size * sizeof *part);
    }
}

void scatter_entries(const tug_model *model, const working_set *set, const double *part,
                     double *whole)
{
    int32_t S = model->header.shapes;
    memset(whole, 0, (size_t)(model->header.groups * S) * sizeof *whole);
    for (int32_t i = 0; i < model->header.groups * set->width; i++) {
        whole[i / set->width * S + set->shapes[i]] = part[i];
    }
}
