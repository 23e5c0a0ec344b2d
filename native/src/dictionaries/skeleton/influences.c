/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An active set for each vertex: bones enter where the gradient is lowest and leave at zero. A
 * fifth may enter for a moment, to take the place of the weakest where that is better. */
#include "dictionaries/skeleton/influences.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { most_candidates = most_influences + 1, most_entries = 32 };

/* A bone whose gradient is lower by less than this part of it does not enter. */
static const double least_gain = 1e-9;

typedef struct candidate_set {
    int32_t count;
    int32_t bone[most_candidates];
    double weight[most_candidates];
} candidate_set;

/* What is constant while one vertex is improved. */
typedef struct vertex_problem {
    int32_t width, bones;
    double mass, stiffness; /* m_v; smoothness L_vv */
    influence_room *room;
} vertex_problem;

int influence_room_create(const skinning *s, influence_room *room)
{
    size_t width = (size_t)(s->poses * s->dimension), bones = (size_t)s->bones;
    room->misses = allocate(bones * width, sizeof(double));
    room->pull = allocate(bones, sizeof(double));
    room->gradient = allocate(bones, sizeof(double));
    room->sum = allocate(width, sizeof(double));
    return room->misses && room->pull && room->gradient && room->sum;
}

void influence_room_destroy(influence_room *room)
{
    release(room->misses);
    release(room->pull);
    release(room->gradient);
    release(room->sum);
}

static const double *miss_of(const vertex_problem *p, int32_t bone)
{
    return p->room->misses + (size_t)bone * (size_t)p->width;
}

/* pull_j = smoothness sum_u L_vu w_uj; returns smoothness L_vv. */
static double find_pull(const skinning *s, int32_t vertex, double *pull)
{
    double own = 0.0;
    memset(pull, 0, (size_t)s->bones * sizeof *pull);
    for (int32_t e = s->L.starts[vertex]; e < s->L.starts[vertex + 1]; e++) {
        int32_t other = s->L.columns[e];
        double factor = s->smoothness * s->L.values[e];
        if (other == vertex) {
            own = factor;
            continue;
        }
        for (int32_t i = other * most_influences; i < (other + 1) * most_influences; i++) {
            if (s->bone[i] != no_bone) {
                pull[s->bone[i]] += factor * s->weight[i];
            }
        }
    }
    return own;
}

static vertex_problem state_problem(const skinning *s, int32_t vertex, influence_room *room)
{
    vertex_problem p = {.width = s->poses * s->dimension,
                        .bones = s->bones,
                        .mass = s->L.mass[vertex],
                        .room = room};
    p.stiffness = find_pull(s, vertex, room->pull);
    const double *posed = s->posed + (size_t)vertex * (size_t)p.width;
    for (int32_t j = 0; j < s->bones; j++) {
        double *miss = room->misses + (size_t)j * (size_t)p.width;
        carry_vertex(s, j, vertex, miss);
        for (int32_t i = 0; i < p.width; i++) {
            miss[i] -= posed[i];
        }
    }
    return p;
}

/* sum_j w_j c_j into the room; returns the objective. */
static double evaluate(const vertex_problem *p, const candidate_set *set)
{
    double *sum = p->room->sum, value = 0.0;
    memset(sum, 0, (size_t)p->width * sizeof *sum);
    for (int32_t j = 0; j < set->count; j++) {
        const double *miss = miss_of(p, set->bone[j]);
        double weight = set->weight[j];
        for (int32_t i = 0; i < p->width; i++) {
            sum[i] += weight * miss[i];
        }
        value += weight * (p->stiffness * weight + 2.0 * p->room->pull[set->bone[j]]);
    }
    return value + p->mass * dot(sum, sum, (size_t)p->width);
}

/* The optimum over weights of any sign that sum to one. Returns 0 where it is not determined. */
static int solve_equality(const vertex_problem *p, const candidate_set *set, double *x)
{
    int32_t n = set->count;
    double K[most_candidates * most_candidates], right[2 * most_candidates];
    for (int32_t a = 0; a < n; a++) {
        for (int32_t b = 0; b <= a; b++) {
            double product =
                dot(miss_of(p, set->bone[a]), miss_of(p, set->bone[b]), (size_t)p->width);
            K[a * n + b] = K[b * n + a] = p->mass * product + (a == b ? p->stiffness : 0.0);
        }
        right[2 * a] = 1.0;
        right[2 * a + 1] = -p->room->pull[set->bone[a]];
    }
    if (!cholesky_factor(K, n)) {
        return 0;
    }
    cholesky_solve(K, n, right, 2);
    double ones = 0.0, pulled = 0.0;
    for (int32_t a = 0; a < n; a++) {
        ones += right[2 * a];
        pulled += right[2 * a + 1];
    }
    for (int32_t a = 0; a < n; a++) {
        x[a] = right[2 * a + 1] + right[2 * a] * (1.0 - pulled) / ones;
    }
    return isfinite(ones) && ones > 0.0;
}

