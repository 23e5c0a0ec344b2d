/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coordinate descent alone needs thousands of sweeps where columns of X are nearly collinear, and a
 * dictionary's are. So a sweep only finds out which entries may be other than zero; between the
 * sweeps the objective, which is quadratic as long as no sign changes, is minimised over these
 * directly. It never rises, and as there are only so many sets of signs that ends. */
#include "solver/elastic_net.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

/* A column has converged when the duality gap is below this part of the objective at zero. */
static const double TOLERANCE = 1e-12;

/* After so many rounds that did not lower the objective by more than its rounding, in parts of that
 * at zero, the gap will not fall either: a sparsity of 1e-12 of what draws the entries is lost. */
enum { PATIENCE = 4, MAX_ROUNDS = 1000 };
static const double ROUNDING = 1e-15;

/* Members whose squared distance from the span of the others is below this depend on them. */
static const double RANK_TOLERANCE = 1e-12;

/* Eigenvalues below this part of the largest are zero. */
static const double LEAST_EIGENVALUE = 1e-12;

/* Eigenvalues of Lambda may be negative by this part of the largest: rounding. */
static const double LEAST_NEGATIVE = 1e-9;

void elastic_net_free(elastic_net *net)
{
    release(net->X);
    release(net->G);
    release(net->inverse);
    release(net->t);
    release(net->c);
    release(net->slack);
    release(net->factor);
    release(net->scale);
    release(net->step);
    release(net->work);
    release(net->members);
    release(net->pivots);
    memset(net, 0, sizeof *net);
}

static int allocate_net(elastic_net *net)
{
    size_t b = (size_t)net->unknowns, h = (size_t)net->rows;
    net->X = allocate(h * b, sizeof *net->X);
    net->G = allocate(b * b, sizeof *net->G);
    net->t = allocate(b, sizeof *net->t);
    net->c = allocate(b, sizeof *net->c);
    net->slack = allocate(b, sizeof *net->slack);
    net->factor = allocate(b * b, sizeof *net->factor);
    net->scale = allocate(b, sizeof *net->scale);
    net->step = allocate(b, sizeof *net->step);
    net->work = allocate(2 * b, sizeof *net->work);
    net->members = allocate(b, sizeof *net->members);
    net->pivots = allocate(b, sizeof *net->pivots);
    return net->X && net->G && net->t && net->c && net->slack && net->factor && net->scale &&
           net->step && net->work && net->members && net->pivots;
}

/* Only the symmetric part of Lambda counts. */
static tug_status find_gram_matrix(elastic_net *net, const elastic_net_problem *p)
{
    size_t b = (size_t)p->unknowns;
    for (size_t i = 0; i < b && p->Lambda != NULL; i++) {
        for (size_t j = 0; j < b; j++) {
            double both = p->Lambda[i * b + j] + p->Lambda[j * b + i];
            net->G[i * b + j] = 0.5 * p->smoothness * both;
        }
    }
    add_product_tn(p->unknowns, p->unknowns, p->rows, p->fit, p->X, p->unknowns, p->X, p->unknowns,
                   net->G, p->unknowns);
    for (size_t i = 0; i < b * b; i++) {
        if (!isfinite(net->G[i])) {
            return fail(TUG_ERROR_NUMERIC, "the squares of X or Lambda are too large");
        }
    }
    return TUG_OK;
}

/* inverse = G^+ fit X^T, from the eigenvectors of G: (F 22), of least norm where it leaves T open.
 */
static tug_status find_inverse(elastic_net *net)
{
    int32_t b = net->unknowns, h = net->rows;
    size_t size = (size_t)b;
    double *vectors = net->factor, *values = net->scale;
    double *work = allocate(34 * size, sizeof *work);
    double *shares = allocate(size * (size_t)h, sizeof *shares);
    net->inverse = allocate(size * (size_t)h, sizeof *net->inverse);
    tug_status status = work && shares && net->inverse ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        memcpy(vectors, net->G, size * size * sizeof *vectors);
        if (!symmetric_eigenpairs(vectors, b, values, work)) {
            status = fail(TUG_ERROR_NUMERIC, "the eigenvalues of X and Lambda were not found");
        }
    }
    if (status == TUG_OK) {
        add_product_nt(b, h, b, net->fit, vectors, b, net->X, b, shares, h);
        for (size_t i = 0; i < size; i++) {
            double inverse =
                values[i] > LEAST_EIGENVALUE * values[size - 1] ? 1.0 / values[i] : 0.0;
            for (size_t r = 0; r < (size_t)h; r++) {
                shares[i * (size_t)h + r] *= inverse;
            }
        }
        add_product_tn(b, h, b, 1.0, vectors, b, shares, h, net->inverse, h);
    }
    release(work);
    release(shares);
    return status;
}

