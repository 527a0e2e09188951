/* SPDX-License-Identifier: Apache-2.0
 * Bounds the memory of a model: a file of a few hundred bytes can ask for gigabytes of tensors.
 *
 * Walks the nodes in order, as they run, with an upper bound on the extents of each value, and adds
 * up the elements of the values that are alive: those that a later node uses, and all that depend on
 * constants alone, which the runtime computes in advance. Operators whose results cannot be bounded
 * from the extents of their inputs are refused. Time and memory are linear in the nodes. */
#include "neural/onnx_memory.h"
#include "base/memory.h"
#include "neural/protobuf.h"
#include <string.h>

enum { AXES = 4, MOST_INPUTS = 256, MOST_VALUES = 1 << 18, NEVER = 0 };
static const uint64_t HUGE_COUNT = (uint64_t)1 << 40;

/* Upper bounds on the extents of a value. Shapes of fewer axes are aligned at the end, as in
 * broadcasting, with ones before them. Where the axes are not known, the last has all elements. */
typedef struct value {
    span name;
    uint64_t extent[AXES];
    uint32_t axes;     /* AXES + 1: not known */
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

static uint64_t count_of(const value *v) {
    uint64_t count = 1;
    for (int i = 0; i < AXES; ++i) count = times(count, v->extent[i]);
    return count;
}

/* A value of `count` elements whose axes are not known. */
static void set_flat(value *v, uint64_t count) {
    v->extent[0] = v->extent[1] = v->extent[2] = 1;
    v->extent[3] = count;
    v->axes = count == 1 ? 0 : AXES + 1;
}

static void copy_shape(value *to, const value *from) {
    memcpy(to->extent, from->extent, sizeof to->extent);
    to->axes = from->axes;
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
            memcmp(v->name.at, name.at, length) == 0)
            return v;
    }
}

/* ---- Attributes and tensors */

/* Reads repeated integers, packed or not: those of field `number`, at most `most`; -1 when there are
 * more or the message is malformed. Negative ones count as 0. */
static int read_integers(span s, uint32_t number, uint64_t *integers, int most) {
    field f;
    int state, count = 0;
    while ((state = next_field(&s, &f)) == 1) {
        if (f.number != number) continue;
        span packed = f.bytes;
        uint64_t one = f.value;
        while (f.wire != WIRE_BYTES || packed.at != packed.end) {
            if (f.wire == WIRE_BYTES && !read_varint(&packed, &one)) return -1;
            if (count == most) return -1;
            integers[count++] = one >> 63 ? 0 : one;
            if (f.wire != WIRE_BYTES) break;
        }
    }
    return state == 0 ? count : -1;
}

/* The attribute of a node by its name: 1, 0 when there is none, -1 when there are several. */
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

/* The integers of an attribute, `fallback` where there are none; 0 when they cannot be read. */
static int attribute_integers(span node, const char *name, uint64_t *integers, int most,
                              uint64_t fallback) {
    span attribute;
    const int found = find_attribute(node, name, &attribute);
    for (int i = 0; i < most; ++i) integers[i] = fallback;
    return found == 0 || (found == 1 && read_integers(attribute, 8, integers, most) >= 0);
}

/* The single integer of an attribute, with its sign; 0 if it cannot be read. */
static int attribute_integer(span node, const char *name, int64_t fallback, int64_t *integer) {
    span attribute;
    field f;
    const int found = find_attribute(node, name, &attribute);
    *integer = fallback;
    while (found == 1 && next_field(&attribute, &f) == 1) {
        if (f.number == 3 && f.wire == WIRE_VARINT) *integer = (int64_t)f.value;
    }
    return found >= 0;
}

