/* SPDX-License-Identifier: Apache-2.0
 * Bounds the memory of a model: a file of a few hundred bytes can ask for gigabytes of tensors.
 *
 * Walks the nodes in order, as they run, with an upper bound on the four extents of each value, and
 * adds up the elements of the values that are alive: those that a later node uses, and all that
 * depend on constants alone, which the runtime computes in advance. Only operators that keep images
 * images are known, and few let them grow. Time and memory are linear in the nodes. */
#include "neural/onnx_memory.h"
#include "base/memory.h"
#include "neural/protobuf.h"
#include <string.h>

enum { AXES = 4, MOST_INPUTS = 256, MOST_VALUES = 1 << 18, NEVER = 0 };
static const uint64_t HUGE_COUNT = (uint64_t)1 << 40;

/* Upper bounds on the extents of a value. Constants may have fewer axes, aligned at the end, as in
 * broadcasting, with ones before them. */
typedef struct value {
    span name;
    uint64_t extent[AXES];
    uint32_t last_use; /* the number of a node, from 1 */
    int is_ready, is_constant;
} value;

typedef struct table {
    value *slots;
    size_t size; /* a power of two */
} table;

static uint64_t times(uint64_t a, uint64_t b) {
    return b != 0 && a > HUGE_COUNT / b ? HUGE_COUNT : a * b;
}

static uint64_t plus(uint64_t a, uint64_t b) {
    return a + b > HUGE_COUNT ? HUGE_COUNT : a + b;
}

static uint64_t larger(uint64_t a, uint64_t b) {
    return a > b ? a : b;
}

static uint64_t count_of(const uint64_t extent[AXES]) {
    uint64_t count = 1;
    for (int i = 0; i < AXES; ++i) count = times(count, extent[i]);
    return count;
}

