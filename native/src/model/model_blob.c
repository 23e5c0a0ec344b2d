/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A model as one block of bytes: magic and version, checksum of all that follows, header, indices,
 * data. */
#include "model/model.h"

#include "dense/dense.h"
#include "memory.h"

#include <math.h>
#include <string.h>

static const char MAGIC[8] = {'T', 'U', 'G', 'M', 'O', 'D', 'E', 'L'};

enum { BLOB_VERSION = 3 };

typedef struct blob_front {
    char magic[8];
    uint32_t version;
    uint32_t byte_order; /* 1 in the order of the machine that wrote it */
    uint64_t checksum;
    model_header header;
} blob_front;

static const uint64_t CHECKSUM_START = 0xcbf29ce484222325U;

/* FNV-1a over 64-bit words: the length is a multiple of eight. */
static uint64_t checksum_words(uint64_t sum, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    for (size_t i = 0; i + 8 <= size; i += 8) {
        uint64_t word;
        memcpy(&word, at + i, 8);
        sum = (sum ^ word) * 0x100000001b3U;
        sum ^= sum >> 29; /* words, not bytes: let the high bits come down */
    }
    return sum;
}

static size_t index_bytes(const tug_model *model)
{
    return model->index_count * sizeof *model->indices;
}

static size_t data_bytes(const tug_model *model)
{
    return model->data_count * sizeof *model->data;
}

size_t model_blob_size(const tug_model *model)
{
    return sizeof(blob_front) + index_bytes(model) + data_bytes(model);
}

tug_status model_save(const tug_model *model, void *blob, size_t size)
{
    if (size < model_blob_size(model)) {
        return fail(TUG_ERROR_ARGUMENT, "tug_save_model: the model needs %zu bytes, not %zu",
                    model_blob_size(model), size);
    }
    blob_front front = {.version = BLOB_VERSION, .byte_order = 1, .header = model->header};
    memcpy(front.magic, MAGIC, sizeof MAGIC);
    uint64_t sum = checksum_words(CHECKSUM_START, &model->header, sizeof model->header);
    sum = checksum_words(sum, model->indices, index_bytes(model));
    front.checksum = checksum_words(sum, model->data, data_bytes(model));
    char *at = blob;
    memcpy(at, &front, sizeof front);
    memcpy(at + sizeof front, model->indices, index_bytes(model));
    memcpy(at + sizeof front + index_bytes(model), model->data, data_bytes(model));
    return TUG_OK;
}

/* Doubles in the largest arrays of such a model, found without overflow. */
static double largest_array(const model_header *header)
{
    double n = header->vertices, k = header->dimension, S = header->shapes, m = header->weights;
    double h = header->rows, G = header->groups, seen = header->seen;
    double p = S * k, turned = G * p, unknowns = m * (1.0 + p);
    double columns = fmax(p, m), groups = fmax(0.5 * turned * turned, seen * p * (1.0 + p));
    return fmax(fmax(n * columns, groups), fmax(h, 0.5 * unknowns) * fmax(unknowns, turned));
}

static int header_is_sane(const model_header *header, size_t size)
{
    const int32_t counts[] = {header->vertices, header->shapes, header->weights,
                              header->rows,     header->groups, header->seen};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        if (counts[i] < 1) {
            return 0;
        }
    }
    return (header->dimension == 2 || header->dimension == 3) && header->unit > 0.0 &&
           isfinite(header->unit) && (header->soft == 0 || header->soft == 1) &&
           largest_array(header) <= (double)(size / sizeof(double));
}

static tug_status fail_damaged(void)
{
    return fail(TUG_ERROR_BLOB, "tug_load_model: the model is damaged or cut short: bind again");
}

