/* SPDX-License-Identifier: Apache-2.0
 * Small model files that would take gigabytes are refused before a runtime sees them; harmless ones
 * that resemble them are not. The fake ONNX Runtime would accept any of them. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <stdlib.h>
#include <string.h>

enum { RAW = 9, NODES = 300 };

/* A graph that is written node by node. */
typedef struct writer {
    message *graph, *scratch;
} writer;

static void put_node(writer *w, const char *operator_name, const char *const *inputs, int count,
                     const char *output, const message *attributes) {
    message *node = w->scratch;
    node->size = 0;
    for (int i = 0; i < count; ++i) put_text(node, 1, inputs[i]);
    put_text(node, 2, output);
    put_text(node, 4, operator_name);
    if (attributes != NULL) {
        memcpy(node->bytes + node->size, attributes->bytes, attributes->size);
        node->size += attributes->size;
    }
    put_message(w->graph, 1, node);
}

static void put_unary(writer *w, const char *operator_name, const char *input, const char *output) {
    put_node(w, operator_name, &input, 1, output, NULL);
}

static void put_integers(message *attributes, const char *name, const int64_t *values, int count) {
    message attribute = {{0}, 0};
    put_text(&attribute, 1, name);
    for (int i = 0; i < count; ++i) put_number(&attribute, 8, (uint64_t)values[i]);
    put_message(attributes, 5, &attribute);
}

static void put_integer(message *attributes, const char *name, int64_t value) {
    message attribute = {{0}, 0};
    put_text(&attribute, 1, name);
    put_number(&attribute, 3, (uint64_t)value);
    put_message(attributes, 5, &attribute);
}

/* A tensor of floats that says it has these extents; its data are as long as `bytes` says. */
static void put_tensor(message *to, uint32_t field, const char *name, const int64_t *extents,
                       int axes, size_t bytes) {
    message tensor = {{0}, 0};
    static const unsigned char zeros[4096];
    for (int i = 0; i < axes; ++i) put_number(&tensor, 1, (uint64_t)extents[i]);
    put_number(&tensor, 2, 1);
    put_text(&tensor, 8, name);
    put_bytes(&tensor, RAW, zeros, bytes);
    put_message(to, field, &tensor);
}

typedef void (*body)(writer *w);

/* Opens a model whose graph is the body's, and in the end an operator that makes the output "mask"
 * of the value "last". */
static bn_result open_graph(body write) {
    static message graph, scratch, model;
    const model_parts parts = model_parts_default();
    writer w = {&graph, &scratch};
    bn_neural *neural;
    graph.size = 0;
    write(&w);
    put_unary(&w, "Identity", "last", "mask");
    put_tensor_value(&graph, 11, "noise", &parts, 1);
    put_tensor_value(&graph, 12, "mask", &parts, 1);
    model.size = 0;
    put_number(&model, 1, 8);
    put_message(&model, 7, &graph);
    put_pair(&model, 14, "bn.receptive_radius", "1");
    put_pair(&model, 14, "bn.align", "1");
    put_pair(&model, 14, "bn.version", "1");
    CHECK(model.size < MODEL_MOST_BYTES);
    const bn_neural_options options = fake_options(&model);
    const bn_result result = bn_neural_open(&options, &neural);
    bn_neural_close(neural);
    return result;
}

/* ---- What is refused */

static void weights_without_data(writer *w) {
    static const int64_t extents[] = {30000, 30000};
    put_tensor(w->graph, 5, "last", extents, 2, 4);
}

/* Each value is twice as large as the one before. */
static void doubled(writer *w, int times, const char *operator_name) {
    char from[16] = "noise", to[16];
    for (int i = 0; i < times; ++i) {
        const char *const both[] = {from, from};
        message attributes = {{0}, 0};
        snprintf(to, sizeof to, i + 1 < times ? "v%d" : "last", i);
        put_integer(&attributes, "axis", i % 2 == 0 ? 1 : -1);
        put_node(w, operator_name, both, 2, to, &attributes);
        memcpy(from, to, sizeof from);
    }
}

static void doubled_often(writer *w) {
    doubled(w, 30, "Concat");
}

static void broadcast(writer *w) {
    static const int64_t deep[] = {5000, 1, 1};
    const char *const both[] = {"noise", "deep"};
    put_tensor(w->graph, 5, "deep", deep, 3, 0);
    put_node(w, "Add", both, 2, "last", NULL);
}

/* Images in a batch would multiply the channels. */
static void batch(writer *w) {
    static const int64_t many[] = {50, 1, 1, 1};
    const char *const both[] = {"noise", "many"};
    put_tensor(w->graph, 5, "many", many, 4, 200);
    put_node(w, "Add", both, 2, "last", NULL);
}

