/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A model as one block of bytes: magic and version, checksum of all that follows, header, data. */
#include "dense.h"
#include "model.h"

#include <math.h>
#include <string.h>

static const char MAGIC[8] = {'T', 'U', 'G', 'M', 'O', 'D', 'E', 'L'};

enum { BLOB_VERSION = 1 };

typedef struct blob_front {
    char magic[8];
    uint32_t version;
    uint32_t byte_order; /* 1 in the order of the machine that wrote it */
    uint64_t checksum;
    model_header header;
} blob_front;

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

static uint64_t find_checksum(const model_header *header, const void *data, size_t size)
{
    uint64_t sum = checksum_words(0xcbf29ce484222325U, header, sizeof *header);
    return checksum_words(sum, data, size);
}

size_t model_blob_size(const tug_model *model)
{
    return sizeof(blob_front) + model->data_count * sizeof *model->data;
}

tug_status model_save(const tug_model *model, void *blob, size_t size)
{
    size_t data_size = model->data_count * sizeof *model->data;
    if (size < model_blob_size(model)) {
        return fail(TUG_ERROR_ARGUMENT, "tug_save_model: the model needs %zu bytes, not %zu",
                    model_blob_size(model), size);
    }
    blob_front front = {.version = BLOB_VERSION, .byte_order = 1, .header = model->header};
    memcpy(front.magic, MAGIC, sizeof MAGIC);
    front.checksum = find_checksum(&model->header, model->data, data_size);
    memcpy(blob, &front, sizeof front);
    memcpy((char *)blob + sizeof front, model->data, data_size);
    return TUG_OK;
}

/* Doubles in the largest arrays of such a model, found without overflow. */
static double largest_array(const model_header *header)
{
    double n = header->vertices, k = header->dimension, S = header->shapes, m = header->weights;
    double h = header->rows, G = header->groups;
    double turned = G * S * k, unknowns = m * (1.0 + S * k), alone = m * (1.0 + k);
    double columns = fmax(S * k, m), rows = fmax(turned, h);
    return fmax(fmax(n * columns, rows * fmax(rows, unknowns)), S * G * alone * alone);
}

static int header_is_sane(const model_header *header, size_t size)
{
    const int32_t counts[] = {header->vertices, header->shapes, header->weights, header->rows,
                              header->groups};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        if (counts[i] < 1) {
            return 0;
        }
    }
    return (header->dimension == 2 || header->dimension == 3) && header->unit > 0.0 &&
           isfinite(header->unit) && largest_array(header) <= (double)(size / sizeof(double));
}

static tug_status check_front(const blob_front *front, const void *data, size_t size)
{
    if (memcmp(front->magic, MAGIC, sizeof MAGIC) != 0) {
        return fail(TUG_ERROR_BLOB, "tug_load_model: this is not a Tug model");
    }
    if (front->version != BLOB_VERSION || front->byte_order != 1) {
        return fail(TUG_ERROR_BLOB,
                    "tug_load_model: the model is of format %u, this library reads %d: bind again",
                    front->version, BLOB_VERSION);
    }
    if (size % sizeof(double) != 0 ||
        front->checksum != find_checksum(&front->header, data, size) ||
        !header_is_sane(&front->header, size)) {
        return fail(TUG_ERROR_BLOB,
                    "tug_load_model: the model is damaged or cut short: bind again");
    }
    return TUG_OK;
}

tug_status model_load(const void *blob, size_t size, tug_model **out)
{
    blob_front front;
    if (size < sizeof front) {
        return fail(TUG_ERROR_BLOB, "tug_load_model: %zu bytes are no Tug model", size);
    }
    memcpy(&front, blob, sizeof front);
    const void *data = (const char *)blob + sizeof front;
    size_t data_size = size - sizeof front;
    tug_status status = check_front(&front, data, data_size);
    if (status != TUG_OK) {
        return status;
    }
    tug_model *model = NULL;
    status = model_allocate(&front.header, &model);
    if (status != TUG_OK) {
        return status;
    }
    if (model->data_count * sizeof *model->data != data_size) {
        model_destroy(model);
        return fail(TUG_ERROR_BLOB,
                    "tug_load_model: the model is damaged or cut short: bind again");
    }
    memcpy(model->data, data, data_size);
    use_one_blas_thread(); /* for its solves: this process may never have made a model */
    *out = model;
    return TUG_OK;
}
