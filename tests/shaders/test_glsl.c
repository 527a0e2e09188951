/* SPDX-License-Identifier: Apache-2.0
 * The draws of a shader, made of bn_draw.glsl and the words of bn_sampler_table_words() alone, give
 * the bits of the library; so do the choices of bn_choose.glsl. That the text is GLSL is checked by glslangValidator where that is
 * installed. */
#include "../c/check.h"
#include "glsl_in_c.h"
#include <bn/bn_choose.h>
#include <math.h>
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

/* Every width that an item can have, at its ends and in the middle. */
static void test_choices(void) {
    enum { STEPS = 1 << 24, ITEMS = 5 };
    float cdf[ITEMS + 2] = {NAN, -1.0f, 0.0f, 0.2f, 0.2f, 0.6f, 1.0f};
    int wrong = 0;
    uint32_t random = 3;
    for (uint32_t limit = 0; limit <= STEPS; ++limit) {
        random = random * 1664525u + 1013904223u;
        const uint32_t steps[] = {0, limit / 2, limit - 1, limit, random >> 8, STEPS - 1};
        const float p = (float)limit / STEPS;
        const uint32_t count = limit < 1000 ? limit : random >> (limit & 31u);
        for (int i = limit % 64 == 0 ? 0 : 2; i < (limit % 64 == 0 ? 6 : 5); ++i) {
            const float u = (float)(steps[i] & (STEPS - 1u)) / STEPS;
            float a = u, b = u;
            wrong += glsl_choose(p, &a) != bn_choose(p, &b) || a != b;
            a = b = u;
            wrong += glsl_choose_u32(count, &a) != bn_choose_u32(count, &b) || a != b;
            a = b = u;
            wrong += glsl_choose_cdf(cdf, 2, ITEMS, &a) != bn_choose_cdf(cdf + 2, ITEMS, &b);
            wrong += a != b;
        }
    }
    CHECK(wrong == 0);
    static const float strange[] = {-1.0f, -0.0f, 1e-45f, 0.3f, 1.0f, 2.0f, INFINITY, NAN};
    for (int i = 0; i < 64; ++i) {
        float a = strange[i / 8], b = a;
        CHECK(glsl_choose(strange[i % 8], &a) == bn_choose(strange[i % 8], &b) && a == b);
    }
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
                for (uint32_t pair = 0; pair < 2u; ++pair) {
                    glsl_draw_pair(words, kind, x, y, indices[i / NC / NC], domain, pair, shader);
                    CHECK(memcmp(bits + 2u * pair, shader, sizeof bits / 2) == 0);
                }
            }
            bn_sampler_destroy(s);
        }
    }
    free(words);
    test_choices();
    return check_result();
}
