/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is wrong with a mesh, in the words of Blender's menus. */
#include "memory.h"
#include "mesh/disjoint_sets.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    NOT_FINITE,
    NO_AREA,
    LOOSE,
    CROWDED,
    FLIPPED,
    PINCHED,
    DOUBLED,
    PROBLEM_COUNT,
    FIRST_WARNING = CROWDED
};

typedef struct problem_words {
    const char *name;
    int example_size; /* vertices that show one of the kind */
    const char *remedy;
} problem_words;

static const problem_words words[PROBLEM_COUNT] = {
    [NOT_FINITE] = {"Vertices whose coordinates are not finite", 1,
                    "Give them a place in Sidebar > Item > Vertex, or delete them."},
    [NO_AREA] = {"Triangles of no area", 3,
                 "Use Mesh > Merge > By Distance or Mesh > Clean Up > Degenerate Dissolve."},
    [LOOSE] = {"Vertices in no face", 1, "Use Mesh > Clean Up > Delete Loose."},
    [CROWDED] = {"Edges of more than two triangles", 2,
                 "Find them by Select > All by Trait > Non Manifold and delete the inner faces."},
    [FLIPPED] = {"Neighbouring faces that face opposite ways", 2,
                 "Use Mesh > Normals > Recalculate Outside."},
    [PINCHED] = {"Vertices where parts of the surface touch in a point only", 1,
                 "Use Mesh > Split > Faces by Edges, or join the parts by faces."},
    [DOUBLED] = {"Triangles that are there twice", 3, "Delete one of the two, Only Faces."},
};

/* How often a problem was met, and the vertices of the first time. */
typedef struct problem {
    int32_t count;
    int32_t example[3];
} problem;

static void note(problem *met, int32_t a, int32_t b, int32_t c)
{
    if (met->count++ == 0) {
        met->example[0] = a;
        met->example[1] = b;
        met->example[2] = c;
    }
}

/* ------------------------------------------------------------------------------------------------
 * Errors
 */

static void find_bad_coordinates(const tug_mesh *mesh, problem *problems)
{
    size_t k = (size_t)mesh->dimension;
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        const double *x = mesh->vertices + k * (size_t)v;
        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[k - 1])) {
            note(&problems[NOT_FINITE], v, v, v);
        }
    }
}

static void find_flat_triangles(const tug_mesh *mesh, problem *problems)
{
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *corner = mesh->triangles + 3 * (size_t)t;
        if (mesh->area[t] <= 0.0) {
            note(&problems[NO_AREA], corner[0], corner[1], corner[2]);
        }
    }
}

static tug_status find_loose_vertices(const tug_mesh *mesh, problem *problems)
{
    unsigned char *used = allocate((size_t)mesh->vertex_count, 1);
    if (used == NULL) {
        return fail_memory();
    }
    for (int32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        used[mesh->triangles[i]] = 1;
    }
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        if (!used[v]) {
            note(&problems[LOOSE], v, v, v);
        }
    }
    release(used);
    return TUG_OK;
}

static tug_status find_errors(const tug_mesh *mesh, problem *problems)
{
    find_bad_coordinates(mesh, problems);
    find_flat_triangles(mesh, problems);
    return find_loose_vertices(mesh, problems);
}

/* ------------------------------------------------------------------------------------------------
 * Warnings
 */

/* order: the rows (count by width, entries below `range`) from least to greatest. A counting sort
 * for each column from the last: O(width (count + range)). */
static tug_status sort_rows(const int32_t *rows, int32_t count, size_t width, int32_t range,
                            int32_t *order)
{
    int32_t *previous = allocate((size_t)count, sizeof *previous);
    int32_t *starts = allocate((size_t)range + 1, sizeof *starts);
    int complete = previous != NULL && starts != NULL;
    for (int32_t i = 0; complete && i < count; i++) {
        order[i] = i;
    }
    for (size_t column = width; complete && column-- > 0;) {
        memcpy(previous, order, (size_t)count * sizeof *order);
        memset(starts, 0, ((size_t)range + 1) * sizeof *starts);
        for (int32_t i = 0; i < count; i++) {
            starts[rows[width * (size_t)i + column] + 1]++;
        }
        for (int32_t value = 0; value < range; value++) {
            starts[value + 1] += starts[value];
        }
        for (int32_t i = 0; i < count; i++) {
            int32_t row = previous[i];
            order[starts[rows[width * (size_t)row + column]]++] = row;
        }
    }
    release(previous);
    release(starts);
    return complete ? TUG_OK : fail_memory();
}

