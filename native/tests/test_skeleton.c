/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bones from examples: the whole decomposition on skinned tubes, and its steps one by one. */
#include "bench.h"
#include "dense/rotation.h"
#include "dictionaries/skeleton/influences.h"
#include "dictionaries/skeleton/motions.h"
#include "test.h"

enum { true_bones = 3, most_bones = 12 };

static double clamp(double value)
{
    return value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value;
}

/* Three bones along the tube, from x = -2 to 2, that share what is near x = -0.7 and 0.7. */
static void true_weights(double x, double *weight)
{
    double first = clamp((x + 1.0) / 0.6), second = clamp((x - 0.4) / 0.6);
    weight[0] = 1.0 - first;
    weight[1] = first - second;
    weight[2] = second;
}

/* The tube's other shapes become its rest shape skinned by random bones. */
static void skin_tube(fixture *f, uint64_t *state)
{
    make_tube(f, 0);
    f->shapes = 4;
    for (int32_t s = 1; s < f->shapes; s++) {
        double R[true_bones][9], offset[true_bones][3];
        for (int j = 0; j < true_bones; j++) {
            random_rotation(state, 3, R[j]);
            for (int a = 0; a < 3; a++) {
                offset[j][a] = random_between(state, -1.0, 1.0);
            }
        }
        for (int32_t v = 0; v < f->vertices; v++) {
            const double *p = f->shape + 3 * v;
            double weight[true_bones], *q = f->shape + s * coordinate_count(f) + 3 * v;
            true_weights(p[0], weight);
            for (int i = 0; i < 3 * true_bones; i++) {
                int j = i / 3, a = i % 3;
                q[a] = j == 0 ? 0.0 : q[a];
                for (int c = 0; c < 3; c++) {
                    q[a] += weight[j] * R[j][3 * a + c] * p[c];
                }
                q[a] += weight[j] * offset[j][a];
            }
        }
    }
}

static tug_skeleton_options options_of(double smoothness, double tolerance, int32_t max_rounds)
{
    tug_skeleton_options options;
    tug_default_skeleton_options(&options);
    options.smoothness = smoothness;
    options.tolerance = tolerance;
    options.max_rounds = max_rounds;
    return options;
}

static tug_status find(const fixture *f, int32_t wanted, const tug_skeleton_options *options,
                       double *weights, int32_t *bones, tug_skeleton_info *info)
{
    tug_mesh *mesh = make_mesh(f);
    info->struct_size = sizeof *info;
    tug_status status = tug_find_skeleton(mesh, f->shape, f->shapes, wanted, options, NULL, NULL,
                                          weights, bones, info);
    tug_destroy_mesh(mesh);
    return status;
}

static void weights_of_a_skinned_tube_are_found_again(void)
{
    uint64_t state = 5;
    fixture f;
    double weights[true_bones * MAX_VERTICES];
    int32_t bones, bone_of[true_bones];
    tug_skeleton_info info;
    tug_skeleton_options options = options_of(1e-8, 1e-6, 400);
    skin_tube(&f, &state);
    CHECK(find(&f, true_bones, &options, weights, &bones, &info) == TUG_OK);
    CHECK(bones == true_bones && info.converged);
    CHECK(info.error < 2e-3 * diagonal_of(&f));
    for (int j = 0; j < true_bones; j++) { /* by the ends and the middle of the tube */
        const double *row = weights + (j == 0 ? 0 : j == 1 ? 120 : f.vertices - 1) * true_bones;
        bone_of[j] = row[0] > 0.9 ? 0 : row[1] > 0.9 ? 1 : 2;
        CHECK(row[bone_of[j]] > 0.9);
    }
    for (int32_t v = 0; v < f.vertices; v++) {
        double expected[true_bones];
        true_weights(f.shape[3 * v], expected);
        for (int j = 0; j < true_bones; j++) {
            CHECK_NEAR(weights[v * true_bones + bone_of[j]], expected[j], 0.05);
        }
    }
}

