/* SPDX-License-Identifier: Apache-2.0
 * Writes small ONNX models for tests: one convolution, with every kind of mistake.
 * Field numbers are those of the public schema (onnx.proto). */
#ifndef BN_TESTS_ONNX_WRITER_H
#define BN_TESTS_ONNX_WRITER_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { MODEL_MOST_BYTES = 1 << 14 };

typedef struct message {
    unsigned char bytes[MODEL_MOST_BYTES];
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

static inline void put_pair(message *m, uint32_t field, const char *key, const char *value) {
    message pair = {{0}, 0};
    if (value == NULL) return;
    put_text(&pair, 1, key);
    put_text(&pair, 2, value);
    put_message(m, field, &pair);
}

/* Numbers from first on with steps between them, as the metadata has them. */
static inline void write_quantiles(char text[1024], int count, long first, long step) {
    size_t at = 0;
    for (int i = 0; i < count; ++i) {
        at += (size_t)snprintf(text + at, 1024 - at, "%s%ld", i > 0 ? "," : "", first + i * step);
    }
}

/* What a model is made of; start from model_parts_default(). */
typedef struct model_parts {
    const char *radius, *align, *version, *quantiles,
        *spacing;           /* of the metadata; NULL leaves the entry out */
    uint32_t kernel_radius; /* of the convolution */
    uint32_t channels;
    const char *operator_name, *operator_domain;
    const char *input, *output;
    uint32_t element;        /* type of input and output; 1 is float */
    uint32_t input_channels; /* as declared */
    uint32_t fixed_extent;   /* as declared of input and output; 0 for any */
    int external;            /* 1: the weights lie in another file; 2: they only say where */
    int subgraph, function, training, second_input, second_output, second_graph, no_nodes;
    uint32_t spare_outputs; /* of the node, that nothing uses and that take memory; up to 99 */
} model_parts;

static inline model_parts model_parts_default(void) {
    model_parts parts = {.radius = "1",
                         .align = "1",
                         .version = "1",
                         .kernel_radius = 1,
                         .channels = 1,
                         .operator_name = "Conv",
                         .operator_domain = "",
                         .input = "noise",
                         .output = "mask",
                         .element = 1,
                         .input_channels = 1};
    return parts;
}

/* The weight of the convolution at kernel position i for a channel: of both signs, sum near 1/2. */
static inline float model_weight(uint32_t channel, uint32_t i, uint32_t count) {
    return (float)(((i * 7 + channel * 3) % 11) - 4) / (float)count / 2;
}

static inline void put_tensor_value(message *graph, uint32_t field, const char *name,
                                    const model_parts *parts, uint32_t channels) {
    message value = {{0}, 0}, type = {{0}, 0}, tensor = {{0}, 0}, shape = {{0}, 0};
    for (int axis = 0; axis < 4; ++axis) {
        message extent = {{0}, 0};
        if (axis < 2 || parts->fixed_extent != 0) {
            put_number(&extent, 1, axis == 0 ? 1 : axis == 1 ? channels : parts->fixed_extent);
        } else {
            char symbol[] = {'e', (char)('0' + axis), (char)('a' + field - 11), 0};
            put_text(&extent, 2, symbol);
        }
        put_message(&shape, 1, &extent);
    }
    put_number(&tensor, 1, parts->element);
    put_message(&tensor, 2, &shape);
    put_message(&type, 1, &tensor);
    put_text(&value, 1, name);
    put_message(&value, 2, &type);
    put_message(graph, field, &value);
}

static inline void put_weights(message *graph, const model_parts *parts) {
    const uint32_t side = 2 * parts->kernel_radius + 1, count = side * side;
    message tensor = {{0}, 0}, values = {{0}, 0};
    put_number(&tensor, 1, parts->channels);
    put_number(&tensor, 1, 1);
    put_number(&tensor, 1, side);
    put_number(&tensor, 1, side);
    put_number(&tensor, 2, 1);
    put_text(&tensor, 8, "weights");
    for (uint32_t c = 0; c < parts->channels; ++c) {
        for (uint32_t i = 0; i < count; ++i) {
            const float weight = model_weight(c, i, count);
            uint32_t bits;
            memcpy(&bits, &weight, sizeof bits);
            for (int byte = 0; byte < 4; ++byte) {
                values.bytes[values.size++] = (unsigned char)(bits >> 8 * byte);
            }
        }
    }
    if (parts->external != 1) put_bytes(&tensor, 9, values.bytes, values.size);
    if (parts->external != 0) put_pair(&tensor, 13, "location", "/etc/passwd");
    if (parts->external == 1) put_number(&tensor, 14, 1);
    put_message(graph, 5, &tensor);
}

static inline void put_graph(message *model, const model_parts *parts) {
    message graph = {{0}, 0}, node = {{0}, 0};
    put_text(&node, 1, parts->input);
    put_text(&node, 1, "weights");
    put_text(&node, 2, parts->output);
    for (uint32_t i = 0; i < parts->spare_outputs; ++i) {
        const char name[] = {'s', (char)('0' + i / 10), (char)('0' + i % 10), 0};
        put_text(&node, 2, name);
    }
    put_text(&node, 4, parts->operator_name);
    if (parts->subgraph) {
        message attribute = {{0}, 0}, inner = {{0}, 0};
        put_text(&attribute, 1, "body");
        put_text(&inner, 2, "inner");
        put_message(&attribute, 6, &inner);
        put_number(&attribute, 20, 5);
        put_message(&node, 5, &attribute);
    }
    put_text(&node, 7, parts->operator_domain);
    if (!parts->no_nodes) put_message(&graph, 1, &node);
    put_text(&graph, 2, "graph");
    put_weights(&graph, parts);
    put_tensor_value(&graph, 11, parts->input, parts, parts->input_channels);
    if (parts->second_input) put_tensor_value(&graph, 11, "more", parts, 1);
    put_tensor_value(&graph, 12, parts->output, parts, parts->channels);
    if (parts->second_output) put_tensor_value(&graph, 12, parts->output, parts, parts->channels);
    put_message(model, 7, &graph);
}

static inline void put_opset(message *model, const char *domain, uint32_t version) {
    message opset = {{0}, 0};
    put_text(&opset, 1, domain);
    put_number(&opset, 2, version);
    put_message(model, 8, &opset);
}

static inline void make_model(const model_parts *parts, message *model) {
    model->size = 0;
    put_number(model, 1, 8);
    put_text(model, 2, "test");
    put_graph(model, parts);
    if (parts->second_graph) put_graph(model, parts);
    put_opset(model, "", 17);
    if (*parts->operator_domain != 0) put_opset(model, parts->operator_domain, 1);
    put_pair(model, 14, "another", "entry");
    put_pair(model, 14, "bn.receptive_radius", parts->radius);
    put_pair(model, 14, "bn.align", parts->align);
    put_pair(model, 14, "bn.quantiles", parts->quantiles);
    put_pair(model, 14, "bn.sparse_spacing", parts->spacing);
    if (parts->training) put_text(model, 20, "");
    if (parts->function) put_text(model, 25, "");
    /* Last, so that a shorter file is never whole. */
    put_pair(model, 14, "bn.version", parts->version);
}

#endif
