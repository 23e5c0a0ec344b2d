/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounded biharmonic weights: closed forms, a slow reference, optimality from raw input, errors. */
#include "dense/dense.h"
#include "memory.h"
#include "mesh/mesh.h"
#include "weights/bounded_biharmonic.h"

#include "test.h"

#include <pthread.h>
#include <stdlib.h>

enum { most_vertices = 1500, most_handles = 8 };

static const double pi = 3.14159265358979323846;
static const progress_range silent = {NULL, NULL, 0.0, 1.0};

/* Vertices in 3D, triangles, and handles of single vertices unless a test says otherwise. */
typedef struct scene {
    int32_t vertex_count, triangle_count, handle_count;
    double vertices[3 * most_vertices];
    int32_t triangles[6 * most_vertices];
    int32_t starts[most_handles + 1], handle_vertices[most_vertices];
    double weights[most_vertices * most_handles];
    tug_weights_options options;
    tug_weights_info info;
} scene;

static scene s, other;

static void add_triangle(int32_t a, int32_t b, int32_t c)
{
    int32_t corner[] = {a, b, c};
    memcpy(s.triangles + 3 * s.triangle_count++, corner, sizeof corner);
}

static void start_scene(void)
{
    memset(&s, 0, sizeof s);
    s.options.struct_size = sizeof s.options;
    s.options.tolerance = 1e-6;
    s.options.max_iterations = 200;
    s.info.struct_size = sizeof s.info;
}

static void add_handle(int32_t vertex)
{
    s.handle_vertices[s.starts[s.handle_count]] = vertex;
    s.starts[s.handle_count + 1] = s.starts[s.handle_count] + 1;
    s.handle_count++;
}

/* The last handle gets one vertex more. */
static void extend_handle(int32_t vertex)
{
    s.handle_vertices[s.starts[s.handle_count]++] = vertex;
}

/* columns by rows squares in the plane z = 0, joined along the long sides where `wrapped`. */
static void add_sheet(int32_t columns, int32_t rows, int wrapped)
{
    int32_t first = s.vertex_count, around = wrapped ? rows : rows + 1;
    for (int32_t x = 0; x <= columns; x++) {
        for (int32_t y = 0; y < around; y++) {
            double *p = s.vertices + 3 * s.vertex_count++;
            p[0] = x;
            p[1] = y;
        }
    }
    for (int32_t x = 0; x < columns; x++) {
        for (int32_t y = 0; y < rows; y++) {
            int32_t a = first + x * around + y, b = first + x * around + (y + 1) % around;
            add_triangle(a, a + around, b + around);
            add_triangle(a, b + around, b);
        }
    }
}

/* A sheet rolled up around the x axis, with bumps of a relative height. */
static void add_tube(int32_t rings, int32_t segments, double bumps)
{
    int32_t first = s.vertex_count;
    add_sheet(rings, segments, 1);
    double radius = 0.5 / sin(pi / segments);
    for (int32_t v = first; v < s.vertex_count; v++) {
        double *p = s.vertices + 3 * v, angle = 2.0 * pi * p[1] / segments;
        double r = radius * (1.0 + bumps * sin(0.7 * p[0]) * cos(3.0 * angle));
        p[1] = r * cos(angle);
        p[2] = r * sin(angle);
    }
}

/* A tube of 24 rings with four handles. */
static void bumpy_scene(void)
{
    start_scene();
    add_tube(24, 12, 0.25);
    add_handle(3);
    add_handle(24 * 12 + 7);
    add_handle(10 * 12);
    add_handle(16 * 12 + 5);
}

static tug_status compute_weights(const progress_range *range)
{
    tug_mesh *mesh;
    tug_status status =
        mesh_create(s.vertices, s.vertex_count, 3, s.triangles, s.triangle_count, &mesh);
    if (status == TUG_OK) {
        status = bounded_biharmonic_weights(mesh, s.starts, s.handle_vertices, s.handle_count,
                                            &s.options, range, s.weights, &s.info);
        mesh_destroy(mesh);
    }
    return status;
}

static double weight_of(int32_t vertex, int32_t handle)
{
    return s.weights[vertex * s.handle_count + handle];
}

static int32_t owner_of(int32_t vertex)
{
    for (int32_t h = 0; h < s.handle_count; h++) {
        for (int32_t i = s.starts[h]; i < s.starts[h + 1]; i++) {
            if (s.handle_vertices[i] == vertex) {
                return h;
            }
        }
    }
    return -1;
}

/* Half the cotangents of a triangle's angles and the areas nearest to its corners, from the lengths
 * of its sides; returns its area. */