static void weights_are_convex_and_sparse(void)
{
    fixture f;
    double weights[most_bones * MAX_VERTICES];
    int32_t bones;
    tug_skeleton_info info;
    for (int form = 0; form < 2; form++) {
        tug_skeleton_options options = options_of(form == 0 ? 1e-5 : 0.0, 1e-3, 20);
        form == 0 ? make_strip(&f) : make_tube(&f, 1);
        CHECK(find(&f, most_bones, &options, weights, &bones, &info) == TUG_OK);
        CHECK(bones > 4 && bones <= most_bones);
        for (int32_t v = 0; v < f.vertices; v++) {
            double sum = 0.0;
            int32_t count = 0;
            for (int32_t j = 0; j < bones; j++) {
                double weight = weights[v * bones + j];
                CHECK(weight >= 0.0);
                sum += weight;
                count += weight > 0.0;
            }
            CHECK_NEAR(sum, 1.0, 1e-12);
            CHECK(count <= 4);
        }
    }
}

static void the_objective_never_rises(void)
{
    fixture f;
    double weights[most_bones * MAX_VERTICES];
    int32_t bones;
    const double smoothness[] = {0.0, 1e-6, 1e-4};
    for (int i = 0; i < 3; i++) {
        i == 1 ? make_strip(&f) : make_tube(&f, 1);
        double before = INFINITY, first = 0.0;
        for (int32_t rounds = 1; rounds <= 12; rounds++) {
            tug_skeleton_info info;
            tug_skeleton_options options = options_of(smoothness[i], 0.0, rounds);
            CHECK(find(&f, 8, &options, weights, &bones, &info) == TUG_OK);
            CHECK(info.rounds == rounds || info.converged);
            CHECK(info.objective <= before * (1.0 + 1e-12));
            before = info.objective;
            first = rounds == 1 ? before : first;
        }
        CHECK(before < 0.95 * first);
    }
}

/* Two tubes apart that move rigidly, whatever is wanted. */
static void as_many_bones_as_there_are_rigid_parts(void)
{
    uint64_t state = 11;
    fixture f;
    double weights[6 * MAX_VERTICES], R[9], offset[] = {0.0, 5.0, 1.0};
    int32_t bones, kept = 0;
    tug_skeleton_info info;
    tug_skeleton_options options = options_of(1e-5, 1e-3, 50);
    make_tube(&f, 0);
    f.shapes = 3;
    for (int32_t t = 0; t < f.triangles; t++) { /* without the twelfth of the 24 rings' bands */
        if (t / 20 != 11) {
            memmove(f.triangle + 3 * kept++, f.triangle + 3 * t, 3 * sizeof(int32_t));
        }
    }
    f.triangles = kept;
    for (int32_t s = 1; s < f.shapes; s++) {
        double *shape = f.shape + s * coordinate_count(&f);
        memcpy(shape, f.shape, (size_t)coordinate_count(&f) * sizeof *shape);
        random_rotation(&state, 3, R);
        move_points(3, R, offset, 120, shape);
    }
    CHECK(find(&f, 6, &options, weights, &bones, &info) == TUG_OK);
    CHECK(bones == 2 && info.error < 1e-9);
    for (int32_t v = 0; v < f.vertices; v++) {
        CHECK_NEAR(weights[2 * v], weights[v < 120 ? 0 : 240], 1e-9);
        CHECK_NEAR(fabs(weights[2 * v] - weights[2 * v + 1]), 1.0, 1e-9);
    }
}

static void one_shape_has_one_bone(void)
{
    fixture f;
    double weights[4 * MAX_VERTICES];
    int32_t bones;
    tug_skeleton_info info;
    tug_skeleton_options options = options_of(1e-5, 1e-3, 50);
    make_strip(&f);
    f.shapes = 1;
    CHECK(find(&f, 4, &options, weights, &bones, &info) == TUG_OK);
    CHECK(bones == 1 && info.error == 0.0 && info.converged);
    for (int32_t v = 0; v < f.vertices; v++) {
        CHECK(weights[v] == 1.0);
    }
}

