/* SPDX-License-Identifier: Apache-2.0
 * A strict reader of the parts of an ONNX file that decide whether libbn can use a model.
 *
 * An ONNX file is a Protocol Buffers message: a sequence of fields, each a varint (number << 3 |
 * wire type) and a value. The reader treats messages as spans of bytes and checks every length
 * against its span. It allocates nothing, and skips fields that it does not know. Field numbers are
 * those of the public schema (onnx.proto). */
#include "neural/onnx_model.h"
#include "neural/protobuf.h"
#include <string.h>

/* A decimal number of at most nine digits and nothing else. */
static int read_decimal(span s, uint32_t *value) {
    const ptrdiff_t length = s.end - s.at;
    if (length < 1 || length > 9) return 0;
    *value = 0;
    for (; s.at != s.end; ++s.at) {
        if (*s.at < '0' || *s.at > '9') return 0;
        *value = *value * 10 + (uint32_t)(*s.at - '0');
    }
    return 1;
}

/* BN_MODEL_QUANTILES ascending integers with commas between them, as multiples of 2^-24. */
static int read_quantiles(span s, float quantiles[BN_MODEL_QUANTILES]) {
    for (int i = 0; i < BN_MODEL_QUANTILES; ++i) {
        uint32_t size;
        const int negative = s.at != s.end && *s.at == '-';
        if (negative) ++s.at;
        span number = {s.at, s.at};
        while (number.end != s.end && *number.end != ',') ++number.end;
        if (!read_decimal(number, &size)) return 0;
        quantiles[i] = (float)size * (negative ? -0x1p-24f : 0x1p-24f);
        if (i > 0 && quantiles[i] < quantiles[i - 1]) return 0;
        s.at = number.end;
        if ((s.at == s.end) != (i + 1 == BN_MODEL_QUANTILES)) return 0;
        if (s.at != s.end) ++s.at;
    }
    return quantiles[BN_MODEL_QUANTILES - 1] > quantiles[0];
}

/* Reads two string fields of a message, which may hold each at most once. */
static int read_pair(span s, uint32_t first_number, span *first, uint32_t second_number,
                     span *second) {
    field f;
    int state, seen[2] = {0, 0};
    first->at = first->end = second->at = second->end = s.end;
    while ((state = next_field(&s, &f)) == 1) {
        const int which = f.number == first_number ? 0 : f.number == second_number ? 1 : -1;
        if (which < 0) continue;
        if (!is_bytes(&f) || seen[which]++) return 0;
        *(which == 0 ? first : second) = f.bytes;
    }
    return state == 0;
}

/* Messages, and what follows from a field in one: a message to look into, or a refusal. */
typedef enum { MODEL, GRAPH, NODE, ATTRIBUTE, TENSOR, DOMAIN_NAME, REFUSED, REFUSED_UNLESS_0 } part;

static const struct {
    part in;
    uint32_t number;
    part found;
} parts[] = {
    {MODEL, 7, GRAPH},
    {MODEL, 20, REFUSED}, /* training */
    {MODEL, 25, REFUSED}, /* functions */
    {GRAPH, 1, NODE},
    {GRAPH, 5, TENSOR},
    {GRAPH, 15, REFUSED}, /* sparse tensors: a few bytes can claim any size */
    {NODE, 5, ATTRIBUTE},
    {NODE, 7, DOMAIN_NAME},
    {ATTRIBUTE, 5, TENSOR},
    {ATTRIBUTE, 6, REFUSED}, /* a graph, graphs */
    {ATTRIBUTE, 11, REFUSED},
    {ATTRIBUTE, 10, TENSOR},
    {ATTRIBUTE, 22, REFUSED}, /* sparse tensors */
    {ATTRIBUTE, 23, REFUSED},
    {TENSOR, 13, REFUSED},          /* data in another file */
    {TENSOR, 14, REFUSED_UNLESS_0}, /* where the data are */
};

/* Refuses what could reach beyond the file. Goes five messages deep, since graphs inside attributes are
 * refused. */
static bn_result check(part in, span s) {
    field f;
    int state;
    while ((state = next_field(&s, &f)) == 1) {
        for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
            const part found = parts[i].found;
            if (parts[i].in != in || parts[i].number != f.number) continue;
            if (found == REFUSED || (found == REFUSED_UNLESS_0 && f.value != 0))
                return BN_ERROR_UNSUPPORTED;
            if (found == REFUSED_UNLESS_0) continue;
            if (!is_bytes(&f)) return BN_ERROR_BAD_DATA;
            if (found != DOMAIN_NAME) {
                const bn_result result = check(found, f.bytes);
                if (result != BN_SUCCESS) return result;
            } else if (!is_text(f.bytes, "") && !is_text(f.bytes, "ai.onnx")) {
                return BN_ERROR_UNSUPPORTED;
            }
        }
    }
    return state == 0 ? BN_SUCCESS : BN_ERROR_BAD_DATA;
}

enum { MODEL_AXES = 4 };

/* Copies a name as a zero-terminated string; 0 when it is too long or has a zero inside. */
static int copy_name(span s, char name[BN_MODEL_NAME_SIZE]) {
    const size_t length = (size_t)(s.end - s.at);
    if (length >= BN_MODEL_NAME_SIZE) return 0;
    if (length != 0 && memchr(s.at, 0, length) != NULL) return 0;
    if (length != 0) memcpy(name, s.at, length);
    name[length] = 0;
    return 1;
}