static double measure_triangle(const int32_t *corner, double half_cotangent[3], double share[3])
{
    double squares[3], sum = 0.0, least = 0.0;
    for (int e = 0; e < 3; e++) {
        const double *a = s.vertices + 3 * corner[(e + 1) % 3];
        const double *b = s.vertices + 3 * corner[(e + 2) % 3];
        squares[e] = pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2);
        sum += squares[e];
    }
    double x = squares[0], y = squares[1], z = squares[2];
    double area = 0.25 * sqrt(2 * (x * y + y * z + z * x) - x * x - y * y - z * z);
    for (int c = 0; c < 3; c++) {
        half_cotangent[c] = (sum - 2.0 * squares[c]) / (8.0 * area);
        /* The centre of the circumscribed circle in barycentric coordinates. */
        double centre = squares[c] * (sum - 2.0 * squares[c]) / (16.0 * area * area);
        least = fmin(least, centre);
        share[c] = 0.5 * area * (1.0 - centre);
    }
    for (int c = 0; c < 3 && least < 0.0; c++) {
        share[c] = half_cotangent[c] < 0.0 ? 0.5 * area : 0.25 * area;
    }
    return area;
}

/* Q = L M^-1 L, dense, from the raw triangles, for an area of one. */
static double *dense_bilaplacian(void)
{
    int32_t n = s.vertex_count;
    double *L = calloc((size_t)(n * n), sizeof *L), *Q = calloc((size_t)(n * n), sizeof *Q);
    double *mass = calloc((size_t)n, sizeof *mass), whole = 0.0;
    for (int32_t t = 0; t < s.triangle_count; t++) {
        const int32_t *corner = s.triangles + 3 * t;
        double half_cotangent[3], share[3];
        whole += measure_triangle(corner, half_cotangent, share);
        for (int c = 0; c < 3; c++) {
            int32_t a = corner[(c + 1) % 3], b = corner[(c + 2) % 3];
            double weight = half_cotangent[c];
            L[a * n + b] -= weight;
            L[b * n + a] -= weight;
            L[a * n + a] += weight;
            L[b * n + b] += weight;
            mass[corner[c]] += share[c];
        }
    }
    for (int32_t a = 0; a < n; a++) {
        for (int32_t k = 0; k < n; k++) {
            for (int32_t b = 0; L[a * n + k] != 0.0 && b < n; b++) {
                Q[a * n + b] += L[a * n + k] * L[k * n + b] * whole / mass[k];
            }
        }
    }
    free(L);
    free(mass);
    return Q;
}

/* The same problems by projected over-relaxation, normalised; #V by #W. */
static double *reference_weights(const double *Q, int32_t sweeps)
{
    int32_t n = s.vertex_count, count = s.handle_count;
    double *w = calloc((size_t)(n * count), sizeof *w);
    for (int32_t h = 0; h < count; h++) {
        double *x = w + h;
        for (int32_t v = 0; v < n; v++) {
            x[v * count] = owner_of(v) == h ? 1.0 : 0.0;
        }
        for (int32_t sweep = 0; sweep < sweeps; sweep++) {
            for (int32_t v = 0; v < n; v++) {
                double force = 0.0;
                for (int32_t b = 0; owner_of(v) < 0 && b < n; b++) {
                    force += Q[v * n + b] * x[b * count];
                }
                x[v * count] = fmin(fmax(x[v * count] - 1.9 * force / Q[v * n + v], 0.0), 1.0);
            }
        }
    }
    for (int32_t v = 0; v < n; v++) {
        double sum = 0.0;
        for (int32_t h = 0; h < count; h++) {
            sum += w[v * count + h];
        }
        for (int32_t h = 0; h < count; h++) {
            w[v * count + h] /= sum;
        }
    }
    return w;
}

/* Rings 0 and N are the handles, so w depends on x alone. M^-1 L w is linear in x between them, so
 * w is cubic, and at the last ring, with half the mass, 2 (w_0 - w_1) / h^2 = -w''(0). By symmetry
 * w = 1/2 - b ((3/4 + h^2) t - t^3) at t = x - 1/2, b = 2 / (1 + 2 h^2), h = 1 / N. */
