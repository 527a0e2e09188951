/* SPDX-License-Identifier: Apache-2.0
 * Writes small ONNX models for tests: one convolution of 3 x 3 texels. Field numbers are those of the public
 * schema (onnx.proto). tests/python/test_onnx_models.py writes models with mistakes. */
#ifndef BN_TESTS_ONNX_WRITER_H
#define BN_TESTS_ONNX_WRITER_H

#include <stdint.h>
#include <string.h>

typedef struct message {
    unsigned char bytes[1 << 14];
    size_t size;
} message;

static inline void put_varint(message *m, uint64_t value) {
    while (value > 127) {
        m->bytes[m->size++] = (unsigned char)(value | 128);
        value >>= 7;
    }
    m->bytes[m->size++] = (unsigned char)value;
}

static inline void put_number(message *m, uint32_t field, uint64_t value) {
    put_varint(m, field << 3);
    put_varint(m, value);
}

static inline void put_bytes(message *m, uint32_t field, const void *bytes, size_t size) {
    put_varint(m, field << 3 | 2);
    put_varint(m, size);
    if (size != 0) memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static inline void put_text(message *m, uint32_t field, const char *text) {
    put_bytes(m, field, text, strlen(text));
}

static inline void put_message(message *m, uint32_t field, const message *inner) {
    put_bytes(m, field, inner->bytes, inner->size);
}

static inline void put_metadata(message *m, const char *key, const char *value) {
    message pair = {{0}, 0};
    if (value == NULL) return;
    put_text(&pair, 1, key);
    put_text(&pair, 2, value);
    put_message(m, 14, &pair);
}

/* What a model is made of; start from model_parts_default(). */
typedef struct model_parts {
    const char *radius, *align, *spacing; /* of the metadata; NULL leaves the entry out */
    uint32_t channels;
    uint32_t spare_outputs; /* of the node, that nothing uses and that take memory; up to 99 */
} model_parts;

static inline model_parts model_parts_default(void) {
    return (model_parts){.radius = "1", .align = "1", .channels = 1};
}

static inline void put_value(message *graph, uint32_t field, const char *name, uint32_t channels) {
    message value = {{0}, 0}, type = {{0}, 0}, tensor = {{0}, 0}, shape = {{0}, 0};
    for (uint32_t axis = 0; axis < 4; ++axis) {
        message extent = {{0}, 0};
        const char symbol[] = {'e', (char)('0' + axis), (char)('a' + field - 11), 0};
        if (axis < 2) put_number(&extent, 1, axis == 0 ? 1 : channels);
        if (axis >= 2) put_text(&extent, 2, symbol);
        put_message(&shape, 1, &extent);
    }
    put_number(&tensor, 1, 1);
    put_message(&tensor, 2, &shape);
    put_message(&type, 1, &tensor);
    put_text(&value, 1, name);
    put_message(&value, 2, &type);
    put_message(graph, field, &value);
}

/* Weights are a quarter in the middle, and zero elsewhere. */
static inline void put_weights(message *graph, uint32_t channels) {
    message tensor = {{0}, 0}, values = {{0}, 0};
    static const uint32_t extents[3] = {1, 3, 3};
    put_number(&tensor, 1, channels);
    for (int axis = 0; axis < 3; ++axis) put_number(&tensor, 1, extents[axis]);
    put_number(&tensor, 2, 1);
    put_text(&tensor, 8, "weights");
    for (values.size = 0; values.size < channels * 36; values.size += 36) {
        memcpy(values.bytes + values.size + 16, "\0\0\x80\x3e", 4);
    }
    put_bytes(&tensor, 9, values.bytes, values.size);
    put_message(graph, 5, &tensor);
}

static inline void make_model(const model_parts *parts, message *model) {
    message graph = {{0}, 0}, node = {{0}, 0}, opset = {{0}, 0};
    put_text(&node, 1, "noise");
    put_text(&node, 1, "weights");
    put_text(&node, 2, "mask");
    for (uint32_t i = 0; i < parts->spare_outputs; ++i) {
        const char name[] = {'s', (char)('0' + i / 10), (char)('0' + i % 10), 0};
        put_text(&node, 2, name);
    }
    put_text(&node, 4, "Conv");
    put_message(&graph, 1, &node);
    put_text(&graph, 2, "graph");
    put_weights(&graph, parts->channels);
    put_value(&graph, 11, "noise", 1);
    put_value(&graph, 12, "mask", parts->channels);
    put_text(&opset, 1, "");
    put_number(&opset, 2, 17);
    model->size = 0;
    put_number(model, 1, 8);
    put_message(model, 7, &graph);
    put_message(model, 8, &opset);
    put_metadata(model, "bn.receptive_radius", parts->radius);
    put_metadata(model, "bn.align", parts->align);
    put_metadata(model, "bn.sparse_spacing", parts->spacing);
    put_metadata(model, "bn.version", "1");
}

#endif