/* ValueInfoProto of a float tensor of four axes: its name and their extents, 0 where they are not
 * fixed. */
static int read_value(span s, span *name, uint64_t extents[MODEL_AXES]) {
    enum { NAME = 1, TYPE = 2, TENSOR_TYPE = 1, ELEMENT = 1, SHAPE = 2, AXIS = 1 };
    enum { EXTENT = 1 };
    enum { ELEMENT_FLOAT = 1 };
    span type, tensor, shape;
    uint32_t axes = 0;
    int state, floats = 0;
    field f;
    if (!read_pair(s, NAME, name, TYPE, &type) || !only_message(type, TENSOR_TYPE, &tensor))
        return 0;
    if (!only_message(tensor, SHAPE, &shape)) return 0;
    while ((state = next_field(&tensor, &f)) == 1) {
        if (f.number == ELEMENT) floats = f.wire == WIRE_VARINT && f.value == ELEMENT_FLOAT;
    }
    if (state != 0 || !floats) return 0;
    while ((state = next_field(&shape, &f)) == 1) {
        if (f.number != AXIS) continue;
        if (!is_bytes(&f) || axes == MODEL_AXES) return 0;
        span axis = f.bytes;
        extents[axes] = 0;
        while ((state = next_field(&axis, &f)) == 1) {
            if (f.number == EXTENT) extents[axes] = f.wire == WIRE_VARINT ? f.value : UINT64_MAX;
        }
        if (state != 0) return 0;
        ++axes;
    }
    return state == 0 && axes == MODEL_AXES;
}

static bn_result read_graph(span s, bn_onnx_model *model) {
    enum { NODES = 1, INPUT = 11, OUTPUT = 12 };
    uint32_t nodes = 0, inputs = 0, outputs = 0;
    uint64_t extents[MODEL_AXES];
    span name;
    field f;
    while (next_field(&s, &f) == 1) {
        if (f.number == NODES && ++nodes > BN_MODEL_MOST_NODES) return BN_ERROR_UNSUPPORTED;
        if (f.number != INPUT && f.number != OUTPUT) continue;
        if (!is_bytes(&f) || !read_value(f.bytes, &name, extents) || extents[0] != 1 ||
            extents[2] != 0 || extents[3] != 0) {
            return BN_ERROR_BAD_DATA;
        }
        if (f.number == INPUT) {
            if (inputs++ || !is_text(name, "noise") || extents[1] != 1) return BN_ERROR_BAD_DATA;
        } else {
            if (outputs++ || extents[1] < 1 || extents[1] > BN_MODEL_MOST_CHANNELS ||
                name.at == name.end || !copy_name(name, model->output)) {
                return BN_ERROR_BAD_DATA;
            }
            model->channels = (uint32_t)extents[1];
        }
    }
    return nodes > 0 && inputs == 1 && outputs == 1 ? BN_SUCCESS : BN_ERROR_BAD_DATA;
}

bn_result bn_onnx_model_read(const void *bytes, size_t size, bn_onnx_model *model) {
    enum { GRAPH_FIELD = 7, METADATA = 14 };
    static const char *const keys[] = {"bn.receptive_radius", "bn.align", "bn.version",
                                       "bn.sparse_spacing"};
    enum { KEYS = sizeof keys / sizeof *keys };
    uint32_t values[KEYS] = {0}, seen[KEYS] = {0};
    bn_onnx_model found;
    span graph;
    field f;
    if (size == 0 || size > BN_MODEL_MOST_BYTES) return BN_ERROR_BAD_DATA;
    memset(&found, 0, sizeof found);
    const span whole = {bytes, (const unsigned char *)bytes + size};
    if (!only_message(whole, GRAPH_FIELD, &graph)) return BN_ERROR_BAD_DATA;
    bn_result result = check(MODEL, whole);
    if (result != BN_SUCCESS) return result;
    span s = whole;
    while (next_field(&s, &f) == 1) {
        span key, value;
        if (f.number != METADATA) continue;
        if (!is_bytes(&f) || !read_pair(f.bytes, 1, &key, 2, &value)) return BN_ERROR_BAD_DATA;
        if (is_text(key, "bn.quantiles") &&
            (found.has_quantiles++ || !read_quantiles(value, found.quantiles))) {
            return BN_ERROR_BAD_DATA;
        }
        for (int k = 0; k < KEYS; ++k) {
            if (is_text(key, keys[k]) && (seen[k]++ || !read_decimal(value, &values[k]))) {
                return BN_ERROR_BAD_DATA;
            }
        }
    }
    if (!seen[0] || !seen[1] || !seen[2]) return BN_ERROR_BAD_DATA;
    if (values[2] != 1) return BN_ERROR_UNSUPPORTED;
    if (values[0] > BN_MODEL_MOST_RADIUS || values[1] < 1 || values[1] > BN_MODEL_MOST_ALIGN) {
        return BN_ERROR_BAD_DATA;
    }
    if (seen[3] && (values[3] < 1 || values[3] > BN_MODEL_MOST_SPACING)) return BN_ERROR_BAD_DATA;
    found.radius = values[0];
    found.align = values[1];
    found.sparse_spacing = values[3];
    result = read_graph(graph, &found);
    if (result == BN_SUCCESS) *model = found;
    return result;
}