static void drop(candidate_set *set, int32_t place)
{
    set->count--;
    for (int32_t i = place; i < set->count; i++) {
        set->bone[i] = set->bone[i + 1];
        set->weight[i] = set->weight[i + 1];
    }
}

/* The optimum over weights of the set that are not negative: go towards the optimum of any sign,
 * and leave out what meets zero first. */
static void solve_set(const vertex_problem *p, candidate_set *set)
{
    double x[most_candidates];
    while (set->count > 1 && solve_equality(p, set, x)) {
        double step = 1.0;
        int32_t blocking = -1;
        for (int32_t i = 0; i < set->count; i++) {
            double reach = x[i] < 0.0 ? set->weight[i] / (set->weight[i] - x[i]) : 1.0;
            if (reach < step) {
                step = reach;
                blocking = i;
            }
        }
        for (int32_t i = 0; i < set->count; i++) {
            set->weight[i] += step * (x[i] - set->weight[i]);
        }
        if (blocking < 0) {
            return;
        }
        drop(set, blocking);
    }
    if (set->count == 1) {
        set->weight[0] = 1.0;
    }
}

/* The bone of the lowest gradient outside of the set, or no_bone. Uses the sum of evaluate. */
static int32_t find_entering(const vertex_problem *p, const candidate_set *set)
{
    double *gradient = p->room->gradient, level = 0.0, scale = 0.0;
    for (int32_t j = 0; j < p->bones; j++) {
        gradient[j] =
            p->mass * dot(miss_of(p, j), p->room->sum, (size_t)p->width) + p->room->pull[j];
    }
    for (int32_t i = 0; i < set->count; i++) {
        double *own = gradient + set->bone[i];
        *own += p->stiffness * set->weight[i];
        level += set->weight[i] * *own;
        scale += set->weight[i] * (fabs(*own) + p->stiffness);
        *own = INFINITY;
    }
    int32_t lowest = 0;
    for (int32_t j = 1; j < p->bones; j++) {
        lowest = gradient[j] < gradient[lowest] ? j : lowest;
    }
    return gradient[lowest] < level - least_gain * scale ? lowest : no_bone;
}

static void drop_weakest(candidate_set *set)
{
    int32_t weakest = 0;
    for (int32_t i = 1; i < set->count; i++) {
        weakest = set->weight[i] < set->weight[weakest] ? i : weakest;
    }
    double rest = 1.0 - set->weight[weakest];
    drop(set, weakest);
    for (int32_t i = 0; i < set->count; i++) {
        set->weight[i] /= rest;
    }
}

static void minimise(const vertex_problem *p, candidate_set *best)
{
    double lowest = evaluate(p, best);
    candidate_set next = *best;
    for (int entries = 0; entries < most_entries; entries++) {
        solve_set(p, &next);
        if (next.count > most_influences) {
            drop_weakest(&next);
            solve_set(p, &next);
        }
        double value = evaluate(p, &next);
        if (!(value < lowest)) {
            value = evaluate(p, best);
            if (entries > 0) {
                return;
            }
            next = *best;
        }
        *best = next;
        lowest = value;
        int32_t entering = find_entering(p, &next);
        if (entering == no_bone) {
            return;
        }
        next.bone[next.count] = entering;
        next.weight[next.count++] = 0.0;
    }
}

void improve_vertex(skinning *s, int32_t vertex, influence_room *room)
{
    vertex_problem p = state_problem(s, vertex, room);
    int32_t *bone = s->bone + (size_t)vertex * most_influences;
    double *weight = s->weight + (size_t)vertex * most_influences;
    candidate_set set = {0};
    for (int32_t i = 0; i < most_influences; i++) {
        if (bone[i] != no_bone) {
            set.bone[set.count] = bone[i];
            set.weight[set.count++] = weight[i];
        }
    }
    minimise(&p, &set);
    for (int32_t i = 0; i < most_influences; i++) {
        bone[i] = i < set.count ? set.bone[i] : no_bone;
        weight[i] = i < set.count ? set.weight[i] : 0.0;
    }
    evaluate(&p, &set);
    for (int32_t i = 0; i < p.width; i++) {
        s->miss[(size_t)vertex * (size_t)p.width + (size_t)i] = -room->sum[i];
    }
}