static void tube_between_its_ends_is_cubic(void)
{
    enum { rings = 20, segments = 9 };
    start_scene();
    add_tube(rings, segments, 0.0);
    add_handle(0);
    for (int32_t v = 1; v < segments; v++) {
        extend_handle(v);
    }
    add_handle(rings * segments);
    for (int32_t v = 1; v < segments; v++) {
        extend_handle(rings * segments + v);
    }
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged);
    double h = 1.0 / rings, b = 2.0 / (1.0 + 2.0 * h * h);
    for (int32_t v = 0; v < s.vertex_count; v++) {
        double t = v / segments * h - 0.5;
        double expected = 0.5 + b * ((0.75 + h * h) * -t + t * t * t);
        CHECK_NEAR(weight_of(v, 0), expected, 1e-10);
        CHECK_NEAR(weight_of(v, 1), 1.0 - expected, 1e-10);
    }
}

static void rows_sum_to_one_within_bounds(void)
{
    bumpy_scene();
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged && s.info.iterations > 0);
    CHECK(s.info.gap <= 1e-6 && s.info.kkt_residual < 1e-8 && s.info.bound_violation < 1e-3);
    CHECK(s.info.struct_size == sizeof s.info);
    for (int32_t v = 0; v < s.vertex_count; v++) {
        double sum = 0.0;
        for (int32_t h = 0; h < s.handle_count; h++) {
            CHECK(weight_of(v, h) >= 0.0 && weight_of(v, h) <= 1.0);
            CHECK(owner_of(v) < 0 || weight_of(v, h) == (owner_of(v) == h ? 1.0 : 0.0));
            sum += weight_of(v, h);
        }
        CHECK_NEAR(sum, 1.0, 1e-14);
    }
}

static double distance_to_reference(int32_t sweeps)
{
    double *Q = dense_bilaplacian(), *reference = reference_weights(Q, sweeps), largest = 0.0;
    for (int32_t i = 0; i < s.vertex_count * s.handle_count; i++) {
        largest = fmax(largest, fabs(s.weights[i] - reference[i]));
    }
    free(Q);
    free(reference);
    return largest;
}

/* A handle reaches as far as its weights count, and no further. */
static void weights_are_zero_or_count(void)
{
    bumpy_scene();
    CHECK(compute_weights(&silent) == TUG_OK);
    int32_t zeros = 0;
    for (int32_t i = 0; i < s.vertex_count * s.handle_count; i++) {
        zeros += s.weights[i] == 0.0;
        CHECK(s.weights[i] == 0.0 || s.weights[i] > s.options.tolerance);
    }
    CHECK(zeros > s.vertex_count / 2);
}

static void agrees_with_slow_reference(void)
{
    start_scene();
    add_tube(11, 7, 0.3);
    add_handle(0);
    extend_handle(1);
    add_handle(5 * 7 + 3);
    add_handle(11 * 7 + 5);
    s.options.tolerance = 1e-10;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged);
    CHECK(distance_to_reference(20000) < 1e-5);
    s.options.tolerance = 1e-6;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(distance_to_reference(20000) < 1e-3);
}

/* Sheared so far that many cotangents are negative. */
static void agrees_where_cotangents_are_negative(void)
{
    start_scene();
    add_sheet(9, 7, 0);
    for (int32_t v = 0; v < s.vertex_count; v++) {
        s.vertices[3 * v] += 1.5 * s.vertices[3 * v + 1];
    }
    add_handle(0);
    add_handle(4 * 8 + 4);
    add_handle(s.vertex_count - 1);
    s.options.tolerance = 1e-10;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged);
    CHECK(distance_to_reference(20000) < 1e-5);
}

/* Of two handles the weights sum to one before they are divided, so they must be optimal as they
 * are: no force inside of the bounds, and one towards the bound on it. */
static void two_handles_are_optimal(void)
{
    start_scene();
    add_sheet(16, 12, 0);
    add_handle(5 * 13 + 6);
    add_handle(9 * 13 + 6);
    s.options.tolerance = 1e-11;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged);
    int32_t n = s.vertex_count, bound = 0;
    double *Q = dense_bilaplacian(), largest = 0.0, worst = 0.0;
    for (int32_t v = 0; v < n; v++) {
        double force = 0.0, w = weight_of(v, 0);
        for (int32_t b = 0; b < n; b++) {
            force += Q[v * n + b] * weight_of(b, 0);
        }
        largest = fmax(largest, fabs(force));
        if (owner_of(v) < 0) {
            bound += w == 0.0 || w == 1.0;
            worst = fmax(worst, w > 1e-7 ? force : 0.0);
            worst = fmax(worst, w < 1.0 - 1e-7 ? -force : 0.0);
        }
    }
    free(Q);
    CHECK(bound > 0);
    CHECK(worst < 1e-12 * largest);
}