/* TensorProto: its name and extents. */
static int read_tensor(span s, value *v) {
    enum { DIMS = 1, NAME = 8 };
    uint64_t dims[8], leading = 1;
    field f;
    const int axes = read_integers(s, DIMS, dims, 8);
    if (axes < 0) return 0;
    for (int i = 0; i < AXES; ++i) v->extent[i] = 1;
    for (int i = 0; i < axes; ++i) {
        const int at = AXES - axes + i;
        if (at >= 0) v->extent[at] = times(1, dims[i]);
        if (at <= 0) leading = times(leading, dims[i]);
    }
    v->extent[0] = axes >= AXES ? leading : v->extent[0];
    v->axes = (uint32_t)axes;
    if (axes > AXES) set_flat(v, count_of(v));
    v->name.at = v->name.end = NULL;
    while (next_field(&s, &f) == 1) {
        if (f.number == NAME && is_bytes(&f)) v->name = f.bytes;
    }
    return 1;
}

/* ---- Operators */

typedef enum rule {
    SAME,      /* at most the extents of the first input */
    BROADCAST, /* of all inputs together */
    FLAT,      /* as many elements as the first input, of other axes */
    PRODUCT,   /* at most as many elements as the first two inputs multiplied */
    REDUCE,
    GLOBAL_POOL,
    POOL,
    CONV,
    CONV_TRANSPOSE,
    CONCAT,
    DEPTH_TO_SPACE,
    SPACE_TO_DEPTH,
    SHAPE,
    CONSTANT,
    CAST
} rule;

static const struct {
    const char *name;
    rule rule;
} operators[] = {
    {"Conv", CONV},
    {"ConvTranspose", CONV_TRANSPOSE},
    {"Concat", CONCAT},
    {"Constant", CONSTANT},
    {"Cast", CAST},
    {"DepthToSpace", DEPTH_TO_SPACE},
    {"SpaceToDepth", SPACE_TO_DEPTH},
    {"Shape", SHAPE},
    {"AveragePool", POOL},
    {"MaxPool", POOL},
    {"LpPool", POOL},
    {"GlobalAveragePool", GLOBAL_POOL},
    {"GlobalMaxPool", GLOBAL_POOL},
    {"GlobalLpPool", GLOBAL_POOL},
    {"ReduceMean", REDUCE},
    {"ReduceSum", REDUCE},
    {"ReduceMax", REDUCE},
    {"ReduceMin", REDUCE},
    {"ReduceL1", REDUCE},
    {"ReduceL2", REDUCE},
    {"ReduceSumSquare", REDUCE},
    {"Gather", PRODUCT},
    {"Gemm", PRODUCT},
    {"MatMul", PRODUCT},
    {"Reshape", FLAT},
    {"Flatten", FLAT},
    {"Squeeze", FLAT},
    {"Unsqueeze", FLAT},
    {"Transpose", FLAT},
    {"Add", BROADCAST},
    {"Sub", BROADCAST},
    {"Mul", BROADCAST},
    {"Div", BROADCAST},
    {"Pow", BROADCAST},
    {"Mod", BROADCAST},
    {"Max", BROADCAST},
    {"Min", BROADCAST},
    {"Sum", BROADCAST},
    {"Mean", BROADCAST},
    {"PRelu", BROADCAST},
    {"Where", BROADCAST},
    {"Less", BROADCAST},
    {"LessOrEqual", BROADCAST},
    {"Greater", BROADCAST},
    {"GreaterOrEqual", BROADCAST},
    {"Equal", BROADCAST},
    {"And", BROADCAST},
    {"Or", BROADCAST},
    {"Xor", BROADCAST},
    {"Abs", SAME},
    {"BatchNormalization", SAME},
    {"Ceil", SAME},
    {"Celu", SAME},
    {"Clip", SAME},
    {"Cos", SAME},
    {"CumSum", SAME},
    {"Dropout", SAME},
    {"Elu", SAME},
    {"Erf", SAME},
    {"Exp", SAME},
    {"Floor", SAME},
    {"Gelu", SAME},
    {"GroupNormalization", SAME},
    {"HardSigmoid", SAME},
    {"HardSwish", SAME},
    {"Identity", SAME},
    {"InstanceNormalization", SAME},
    {"LayerNormalization", SAME},
    {"LeakyRelu", SAME},
    {"Log", SAME},
    {"LogSoftmax", SAME},
    {"LRN", SAME},
    {"Mish", SAME},
    {"Neg", SAME},
    {"Not", SAME},
    {"Reciprocal", SAME},
    {"Relu", SAME},
    {"Round", SAME},
    {"Selu", SAME},
    {"Sigmoid", SAME},
    {"Sign", SAME},
    {"Sin", SAME},
    {"Slice", SAME},
    {"Softmax", SAME},
    {"Softplus", SAME},
    {"Softsign", SAME},
    {"Split", SAME},
    {"Sqrt", SAME},
    {"Tanh", SAME},
    {"ThresholdedRelu", SAME},
};

