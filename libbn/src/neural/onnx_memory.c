/* SPDX-License-Identifier: Apache-2.0
 * Bounds the memory of a model: a file of a few hundred bytes can ask for gigabytes of tensors.
 *
 * Walks the nodes in order, as they run, with an upper bound on the extents of each value, and adds
 * up the elements of the values that are alive: those that a later node uses, and all that depend on
 * constants alone, which the runtime computes in advance. Only operators that keep images images are
 * known, and few let them grow. Time and memory are linear in the nodes. */
#include "neural/onnx_memory.h"
#include "base/memory.h"
#include "neural/protobuf.h"
#include <math.h>
#include <string.h>

enum { AXES = 4, MOST_INPUTS = 256, MOST_VALUES = 1 << 18, NEVER = 0 };

/* Upper bounds on the extents of a value, in doubles, which do not overflow. Constants may have fewer
 * axes, aligned at the end, as in broadcasting, with ones before them. */
typedef struct value {
    span name;
    double batch, channels, side; /* of height and width, the larger */
    double count;                 /* of elements */
    uint32_t last_use;            /* the number of a node, from 1 */
    int is_defined, is_ready, is_constant;
} value;

typedef struct table {
    value *slots;
    size_t size; /* a power of two */
} table;

/* The value of a name, a new one for a new name. */
static value *find(const table *t, span name) {
    const size_t length = (size_t)(name.end - name.at);
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
    for (size_t i = 0; i < length; ++i) hash = (hash ^ name.at[i]) * 0x100000001b3u;
    for (size_t at = (size_t)(hash ^ hash >> 32);; ++at) {
        value *v = &t->slots[at & (t->size - 1)];
        if (v->name.at == NULL) v->name = name;
        if ((size_t)(v->name.end - v->name.at) == length &&
            (length == 0 || memcmp(v->name.at, name.at, length) == 0))
            return v;
    }
}

/* ---- Attributes and tensors */

/* Reads repeated integers, packed or not: those of field `number`, at most `most`. Returns how many,
 * or -1 when there are more or the message is malformed. */
static int read_integers(span s, uint32_t number, int64_t *integers, int most) {
    field f;
    int state, count = 0;
    while ((state = next_field(&s, &f)) == 1) {
        if (f.number != number) continue;
        span packed = f.bytes;
        uint64_t one = f.value;
        while (f.wire != WIRE_BYTES || packed.at != packed.end) {
            if (f.wire == WIRE_BYTES && !read_varint(&packed, &one)) return -1;
            if (count == most) return -1;
            integers[count++] = (int64_t)one;
            if (f.wire != WIRE_BYTES) break;
        }
    }
    return state == 0 ? count : -1;
}

/* The attribute of a node by its name: 1, 0 when there is none, -1 when there are several, of which
 * a runtime might take either. */
static int find_attribute(span node, const char *name, span *attribute) {
    field f, inner;
    int count = 0;
    while (next_field(&node, &f) == 1) {
        if (f.number != 5 || !is_bytes(&f)) continue;
        for (span s = f.bytes; next_field(&s, &inner) == 1;) {
            if (inner.number != 1 || !is_bytes(&inner) || !is_text(inner.bytes, name)) continue;
            *attribute = f.bytes;
            ++count;
            break;
        }
    }
    return count > 1 ? -1 : count;
}

/* The integer or the integers of an attribute: how many, at most AXES, or -1. */
static int attribute_integers(span node, const char *name, int64_t integers[AXES]) {
    enum { INTEGER = 3, INTEGERS = 8 };
    span attribute;
    const int found = find_attribute(node, name, &attribute);
    if (found != 1) return found;
    const int one = read_integers(attribute, INTEGER, integers, AXES);
    return one == 0 ? read_integers(attribute, INTEGERS, integers, AXES) : one;
}

/* The largest integer of an attribute, `least` where there is none larger. Returns 0 when it cannot
 * be read or one is negative. */
static int largest(span node, const char *name, double least, double *found) {
    int64_t integers[AXES];
    const int count = attribute_integers(node, name, integers);
    *found = least;
    for (int i = 0; i < count; ++i) {
        /* So many were read. NOLINTNEXTLINE(*-core.UndefinedBinaryOperatorResult) */
        if (integers[i] < 0) return 0;
        *found = fmax(*found, (double)integers[i]);
    }
    return count >= 0;
}

/* TensorProto of at most AXES axes: its name and extents. */
static int read_tensor(span s, value *v) {
    enum { DIMS = 1, NAME = 8 };
    int64_t dims[AXES];
    double extent[AXES] = {1, 1, 1, 1};
    field f;
    const int axes = read_integers(s, DIMS, dims, AXES);
    for (int i = 0; i < axes; ++i) {
        if (dims[i] < 0) return 0;
        extent[AXES - axes + i] = (double)dims[i];
    }
    v->batch = extent[0];
    v->channels = extent[1];
    v->side = fmax(extent[2], extent[3]);
    v->count = extent[0] * extent[1] * extent[2] * extent[3];
    while (next_field(&s, &f) == 1) {
        if (f.number == NAME && is_bytes(&f)) v->name = f.bytes;
    }
    return axes >= 0;
}