/* The triangles and edges that the warnings are about. */
typedef struct surface {
    const tug_mesh *mesh;
    unsigned char *left_out; /* #F: triangles that name a vertex twice, or repeat another */
    int32_t *sorted_corners; /* #F by 3 */
    int32_t *ends;           /* edge_count by 2, the lesser vertex first */
    int32_t *start;          /* edge_count: the corner, of 3 #F, at which the edge begins */
    int32_t *order;          /* 3 #F */
    int32_t *fan;            /* 3 #F, sets: corners at one vertex joined across edges */
    int32_t *fan_count;      /* #V */
    int32_t edge_count;
} surface;

static void release_surface(surface *s)
{
    release(s->left_out);
    release(s->sorted_corners);
    release(s->ends);
    release(s->start);
    release(s->order);
    release(s->fan);
    release(s->fan_count);
}

static tug_status allocate_surface(surface *s)
{
    size_t corners = 3 * (size_t)s->mesh->triangle_count;
    s->left_out = allocate((size_t)s->mesh->triangle_count, 1);
    s->sorted_corners = allocate(corners, sizeof(int32_t));
    s->ends = allocate(2 * corners, sizeof(int32_t));
    s->start = allocate(corners, sizeof(int32_t));
    s->order = allocate(corners, sizeof(int32_t));
    s->fan = allocate(corners, sizeof(int32_t));
    s->fan_count = allocate((size_t)s->mesh->vertex_count, sizeof(int32_t));
    int complete = s->left_out && s->sorted_corners && s->ends && s->start && s->order && s->fan &&
                   s->fan_count;
    return complete ? TUG_OK : fail_memory();
}

static void order_pair(int32_t *a, int32_t *b)
{
    if (*a > *b) {
        int32_t greater = *a;
        *a = *b;
        *b = greater;
    }
}

static void sort_corners(surface *s)
{
    const tug_mesh *mesh = s->mesh;
    memcpy(s->sorted_corners, mesh->triangles, 3 * (size_t)mesh->triangle_count * sizeof(int32_t));
    for (int32_t t = 0; t < mesh->triangle_count; t++) {
        int32_t *corner = s->sorted_corners + 3 * t;
        order_pair(&corner[0], &corner[1]);
        order_pair(&corner[1], &corner[2]);
        order_pair(&corner[0], &corner[1]);
        s->left_out[t] = corner[0] == corner[1] || corner[1] == corner[2];
    }
}

static tug_status find_doubled_triangles(surface *s, problem *problems)
{
    const tug_mesh *mesh = s->mesh;
    sort_corners(s);
    tug_status status =
        sort_rows(s->sorted_corners, mesh->triangle_count, 3, mesh->vertex_count, s->order);
    for (int32_t i = 1; status == TUG_OK && i < mesh->triangle_count; i++) {
        const int32_t *corner = s->sorted_corners + 3 * s->order[i];
        const int32_t *before = s->sorted_corners + 3 * s->order[i - 1];
        if (!s->left_out[s->order[i]] && memcmp(corner, before, 3 * sizeof *corner) == 0) {
            note(&problems[DOUBLED], corner[0], corner[1], corner[2]);
            s->left_out[s->order[i]] = 1;
        }
    }
    return status;
}