tug_status elastic_net_create(const elastic_net_problem *problem, elastic_net *out)
{
    *out = (elastic_net){.rows = problem->rows,
                         .unknowns = problem->unknowns,
                         .fit = problem->fit,
                         .sparsity = problem->sparsity};
    tug_status status = allocate_net(out) ? find_gram_matrix(out, problem) : fail_memory();
    if (status == TUG_OK) {
        size_t entries = (size_t)problem->rows * (size_t)problem->unknowns;
        memcpy(out->X, problem->X, entries * sizeof *out->X);
        status = problem->sparsity > 0.0 ? TUG_OK : find_inverse(out);
    }
    if (status != TUG_OK) {
        elastic_net_free(out);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------
 * One column
 */

static const double *row_of(const elastic_net *net, int32_t i)
{
    return net->G + (size_t)i * (size_t)net->unknowns;
}

static void change_entry(elastic_net *net, int32_t i, double change)
{
    const double *row = row_of(net, i);
    net->t[i] += change;
    for (int32_t j = 0; j < net->unknowns; j++) {
        net->slack[j] -= change * row[j];
    }
}

static double find_steepest(const elastic_net *net)
{
    double steepest = 0.0;
    for (int32_t i = 0; i < net->unknowns; i++) {
        steepest = fmax(steepest, fabs(net->slack[i]));
    }
    return steepest;
}

/* Each entry in turn to where it is best. Those that are zero stay so unless they are drawn away
 * half as strongly as any: most of them only stand in for a better one. */
static void sweep(elastic_net *net)
{
    double threshold = net->sparsity + 0.5 * fmax(find_steepest(net) - net->sparsity, 0.0);
    for (int32_t i = 0; i < net->unknowns; i++) {
        double curvature = row_of(net, i)[i];
        double pull = net->slack[i] + curvature * net->t[i];
        double least = net->t[i] != 0.0 ? net->sparsity : threshold;
        double best = 0.0;
        if (curvature > 0.0 && fabs(pull) > least) {
            best = (pull - copysign(net->sparsity, pull)) / curvature;
        }
        if (best != net->t[i]) {
            change_entry(net, i, best - net->t[i]);
            net->t[i] = best;
        }
    }
}

static int32_t list_members(elastic_net *net)
{
    int32_t count = 0;
    for (int32_t i = 0; i < net->unknowns; i++) {
        if (net->t[i] != 0.0) {
            net->members[count++] = i;
        }
    }
    return count;
}

/* Factors G in the support; returns its rank. */
static int32_t factor_support(elastic_net *net, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        int32_t member = net->members[i];
        net->scale[i] = 1.0 / sqrt(row_of(net, member)[member]);
    }
    for (int32_t i = 0; i < count; i++) {
        const double *row = row_of(net, net->members[i]);
        for (int32_t j = 0; j < count; j++) {
            net->factor[(size_t)i * (size_t)count + (size_t)j] =
                net->scale[i] * net->scale[j] * row[net->members[j]];
        }
    }
    return pivoted_cholesky(net->factor, count, RANK_TOLERANCE, net->pivots, net->work);
}

/* What stands in `work` by pivots goes to `step` by members. */
static void order_step(elastic_net *net, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        int32_t member = net->pivots[i];
        net->step[member] = net->scale[member] * net->work[i];
    }
}

/* The step to the least objective, were all signs of the support to stay. */
static void find_newton_step(elastic_net *net, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        int32_t member = net->members[net->pivots[i]];
        double slope = net->slack[member] - copysign(net->sparsity, net->t[member]);
        net->work[i] = net->scale[net->pivots[i]] * slope;
    }
    solve_right_upper(net->work, 1, count, net->factor, count, count);
    solve_right_upper_transposed(net->work, 1, count, net->factor, count, count);
    order_step(net, count);
}

/* A step along which X t and Lambda t stay as they are, but the entries' sum does not grow, and
 * which in the end takes one of them to zero: the first member that depends on others is exchanged
 * for them. */
static void find_idle_step(elastic_net *net, int32_t count, int32_t rank)
{
    memset(net->work, 0, (size_t)count * sizeof *net->work);
    for (int32_t i = 0; i < rank; i++) {
        net->work[i] = -net->factor[(size_t)i * (size_t)count + (size_t)rank];
    }
    solve_right_upper_transposed(net->work, 1, rank, net->factor, rank, count);
    net->work[rank] = 1.0;
    order_step(net, count);
    double growth = 0.0;
    for (int32_t i = 0; i < count; i++) {
        growth += copysign(net->step[i], net->step[i] * net->t[net->members[i]]);
    }
    double dependent = net->step[net->pivots[rank]] * net->t[net->members[net->pivots[rank]]];
    if (growth > 0.0 || (growth == 0.0 && dependent > 0.0)) {
        for (int32_t i = 0; i < count; i++) {
            net->step[i] = -net->step[i];
        }
    }
}

