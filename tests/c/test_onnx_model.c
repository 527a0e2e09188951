/* SPDX-License-Identifier: Apache-2.0
 * Models that are refused before a runtime sees them, each with the right result and without a
 * message. The fake ONNX Runtime would accept any of them. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <stdlib.h>
#include <unistd.h>

static bn_result open_bytes(const void *bytes, size_t size) {
    bn_neural *neural = NULL;
    bn_neural_options options = bn_neural_options_default();
    options.model = bytes;
    options.model_size = size;
    options.runtime_path = FAKE_RUNTIME;
    options.threads = 1;
    const bn_result result = bn_neural_open(&options, &neural);
    CHECK((result == BN_SUCCESS) == (neural != NULL));
    bn_neural_close(neural);
    return result;
}

static bn_result result_of(const model_parts *parts) {
    message model;
    make_model(parts, &model);
    return open_bytes(model.bytes, model.size);
}

#define CHECK_PART(field, value, result)                                                           \
    do {                                                                                           \
        model_parts parts = model_parts_default();                                                 \
        parts.field = value;                                                                       \
        CHECK(result_of(&parts) == result);                                                        \
    } while (0)

static void test_metadata(void) {
    static const char *const no_number[] = {NULL, "", "-1", " 1", "1 ", "1.0", "x", "1234567890"};
    for (size_t i = 0; i < sizeof no_number / sizeof *no_number; ++i) {
        CHECK_PART(radius, no_number[i], BN_ERROR_BAD_DATA);
        CHECK_PART(align, no_number[i], BN_ERROR_BAD_DATA);
        CHECK_PART(version, no_number[i], BN_ERROR_BAD_DATA);
    }
    CHECK_PART(radius, "0", BN_SUCCESS);
    CHECK_PART(radius, "256", BN_SUCCESS);
    CHECK_PART(radius, "257", BN_ERROR_BAD_DATA);
    CHECK_PART(radius, "999999999", BN_ERROR_BAD_DATA);
    CHECK_PART(align, "0", BN_ERROR_BAD_DATA);
    CHECK_PART(align, "64", BN_SUCCESS);
    CHECK_PART(align, "65", BN_ERROR_BAD_DATA);
    CHECK_PART(version, "0", BN_ERROR_UNSUPPORTED);
    CHECK_PART(version, "2", BN_ERROR_UNSUPPORTED);
    CHECK_PART(spacing, "1", BN_SUCCESS);
    CHECK_PART(spacing, "10000", BN_SUCCESS);
    CHECK_PART(spacing, "10001", BN_ERROR_BAD_DATA);
    CHECK_PART(spacing, "0", BN_ERROR_BAD_DATA);
    CHECK_PART(spacing, "3.5", BN_ERROR_BAD_DATA);
    CHECK_PART(spacing, "", BN_ERROR_BAD_DATA);
    char quantiles[1024];
    write_quantiles(quantiles, 65, -1000, 1000);
    CHECK_PART(quantiles, quantiles, BN_SUCCESS);
    write_quantiles(quantiles, 65, 7, 0);
    CHECK_PART(quantiles, quantiles, BN_ERROR_BAD_DATA); /* all the same */
    write_quantiles(quantiles, 65, 100000, -1);
    CHECK_PART(quantiles, quantiles, BN_ERROR_BAD_DATA); /* falling */
    write_quantiles(quantiles, 64, 0, 1);
    CHECK_PART(quantiles, quantiles, BN_ERROR_BAD_DATA);
    write_quantiles(quantiles, 66, 0, 1);
    CHECK_PART(quantiles, quantiles, BN_ERROR_BAD_DATA);
    static const char *const no_quantiles[] = {"", ",", "1", "0.5", "-", "--1", "1,,2"};
    for (size_t i = 0; i < sizeof no_quantiles / sizeof *no_quantiles; ++i) {
        CHECK_PART(quantiles, no_quantiles[i], BN_ERROR_BAD_DATA);
    }
    /* The same key twice. */
    message model;
    const model_parts parts = model_parts_default();
    make_model(&parts, &model);
    put_pair(&model, 14, "bn.align", "1");
    CHECK(open_bytes(model.bytes, model.size) == BN_ERROR_BAD_DATA);
}