static int find_rule(span name, rule *found) {
    for (size_t i = 0; i < sizeof operators / sizeof *operators; ++i) {
        if (!is_text(name, operators[i].name)) continue;
        *found = operators[i].rule;
        return 1;
    }
    return 0;
}

static void broadcast(value *to, const value *with) {
    if (to->axes == 0) {
        copy_shape(to, with);
    } else if (with->axes != 0 && (to->axes > AXES || with->axes > AXES)) {
        set_flat(to, times(count_of(to), count_of(with)));
    } else {
        for (int i = 0; i < AXES; ++i) to->extent[i] = larger(to->extent[i], with->extent[i]);
        to->axes = (uint32_t)larger(to->axes, with->axes);
    }
}

/* Adds the padding of a node to the extents of an image: the larger sum to both, as flat values do
 * not say which axis is which. */
static int pad(span node, value *to) {
    uint64_t pads[AXES], most = 0;
    if (!attribute_integers(node, "pads", pads, AXES, 0)) return 0;
    for (int i = 0; i < 2; ++i) most = larger(most, plus(times(1, pads[i]), times(1, pads[i + 2])));
    to->extent[2] = plus(to->extent[2], most);
    to->extent[3] = plus(to->extent[3], most);
    return 1;
}

static int conv_transpose(span node, const value *weights, value *to) {
    uint64_t strides[2], dilations[2], extra[2];
    int64_t group;
    span attribute;
    if (find_attribute(node, "output_shape", &attribute) != 0 || weights->axes != AXES ||
        !attribute_integers(node, "strides", strides, 2, 1) ||
        !attribute_integers(node, "dilations", dilations, 2, 1) ||
        !attribute_integers(node, "output_padding", extra, 2, 0) ||
        !attribute_integer(node, "group", 1, &group)) {
        return 0;
    }
    const uint64_t stride = larger(larger(strides[0], strides[1]), 1);
    const uint64_t dilation = larger(dilations[0], dilations[1]);
    const uint64_t kernel = larger(weights->extent[2], weights->extent[3]);
    to->extent[1] = times(weights->extent[1], group < 1 ? 1 : times(1, (uint64_t)group));
    for (int i = 2; i < AXES; ++i) {
        to->extent[i] = plus(times(to->extent[i], times(1, stride)), times(kernel, dilation));
        to->extent[i] = plus(to->extent[i], times(1, larger(extra[0], extra[1])));
    }
    return 1;
}

static int concat(span node, value *const *inputs, int count, value *to) {
    uint64_t total = 0;
    int64_t axis;
    int known = 1;
    if (!attribute_integer(node, "axis", 0, &axis)) return 0;
    for (int i = 0; i < count; ++i) {
        total = plus(total, count_of(inputs[i]));
        known = known && inputs[i]->axes == inputs[0]->axes && inputs[i]->axes <= AXES;
    }
    if (axis < 0) axis += inputs[0]->axes;
    if (!known || axis < 0 || axis >= inputs[0]->axes) {
        set_flat(to, total);
        return 1;
    }
    const int at = AXES - (int)inputs[0]->axes + (int)axis;
    copy_shape(to, inputs[0]);
    for (int i = 1; i < count; ++i) {
        for (int k = 0; k < AXES; ++k) {
            to->extent[k] = k == at ? plus(to->extent[k], inputs[i]->extent[k])
                                    : larger(to->extent[k], inputs[i]->extent[k]);
        }
    }
    return 1;
}