/* How far along the step the first entry becomes zero, INFINITY where none does, and which. */
static double find_first_zero(const elastic_net *net, int32_t count, int32_t *which)
{
    double first = INFINITY;
    for (int32_t i = 0; i < count; i++) {
        double value = net->t[net->members[i]], step = net->step[i];
        int falls = value > 0.0 ? step < 0.0 : step > 0.0;
        if (falls && -value / step < first) {
            first = -value / step;
            *which = i;
        }
    }
    return first;
}

/* By how much the objective rises over a whole step that is cut where an entry would change its
 * sign. work: the cut step. */
static double find_rise(elastic_net *net, int32_t count)
{
    double rise = 0.0;
    for (int32_t i = 0; i < count; i++) {
        double value = net->t[net->members[i]], sum = value + net->step[i];
        net->work[i] = sum * value > 0.0 ? net->step[i] : -value;
        rise += net->sparsity * copysign(net->work[i], value * net->work[i]);
    }
    for (int32_t i = 0; i < count; i++) {
        const double *row = row_of(net, net->members[i]);
        double product = -net->slack[net->members[i]];
        for (int32_t j = 0; j < count; j++) {
            product += 0.5 * row[net->members[j]] * net->work[j];
        }
        rise += net->work[i] * product;
    }
    return rise;
}

static void find_slack(elastic_net *net)
{
    memcpy(net->slack, net->c, (size_t)net->unknowns * sizeof *net->slack);
    for (int32_t i = 0; i < net->unknowns; i++) {
        const double *row = row_of(net, i);
        for (int32_t j = 0; j < net->unknowns && net->t[i] != 0.0; j++) {
            net->slack[j] -= net->t[i] * row[j];
        }
    }
}

/* `part` of the step; entries that would change their sign, and `zero` in any case, become zero. */
static void take_step(elastic_net *net, int32_t count, double part, int32_t zero)
{
    for (int32_t i = 0; i < count; i++) {
        double *value = net->t + net->members[i], sum = *value + part * net->step[i];
        *value = sum * *value > 0.0 && i != zero ? sum : 0.0;
    }
    find_slack(net);
}

/* To the least objective with these signs or fewer. A step that would change a sign is cut there
 * for all entries whose sign would change at once; where that would raise the objective, it ends
 * where the first of them is zero. */
static void settle_support(elastic_net *net)
{
    int settled = 0;
    for (int32_t count = list_members(net); count > 0 && !settled; count = list_members(net)) {
        int32_t rank = factor_support(net, count), zero = -1;
        int independent = rank == count;
        if (independent) {
            find_newton_step(net, count);
        } else {
            find_idle_step(net, count, rank);
        }
        double first = find_first_zero(net, count, &zero);
        settled = independent && first > 1.0;
        if (settled || (independent && find_rise(net, count) < 0.0)) {
            take_step(net, count, 1.0, -1);
        } else {
            take_step(net, count, first, zero);
        }
    }
}

/* How far the objective is above its optimum at most: less the dual objective at the residual times
 * the largest part that is feasible,
 *
 *     1/2 (1 - part)^2 |residual|^2 + sum_i (sparsity |t_i| - part slack_i t_i),
 *
 * the residual being that of X t = y and sqrt(Lambda) t = 0. No term is negative. */
static double find_gap(const elastic_net *net, double squares)
{
    double steepest = find_steepest(net), residual = squares, gap = 0.0;
    for (int32_t i = 0; i < net->unknowns; i++) {
        residual -= (net->c[i] + net->slack[i]) * net->t[i];
    }
    double part = steepest > net->sparsity ? net->sparsity / steepest : 1.0;
    for (int32_t i = 0; i < net->unknowns; i++) {
        gap += net->sparsity * fabs(net->t[i]) - part * net->slack[i] * net->t[i];
    }
    return gap + 0.5 * (1.0 - part) * (1.0 - part) * fmax(residual, 0.0);
}

static double find_objective(const elastic_net *net, double squares)
{
    double objective = 0.5 * squares;
    for (int32_t i = 0; i < net->unknowns; i++) {
        objective += net->sparsity * fabs(net->t[i]);
        objective -= 0.5 * (net->c[i] + net->slack[i]) * net->t[i];
    }
    return objective;
}