static void the_unit_of_length_does_not_matter(void)
{
    fixture f;
    double one[6 * MAX_VERTICES], other[6 * MAX_VERTICES];
    int32_t bones, others;
    tug_skeleton_info info, scaled;
    tug_skeleton_options options = options_of(1e-5, 1e-3, 10);
    make_tube(&f, 1);
    CHECK(find(&f, 6, &options, one, &bones, &info) == TUG_OK);
    rescale(&f, 1024.0, 0.0);
    CHECK(find(&f, 6, &options, other, &others, &scaled) == TUG_OK);
    CHECK(bones == others);
    for (int32_t i = 0; i < bones * f.vertices; i++) {
        CHECK_NEAR(other[i], one[i], 1e-6);
    }
    CHECK_NEAR(scaled.error, 1024.0 * info.error, 1e-6 * scaled.error);
}

/* Groups of the bones' weights make a model that finds its examples again. */
static void a_model_can_be_made_of_them(void)
{
    bench b = {.model = NULL};
    double weights[5 * MAX_VERTICES];
    int32_t bones;
    tug_skeleton_info info;
    tug_skeleton_options options = options_of(1e-5, 1e-3, 20);
    make_tube(&b.f, 1);
    tug_default_solver_options(&b.options);
    CHECK(find(&b.f, 5, &options, weights, &bones, &info) == TUG_OK);
    tug_mesh *mesh = make_mesh(&b.f);
    tug_rows rows = {b.f.row_starts, b.f.row_vertices, b.f.row_values, b.f.rows};
    CHECK(tug_cluster_triangles(mesh, weights, bones, 8, NULL, NULL, b.f.group, &b.f.groups) ==
          TUG_OK);
    CHECK(tug_create_model(mesh, b.f.shape, b.f.shapes, weights, bones, &rows, b.f.group,
                           b.f.groups, NULL, 0.0, NULL, NULL, &b.model) == TUG_OK);
    CHECK(finds_examples(&b, 1e-4));
    clear(&b);
    tug_destroy_mesh(mesh);
}

static void a_weighted_motion_is_found_exactly(void)
{
    uint64_t state = 3;
    for (int32_t k = 2; k <= 3; k++) {
        motion_sums sums = {0};
        double R[9], offset[3], motion[12];
        random_rotation(&state, k, R);
        for (int32_t a = 0; a < k; a++) {
            offset[a] = random_between(&state, -2.0, 2.0);
        }
        for (int i = 0; i < 20; i++) {
            double p[3], q[3], mass = random_between(&state, 0.1, 1.0);
            double weight = random_between(&state, 0.0, 1.0);
            for (int32_t a = 0; a < k; a++) {
                p[a] = q[a] = random_between(&state, -1.0, 1.0);
            }
            move_points(k, R, offset, 1, q);
            for (int32_t a = 0; a < k; a++) {
                q[a] *= weight;
            }
            add_to_motion(&sums, k, mass, weight, p, q);
        }
        fit_motion(&sums, k, motion);
        for (int32_t a = 0; a < k; a++) {
            CHECK_NEAR(motion[k * k + a], offset[a], 1e-12);
            for (int32_t c = 0; c < k; c++) {
                CHECK_NEAR(motion[c * k + a], R[a * k + c], 1e-12);
            }
        }
    }
}

enum { poses = 2, four_bones = 4 };

/* Three vertices, the first of which has the others as neighbours. */
typedef struct small_skinning {
    double rest[9], posed[9 * poses], miss[9 * poses], motion[four_bones * poses * 12];
    double weight[3 * most_influences], values[3], mass[3];
    int32_t bone[3 * most_influences], starts[4], columns[3];
} small_skinning;

