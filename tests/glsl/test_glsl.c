/* SPDX-License-Identifier: Apache-2.0
 * The draws of a shader, made of bn_draw.glsl and the words of bn_sampler_table_words() alone, give
 * the bits of the library. That the text is GLSL is checked by glslangValidator where that is
 * installed. */
#include "../c/check.h"
#include "glsl_in_c.h"
#include <stdlib.h>
#include <string.h>

static void test_words(const bn_sampler *s) {
    size_t needed = 0;
    uint32_t word = 7;
    CHECK(bn_sampler_table_words(s, NULL, 0, &needed) == BN_SUCCESS);
    CHECK(needed == glsl_word_count());
    CHECK(bn_sampler_table_words(s, NULL, 0, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_sampler_table_words(NULL, &word, 1, &needed) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_sampler_table_words(s, &word, 1, NULL) == BN_ERROR_SIZE_MISMATCH && word == 7);
}

int main(void) {
    static const int32_t coordinates[] = {0, 5, -1, 127, 128, -129, INT32_MAX, INT32_MIN};
    static const uint32_t indices[] = {0,   1,   2,   3,    30,       64,         200,
                                       255, 256, 257, 1000, 1u << 20, UINT32_MAX, 0x80000001u};
    enum { NC = sizeof coordinates / sizeof *coordinates, NI = sizeof indices / sizeof *indices };
    uint32_t *words = malloc(glsl_word_count() * sizeof *words);
    for (int32_t kind = BN_SAMPLER_BLUE; kind <= BN_SAMPLER_WHITE; ++kind) {
        for (uint64_t seed = 0; seed < 8; ++seed) {
            bn_sampler_options options = bn_sampler_options_default();
            bn_sampler *s = NULL;
            options.kind = kind;
            options.seed = seed;
            CHECK(bn_sampler_create(&options, &s) == BN_SUCCESS);
            test_words(s);
            CHECK(bn_sampler_table_words(s, words, glsl_word_count(), NULL) == BN_SUCCESS);
            uint32_t domain = (uint32_t)seed;
            for (int i = 0; i < NC * NC * NI; ++i) {
                uint32_t bits[4], shader[4];
                int32_t x = coordinates[i % NC], y = coordinates[i / NC % NC];
                uint32_t child = bn_domain_child(domain, (uint32_t)i);
                CHECK(glsl_domain_child(domain, (uint32_t)i) == child);
                domain = child;
                bn_sample_4d_u32(s, x, y, indices[i / NC / NC], domain, bits);
                glsl_draw(words, kind, x, y, indices[i / NC / NC], domain, shader);
                CHECK(memcmp(bits, shader, sizeof bits) == 0);
            }
            bn_sampler_destroy(s);
        }
    }
    free(words);
    return check_result();
}