/* t for net->c. squares: fit |y|^2. */
static void solve_column(elastic_net *net, double squares, tug_elastic_net_info *info)
{
    double scale = squares > 0.0 ? 0.5 * squares : 1.0, gap = INFINITY, objective = INFINITY;
    int32_t rounds = 0, idle = 0;
    memset(net->t, 0, (size_t)net->unknowns * sizeof *net->t);
    find_slack(net);
    while (gap > TOLERANCE * scale && idle < PATIENCE && rounds < MAX_ROUNDS) {
        double before = objective;
        sweep(net);
        settle_support(net);
        gap = find_gap(net, squares);
        objective = find_objective(net, squares);
        idle = objective < before - ROUNDING * scale ? 0 : idle + 1;
        rounds++;
    }
    info->rounds = rounds > info->rounds ? rounds : info->rounds;
    info->gap = fmax(info->gap, gap / scale);
}

void elastic_net_solve(elastic_net *net, const double *Y, int32_t k, double *T,
                       tug_elastic_net_info *info)
{
    size_t b = (size_t)net->unknowns, columns = (size_t)k;
    *info = (tug_elastic_net_info){.struct_size = sizeof *info};
    if (net->inverse != NULL) {
        memset(T, 0, b * columns * sizeof *T);
        add_product(net->unknowns, k, net->rows, 1.0, net->inverse, net->rows, Y, k, T, k);
    }
    for (size_t a = 0; a < columns && net->inverse == NULL; a++) {
        double squares = 0.0;
        memset(net->c, 0, b * sizeof *net->c);
        for (size_t r = 0; r < (size_t)net->rows; r++) {
            double y = Y[r * columns + a];
            squares += net->fit * y * y;
            for (size_t i = 0; i < b; i++) {
                net->c[i] += net->fit * y * net->X[r * b + i];
            }
        }
        solve_column(net, squares, info);
        for (size_t i = 0; i < b; i++) {
            T[i * columns + a] = net->t[i];
        }
    }
    info->converged = info->gap <= TOLERANCE;
}

static tug_status require_semidefinite(const elastic_net_problem *p)
{
    size_t b = (size_t)p->unknowns;
    double *A = allocate(b * b, sizeof *A), *values = allocate(b, sizeof *values);
    double *work = allocate(34 * b, sizeof *work);
    tug_status status = A && values && work ? TUG_OK : fail_memory();
    if (status == TUG_OK) {
        for (size_t i = 0; i < b * b; i++) {
            A[i] = 0.5 * (p->Lambda[i] + p->Lambda[i % b * b + i / b]);
        }
        int found = symmetric_eigenpairs(A, p->unknowns, values, work);
        if (!found || !(values[0] >= -LEAST_NEGATIVE * fabs(values[b - 1]))) {
            status = fail(TUG_ERROR_ARGUMENT, "tug_solve_elastic_net: Lambda is not positive "
                                              "semidefinite: the objective has no minimum");
        }
    }
    release(A);
    release(values);
    release(work);
    return status;
}

/* solve_elastic_net with room for T beside it, since a failed call leaves T as it was. */
static tug_status solve_aside(const elastic_net_problem *problem, const double *Y, int32_t k,
                              double *aside, double *T, tug_elastic_net_info *info)
{
    elastic_net net;
    tug_elastic_net_info found;
    if (!isfinite(problem->fit * dot(Y, Y, (size_t)problem->rows * (size_t)k))) {
        return fail(TUG_ERROR_NUMERIC, "the squares of Y are too large");
    }
    tug_status status = elastic_net_create(problem, &net);
    if (status != TUG_OK) {
        return status;
    }
    elastic_net_solve(&net, Y, k, aside, &found);
    elastic_net_free(&net);
    size_t entries = (size_t)problem->unknowns * (size_t)k;
    for (size_t i = 0; i < entries; i++) {
        if (!isfinite(aside[i])) {
            return fail(TUG_ERROR_NUMERIC, "X, Y and Lambda are too large or too small together");
        }
    }
    memcpy(T, aside, entries * sizeof *T);
    *info = found;
    return TUG_OK;
}

tug_status solve_elastic_net(const elastic_net_problem *problem, const double *Y, int32_t k,
                             double *T, tug_elastic_net_info *info)
{
    tug_status status = problem->Lambda != NULL ? require_semidefinite(problem) : TUG_OK;
    if (status != TUG_OK) {
        return status;
    }
    double *aside = allocate((size_t)problem->unknowns * (size_t)k, sizeof *aside);
    if (aside == NULL) {
        return fail_memory();
    }
    status = solve_aside(problem, Y, k, aside, T, info);
    release(aside);
    return status;
}
