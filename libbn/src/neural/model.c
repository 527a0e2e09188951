/* SPDX-License-Identifier: Apache-2.0
 * Checks the metadata and shapes of a model that ONNX Runtime has loaded. Everything that later computations
 * rely on is bounded here: the radius, the alignment and the channels, which determine the memory of a tile,
 * and the order of the quantiles. Whether the model's output really has these extents, bn_neural_open() tries. */
#include "neural/model.h"
#include <string.h>

/* Reads a decimal number of at most nine digits, followed by `end`. Returns NULL if there is none. */
static const char *read_decimal(const char *text, char end, uint32_t *value) {
    const char *at = text;
    for (*value = 0; *at >= '0' && *at <= '9' && at - text < 9; ++at) {
        *value = *value * 10 + (uint32_t)(*at - '0');
    }
    return at != text && *at == end ? at : NULL;
}

/* Reads BN_MODEL_QUANTILES ascending integers, separated by commas, as multiples of 2^-24. */
static int read_quantiles(const char *text, float quantiles[BN_MODEL_QUANTILES]) {
    for (int i = 0; i < BN_MODEL_QUANTILES; ++i) {
        uint32_t size;
        const int negative = *text == '-';
        text = read_decimal(text + negative, i + 1 == BN_MODEL_QUANTILES ? 0 : ',', &size);
        if (text == NULL) return 0;
        quantiles[i] = (float)size * (negative ? -0x1p-24f : 0x1p-24f);
        if (i > 0 && quantiles[i] < quantiles[i - 1]) return 0;
        ++text;
    }
    return quantiles[BN_MODEL_QUANTILES - 1] > quantiles[0];
}

bn_result bn_model_read(const bn_runtime *runtime, bn_model *model) {
    enum { KEYS = 4 };
    static const char *const keys[KEYS] = {"bn.version", "bn.receptive_radius", "bn.align",
                                           "bn.sparse_spacing"};
    char text[BN_RUNTIME_TEXT_SIZE], name[BN_RUNTIME_TEXT_SIZE];
    uint32_t values[KEYS] = {0}, channels;
    bn_model found;
    memset(&found, 0, sizeof found);
    for (int k = 0; k < KEYS; ++k) {
        const bn_result result = bn_runtime_metadata(runtime, keys[k], text);
        if (result != BN_SUCCESS) return result;
        if (k == 3 && *text == 0) continue; /* the spacing is optional */
        if (read_decimal(text, 0, &values[k]) == NULL) return BN_ERROR_BAD_DATA;
        if (k == 0 && values[0] != 1) return BN_ERROR_UNSUPPORTED;
        if (k == 3 && values[3] < 1) return BN_ERROR_BAD_DATA;
    }
    if (values[1] > BN_MODEL_MOST_RADIUS || values[2] < 1 || values[2] > BN_MODEL_MOST_ALIGN ||
        values[3] > BN_MODEL_MOST_SPACING) {
        return BN_ERROR_BAD_DATA;
    }
    found.radius = values[1];
    found.align = values[2];
    found.sparse_spacing = values[3];
    bn_result result = bn_runtime_metadata(runtime, "bn.quantiles", text);
    if (result != BN_SUCCESS) return result;
    found.has_quantiles = *text != 0;
    if (found.has_quantiles && !read_quantiles(text, found.quantiles)) return BN_ERROR_BAD_DATA;
    result = bn_runtime_value(runtime, BN_RUNTIME_INPUT, name, &channels);
    if (result != BN_SUCCESS) return result;
    if (strcmp(name, "noise") != 0 || channels != 1) return BN_ERROR_BAD_DATA;
    result = bn_runtime_value(runtime, BN_RUNTIME_OUTPUT, found.output, &found.channels);
    if (result != BN_SUCCESS) return result;
    if (found.channels > BN_MODEL_MOST_CHANNELS) return BN_ERROR_BAD_DATA;
    *model = found;
    return BN_SUCCESS;
}
