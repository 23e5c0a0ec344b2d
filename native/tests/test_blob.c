/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Saved models: what comes back is the same to the last bit, and nothing but a whole and unchanged
 * blob is taken. */
#include "fixture.h"
#include "memory.h"
#include "test.h"

#include <stdlib.h>

/* A saved model, with room for a few bytes more. */
typedef struct saved {
    fixture f;
    tug_model *model;
    size_t size;
    unsigned char *blob;
} saved;

enum { ROOM = 64, HEADER = 64 };

static int save(saved *x, int space)
{
    space ? make_tube(&x->f, 1) : make_strip(&x->f);
    x->model = make_model(&x->f);
    x->size = tug_model_blob_size(x->model);
    x->blob = calloc(x->size + ROOM, 1);
    return tug_save_model(x->model, x->blob, x->size) == TUG_OK;
}

static void discard(saved *x)
{
    tug_destroy_model(x->model);
    free(x->blob);
}

/* Whether a blob of so many bytes is refused, with words, without a model and without a leak. */
static int is_refused(const void *blob, size_t size)
{
    long live = live_allocations();
    tug_model *model = (tug_model *)&live;
    tug_status status = tug_load_model(blob, size, &model);
    int refused = status == TUG_ERROR_BLOB && model == NULL && live_allocations() == live &&
                  strstr(tug_error_text(), "tug_load_model: ") == tug_error_text();
    if (status == TUG_OK) {
        tug_destroy_model(model);
    }
    return refused;
}

/* All that a default solver says about some targets. */
typedef struct answer {
    double positions[MAX_COORDINATES], blend[MAX_PAIRS], costs[MAX_PAIRS], rotations[9 * MAX_PAIRS];
} answer;

static int find_answer(const tug_model *model, const double *targets, int32_t form, answer *x)
{
    tug_solver_options options;
    tug_solver *solver;
    tug_default_solver_options(&options);
    options.form = form;
    memset(x, 0, sizeof *x);
    int good = tug_create_solver(model, &options, &solver) == TUG_OK &&
               tug_solve(solver, targets, NULL) == TUG_OK &&
               tug_get_positions(solver, x->positions) == TUG_OK &&
               tug_get_blend(solver, x->blend) == TUG_OK &&
               tug_get_costs(solver, x->costs) == TUG_OK &&
               tug_get_rotations(solver, x->rotations) == TUG_OK;
    tug_destroy_solver(solver);
    return good;
}

static void loaded_model_solves_as_the_saved_one(void)
{
    uint64_t random = 1;
    for (int i = 0; i < 6; i++) {
        saved x;
        CHECK(save(&x, i % 2));
        tug_model *loaded;
        CHECK(tug_load_model(x.blob, x.size, &loaded) == TUG_OK);
        double targets[3 * MAX_WEIGHTS];
        answer before, after;
        mix_targets(&x.f, &random, 0.1, targets);
        CHECK(find_answer(x.model, targets, i / 2, &before));
        memset(x.blob, 0, x.size); /* the model has to have its own copy */
        tug_destroy_model(x.model);
        x.model = NULL;
        CHECK(find_answer(loaded, targets, i / 2, &after));
        CHECK(memcmp(&before, &after, sizeof before) == 0);
        tug_destroy_model(loaded);
        discard(&x);
    }
}

static void loaded_model_saves_the_same_bytes(void)
{
    saved x;
    CHECK(save(&x, 1));
    tug_model *loaded;
    CHECK(tug_load_model(x.blob, x.size, &loaded) == TUG_OK);
    CHECK(tug_model_blob_size(loaded) == x.size);
    unsigned char *again = calloc(x.size + ROOM, 1);
    CHECK(tug_save_model(loaded, again, x.size + ROOM) == TUG_OK);
    CHECK(memcmp(again, x.blob, x.size + ROOM) == 0); /* no byte beyond the size is written */
    free(again);
    tug_destroy_model(loaded);
    discard(&x);
}

static void blob_may_lie_anywhere(void)
{
    saved x;
    CHECK(save(&x, 0));
    for (size_t shift = 1; shift < 8; shift++) {
        unsigned char *moved = malloc(x.size + shift);
        tug_model *loaded;
        CHECK(tug_save_model(x.model, moved + shift, x.size) == TUG_OK);
        CHECK(memcmp(moved + shift, x.blob, x.size) == 0);
        CHECK(tug_load_model(moved + shift, x.size, &loaded) == TUG_OK);
        tug_destroy_model(loaded);
        free(moved);
    }
    discard(&x);
}

static void too_little_room_is_refused(void)
{
    saved x;
    CHECK(save(&x, 0));
    memset(x.blob, 7, x.size);
    CHECK(tug_save_model(x.model, x.blob, x.size - 1) == TUG_ERROR_ARGUMENT);
    CHECK(tug_save_model(x.model, x.blob, 0) == TUG_ERROR_ARGUMENT);
    for (size_t i = 0; i < x.size; i++) {
        CHECK(x.blob[i] == 7);
    }
    discard(&x);
}

