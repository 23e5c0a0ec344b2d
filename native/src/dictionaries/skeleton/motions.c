/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "dictionaries/skeleton/motions.h"

#include "dense/rotation.h"

#include <string.h>

void add_to_motion(motion_sums *sums, int32_t k, double mass, double weight, const double *p,
                   const double *q)
{
    double once = mass * weight;
    sums->weight += once * weight;
    for (int32_t a = 0; a < k; a++) {
        sums->from[a] += once * weight * p[a];
        sums->to[a] += once * q[a];
        for (int32_t c = 0; c < k; c++) {
            sums->products[a * k + c] += once * p[a] * q[c];
        }
    }
}

/* About p* = sum m w^2 p / sum m w^2 and q* = sum m w q / sum m w^2 the rotation stands alone. */
void fit_motion(const motion_sums *sums, int32_t k, double *motion)
{
    double M[9], R[9];
    for (int32_t i = 0; i < k * k; i++) {
        M[i] = sums->products[i] - sums->from[i / k] * sums->to[i % k] / sums->weight;
    }
    closest_rotation(k, M, R);
    for (int32_t a = 0; a < k; a++) {
        motion[k * k + a] = sums->to[a] / sums->weight;
        for (int32_t c = 0; c < k; c++) {
            motion[c * k + a] = R[a * k + c];
            motion[k * k + a] -= R[a * k + c] * sums->from[c] / sums->weight;
        }
    }
}

static double weight_of(const skinning *s, int32_t vertex, int32_t bone)
{
    const int32_t *bones = s->bone + (size_t)vertex * most_influences;
    for (int32_t i = 0; i < most_influences; i++) {
        if (bones[i] == bone) {
            return s->weight[(size_t)vertex * most_influences + (size_t)i];
        }
    }
    return 0.0;
}

/* miss += factor w_vj (R_j p_v + t_j) for all vertices of the bone. */
static void add_bone(skinning *s, int32_t bone, double factor, double *places)
{
    size_t width = (size_t)(s->poses * s->dimension);
    for (int32_t v = 0; v < s->vertices; v++) {
        double weight = factor * weight_of(s, v, bone);
        if (weight == 0.0) {
            continue;
        }
        carry_vertex(s, bone, v, places);
        for (size_t i = 0; i < width; i++) {
            s->miss[(size_t)v * width + i] += weight * places[i];
        }
    }
}

static void refit_bone(skinning *s, int32_t bone, motion_sums *sums)
{
    int32_t k = s->dimension, poses = s->poses;
    memset(sums, 0, (size_t)poses * sizeof *sums);
    for (int32_t v = 0; v < s->vertices; v++) {
        double weight = weight_of(s, v, bone);
        const double *p = s->rest + (size_t)v * (size_t)k;
        const double *q = s->miss + (size_t)v * (size_t)(poses * k);
        for (int32_t i = 0; weight > 0.0 && i < poses; i++) {
            add_to_motion(sums + i, k, s->L.mass[v], weight, p, q + i * k);
        }
    }
    for (int32_t i = 0; i < poses; i++) {
        if (sums[i].weight > 0.0) {
            fit_motion(sums + i, k, s->motion + (size_t)(bone * poses + i) * (size_t)((k + 1) * k));
        }
    }
}

void improve_motions(skinning *s, motion_sums *room, double *places)
{
    for (int32_t bone = 0; bone < s->bones; bone++) {
        add_bone(s, bone, 1.0, places);
        refit_bone(s, bone, room);
        add_bone(s, bone, -1.0, places);
    }
}