static void unit_of_length_does_not_matter(void)
{
    bumpy_scene();
    CHECK(compute_weights(&silent) == TUG_OK);
    other = s;
    double factor[] = {1e-4, 1e5};
    for (int f = 0; f < 2; f++) {
        for (int32_t i = 0; i < 3 * s.vertex_count; i++) {
            s.vertices[i] = other.vertices[i] * factor[f];
        }
        CHECK(compute_weights(&silent) == TUG_OK);
        for (int32_t i = 0; i < s.vertex_count * s.handle_count; i++) {
            CHECK_NEAR(s.weights[i], other.weights[i], 1e-6);
        }
    }
}

static void threads_do_not_change_a_bit(void)
{
    bumpy_scene();
    s.options.threads = 1;
    CHECK(compute_weights(&silent) == TUG_OK);
    other = s;
    for (int32_t threads = 0; threads <= 7; threads += 7) {
        s.options.threads = threads;
        CHECK(compute_weights(&silent) == TUG_OK);
        CHECK(memcmp(s.weights, other.weights, sizeof s.weights) == 0);
        CHECK(s.info.gap == other.info.gap && s.info.iterations == other.info.iterations);
    }
}

static void iteration_limit_gives_the_best_so_far(void)
{
    bumpy_scene();
    double gap = INFINITY;
    for (int32_t limit = 0; limit < 4; limit++) {
        s.options.max_iterations = limit;
        CHECK(compute_weights(&silent) == TUG_OK);
        CHECK(!s.info.converged && s.info.iterations == limit);
        CHECK(s.info.gap > 1e-6 && s.info.gap < gap);
        gap = s.info.gap;
        for (int32_t i = 0; i < s.vertex_count * s.handle_count; i++) {
            CHECK(s.weights[i] >= 0.0 && s.weights[i] <= 1.0);
        }
    }
}

/* A tolerance below the rounding: it stops all the same. */
static void unreachable_tolerance_ends(void)
{
    bumpy_scene();
    s.options.tolerance = 0.0;
    s.options.max_iterations = INT32_MAX;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.gap < 1e-12);
}

typedef struct watcher {
    int calls, calls_left, same_thread;
    double fraction;
    pthread_t thread;
} watcher;

static int watch_progress(void *user, const char *stage, double fraction)
{
    watcher *w = user;
    w->calls++;
    w->same_thread &= pthread_equal(w->thread, pthread_self()) != 0;
    w->same_thread &= stage[0] != '\0' && fraction >= w->fraction && fraction <= 1.0;
    w->fraction = fraction;
    return w->calls > w->calls_left;
}

static void progress_rises_in_the_calling_thread(void)
{
    watcher w = {.calls_left = INT32_MAX, .same_thread = 1, .thread = pthread_self()};
    progress_range range = {watch_progress, &w, 0.0, 1.0};
    bumpy_scene();
    CHECK(compute_weights(&range) == TUG_OK);
    CHECK(w.calls >= 2 && w.same_thread);
    CHECK_NEAR(w.fraction, 1.0, 0.0);
}

static void cancel_leaves_the_output(void)
{
    for (int calls = 0; calls < 2; calls++) {
        watcher w = {.calls_left = calls, .same_thread = 1, .thread = pthread_self()};
        progress_range range = {watch_progress, &w, 0.0, 1.0};
        bumpy_scene();
        s.weights[0] = -7.0;
        s.info.iterations = -7;
        CHECK(compute_weights(&range) == TUG_ERROR_CANCELLED);
        CHECK(w.calls == calls + 1);
        CHECK(s.weights[0] == -7.0 && s.info.iterations == -7);
    }
}

static void refuses_bad_handles(void)
{
    bumpy_scene();
    s.weights[0] = -7.0;
    add_handle(10 * 12);
    CHECK(compute_weights(&silent) == TUG_ERROR_HANDLES);
    CHECK(strstr(tug_error_text(), "handles 2 and 4 share vertex 120") != NULL);
    s.handle_vertices[4] = s.vertex_count;
    CHECK(compute_weights(&silent) == TUG_ERROR_ARGUMENT);
    CHECK(strstr(tug_error_text(), "handle 4 names vertex 300 of 300") != NULL);
    s.handle_vertices[4] = -1;
    CHECK(compute_weights(&silent) == TUG_ERROR_ARGUMENT);
    CHECK(s.weights[0] == -7.0);
}

/* A tube with two handles, one with a single handle, and one with none, nearest to handle 2. */
static void component_scene(void)
{
    start_scene();
    for (int32_t tube = 0; tube < 3; tube++) {
        int32_t first = s.vertex_count;
        add_tube(8, 6, 0.0);
        for (int32_t v = first; v < s.vertex_count; v++) {
            s.vertices[3 * v] += 20.0 * tube;
        }
    }
    add_handle(0);
    add_handle(50);
    add_handle(54 + 20);
}