/* ---- Operators */

typedef enum rule {
    ELEMENTWISE, /* at most the extents of all inputs together */
    CONCAT,
    CONSTANT,
    CONV,
    CONV_TRANSPOSE,
    DEPTH_TO_SPACE,
    POOL,
    GLOBAL_POOL,
    RULES
} rule;

static const char *const operators[RULES] = {
    "Abs Add And BatchNormalization Ceil Celu Clip Cast Cos CumSum Div Dropout Elu Equal Erf Exp "
    "Floor "
    "Gelu Greater GreaterOrEqual GroupNormalization HardSigmoid HardSwish Identity "
    "InstanceNormalization LRN LayerNormalization LeakyRelu Less LessOrEqual Log LogSoftmax Max "
    "Mean Min Mish Mod Mul Neg Not Or PRelu Pow Reciprocal Relu Round Selu Sigmoid Sign Sin Slice "
    "Softmax Softplus Softsign Split Sqrt Sub Sum Tanh ThresholdedRelu Where Xor",
    "Concat",
    "Constant",
    "Conv",
    "ConvTranspose",
    "DepthToSpace",
    "AveragePool LpPool MaxPool",
    "GlobalAveragePool GlobalLpPool GlobalMaxPool"};

static rule rule_of(span name) {
    const size_t length = (size_t)(name.end - name.at);
    for (int r = 0; r < RULES && length != 0; ++r) {
        for (const char *at = operators[r]; *at != 0; at += *at == ' ') {
            const size_t word = strcspn(at, " ");
            if (word == length && memcmp(at, name.at, length) == 0) return (rule)r;
            at += word;
        }
    }
    return RULES;
}

/* The extents of the other operators' results are those of all inputs together; a batch of more than
 * one image, which could multiply them, is refused. */
static int elementwise(value *const *inputs, int count, value *to) {
    for (int k = 0; k < count; ++k) {
        to->batch = fmax(to->batch, inputs[k]->batch);
        to->channels = fmax(to->channels, inputs[k]->channels);
        to->side = fmax(to->side, inputs[k]->side);
    }
    return to->batch == 1;
}

static int concat(span node, value *const *inputs, int count, value *to) {
    int64_t axis[AXES];
    double channels = 0, side = 0;
    if (attribute_integers(node, "axis", axis) != 1 || !elementwise(inputs, count, to)) return 0;
    if (axis[0] < 0) axis[0] += AXES;
    for (int k = 0; k < count; ++k) {
        /* Constants may have fewer axes. */
        if (inputs[k]->is_constant) return 0;
        channels += inputs[k]->channels;
        side += inputs[k]->side;
    }
    if (axis[0] == 1) {
        to->channels = channels;
    } else {
        to->side = side;
    }
    return axis[0] >= 1 && axis[0] < AXES;
}

static int constant(span node, value *to) {
    span attribute, tensor;
    const int found = find_attribute(node, "value", &attribute);
    if (found == 1) return only_message(attribute, 5, &tensor) && read_tensor(tensor, to);
    /* The numbers are in the attributes: no more of them than the node has bytes. */
    to->side = to->count = (double)(node.end - node.at);
    return found == 0;
}

static int conv_transpose(span node, const value *weights, value *to) {
    double shape, stride, dilation, extra, group;
    if (!largest(node, "output_shape", 0, &shape) || shape != 0 ||
        !largest(node, "strides", 1, &stride) || !largest(node, "dilations", 1, &dilation) ||
        !largest(node, "output_padding", 0, &extra) || !largest(node, "group", 1, &group)) {
        return 0;
    }
    to->channels = weights->channels * group;
    to->side = to->side * stride + weights->side * dilation + extra;
    return 1;
}

/* The extents of a node's results, which are images of one texel before; 0 when they cannot be
 * bounded. */
static int infer(span node, rule kind, value *const *inputs, int count, value *to) {
    enum { STRING = 8 };
    double number;
    if (count < 1) return 0;
    if (kind == CONCAT) return concat(node, inputs, count, to);
    if (kind == ELEMENTWISE) {
        return largest(node, "to", 0, &number) && number != STRING && /* of Cast */
               elementwise(inputs, count, to);
    }
    /* The others take one image, and weights. */
    if (inputs[0]->is_constant || !elementwise(inputs, 1, to)) return 0;
    switch (kind) {
    case CONV:
        if (count < 2) return 0;
        to->channels = inputs[1]->batch;
        return largest(node, "pads", 0, &number) && number == 0;
    case CONV_TRANSPOSE:
        return count >= 2 && conv_transpose(node, inputs[1], to);
    case DEPTH_TO_SPACE: /* as many elements as before */
        if (!largest(node, "blocksize", 1, &number) || number > 1024) return 0;
        to->channels = floor(to->channels / (number * number)) + 1;
        to->side *= number;
        return 1;
    case POOL:
        return largest(node, "pads", 0, &number) && number == 0;
    case GLOBAL_POOL:
        to->side = 1;
        return 1;
    default:
        return 0;
    }
}