static int constant(span node, value *to) {
    span attribute, tensor;
    const int found = find_attribute(node, "value", &attribute);
    if (found != 0) {
        value read;
        if (found < 0 || !only_message(attribute, 5, &tensor) || !read_tensor(tensor, &read))
            return 0;
        copy_shape(to, &read);
        return 1;
    }
    /* The numbers are in the attributes: no more of them than the node has bytes. */
    set_flat(to, (uint64_t)(node.end - node.at));
    return 1;
}

/* The extents of a node's first output; 0 when they cannot be bounded. */
static int infer(span node, rule kind, value *const *inputs, int count, value *to) {
    enum { STRING = 8 };
    int64_t number;
    if (kind == CONSTANT) return constant(node, to);
    if (count < 1) return 0;
    copy_shape(to, inputs[0]);
    switch (kind) {
    case BROADCAST:
        for (int i = 1; i < count; ++i) broadcast(to, inputs[i]);
        return 1;
    case FLAT:
        set_flat(to, count_of(to));
        return 1;
    case PRODUCT:
        set_flat(to, count < 2 ? count_of(to) : times(count_of(to), count_of(inputs[1])));
        return 1;
    case REDUCE:
        if (!attribute_integer(node, "keepdims", 1, &number)) return 0;
        if (number == 0) set_flat(to, count_of(to));
        return 1;
    case GLOBAL_POOL:
        to->extent[2] = to->extent[3] = 1;
        return to->axes == AXES;
    case POOL:
        return pad(node, to);
    case CONV:
        if (count < 2 || inputs[1]->axes != AXES) return 0;
        if (to->axes <= AXES) to->extent[1] = inputs[1]->extent[0];
        if (to->axes > AXES) to->extent[0] = inputs[1]->extent[0];
        return pad(node, to);
    case CONV_TRANSPOSE:
        return count >= 2 && to->axes == AXES && conv_transpose(node, inputs[1], to);
    case CONCAT:
        return concat(node, inputs, count, to);
    case DEPTH_TO_SPACE:
    case SPACE_TO_DEPTH:
        if (to->axes != AXES || !attribute_integer(node, "blocksize", 1, &number) || number < 1 ||
            number > 1024) {
            return 0;
        }
        for (int i = 2; i < AXES; ++i) {
            to->extent[i] = kind == DEPTH_TO_SPACE ? times(to->extent[i], (uint64_t)number)
                                                   : to->extent[i] / (uint64_t)number + 1;
        }
        to->extent[1] = kind == DEPTH_TO_SPACE ? to->extent[1] / (uint64_t)(number * number) + 1
                                               : times(to->extent[1], (uint64_t)(number * number));
        return 1;
    case SHAPE:
        set_flat(to, 8);
        return 1;
    case CAST:
        return attribute_integer(node, "to", STRING, &number) && number != STRING;
    default:
        return 1;
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
    value *v = find(t, name);
    if (name.at == NULL || v->name.at != NULL) return NULL;
    v->name = name;
    return v;
}

/* Fills the table with the initializers, the input and all outputs of nodes. */
static bn_result list_values(span graph, uint32_t height, uint32_t width, const table *t,
                             uint64_t *alive) {
    field f, inner;
    while (next_field(&graph, &f) == 1) {
        value read = {.extent = {1, 1, height, width}, .axes = AXES, .is_ready = 1};
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
        *alive = plus(*alive, count_of(v));
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
    value *inputs[MOST_INPUTS], result;
    span name = {NULL, NULL};
    field f;
    rule kind;
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
    if (name.at == NULL || !find_rule(name, &kind)) return BN_ERROR_UNSUPPORTED;
    if (!infer(node, kind, inputs, count, &result)) return BN_ERROR_UNSUPPORTED;
    for (span s = node; next_field(&s, &f) == 1;) {
        if (!is_output(&f)) continue;
        value *v = find(t, f.bytes);
        copy_shape(v, &result);
        v->is_ready = 1;
        v->is_constant = constants == count;
        *alive = plus(*alive, count_of(v));
    }
    if (*alive > most) return BN_ERROR_UNSUPPORTED;
    for (int i = 0; i < count; ++i) {
        if (inputs[i]->last_use != number || inputs[i]->is_constant) continue;
        *alive -= count_of(inputs[i]);
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