/* The slot of a name: the one that has it, or the free one where it belongs. */
static value *find(const table *t, span name) {
    const size_t length = (size_t)(name.end - name.at);
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
    for (size_t i = 0; i < length; ++i) hash = (hash ^ name.at[i]) * 0x100000001b3u;
    for (size_t at = (size_t)(hash ^ hash >> 32);; ++at) {
        value *v = &t->slots[at & (t->size - 1)];
        if (v->name.at == NULL) return v;
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
static int largest(span node, const char *name, uint64_t least, uint64_t *found) {
    int64_t integers[AXES];
    const int count = attribute_integers(node, name, integers);
    *found = least;
    for (int i = 0; i < count; ++i) {
        /* So many were read. NOLINTNEXTLINE(*-core.UndefinedBinaryOperatorResult) */
        if (integers[i] < 0) return 0;
        *found = larger(*found, times(1, (uint64_t)integers[i]));
    }
    return count >= 0;
}

/* TensorProto of at most AXES axes: its name and extents. */
static int read_tensor(span s, value *v) {
    enum { DIMS = 1, NAME = 8 };
    int64_t dims[AXES];
    field f;
    const int axes = read_integers(s, DIMS, dims, AXES);
    if (axes < 0) return 0;
    for (int i = 0; i < AXES; ++i) {
        const int64_t extent = i < AXES - axes ? 1 : dims[i - (AXES - axes)];
        if (extent < 0) return 0;
        v->extent[i] = times(1, (uint64_t)extent);
    }
    while (next_field(&s, &f) == 1) {
        if (f.number == NAME && is_bytes(&f)) v->name = f.bytes;
    }
    return 1;
}

/* ---- Operators */

typedef enum rule {
    ELEMENTWISE, /* at most the extents of all inputs together */
    CAST,
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
    "Abs Add And BatchNormalization Ceil Celu Clip Cos CumSum Div Dropout Elu Equal Erf Exp Floor "
    "Gelu Greater GreaterOrEqual GroupNormalization HardSigmoid HardSwish Identity "
    "InstanceNormalization LRN LayerNormalization LeakyRelu Less LessOrEqual Log LogSoftmax Max "
    "Mean Min Mish Mod Mul Neg Not Or PRelu Pow Reciprocal Relu Round Selu Sigmoid Sign Sin Slice "
    "Softmax Softplus Softsign Split Sqrt Sub Sum Tanh ThresholdedRelu Where Xor",
    "Cast",
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
static int elementwise(value *const *inputs, int count, uint64_t to[AXES]) {
    for (int k = 0; k < count; ++k) {
        for (int i = 0; i < AXES; ++i) to[i] = larger(to[i], inputs[k]->extent[i]);
    }
    return to[0] == 1;
}

static int concat(span node, value *const *inputs, int count, uint64_t to[AXES]) {
    int64_t axis[AXES];
    if (attribute_integers(node, "axis", axis) != 1 || !elementwise(inputs, count, to)) return 0;
    if (axis[0] < 0) axis[0] += AXES;
    if (axis[0] < 1 || axis[0] >= AXES) return 0;
    to[axis[0]] = 0;
    for (int k = 0; k < count; ++k) {
        /* Constants may have fewer axes. */
        if (inputs[k]->is_constant) return 0;
        to[axis[0]] = plus(to[axis[0]], inputs[k]->extent[axis[0]]);
    }
    return 1;
}

static int constant(span node, uint64_t to[AXES]) {
    value read;
    span attribute, tensor;
    const int found = find_attribute(node, "value", &attribute);
    if (found < 0) return 0;
    if (found == 1) {
        if (!only_message(attribute, 5, &tensor) || !read_tensor(tensor, &read)) return 0;
        memcpy(to, read.extent, sizeof read.extent);
    } else {
        /* The numbers are in the attributes: no more of them than the node has bytes. */
        to[AXES - 1] = (uint64_t)(node.end - node.at);
    }
    return 1;
}

static int conv_transpose(span node, const value *weights, uint64_t to[AXES]) {
    uint64_t shape, stride, dilation, extra, group;
    if (!largest(node, "output_shape", 0, &shape) || shape != 0 ||
        !largest(node, "strides", 1, &stride) || !largest(node, "dilations", 1, &dilation) ||
        !largest(node, "output_padding", 0, &extra) || !largest(node, "group", 1, &group)) {
        return 0;
    }
    const uint64_t kernel = times(larger(weights->extent[2], weights->extent[3]), dilation);
    to[1] = times(weights->extent[1], group);
    for (int i = 2; i < AXES; ++i) to[i] = plus(times(to[i], stride), plus(kernel, extra));
    return 1;
}

/* The extents of a node's results; 0 when they cannot be bounded. */
static int infer(span node, rule kind, value *const *inputs, int count, uint64_t to[AXES]) {
    enum { STRING = 8 };
    uint64_t number;
    for (int i = 0; i < AXES; ++i) to[i] = 1;
    if (kind == CONSTANT) return constant(node, to);
    if (count < 1) return 0;
    if (kind == CONCAT) return concat(node, inputs, count, to);
    if (kind == CAST && (!largest(node, "to", 0, &number) || number == STRING)) return 0;
    if (kind == CAST || kind == ELEMENTWISE) return elementwise(inputs, count, to);
    /* The others take one image, and weights. */
    if (inputs[0]->is_constant || !elementwise(inputs, 1, to)) return 0;
    switch (kind) {
    case CONV:
        if (count < 2) return 0;
        to[1] = inputs[1]->extent[0];
        return largest(node, "pads", 0, &number) && number == 0;
    case CONV_TRANSPOSE:
        return count >= 2 && conv_transpose(node, inputs[1], to);
    case DEPTH_TO_SPACE: /* as many elements as before */
        if (!largest(node, "blocksize", 1, &number) || number > 1024) return 0;
        to[1] = to[1] / (number * number) + 1;
        for (int i = 2; i < AXES; ++i) to[i] = times(to[i], number);
        return 1;
    case POOL:
        return largest(node, "pads", 0, &number) && number == 0;
    case GLOBAL_POOL:
        to[2] = to[3] = 1;
        return 1;
    default:
        return 0;
    }
}

/* ---- The graph */

enum { NODE = 1, INITIALIZER = 5, INPUT = 11 };
enum { NODE_INPUT = 1, NODE_OUTPUT = 2, NODE_OPERATOR = 4 };

static int is_output(const field *f) {
    return f->number == NODE_OUTPUT && is_bytes(f) && f->bytes.at != f->bytes.end;
}

/* Puts a value with a name of its own into the table. */
static value *insert(const table *t, span name) {
    value *v = name.at == NULL ? NULL : find(t, name);
    if (v == NULL || v->name.at != NULL) return NULL;
    v->name = name;
    return v;
}

/* Fills the table with the initializers, the input and all outputs of nodes. */
static bn_result list_values(span graph, uint32_t height, uint32_t width, const table *t,
                             uint64_t *alive) {
    field f, inner;
    while (next_field(&graph, &f) == 1) {
        value read = {.extent = {1, 1, height, width}, .is_ready = 1};
        span s = f.bytes;
        if (f.number == NODE) {
            while (next_field(&s, &inner) == 1) {
                if (is_output(&inner) && insert(t, inner.bytes) == NULL) return BN_ERROR_BAD_DATA;
            }
        } else if (f.number == INITIALIZER) {
            if (!read_tensor(s, &read)) return BN_ERROR_UNSUPPORTED;
            read.is_constant = 1;
        } else if (f.number == INPUT) {
            while (next_field(&s, &inner) == 1) {
                if (inner.number == 1 && is_bytes(&inner)) read.name = inner.bytes;
            }
        }
        if (f.number != INITIALIZER && f.number != INPUT) continue;
        value *v = insert(t, read.name);
        if (v == NULL) return BN_ERROR_BAD_DATA;
        *v = read;
        *alive = plus(*alive, count_of(v->extent));
    }
    return BN_SUCCESS;
}

/* Records the last node that uses each value. */
static void note_uses(span graph, const table *t) {
    uint32_t number = 0;
    field f, inner;
    while (next_field(&graph, &f) == 1) {
        if (f.number != NODE) continue;
        ++number;
        for (span s = f.bytes; next_field(&s, &inner) == 1;) {
            if (inner.number == NODE_INPUT && is_bytes(&inner)) {
                find(t, inner.bytes)->last_use = number;
            }
        }
    }
}

static bn_result run_node(span node, uint32_t number, const table *t, uint64_t most,
                          uint64_t *alive) {
    value *inputs[MOST_INPUTS];
    uint64_t extent[AXES];
    span name = {NULL, NULL};
    field f;
    int count = 0, constants = 0;
    for (span s = node; next_field(&s, &f) == 1;) {
        if (f.number == NODE_OPERATOR && is_bytes(&f)) name = f.bytes;
        if (f.number != NODE_INPUT || !is_bytes(&f) || f.bytes.at == f.bytes.end) continue;
        value *v = find(t, f.bytes);
        if (!v->is_ready) return BN_ERROR_BAD_DATA;
        if (count == MOST_INPUTS) return BN_ERROR_UNSUPPORTED;
        constants += v->is_constant;
        inputs[count++] = v;
    }
    if (!infer(node, rule_of(name), inputs, count, extent)) return BN_ERROR_UNSUPPORTED;
    for (span s = node; next_field(&s, &f) == 1;) {
        if (!is_output(&f)) continue;
        value *v = find(t, f.bytes);
        memcpy(v->extent, extent, sizeof extent);
        v->is_ready = 1;
        v->is_constant = constants == count;
        *alive = plus(*alive, count_of(v->extent));
    }
    if (*alive > most) return BN_ERROR_UNSUPPORTED;
    for (int i = 0; i < count; ++i) {
        if (inputs[i]->last_use != number || inputs[i]->is_constant) continue;
        *alive -= count_of(inputs[i]->extent);
        inputs[i]->last_use = NEVER;
    }
    return BN_SUCCESS;
}

bn_result bn_onnx_memory_check(const void *bytes, size_t size, uint32_t height, uint32_t width,
                               uint64_t most) {
    const span whole = {bytes, (const unsigned char *)bytes + size};
    span graph;
    field f, inner;
    if (!only_message(whole, 7, &graph)) return BN_ERROR_BAD_DATA;
    size_t names = 0;
    for (span s = graph; next_field(&s, &f) == 1;) {
        names += f.number == INITIALIZER || f.number == INPUT;
        for (span t = f.bytes; f.number == NODE && next_field(&t, &inner) == 1;) {
            names += is_output(&inner) != 0;
        }
    }
    if (names > MOST_VALUES) return BN_ERROR_UNSUPPORTED;
    table t = {NULL, 16};
    while (t.size < 2 * names + 2) t.size *= 2;
    t.slots = bn_allocate_zero(t.size, sizeof *t.slots);
    if (t.slots == NULL) return BN_ERROR_OUT_OF_MEMORY;
    uint64_t alive = 0;
    uint32_t number = 0;
    bn_result result = list_values(graph, height, width, &t, &alive);
    if (result == BN_SUCCESS && alive > most) result = BN_ERROR_UNSUPPORTED;
    note_uses(graph, &t);
    for (span s = graph; result == BN_SUCCESS && next_field(&s, &f) == 1;) {
        if (f.number == NODE) result = run_node(f.bytes, ++number, &t, most, &alive);
    }
    bn_free(t.slots);
    return result;
}
