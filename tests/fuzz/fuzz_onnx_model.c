/* SPDX-License-Identifier: Apache-2.0
 * Fuzzes the readers of model files: they must not read beyond the bytes they are given, and what
 * they accept must be in range.
 *
 * Built with -fsanitize=fuzzer (BN_FUZZ) this is a libFuzzer program. Otherwise main() mutates
 * models of the test writer: `fuzz_onnx_model [count] [seed]` makes count inputs. */
#include "../c/onnx_writer.h"
#include "neural/onnx_memory.h"
#include "neural/onnx_model.h"
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void require(int condition, const char *what) {
    if (condition) return;
    fprintf(stderr, "fuzz_onnx_model: %s\n", what);
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    bn_onnx_model model;
    memset(&model, 0x5a, sizeof model);
    const bn_onnx_model before = model;
    const bn_result result = bn_onnx_model_read(bytes, size, &model);
    if (result == BN_SUCCESS) {
        require(model.radius <= BN_MODEL_MOST_RADIUS, "radius");
        require(model.align >= 1 && model.align <= BN_MODEL_MOST_ALIGN, "align");
        require(model.channels >= 1 && model.channels <= BN_MODEL_MOST_CHANNELS, "channels");
        require(memchr(model.output, 0, sizeof model.output) != NULL, "output name");
        const uint32_t extent = 256 + 2 * model.radius;
        const bn_result memory =
            bn_onnx_memory_check(bytes, size, extent, extent, BN_MODEL_MOST_ELEMENTS);
        require(memory == BN_SUCCESS || memory == BN_ERROR_BAD_DATA ||
                    memory == BN_ERROR_UNSUPPORTED,
                "result of the memory check");
    } else {
        require(result == BN_ERROR_BAD_DATA || result == BN_ERROR_UNSUPPORTED, "result");
        require(memcmp(&model, &before, sizeof model) == 0, "a failure wrote");
    }
    return 0;
}

#ifndef BN_LIBFUZZER

static uint32_t state;

/* Marsaglia, "Xorshift RNGs", 2003. */
static uint32_t below(uint32_t limit) {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state % limit;
}

static void change(unsigned char *bytes, size_t *size, size_t capacity) {
    const size_t at = below((uint32_t)*size), other = below((uint32_t)*size);
    switch (below(7)) {
    case 0:
        bytes[at] ^= (unsigned char)(1u << below(8));
        break;
    case 1:
        bytes[at] = (unsigned char)below(256);
        break;
    case 2: /* the values at which lengths change their meaning */
        bytes[at] = (unsigned char)(127 + below(3) * 64);
        break;
    case 3:
        bytes[at] = bytes[other];
        break;
    case 4:
        *size = at + 1;
        break;
    case 5: { /* a piece out */
        const size_t count = below((uint32_t)(*size - at)) + 1;
        if (count >= *size) break;
        memmove(bytes + at, bytes + at + count, *size - at - count);
        *size -= count;
        break;
    }
    default: { /* a piece in, from elsewhere */
        size_t count = below(40) + 1;
        if (count > *size - other) count = *size - other;
        if (*size + count > capacity) break;
        unsigned char piece[40];
        memcpy(piece, bytes + other, count);
        memmove(bytes + at + count, bytes + at, *size - at);
        memcpy(bytes + at, piece, count);
        *size += count;
    }
    }
}

int main(int argc, char **argv) {
    const long count = argc > 1 ? atol(argv[1]) : 100000;
    long accepted = 0;
    state = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) | 1 : 1;
    for (long i = 0; i < count; ++i) {
        model_parts parts = model_parts_default();
        message model;
        parts.external = below(4) == 0 ? 2 : 0;
        parts.subgraph = below(4) == 0;
        parts.channels = 1 + below(3);
        char quantiles[1024];
        write_quantiles(quantiles, 65, -3, 1 + (long)below(9));
        parts.quantiles = below(4) == 0 ? quantiles : NULL;
        make_model(&parts, &model);
        for (uint32_t changes = below(4); changes > 0; --changes) {
            change(model.bytes, &model.size, sizeof model.bytes);
        }
        /* In a block of just its size, so that sanitizers see a byte too far. */
        unsigned char *bytes = malloc(model.size);
        require(bytes != NULL, "out of memory");
        memcpy(bytes, model.bytes, model.size);
        bn_onnx_model found;
        accepted += bn_onnx_model_read(bytes, model.size, &found) == BN_SUCCESS;
        LLVMFuzzerTestOneInput(bytes, model.size);
        free(bytes);
    }
    printf("%ld inputs, %ld accepted\n", count, accepted);
    return accepted > 0 && accepted < count ? 0 : 1;
}

#endif
