/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver/blend.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* u is found by cancellation from terms of the size of r, so below this part of r its digits are
 * noise, and u counts as this part of r: where the handles sit exactly on an example (u = 0) the
 * costs alone decide. f moves by at most sqrt(FLOOR r). */
static const double FLOOR = 4e-15;

/* The face's Hessian is raised by this part of its mean diagonal, so that shapes that are there
 * twice do no harm; what the raised step misses, the next one makes up for. */
static const double RIDGE = 1e-12;

/* Weights closer to zero are zero. */
static const double NOTHING = 1e-14;

int blend_workspace_create(int32_t groups, int32_t shapes, blend_workspace *w)
{
    size_t n = (size_t)groups * (size_t)shapes;
    w->gradient = allocate(n, sizeof *w->gradient);
    w->direction = allocate(n, sizeof *w->direction);
    w->reduced = allocate(n * n, sizeof *w->reduced);
    w->to_u = allocate(n, sizeof *w->to_u);
    w->along_d = allocate(n, sizeof *w->along_d);
    w->reduced_d = allocate(n, sizeof *w->reduced_d);
    w->kept = allocate(n, sizeof *w->kept);
    w->best = allocate(n, sizeof *w->best);
    w->free = allocate(n, sizeof *w->free);
    w->list = allocate(n, sizeof *w->list);
    w->pivot = allocate((size_t)groups, sizeof *w->pivot);
    return w->gradient && w->direction && w->reduced && w->to_u && w->along_d && w->reduced_d &&
           w->kept && w->best && w->free && w->list && w->pivot;
}

void blend_workspace_destroy(blend_workspace *w)
{
    release(w->gradient);
    release(w->direction);
    release(w->reduced);
    release(w->to_u);
    release(w->along_d);
    release(w->reduced_d);
    release(w->kept);
    release(w->best);
    release(w->free);
    release(w->list);
    release(w->pivot);
}

static int32_t size_of(const blend_problem *p)
{
    return p->groups * p->shapes;
}

static void find_gradient(const blend_problem *p, const double *B, double *gradient)
{
    size_t n = (size_t)size_of(p);
    memcpy(gradient, p->c, n * sizeof *gradient);
    for (size_t i = 0; i < n; i++) {
        if (B[i] != 0.0) {
            const double *row = p->Q + i * n;
            for (size_t j = 0; j < n; j++) {
                gradient[j] += B[i] * row[j];
            }
        }
    }
}

/* Above zero even where there is nothing to fit and r is zero. */
double raise_to_rounding(double u, double r)
{
    return fmax(u, FLOOR * fabs(r) + 1e-300);
}

/* u, from B and its gradient. */
static double find_u(const blend_problem *p, const double *B, const double *gradient)
{
    size_t n = (size_t)size_of(p);
    double u = 0.5 * (dot(B, gradient, n) + dot(B, p->c, n) + p->r);
    return raise_to_rounding(u, p->r);
}

/* The least that u can be. */
static double least_u(const blend_problem *p)
{
    return raise_to_rounding(0.0, p->r);
}

/* What an energy adds to f. */
static double weigh_energy(const blend_problem *p, double u)
{
    return p->squared ? u : sqrt(u);
}

static double find_objective(const blend_problem *p, const double *B, double u)
{
    return weigh_energy(p, u) + dot(p->d, B, (size_t)size_of(p));
}

/* The weight of d against u in the optimality conditions of f: 2 sqrt(u), or 1 without the root. */
static double find_tau(const blend_problem *p, double u)
{
    return p->squared ? 1.0 : 2.0 * sqrt(u);
}

/* Each group's largest entry is its pivot; the other free entries make up the face. */
static void choose_face(const blend_problem *p, const double *B, blend_workspace *w)
{
    w->face = 0;
    for (int32_t g = 0; g < p->groups; g++) {
        int32_t first = g * p->shapes, best = first;
        for (int32_t i = first; i < first + p->shapes; i++) {
            best = B[i] > B[best] ? i : best;
        }
        w->pivot[g] = best;
        w->free[best] = 1;
        for (int32_t i = first; i < first + p->shapes; i++) {
            if (w->free[i] && i != best) {
                w->list[w->face++] = i;
            }
        }
    }
}

/* Hessian, gradient of u and d along the face's directions e_i - e_pivot. */
static void reduce_to_face(const blend_problem *p, blend_workspace *w)
{
    size_t n = (size_t)size_of(p), q = (size_t)w->face;
    double mean = 0.0;
    for (size_t a = 0; a < q; a++) {
        int32_t i = w->list[a], pi = w->pivot[i / p->shapes];
        const double *row = p->Q + (size_t)i * n, *pivot_row = p->Q + (size_t)pi * n;
        for (size_t b = a; b < q; b++) {
            int32_t j = w->list[b], pj = w->pivot[j / p->shapes];
            w->reduced[a * q + b] = row[j] - row[pj] - pivot_row[j] + pivot_row[pj];
        }
        mean += w->reduced[a * q + a] / (double)q;
        w->reduced_d[a] = p->d[i] - p->d[pi];
        w->to_u[a] = w->gradient[pi] - w->gradient[i];
        w->along_d[a] = -w->reduced_d[a];
    }
    for (size_t a = 0; a < q; a++) {
        w->reduced[a * q + a] += RIDGE * mean;
    }
}