static void spread(writer *w) {
    message attributes = {{0}, 0};
    const char *const noise[] = {"noise"};
    put_integer(&attributes, "blocksize", 100);
    put_node(w, "DepthToSpace", noise, 1, "last", &attributes);
}

static void convolved(writer *w, int64_t channels, const int64_t pads[4]) {
    const int64_t extents[] = {channels, 1, 3, 3};
    const char *const both[] = {"noise", "weights"};
    message attributes = {{0}, 0};
    put_tensor(w->graph, 5, "weights", extents, 4, 0);
    if (pads != NULL) put_integers(&attributes, "pads", pads, 4);
    put_node(w, "Conv", both, 2, "deep", &attributes);
}

static void many_channels(writer *w) {
    convolved(w, 2000, NULL);
    put_unary(w, "Relu", "deep", "last");
}

static void padded(writer *w) {
    static const int64_t pads[] = {0, 50000, 0, 50000};
    convolved(w, 1, pads);
    put_unary(w, "Relu", "deep", "last");
}

static void transposed(writer *w) {
    static const int64_t extents[] = {1, 1, 3, 3}, strides[] = {200, 200};
    const char *const both[] = {"noise", "weights"};
    message attributes = {{0}, 0};
    put_tensor(w->graph, 5, "weights", extents, 4, 36);
    put_integers(&attributes, "strides", strides, 2);
    put_node(w, "ConvTranspose", both, 2, "last", &attributes);
}

/* All of the values are used at the end, so all are alive at once. */
static void used_at_the_end(writer *w) {
    const char *inputs[NODES];
    static char names[NODES][16];
    convolved(w, 32, NULL);
    memcpy(names[0], "deep", 5);
    for (int i = 1; i < 60; ++i) {
        snprintf(names[i], sizeof names[i], "v%d", i);
        put_unary(w, "Relu", names[i - 1], names[i]);
        inputs[i - 1] = names[i];
    }
    put_node(w, "Sum", inputs, 59, "last", NULL);
}

/* Two attributes of one name, of which a runtime might take either. */
static void two_pads(writer *w) {
    static const int64_t extents[] = {1, 1, 3, 3}, small[] = {0, 0, 0, 0},
                         large[] = {90000, 90000, 90000, 90000};
    const char *const both[] = {"noise", "weights"};
    message attributes = {{0}, 0};
    put_tensor(w->graph, 5, "weights", extents, 4, 36);
    put_integers(&attributes, "pads", small, 4);
    put_integers(&attributes, "pads", large, 4);
    put_node(w, "Conv", both, 2, "last", &attributes);
}

static void unknown_operator(writer *w) {
    put_unary(w, "NoSuchOperator", "noise", "last");
}

static void value_from_nowhere(writer *w) {
    put_unary(w, "Relu", "nowhere", "last");
}

/* ---- What is not */

static void added_to_itself(writer *w) {
    doubled(w, 40, "Add");
}

static void usual_operators(writer *w) {
    static const int64_t one[] = {1};
    const char *const clip[] = {"deep", "", "one"}, *const add[] = {"clipped", "one"};
    convolved(w, 64, NULL);
    put_tensor(w->graph, 5, "one", one, 1, 4);
    put_node(w, "Clip", clip, 3, "clipped", NULL);
    put_node(w, "Mul", add, 2, "scaled", NULL);
    put_unary(w, "GlobalAveragePool", "scaled", "means");
    const char *const gate[] = {"scaled", "means"};
    put_node(w, "Mul", gate, 2, "last", NULL);
}

int main(void) {
    static const struct {
        body write;
        bn_result expected;
    } cases[] = {
        {weights_without_data, BN_ERROR_UNSUPPORTED},
        {doubled_often, BN_ERROR_UNSUPPORTED},
        {batch, BN_ERROR_UNSUPPORTED},
        {spread, BN_ERROR_UNSUPPORTED},
        {broadcast, BN_ERROR_UNSUPPORTED},
        {many_channels, BN_ERROR_UNSUPPORTED},
        {padded, BN_ERROR_UNSUPPORTED},
        {transposed, BN_ERROR_UNSUPPORTED},
        {used_at_the_end, BN_ERROR_UNSUPPORTED},
        {two_pads, BN_ERROR_UNSUPPORTED},
        {unknown_operator, BN_ERROR_UNSUPPORTED},
        {value_from_nowhere, BN_ERROR_BAD_DATA},
        {added_to_itself, BN_SUCCESS},
        {usual_operators, BN_SUCCESS},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const bn_result found = open_graph(cases[i].write);
        if (found != cases[i].expected) printf("case %zu: %s\n", i, bn_result_string(found));
        CHECK(found == cases[i].expected);
    }
    return check_result();
}