static int32_t next_corner(int32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

static tug_status sort_edges(surface *s)
{
    for (int32_t i = 0; i < 3 * s->mesh->triangle_count; i++) {
        if (!s->left_out[i / 3]) {
            int32_t *ends = s->ends + 2 * (size_t)s->edge_count;
            ends[0] = s->mesh->triangles[i];
            ends[1] = s->mesh->triangles[next_corner(i)];
            order_pair(&ends[0], &ends[1]);
            s->start[s->edge_count++] = i;
        }
    }
    return sort_rows(s->ends, s->edge_count, 2, s->mesh->vertex_count, s->order);
}

/* Join the corners of two triangles at both ends of an edge of both. Whether it runs the same way
 * through both. */
static int join_across_edge(surface *s, int32_t one, int32_t other)
{
    int32_t from = s->start[one], to = next_corner(from);
    int32_t other_from = s->start[other], other_to = next_corner(other_from);
    int same_way = s->mesh->triangles[from] == s->mesh->triangles[other_from];
    merge_sets(s->fan, from, same_way ? other_from : other_to);
    merge_sets(s->fan, to, same_way ? other_to : other_from);
    return same_way;
}

static void walk_edges(surface *s, problem *problems)
{
    int32_t next;
    for (int32_t first = 0; first < s->edge_count; first = next) {
        const int32_t *ends = s->ends + 2 * (size_t)s->order[first];
        int same_way = 0;
        for (next = first + 1; next < s->edge_count; next++) {
            if (memcmp(ends, s->ends + 2 * (size_t)s->order[next], 2 * sizeof *ends) != 0) {
                break;
            }
            same_way = join_across_edge(s, s->order[first], s->order[next]);
        }
        if (next - first > 2) {
            note(&problems[CROWDED], ends[0], ends[1], ends[1]);
        } else if (same_way) {
            note(&problems[FLIPPED], ends[0], ends[1], ends[1]);
        }
    }
}

static void find_pinched_vertices(surface *s, problem *problems)
{
    for (int32_t i = 0; i < 3 * s->mesh->triangle_count; i++) {
        if (!s->left_out[i / 3] && find_set(s->fan, i) == i) {
            s->fan_count[s->mesh->triangles[i]]++;
        }
    }
    for (int32_t v = 0; v < s->mesh->vertex_count; v++) {
        if (s->fan_count[v] > 1) {
            note(&problems[PINCHED], v, v, v);
        }
    }
}

static tug_status find_warnings_of(surface *s, problem *problems)
{
    tug_status status = allocate_surface(s);
    if (status == TUG_OK) {
        status = find_doubled_triangles(s, problems);
    }
    if (status == TUG_OK) {
        status = sort_edges(s);
    }
    if (status == TUG_OK) {
        separate_sets(s->fan, 3 * s->mesh->triangle_count);
        walk_edges(s, problems);
        find_pinched_vertices(s, problems);
    }
    return status;
}

static tug_status find_warnings(const tug_mesh *mesh, problem *problems)
{
    surface s = {.mesh = mesh};
    tug_status status = find_warnings_of(&s, problems);
    release_surface(&s);
    return status;
}

/* ------------------------------------------------------------------------------------------------
 * Words
 */

enum { LINE_SIZE = 256 };

static void write_line(char line[LINE_SIZE], const problem_words *kind, const problem *met)
{
    char example[64];
    const int32_t *v = met->example;
    if (kind->example_size == 1) {
        snprintf(example, sizeof example, "vertex %d", v[0]);
    } else if (kind->example_size == 2) {
        snprintf(example, sizeof example, "at the edge of vertices %d and %d", v[0], v[1]);
    } else {
        snprintf(example, sizeof example, "of vertices %d, %d and %d", v[0], v[1], v[2]);
    }
    snprintf(line, LINE_SIZE, "%s: %d, for example %s. %s", kind->name, met->count, example,
             kind->remedy);
}

/* Append what fits of a line to the text of `length` bytes; the new length. */
static size_t append_line(char *text, size_t capacity, size_t length, const char *line)
{
    if (length + 1 >= capacity) {
        return length;
    }
    int added = snprintf(text + length, capacity - length, "%s%s", length > 0 ? "\n" : "", line);
    size_t room = capacity - length - 1;
    return length + ((size_t)added < room ? (size_t)added : room);
}

tug_status mesh_describe(const tug_mesh *mesh, char *text, size_t capacity, int32_t *errors,
                         int32_t *warnings)
{
    problem problems[PROBLEM_COUNT] = {0};
    tug_status status = find_errors(mesh, problems);
    if (status == TUG_OK) {
        status = find_warnings(mesh, problems);
    }
    if (status != TUG_OK) {
        return status;
    }
    size_t length = 0;
    *errors = *warnings = 0;
    if (capacity > 0) {
        text[0] = '\0';
    }
    for (int i = 0; i < PROBLEM_COUNT; i++) {
        if (problems[i].count > 0) {
            char line[LINE_SIZE];
            write_line(line, &words[i], &problems[i]);
            length = append_line(text, capacity, length, line);
            ++*(i < FIRST_WARNING ? errors : warnings);
        }
    }
    return TUG_OK;
}

tug_status require_sound_mesh(const tug_mesh *mesh)
{
    problem problems[PROBLEM_COUNT] = {0};
    tug_status status = find_errors(mesh, problems);
    for (int i = 0; status == TUG_OK && i < FIRST_WARNING; i++) {
        if (problems[i].count > 0) {
            char line[LINE_SIZE];
            write_line(line, &words[i], &problems[i]);
            status = fail(TUG_ERROR_MESH, "%s", line);
        }
    }
    return status;
}