/* Factor the face's Hessian, raising its diagonal while it is not definite. */
static void factor_face(const blend_problem *p, blend_workspace *w)
{
    size_t q = (size_t)w->face;
    double ridge = 0.0;
    reduce_to_face(p, w);
    for (size_t a = 0; a < q; a++) {
        ridge += 1e-9 * fabs(w->reduced[a * q + a]) / (double)q;
    }
    for (int attempt = 0; attempt < 30 && !cholesky_factor(w->reduced, w->face); attempt++) {
        reduce_to_face(p, w);
        for (size_t a = 0; a < q; a++) {
            w->reduced[a * q + a] += ridge + 1e-200;
        }
        ridge *= 10.0;
    }
}

/* The tau of f's minimiser on the face. With p0 the step to the face's minimiser of u and p1 its
 * motion with tau: u = u0 + tau^2 kappa / 2 there, and tau = 2 sqrt(u) has the solution below;
 * where 2 kappa >= 1 it has none, f falls along p1 without end and a bound will stop it. */
static double choose_tau(const blend_problem *p, const blend_workspace *w, double u)
{
    if (p->squared) {
        return 1.0;
    }
    double u0 = u, kappa = 0.0;
    for (int32_t a = 0; a < w->face; a++) {
        int32_t i = w->list[a];
        double slope = w->gradient[i] - w->gradient[w->pivot[i / p->shapes]];
        u0 += 0.5 * slope * w->to_u[a];
        kappa -= w->reduced_d[a] * w->along_d[a];
    }
    u0 = fmax(u0, least_u(p));
    return 2.0 * sqrt(2.0 * kappa < 1.0 - 1e-12 ? u0 / (1.0 - 2.0 * kappa) : 1e6 * u);
}

/* The full step on the face, in all entries. */
static void find_direction(const blend_problem *p, blend_workspace *w, double u)
{
    factor_face(p, w);
    cholesky_solve(w->reduced, w->face, w->to_u, 1);
    cholesky_solve(w->reduced, w->face, w->along_d, 1);
    double tau = choose_tau(p, w, u);
    memset(w->direction, 0, (size_t)size_of(p) * sizeof *w->direction);
    for (int32_t a = 0; a < w->face; a++) {
        double step = w->to_u[a] + tau * w->along_d[a];
        w->direction[w->list[a]] = step;
        w->direction[w->pivot[w->list[a] / p->shapes]] -= step;
    }
}

/* B <- B + direction as far as the bounds let it; entries that reach zero leave the face. Returns
 * the part of the step that was taken. */
static double walk(const blend_problem *p, blend_workspace *w, double *B)
{
    int32_t n = size_of(p);
    double part = 1.0;
    for (int32_t i = 0; i < n; i++) {
        if (w->direction[i] < 0.0 && B[i] + part * w->direction[i] < 0.0) {
            part = B[i] / -w->direction[i];
        }
    }
    for (int32_t i = 0; i < n; i++) {
        B[i] += part * w->direction[i];
        if (part < 1.0 && w->direction[i] < 0.0 && B[i] <= NOTHING) {
            w->free[i] = 0;
        }
        B[i] = B[i] <= NOTHING ? 0.0 : B[i];
    }
    return part;
}

/* Entries that were set to zero took a little from their row's sum. */
static void restore_sums(const blend_problem *p, double *B)
{
    for (int32_t g = 0; g < p->groups; g++) {
        double sum = 0.0;
        for (int32_t s = 0; s < p->shapes; s++) {
            sum += B[g * p->shapes + s];
        }
        for (int32_t s = 0; s < p->shapes; s++) {
            B[g * p->shapes + s] /= sum;
        }
    }
}

/* f is convex, so it exceeds its minimum by at most grad f^T B - min grad f^T B' over the
 * simplices; and, since u has a least value, by at most what f is above that and min d^T B', which
 * is the one that tells where u is at its least and has no gradient. */
static double find_gap(const blend_problem *p, const blend_workspace *w, const double *B, double u)
{
    double gap = 0.0, least_f = weigh_energy(p, least_u(p)), tau = find_tau(p, u);
    for (int32_t g = 0; g < p->groups; g++) {
        double mean = 0.0, least = INFINITY, cheapest = INFINITY;
        for (int32_t i = g * p->shapes; i < (g + 1) * p->shapes; i++) {
            double slope = w->gradient[i] / tau + p->d[i];
            mean += B[i] * slope;
            least = fmin(least, slope);
            cheapest = fmin(cheapest, p->d[i]);
        }
        gap += mean - least;
        least_f += cheapest;
    }
    return fmax(fmin(gap, find_objective(p, B, u) - least_f), 0.0);
}

/* Free the entries at zero along which f falls: each group's best, or only the best of all. Returns
 * how many. */