static void test_graph(void) {
    CHECK_PART(channels, 16, BN_SUCCESS);
    CHECK_PART(channels, 17, BN_ERROR_BAD_DATA);
    CHECK_PART(channels, 0, BN_ERROR_BAD_DATA);
    CHECK_PART(input, "image", BN_ERROR_BAD_DATA);
    CHECK_PART(input, "noise2", BN_ERROR_BAD_DATA);
    CHECK_PART(output, "", BN_ERROR_BAD_DATA);
    CHECK_PART(input_channels, 2, BN_ERROR_BAD_DATA);
    CHECK_PART(fixed_extent, 64, BN_ERROR_BAD_DATA);
    CHECK_PART(element, 10, BN_ERROR_BAD_DATA); /* float16 */
    CHECK_PART(second_input, 1, BN_ERROR_BAD_DATA);
    CHECK_PART(second_output, 1, BN_ERROR_BAD_DATA);
    CHECK_PART(second_graph, 1, BN_ERROR_BAD_DATA);
    CHECK_PART(no_nodes, 1, BN_ERROR_BAD_DATA);
    char name[200];
    memset(name, 'a', sizeof name);
    name[128] = 0;
    CHECK_PART(output, name, BN_ERROR_BAD_DATA);
}

static void test_what_could_reach_beyond_the_file(void) {
    CHECK_PART(external, 1, BN_ERROR_UNSUPPORTED);
    CHECK_PART(external, 2, BN_ERROR_UNSUPPORTED);
    CHECK_PART(operator_domain, "com.example", BN_ERROR_UNSUPPORTED);
    CHECK_PART(operator_domain, "ai.onnx.ml", BN_ERROR_UNSUPPORTED);
    CHECK_PART(subgraph, 1, BN_ERROR_UNSUPPORTED);
    CHECK_PART(function, 1, BN_ERROR_UNSUPPORTED);
    CHECK_PART(training, 1, BN_ERROR_UNSUPPORTED);
}

static void test_damage(void) {
    message model;
    const model_parts parts = model_parts_default();
    make_model(&parts, &model);
    CHECK(open_bytes(model.bytes, model.size) == BN_SUCCESS);
    /* In a block of just its size, so that sanitizers see a byte too far. */
    for (size_t size = 1; size < model.size; ++size) {
        unsigned char *bytes = malloc(size);
        memcpy(bytes, model.bytes, size);
        CHECK(open_bytes(bytes, size) == BN_ERROR_BAD_DATA);
        free(bytes);
    }
    unsigned char *bytes = malloc(model.size);
    size_t refused = 0;
    for (size_t at = 0; at < model.size; ++at) {
        for (int bit = 0; bit < 8; ++bit) {
            memcpy(bytes, model.bytes, model.size);
            bytes[at] ^= (unsigned char)(1 << bit);
            refused += open_bytes(bytes, model.size) != BN_SUCCESS;
        }
    }
    CHECK(refused > model.size);
    free(bytes);
    static const char *const foreign[] = {"GIF89a", "\x08", "\x3a", "\x00\x00\x00\x00", "{}"};
    for (size_t i = 0; i < sizeof foreign / sizeof *foreign; ++i) {
        CHECK(open_bytes(foreign[i], strlen(foreign[i]) + 1) == BN_ERROR_BAD_DATA);
    }
    /* A length near the end of the address space, and a varint that never ends. */
    static const unsigned char lengths[][12] = {
        {0x3a, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01, 0},
        {0x08, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1},
        {0x3b, 0x3c, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
    for (size_t i = 0; i < 3; ++i) CHECK(open_bytes(lengths[i], 12) == BN_ERROR_BAD_DATA);
}

static void test_files(void) {
    char path[] = "/tmp/bn_test_onnx_model_XXXXXX";
    const int file = mkstemp(path);
    message model;
    const model_parts parts = model_parts_default();
    make_model(&parts, &model);
    CHECK(file >= 0 && write(file, model.bytes, model.size) == (ssize_t)model.size);
    bn_neural_options options = bn_neural_options_default();
    bn_neural *neural;
    options.model_path = path;
    options.runtime_path = FAKE_RUNTIME;
    CHECK(bn_neural_open(&options, &neural) == BN_SUCCESS);
    bn_neural_close(neural);
    CHECK(ftruncate(file, (off_t)model.size - 1) == 0);
    CHECK(bn_neural_open(&options, &neural) == BN_ERROR_BAD_DATA && neural == NULL);
    CHECK(ftruncate(file, (off_t)65 << 20) == 0);
    CHECK(bn_neural_open(&options, &neural) == BN_ERROR_BAD_DATA);
    close(file);
    unlink(path);
    CHECK(bn_neural_open(&options, &neural) == BN_ERROR_IO && neural == NULL);
}

int main(void) {
    const int silence = begin_silence();
    test_metadata();
    test_graph();
    test_what_could_reach_beyond_the_file();
    test_damage();
    test_files();
    const long printed = end_silence(silence);
    CHECK(check_failures > 0 || printed == 0);
    return check_result();
}