/* payload: what follows the front. */
static tug_status check_front(const blob_front *front, const void *payload, size_t size)
{
    if (memcmp(front->magic, MAGIC, sizeof MAGIC) != 0) {
        return fail(TUG_ERROR_BLOB, "tug_load_model: this is not a Tug model");
    }
    if (front->version != BLOB_VERSION || front->byte_order != 1) {
        return fail(TUG_ERROR_BLOB,
                    "tug_load_model: the model is of format %u, this library reads %d: bind again",
                    front->version, BLOB_VERSION);
    }
    uint64_t sum = checksum_words(CHECKSUM_START, &front->header, sizeof front->header);
    if (size % sizeof(double) != 0 || front->checksum != checksum_words(sum, payload, size) ||
        !header_is_sane(&front->header, size)) {
        return fail_damaged();
    }
    return TUG_OK;
}

/* Whether the index block begins with the groups' functions: each group's in rising order. */
static int support_is_sane(const model_header *header, const support *seen)
{
    const int32_t *starts = seen->starts;
    int sane = starts[0] == 0 && starts[header->groups] == header->seen;
    for (int32_t g = 0; g < header->groups && sane; g++) {
        sane = starts[g] <= starts[g + 1] && starts[g + 1] <= header->seen;
        int32_t least = 0;
        for (int32_t i = starts[g]; i < starts[g + 1] && sane; i++) {
            sane = seen->functions[i] >= least && seen->functions[i] < header->weights;
            least = seen->functions[i] + 1;
        }
    }
    return sane;
}

/* A copy of the groups' functions, which may lie anywhere in memory. */
static tug_status read_support(const model_header *header, const void *payload, size_t size,
                               support *out)
{
    size_t starts = (size_t)header->groups + 1, functions = (size_t)header->seen;
    if (starts + functions > size / sizeof(int32_t)) {
        return fail_damaged();
    }
    *out = (support){allocate(starts, sizeof *out->starts),
                     allocate(functions, sizeof *out->functions)};
    if (out->starts == NULL || out->functions == NULL) {
        support_destroy(out);
        return fail_memory();
    }
    memcpy(out->starts, payload, starts * sizeof *out->starts);
    memcpy(out->functions, (const char *)payload + starts * sizeof *out->starts,
           functions * sizeof *out->functions);
    if (!support_is_sane(header, out)) {
        support_destroy(out);
        return fail_damaged();
    }
    return TUG_OK;
}

static int ranks_are_sane(const reduction *energy)
{
    int sane = *energy->rank >= 0 && *energy->rank <= energy->unknowns;
    for (int32_t i = 0; i < energy->unknowns && sane; i++) {
        sane = energy->pivots[i] >= 0 && energy->pivots[i] < energy->unknowns;
    }
    return sane;
}

static int pivots_are_sane(const tug_model *model)
{
    int sane = ranks_are_sane(&model->energy);
    for (int32_t s = 0; s < model->header.shapes && sane; s++) {
        sane = ranks_are_sane(&model->shape[s].energy);
    }
    return sane;
}

static tug_status read_model(const model_header *header, const char *payload, size_t size,
                             tug_model **out)
{
    support seen;
    tug_model *model = NULL;
    tug_status status = read_support(header, payload, size, &seen);
    if (status == TUG_OK) {
        status = model_allocate(header, &seen, &model);
        support_destroy(&seen);
    }
    if (status != TUG_OK) {
        return status;
    }
    int whole = index_bytes(model) + data_bytes(model) == size;
    if (whole) {
        memcpy(model->indices, payload, index_bytes(model));
        memcpy(model->data, payload + index_bytes(model), data_bytes(model));
    }
    if (!whole || !pivots_are_sane(model)) {
        model_destroy(model);
        return fail_damaged();
    }
    use_one_blas_thread(); /* for its solves: this process may never have made a model */
    *out = model;
    return TUG_OK;
}

tug_status model_load(const void *blob, size_t size, tug_model **out)
{
    blob_front front;
    if (size < sizeof front) {
        return fail(TUG_ERROR_BLOB, "tug_load_model: %zu bytes are no Tug model", size);
    }
    memcpy(&front, blob, sizeof front);
    const char *payload = (const char *)blob + sizeof front;
    tug_status status = check_front(&front, payload, size - sizeof front);
    return status == TUG_OK ? read_model(&front.header, payload, size - sizeof front, out) : status;
}