static int32_t release_entries(const blend_problem *p, blend_workspace *w, double tau, int one_only)
{
    int32_t released = 0, best_of_all = -1;
    double steepest = 0.0;
    for (int32_t g = 0; g < p->groups; g++) {
        int32_t pivot = w->pivot[g], best = -1;
        double level = w->gradient[pivot] + tau * p->d[pivot], least = -1e-15 * fabs(p->r);
        for (int32_t i = g * p->shapes; i < (g + 1) * p->shapes; i++) {
            double slope = w->gradient[i] + tau * p->d[i] - level;
            if (!w->free[i] && slope < least) {
                least = slope;
                best = i;
            }
        }
        if (best >= 0 && !one_only) {
            w->free[best] = 1;
            released++;
        }
        if (best >= 0 && least < steepest) {
            steepest = least;
            best_of_all = best;
        }
    }
    if (one_only && best_of_all >= 0) {
        w->free[best_of_all] = 1;
        released = 1;
    }
    return released;
}

/* Only entries above zero may move. */
static void free_support(const blend_problem *p, const double *B, blend_workspace *w)
{
    for (int32_t i = 0; i < size_of(p); i++) {
        w->free[i] = B[i] > 0.0;
    }
}

/* One step on the face. Returns the part of it that was taken. Where u is rounding along the face,
 * a step may lead upwards by more than that shows in f: it is not taken, the face counts as done.
 */
static double descend(const blend_problem *p, blend_workspace *w, double *B, blend_result *result)
{
    size_t bytes = (size_t)size_of(p) * sizeof *B;
    double rounding = 1e-15 * fabs(p->r) / find_tau(p, result->u);
    memcpy(w->kept, B, bytes);
    choose_face(p, B, w);
    find_direction(p, w, result->u);
    double part = walk(p, w, B);
    restore_sums(p, B);
    find_gradient(p, B, w->gradient);
    double u = find_u(p, B, w->gradient), objective = find_objective(p, B, u);
    if (objective > result->objective + rounding) {
        memcpy(B, w->kept, bytes);
        find_gradient(p, B, w->gradient);
        free_support(p, B, w);
        choose_face(p, B, w);
        return 1.0;
    }
    result->u = u;
    result->objective = objective;
    return part;
}

blend_result minimise_blend(const blend_problem *p, blend_workspace *w, double *B)
{
    int32_t limit = 100 + 20 * size_of(p), idle = 0;
    size_t bytes = (size_t)size_of(p) * sizeof *B;
    double precision = 1e-13 * sqrt(fabs(p->r));
    free_support(p, B, w);
    find_gradient(p, B, w->gradient);
    double u = find_u(p, B, w->gradient);
    blend_result result = {0, find_objective(p, B, u), u, INFINITY}, best = result;
    while (result.pivots < limit) {
        double before = result.objective, part = descend(p, w, B, &result);
        idle = result.objective < before - precision ? 0 : idle + 1;
        result.pivots++;
        if (part < 1.0 && result.pivots < limit) {
            continue;
        }
        result.gap = find_gap(p, w, B, result.u);
        if (result.gap < best.gap) { /* f may no longer show what is won */
            idle = best.pivots > 0 && result.gap < 0.9 * best.gap ? 0 : idle;
            best = result;
            memcpy(w->best, B, bytes);
        }
        if (result.gap <= 1e-12 * result.objective || idle > 3 ||
            (release_entries(p, w, find_tau(p, result.u), idle > 0) == 0 && idle > 0)) {
            break;
        }
    }
    if (best.gap < result.gap) {
        memcpy(B, w->best, bytes);
        best.pivots = result.pivots;
        return best;
    }
    return result;
}

int is_on_simplices(const double *B, int32_t groups, int32_t shapes)
{
    for (int32_t g = 0; g < groups; g++) {
        double sum = 0.0;
        for (int32_t i = g * shapes; i < (g + 1) * shapes; i++) {
            if (!(B[i] >= 0.0)) {
                return 0;
            }
            sum += B[i];
        }
        if (!(fabs(sum - 1.0) <= 1e-9)) {
            return 0;
        }
    }
    return 1;
}

tug_status minimise_blend_alone(int32_t groups, int32_t shapes, const double *Q, const double *c,
                                double r, const double *d, double lambda, int32_t squared,
                                double *B, tug_blend_info *info)
{
    if (!is_on_simplices(B, groups, shapes)) {
        return fail(TUG_ERROR_ARGUMENT,
                    "tug_minimise_blend: the blend to start from has a negative "
                    "weight or a row that does not sum to one");
    }
    size_t n = (size_t)groups * (size_t)shapes;
    blend_workspace workspace = {0};
    double *scaled = allocate(n, sizeof *scaled);
    int room = scaled != NULL && blend_workspace_create(groups, shapes, &workspace);
    if (room) {
        for (size_t i = 0; i < n; i++) {
            scaled[i] = lambda * d[i];
        }
        blend_problem problem = {groups, shapes, Q, c, r, scaled, squared};
        blend_result result = minimise_blend(&problem, &workspace, B);
        if (info != NULL) {
            *info = (tug_blend_info){sizeof *info, result.pivots, result.objective, result.gap};
        }
    }
    blend_workspace_destroy(&workspace);
    release(scaled);
    return room ? TUG_OK : fail_memory();
}