static void every_flipped_bit_of_the_header_is_noticed(void)
{
    saved x;
    CHECK(save(&x, 1));
    for (size_t bit = 0; bit < 8 * HEADER; bit++) {
        x.blob[bit / 8] ^= (unsigned char)(1 << bit % 8);
        CHECK(is_refused(x.blob, x.size));
        x.blob[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    for (size_t byte = 0; byte < HEADER; byte++) {
        unsigned char kept = x.blob[byte];
        x.blob[byte] = kept == 0xff ? 0 : 0xff;
        CHECK(is_refused(x.blob, x.size));
        x.blob[byte] = kept;
    }
    CHECK(!is_refused(x.blob, x.size));
    discard(&x);
}

static void changed_data_are_noticed(void)
{
    saved x;
    uint64_t random = 2;
    CHECK(save(&x, 1));
    for (int i = 0; i < 300; i++) {
        size_t at = (size_t)random_between(&random, HEADER, (double)x.size);
        unsigned char flip = (unsigned char)(1 << i % 8);
        x.blob[at] ^= flip;
        CHECK(is_refused(x.blob, x.size));
        x.blob[at] ^= flip;
    }
    for (size_t at = x.size - 16; at < x.size; at++) { /* to the last byte */
        x.blob[at] ^= 0x80;
        CHECK(is_refused(x.blob, x.size));
        x.blob[at] ^= 0x80;
    }
    CHECK(!is_refused(x.blob, x.size));
    discard(&x);
}

/* Sums and products of words do not notice these. */
static void exchanged_data_are_noticed(void)
{
    saved x;
    uint64_t random = 3;
    CHECK(save(&x, 1));
    size_t words = (x.size - HEADER) / 8;
    for (int i = 0; i < 100; i++) {
        size_t at = (size_t)random_between(&random, 0.0, (double)(words - 1));
        unsigned char *first = x.blob + HEADER + 8 * at, kept[16];
        memcpy(kept, first, 16);
        memcpy(first, kept + 8, 8);
        memcpy(first + 8, kept, 8);
        CHECK(memcmp(kept, kept + 8, 8) == 0 || is_refused(x.blob, x.size));
        memcpy(first, kept, 16);
    }
    discard(&x);
}

static void other_sizes_are_noticed(void)
{
    saved x;
    uint64_t random = 4;
    CHECK(save(&x, 1));
    for (size_t size = 0; size < 2 * HEADER; size++) {
        CHECK(is_refused(x.blob, size));
    }
    for (int i = 0; i < 50; i++) {
        CHECK(is_refused(x.blob, (size_t)random_between(&random, 0.0, (double)x.size)));
    }
    for (size_t size = x.size - 16; size < x.size; size++) {
        CHECK(is_refused(x.blob, size));
    }
    for (size_t more = 1; more <= ROOM; more++) {
        CHECK(is_refused(x.blob, x.size + more));
    }
    discard(&x);
}

/* The format's own checksum, put right after the header was changed: what remains is the sanity of
 * the sizes. */
static void sign(unsigned char *blob, size_t size)
{
    enum { CHECKSUM = 16, SIGNED = 24 };
    uint64_t sum = 0xcbf29ce484222325U;
    for (size_t i = SIGNED; i + 8 <= size; i += 8) {
        uint64_t word;
        memcpy(&word, blob + i, 8);
        sum = (sum ^ word) * 0x100000001b3U;
        sum ^= sum >> 29;
    }
    memcpy(blob + CHECKSUM, &sum, 8);
}

static void signed_nonsense_is_noticed(void)
{
    enum { COUNTS = 24, COUNT_FIELDS = 6 };
    const int32_t wrong[] = {0, -1, 1, 2, 7, 1000, 1 << 20, INT32_MAX, INT32_MIN};
    saved x;
    CHECK(save(&x, 1));
    unsigned char *unchanged = malloc(x.size);
    memcpy(unchanged, x.blob, x.size);
    sign(x.blob, x.size);
    CHECK(memcmp(unchanged, x.blob, x.size) == 0); /* the test knows the checksum */
    for (size_t i = 0; i < COUNT_FIELDS * sizeof wrong / sizeof *wrong; i++) {
        size_t at = COUNTS + 4 * (i % COUNT_FIELDS);
        memcpy(x.blob + at, wrong + i / COUNT_FIELDS, 4);
        sign(x.blob, x.size);
        CHECK(is_refused(x.blob, x.size));
        memcpy(x.blob + at, unchanged + at, 4);
    }
    const double units[] = {0.0, -1.0, NAN, INFINITY};
    for (size_t i = 0; i < 4; i++) {
        memcpy(x.blob + HEADER - 8, units + i, 8);
        sign(x.blob, x.size);
        CHECK(is_refused(x.blob, x.size));
    }
    free(unchanged);
    discard(&x);
}

static void foreign_bytes_are_refused_in_words(void)
{
    unsigned char bytes[256] = "a text file of some length, not a model";
    CHECK(is_refused(bytes, sizeof bytes));
    CHECK(strstr(tug_error_text(), "not a Tug model") != NULL);
    CHECK(is_refused(bytes, 0));
    saved x;
    CHECK(save(&x, 0));
    x.blob[8]++; /* the version */
    CHECK(is_refused(x.blob, x.size));
    CHECK(strstr(tug_error_text(), "format 4") != NULL);
    discard(&x);
}

int main(int argc, char **argv)
{
    RUN(loaded_model_solves_as_the_saved_one);
    RUN(loaded_model_saves_the_same_bytes);
    RUN(blob_may_lie_anywhere);
    RUN(too_little_room_is_refused);
    RUN(every_flipped_bit_of_the_header_is_noticed);
    RUN(changed_data_are_noticed);
    RUN(exchanged_data_are_noticed);
    RUN(other_sizes_are_noticed);
    RUN(signed_nonsense_is_noticed);
    RUN(foreign_bytes_are_refused_in_words);
    return TEST_RESULT;
}