static skinning make_small(small_skinning *m, uint64_t *state, double smoothness)
{
    *m = (small_skinning){.values = {2.0, -1.2, -0.8}, .mass = {0.3, 0.4, 0.3}};
    m->starts[1] = m->starts[2] = m->starts[3] = 3;
    for (int i = 0; i < 9; i++) {
        m->rest[i] = random_between(state, -1.0, 1.0);
    }
    for (int i = 0; i < 9 * poses; i++) {
        m->posed[i] = random_between(state, -1.0, 1.0);
    }
    for (int i = 0; i < four_bones * poses; i++) {
        random_rotation(state, 3, m->motion + 12 * i);
    }
    for (int v = 0; v < 3; v++) {
        m->columns[v] = v;
        for (int i = 0; i < most_influences; i++) {
            m->bone[v * most_influences + i] = i == 0 ? v : no_bone;
        }
        m->weight[v * most_influences] = 1.0;
    }
    return (skinning){.vertices = 3,
                      .dimension = 3,
                      .poses = poses,
                      .bones = four_bones,
                      .rest = m->rest,
                      .posed = m->posed,
                      .miss = m->miss,
                      .motion = m->motion,
                      .bone = m->bone,
                      .weight = m->weight,
                      .L = {.size = 3,
                            .starts = m->starts,
                            .columns = m->columns,
                            .values = m->values,
                            .mass = m->mass},
                      .smoothness = smoothness};
}

/* What improve_vertex minimises, of any weights of vertex 0. */
static double objective_of(const skinning *s, const double *weight)
{
    double value = 0.0, sum[3 * poses];
    memcpy(sum, s->posed, sizeof sum);
    for (int32_t j = 0; j < s->bones; j++) {
        double places[3 * poses];
        carry_vertex(s, j, 0, places);
        for (int i = 0; i < 3 * poses; i++) {
            sum[i] -= weight[j] * places[i];
        }
        value += s->smoothness * weight[j] * s->L.values[0] * weight[j];
    }
    value += 2.0 * s->smoothness * (weight[1] * s->L.values[1] + weight[2] * s->L.values[2]);
    for (int i = 0; i < 3 * poses; i++) {
        value += s->L.mass[0] * sum[i] * sum[i];
    }
    return value;
}

/* With no more bones than a vertex may have it is convex: nothing near or far is lower. */
static void a_vertex_gets_its_best_weights(void)
{
    uint64_t state = 29;
    for (int trial = 0; trial < 40; trial++) {
        small_skinning m;
        influence_room room = {0};
        skinning s = make_small(&m, &state, trial % 4 == 0 ? 0.0 : 0.3);
        double found[four_bones] = {0}, other[four_bones];
        CHECK(influence_room_create(&s, &room));
        improve_vertex(&s, 0, &room);
        influence_room_destroy(&room);
        for (int i = 0; i < most_influences; i++) {
            if (m.bone[i] != no_bone) {
                found[m.bone[i]] += m.weight[i];
            }
        }
        double lowest = objective_of(&s, found);
        for (int i = 0; i < 500; i++) {
            random_blend(&state, 1, four_bones, other);
            double step = i % 2 == 0 ? 1.0 : 1e-3;
            for (int j = 0; j < four_bones; j++) {
                other[j] = (1.0 - step) * found[j] + step * other[j];
            }
            CHECK(objective_of(&s, other) >= lowest - 1e-12);
        }
    }
}

int main(int argc, char **argv)
{
    RUN(weights_of_a_skinned_tube_are_found_again);
    RUN(weights_are_convex_and_sparse);
    RUN(the_objective_never_rises);
    RUN(as_many_bones_as_there_are_rigid_parts);
    RUN(one_shape_has_one_bone);
    RUN(the_unit_of_length_does_not_matter);
    RUN(a_model_can_be_made_of_them);
    RUN(a_weighted_motion_is_found_exactly);
    RUN(a_vertex_gets_its_best_weights);
    return TEST_RESULT;
}
