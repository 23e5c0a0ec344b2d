/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model/support.h"

#include "memory.h"

void support_destroy(support *s)
{
    release(s->starts);
    release(s->functions);
    *s = (support){0};
}

/* seen: #G by #W, whether a function is not zero on a group. */
static void mark(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                 const int32_t *groups, unsigned char *seen)
{
    size_t m = (size_t)weight_count;
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const double *row = weights + (size_t)mesh->triangles[i] * m;
        unsigned char *mine = seen + (size_t)groups[i / 3] * m;
        for (size_t h = 0; h < m; h++) {
            mine[h] |= row[h] != 0.0;
        }
    }
}

tug_status support_create(const tug_mesh *mesh, const double *weights, int32_t weight_count,
                          const int32_t *groups, int32_t group_count, support *out)
{
    size_t m = (size_t)weight_count, G = (size_t)group_count;
    unsigned char *seen = allocate(G * m, sizeof *seen);
    *out = (support){.starts = allocate(G + 1, sizeof *out->starts),
                     .functions = allocate(G * m, sizeof *out->functions)};
    if (seen == NULL || out->starts == NULL || out->functions == NULL) {
        release(seen);
        support_destroy(out);
        return fail_memory();
    }
    mark(mesh, weights, weight_count, groups, seen);
    int32_t count = 0;
    for (size_t i = 0; i < G * m; i++) {
        if (seen[i]) {
            out->functions[count++] = (int32_t)(i % m);
        }
        out->starts[i / m + 1] = count;
    }
    release(seen);
    return TUG_OK;
}