static void components_get_the_handles_they_have(void)
{
    component_scene();
    s.weights[0] = -7.0;
    CHECK(compute_weights(&silent) == TUG_ERROR_HANDLES);
    CHECK(strstr(tug_error_text(),
                 "component 2 of 3 (54 vertices, for example vertex 108) has no "
                 "handle: put a handle on it, or let it follow the nearest") != NULL);
    CHECK(s.weights[0] == -7.0);
    s.options.follow_nearest = 1;
    CHECK(compute_weights(&silent) == TUG_OK);
    for (int32_t v = 0; v < s.vertex_count; v++) {
        CHECK((weight_of(v, 2) == 0.0) == (v < 54));
        CHECK(v < 54 || weight_of(v, 2) == 1.0);
    }
}

/* One handle for everything: nothing is left to solve. */
static void single_handle_moves_all(void)
{
    component_scene();
    s.handle_count = 1;
    s.options.follow_nearest = 1;
    CHECK(compute_weights(&silent) == TUG_OK);
    CHECK(s.info.converged && s.info.iterations == 0 && s.info.gap == 0.0);
    for (int32_t v = 0; v < s.vertex_count; v++) {
        CHECK(weight_of(v, 0) == 1.0);
    }
}

static void refuses_an_unsound_mesh(void)
{
    bumpy_scene();
    s.vertices[17] = NAN;
    CHECK(compute_weights(&silent) == TUG_ERROR_MESH);
}

static void weights_are_within_bounds(void)
{
    CHECK(compute_weights(&silent) == TUG_OK);
    for (int32_t i = 0; i < s.vertex_count * s.handle_count; i++) {
        CHECK(s.weights[i] >= 0.0 && s.weights[i] <= 1.0);
    }
}

/* A row of nearly flat triangles, and rows that shrink by the same factor each: the energy of
 * neither can be factored as it is. */
static void uneven_meshes_give_weights(void)
{
    for (int shrinking = 0; shrinking < 2; shrinking++) {
        start_scene();
        add_sheet(20, 20, 0);
        for (int32_t v = 0; v < s.vertex_count; v++) {
            double *p = s.vertices + 3 * v;
            p[0] = shrinking ? pow(0.3, p[0]) : p[0];
            p[1] = shrinking ? pow(0.3, p[1]) : p[1] == 7.0 ? 6.0000001 : p[1];
        }
        add_handle(0);
        add_handle(115);
        add_handle(s.vertex_count - 1);
        weights_are_within_bounds();
        CHECK(!test_failed_here);
    }
}

static void survives_every_failing_allocation(void)
{
    tug_mesh *mesh;
    component_scene();
    s.options.follow_nearest = 1;
    s.options.threads = 1;
    CHECK(mesh_create(s.vertices, s.vertex_count, 3, s.triangles, s.triangle_count, &mesh) ==
          TUG_OK);
    long before = live_allocations();
    tug_status status = TUG_ERROR_MEMORY;
    for (long successes = 0; status == TUG_ERROR_MEMORY && successes < 20000; successes++) {
        s.weights[0] = -7.0;
        fail_allocations_after(successes);
        status = bounded_biharmonic_weights(mesh, s.starts, s.handle_vertices, s.handle_count,
                                            &s.options, &silent, s.weights, NULL);
        fail_allocations_after(-1);
        CHECK(live_allocations() == before);
        CHECK(status == TUG_OK || (status == TUG_ERROR_MEMORY && s.weights[0] == -7.0));
    }
    CHECK(status == TUG_OK);
    mesh_destroy(mesh);
}

int main(int argc, char **argv)
{
    use_one_blas_thread();
    RUN(tube_between_its_ends_is_cubic);
    RUN(rows_sum_to_one_within_bounds);
    RUN(weights_are_zero_or_count);
    RUN(agrees_with_slow_reference);
    RUN(agrees_where_cotangents_are_negative);
    RUN(two_handles_are_optimal);
    RUN(unit_of_length_does_not_matter);
    RUN(threads_do_not_change_a_bit);
    RUN(iteration_limit_gives_the_best_so_far);
    RUN(unreachable_tolerance_ends);
    RUN(progress_rises_in_the_calling_thread);
    RUN(cancel_leaves_the_output);
    RUN(refuses_bad_handles);
    RUN(components_get_the_handles_they_have);
    RUN(single_handle_moves_all);
    RUN(refuses_an_unsound_mesh);
    RUN(uneven_meshes_give_weights);
    RUN(survives_every_failing_allocation);
    return TEST_RESULT;
}