/* ---- The graph */

enum { NODE = 1, INITIALIZER = 5, INPUT = 11 };
enum { NODE_INPUT = 1, NODE_OUTPUT = 2, NODE_OPERATOR = 4 };

/* Whether a field of a node names a value. */
static int is_value(const field *f, uint32_t number) {
    return f->number == number && is_bytes(f) && f->bytes.at != f->bytes.end;
}

/* Fills the table with the initializers, the input and all outputs of nodes, each of which has a name
 * of its own, and with the last node that uses each value. */
static bn_result list_values(span graph, double side, const table *t, double *alive) {
    uint32_t number = 0;
    field f, inner;
    while (next_field(&graph, &f) == 1) {
        value read = {.batch = 1, .channels = 1, .side = side, .count = side * side};
        number += f.number == NODE;
        for (span s = f.bytes; f.number == NODE && next_field(&s, &inner) == 1;) {
            if (is_value(&inner, NODE_INPUT)) find(t, inner.bytes)->last_use = number;
            if (is_value(&inner, NODE_OUTPUT) && find(t, inner.bytes)->is_defined++) {
                return BN_ERROR_BAD_DATA;
            }
        }
        if (f.number != INITIALIZER && f.number != INPUT) continue;
        if (f.number == INITIALIZER && !read_tensor(f.bytes, &read)) return BN_ERROR_UNSUPPORTED;
        if (f.number == INPUT) only_message(f.bytes, 1, &read.name);
        if (read.name.at == NULL) return BN_ERROR_BAD_DATA;
        value *v = find(t, read.name);
        if (v->is_defined) return BN_ERROR_BAD_DATA;
        read.is_defined = read.is_ready = 1;
        read.is_constant = f.number == INITIALIZER;
        read.last_use = v->last_use;
        *v = read;
        *alive += v->count;
    }
    return BN_SUCCESS;
}

static bn_result run_node(span node, uint32_t number, const table *t, double most, double *alive) {
    value *inputs[MOST_INPUTS], to = {.batch = 1, .channels = 1, .side = 1};
    span name = {NULL, NULL};
    field f;
    int count = 0, constants = 0;
    for (span s = node; next_field(&s, &f) == 1;) {
        if (is_value(&f, NODE_OPERATOR)) name = f.bytes;
        if (!is_value(&f, NODE_INPUT)) continue;
        value *v = find(t, f.bytes);
        if (!v->is_ready) return BN_ERROR_BAD_DATA;
        if (count == MOST_INPUTS) return BN_ERROR_UNSUPPORTED;
        constants += v->is_constant;
        inputs[count++] = v;
    }
    const rule kind = rule_of(name);
    if (kind == CONSTANT ? !constant(node, &to) : !infer(node, kind, inputs, count, &to)) {
        return BN_ERROR_UNSUPPORTED;
    }
    if (kind != CONSTANT) to.count = to.channels * to.side * to.side;
    for (span s = node; next_field(&s, &f) == 1;) {
        if (!is_value(&f, NODE_OUTPUT)) continue;
        value *v = find(t, f.bytes);
        to.name = v->name;
        to.last_use = v->last_use;
        to.is_defined = to.is_ready = 1;
        to.is_constant = constants == count;
        *v = to;
        *alive += v->count;
    }
    if (!(*alive <= most)) return BN_ERROR_UNSUPPORTED;
    for (int i = 0; i < count; ++i) {
        if (inputs[i]->last_use != number || inputs[i]->is_constant) continue;
        *alive -= inputs[i]->count;
        inputs[i]->last_use = NEVER;
    }
    return BN_SUCCESS;
}

bn_result bn_onnx_memory_check(const void *bytes, size_t size, uint32_t side, double most) {
    const span whole = {bytes, (const unsigned char *)bytes + size};
    span graph;
    field f, inner;
    if (!only_message(whole, 7, &graph)) return BN_ERROR_BAD_DATA;
    size_t names = 0;
    for (span s = graph; next_field(&s, &f) == 1;) {
        names += f.number == INITIALIZER || f.number == INPUT;
        for (span t = f.bytes; f.number == NODE && next_field(&t, &inner) == 1;) {
            names += is_value(&inner, NODE_INPUT) || is_value(&inner, NODE_OUTPUT);
        }
    }
    if (names > MOST_VALUES) return BN_ERROR_UNSUPPORTED;
    table t = {NULL, 16};
    while (t.size < 2 * names + 2) t.size *= 2;
    t.slots = bn_allocate_zero(t.size, sizeof *t.slots);
    if (t.slots == NULL) return BN_ERROR_OUT_OF_MEMORY;
    double alive = 0;
    uint32_t number = 0;
    bn_result result = list_values(graph, side, &t, &alive);
    if (result == BN_SUCCESS && !(alive <= most)) result = BN_ERROR_UNSUPPORTED;
    for (span s = graph; result == BN_SUCCESS && next_field(&s, &f) == 1;) {
        if (f.number == NODE) result = run_node(f.bytes, ++number, &t, most, &alive);
    }
    bn_free(t.slots);
    return result;
}
