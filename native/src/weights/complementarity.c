/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Block principal pivoting (Judice and Pires 1994): solve with y = 0 on the support, then exchange
 * all members that came out negative; where that does not make their number fall for a while, only
 * the last one, which cannot cycle. */
#include "weights/complementarity.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

enum { patience = 8, most_exchanges = 200 };

/* Below these parts of the largest entry a number is rounding. */
static const double least_pivot = 1e-13, least_negative = 1e-12;

void complementarity_free(complementarity *problem)
{
    release(problem->sign);
    release(problem->q);
    release(problem->l);
    release(problem->support);
    release(problem->factor);
    release(problem->part);
    release(problem->slack);
    release(problem->members);
    release(problem->pivots);
    memset(problem, 0, sizeof *problem);
}

/* *array: `old` things of `size` bytes become the first of `count`. */
static int grow(void **array, size_t old, size_t count, size_t size)
{
    void *grown = allocate(count, size);
    if (grown == NULL) {
        return 0;
    }
    if (old > 0) {
        memcpy(grown, *array, old * size);
    }
    release(*array);
    *array = grown;
    return 1;
}

tug_status complementarity_reserve(complementarity *problem, int32_t count)
{
    if (count <= problem->capacity) {
        return TUG_OK;
    }
    size_t old = (size_t)problem->count, all = (size_t)count + (size_t)count / 2;
    int grown = grow((void **)&problem->sign, old, all, sizeof(double)) &&
                grow((void **)&problem->q, old, all, sizeof(double)) &&
                grow((void **)&problem->l, old, all, sizeof(double)) &&
                grow((void **)&problem->support, old, all, sizeof(uint8_t)) &&
                grow((void **)&problem->part, 0, all, sizeof(double)) &&
                grow((void **)&problem->slack, 0, all, sizeof(double)) &&
                grow((void **)&problem->members, 0, all, sizeof(int32_t)) &&
                grow((void **)&problem->pivots, 0, all, sizeof(int32_t));
    if (!grown) {
        return fail_memory();
    }
    problem->capacity = (int32_t)all;
    return TUG_OK;
}

static tug_status reserve_factor(complementarity *problem, int32_t count)
{
    if (count <= problem->factor_capacity) {
        return TUG_OK;
    }
    size_t side = (size_t)count + (size_t)count / 4;
    release(problem->factor);
    problem->factor_capacity = 0;
    problem->factor = allocate(side * (side + 2), sizeof(double));
    if (problem->factor == NULL) {
        return fail_memory();
    }
    problem->factor_capacity = (int32_t)side;
    return TUG_OK;
}

static int32_t list_support(complementarity *problem)
{
    int32_t count = 0;
    for (int32_t i = 0; i < problem->count; i++) {
        if (problem->support[i]) {
            problem->members[count++] = i;
        }
    }
    return count;
}

/* The part of G in the support, and its largest diagonal entry. */
static double gather_part(complementarity *problem, const double *G, int32_t stride, int32_t count)
{
    double largest = 0.0;
    for (int32_t a = 0; a < count; a++) {
        int32_t row = problem->members[a];
        const double *from = G + (size_t)row * (size_t)stride;
        double *to = problem->factor + (size_t)a * (size_t)count;
        for (int32_t b = 0; b < count; b++) {
            int32_t column = problem->members[b];
            to[b] = problem->sign[row] * problem->sign[column] * from[column];
        }
        largest = fmax(largest, to[a]);
    }
    return largest;
}

/* l with y = 0 on the support. Members whose rows of G depend on the others' get l = 0. */
static tug_status solve_on_support(complementarity *problem, const double *G, int32_t stride)
{
    memset(problem->l, 0, (size_t)problem->count * sizeof(double));
    int32_t count = list_support(problem);
    tug_status status = reserve_factor(problem, count);
    if (status != TUG_OK || count == 0) {
        return status;
    }
    double largest = gather_part(problem, G, stride, count);
    int32_t rank = pivoted_cholesky(problem->factor, count, least_pivot * largest, problem->pivots,
                                    problem->factor + (size_t)count * (size_t)count);
    for (int32_t a = 0; a < rank; a++) {
        problem->part[a] = -problem->q[problem->members[problem->pivots[a]]];
    }
    solve_right_upper(problem->part, 1, rank, problem->factor, rank, count);
    solve_right_upper_transposed(problem->part, 1, rank, problem->factor, rank, count);
    for (int32_t a = 0; a < rank; a++) {
        problem->l[problem->members[problem->pivots[a]]] = problem->part[a];
    }
    return TUG_OK;
}

static void find_slack(complementarity *problem, const double *G, int32_t stride)
{
    int32_t count = list_support(problem);
    for (int32_t i = 0; i < problem->count; i++) {
        const double *row = G + (size_t)i * (size_t)stride;
        double sum = 0.0;
        for (int32_t a = 0; !problem->support[i] && a < count; a++) {
            int32_t j = problem->members[a];
            sum += row[j] * problem->sign[j] * problem->l[j];
        }
        problem->slack[i] = problem->support[i] ? 0.0 : problem->q[i] + problem->sign[i] * sum;
    }
}

static double largest_of(const double *values, int32_t count)
{
    double largest = 0.0;
    for (int32_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(values[i]));
    }
    return largest;
}

/* Exchange every member with a negative l or slack, or only the last one. Returns how many there
 * are; exchanges none where `most` is zero. */
static int32_t exchange(complementarity *problem, int32_t most)
{
    double l_limit = -least_negative * largest_of(problem->l, problem->count);
    double q_limit = -least_negative * largest_of(problem->q, problem->count);
    int32_t negative = 0;
    for (int32_t i = problem->count - 1; i >= 0; i--) {
        double value = problem->support[i] ? problem->l[i] : problem->slack[i];
        if (value < (problem->support[i] ? l_limit : q_limit)) {
            if (negative < most) {
                problem->support[i] = !problem->support[i];
            }
            negative++;
        }
    }
    return negative;
}

static void clamp_multipliers(complementarity *problem)
{
    for (int32_t i = 0; i < problem->count; i++) {
        problem->l[i] = fmax(problem->l[i], 0.0);
    }
}

tug_status complementarity_solve(complementarity *problem, const double *G, int32_t stride,
                                 int *solved)
{
    int32_t fewest = problem->count + 1, tries = patience;
    *solved = 0;
    for (int32_t i = 0; i < most_exchanges && !*solved; i++) {
        tug_status status = solve_on_support(problem, G, stride);
        if (status != TUG_OK) {
            return status;
        }
        find_slack(problem, G, stride);
        int32_t negative = exchange(problem, 0);
        if (negative < fewest) {
            fewest = negative;
            tries = patience;
        } else {
            tries--;
        }
        *solved = negative == 0;
        exchange(problem, tries > 0 ? problem->count : 1);
    }
    clamp_multipliers(problem);
    return TUG_OK;
}
