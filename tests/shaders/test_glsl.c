/* SPDX-License-Identifier: Apache-2.0
 * The draws of a shader, made of bn_draw.glsl and the words of bn_tables() alone, give
 * the bits of the library; so do the paths of bn_path.glsl and the choices of bn_choose.glsl. That the
 * text is GLSL is checked by glslangValidator where that is installed. */
#include "../c/check.h"
#include "../c/samplers.h"
#include "glsl_in_c.h"
#include <bn/bn_choose.h>
#include <bn/bn_path.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void test_words(void) {
    size_t count = 0;
    uint32_t version = 0;
    const uint32_t *words = bn_tables(&count, &version);
    CHECK(words != NULL && count == glsl_word_count() && version == BN_DRAW_TABLE_VERSION);
    CHECK(bn_tables(NULL, NULL) == words);
}

static float float_of(uint32_t bits) {
    return (float)(bits >> 8) / (1 << 24);
}

/* A shader that numbers the decisions of a ray itself draws what the objects of bn_path.h hand out. */
static void test_path(const bn_sampler *s, const glsl_table *table, int32_t kind,
                      const bn_path *path, uint32_t frame, uint32_t number, uint32_t count) {
    const int32_t x = (int32_t)path->x, y = (int32_t)path->y;
    bn_ray ray = bn_path_ray(path, number);
    uint32_t bits[4];
    float u[4];
    for (uint32_t k = 0; k < 9; ++k) {
        glsl_path found = glsl_path_words(table, x, y, path->index, frame, number, 2 * k, count, k);
        const bn_split split =
            count > 0 ? bn_ray_split(&ray, count) : bn_ray_split_from(&ray, path->index);
        const bn_path branch = bn_split_path(&split, k);
        CHECK(found.branch_index == branch.index && found.branch_domain == branch.domain);
        const bn_ray first = bn_path_ray(&branch, 0);
        bn_ray_draw(s, &first, u);
        glsl_draw(table, kind, x, y, found.branch_index, found.branch_ray, bits);
        CHECK(u[0] == float_of(bits[0]) && u[3] == float_of(bits[3]));

        found = glsl_path_words(table, x, y, path->index, frame, number, k, 1, k);
        const float single = bn_ray_1d(s, &ray);
        glsl_draw_pair(table, kind, x, y, path->index, found.domain_1d, found.pair_1d, bits);
        CHECK(single == float_of(bits[k % 2]) && single == bn_ray_1d_at(s, &ray, k));
        float at[4];
        bn_ray_2d(s, &ray, u);
        bn_ray_2d_at(s, &ray, k, at);
        CHECK(memcmp(u, at, 2 * sizeof *u) == 0);
        glsl_draw_pair(table, kind, x, y, path->index, found.domain_2d, found.pair_2d, bits);
        CHECK(u[0] == float_of(bits[0]) && u[1] == float_of(bits[1]));
        bn_ray_4d(s, &ray, u);
        bn_ray_4d_at(s, &ray, k, at);
        CHECK(memcmp(u, at, sizeof at) == 0);
        glsl_draw(table, kind, x, y, path->index, found.domain_4d, bits);
        for (int i = 0; i < 4; ++i) CHECK(u[i] == float_of(bits[i]));

        bn_rng rng = bn_ray_rng(s, &ray); /* the domain of split 2 k + 1 */
        found = glsl_path_words(table, x, y, path->index, frame, number, 2 * k + 1, 1, 4);
        glsl_draw(table, kind, x, y, path->index, found.split, bits);
        for (uint32_t i = 0; i < 7; ++i) {
            found = glsl_path_words(table, x, y, path->index, frame, number, 2 * k + 1, 1, i);
            CHECK(bn_rng_1d(&rng) == float_of(i < 4 ? bits[i] : found.noise));
            if (kind == BN_SAMPLER_WHITE && i < 4) CHECK(found.noise == bits[i]);
        }
    }
    const glsl_path found = glsl_path_words(table, x, y, path->index, frame, number, 0, 1, 0);
    bn_ray_draw(s, &ray, u);
    glsl_draw(table, kind, x, y, path->index, found.ray, bits);
    for (int i = 0; i < 4; ++i) CHECK(u[i] == float_of(bits[i]));
    glsl_draw_pair(table, kind, x, y, path->index, found.camera, 1, bits);
    bn_path_time(s, path, u);
    CHECK(u[0] == float_of(bits[0]) && u[1] == float_of(bits[1]));
    bn_path_first_light(s, path, count, 0, u);
    const uint32_t index = path->index * (count == 0 ? 1 : count);
    glsl_draw_pair(table, kind, x, y, index, found.camera, 0, bits);
    CHECK(u[0] == float_of(bits[0]) && u[1] == float_of(bits[1]));
}

static void test_paths(const bn_sampler *s, const glsl_table *table, int32_t kind) {
    static const uint32_t numbers[] = {0, 1, 2, 3, 4, 39, (1u << 28) - 1};
    for (uint32_t i = 0; i < 42; ++i) {
        const uint32_t frame = i % 3 == 0 ? 0 : i * 0x7654321u;
        const int32_t x = (int32_t)(i * 0x9e3779b9u), y = 100 - (int32_t)(7 * i);
        const bn_path path = bn_path_start(x, y, i % 2 ? i : 1000 * i, frame);
        test_path(s, table, kind, &path, frame, numbers[i % 7], i % 5);
    }
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
    test_words();
    for (int32_t kind = BN_SAMPLER_BLUE; kind <= BN_SAMPLER_WHITE; ++kind) {
        for (uint64_t seed = 0; seed < 8; ++seed) {
            const bn_sampler s = make_sampler(kind, 0, seed);
            glsl_table table = {bn_tables(NULL, NULL), {0}};
            bn_sampler_seed(&s, table.seed);
            test_paths(&s, &table, kind);
            uint32_t domain = (uint32_t)seed;
            for (int i = 0; i < NC * NC * NI; ++i) {
                uint32_t bits[4], shader[4];
                int32_t x = coordinates[i % NC], y = coordinates[i / NC % NC];
                uint32_t child = bn_domain_child(domain, (uint32_t)i);
                CHECK(glsl_domain_child(domain, (uint32_t)i) == child);
                domain = child;
                bn_sample_4d_u32(&s, x, y, indices[i / NC / NC], domain, bits);
                glsl_draw(&table, kind, x, y, indices[i / NC / NC], domain, shader);
                CHECK(memcmp(bits, shader, sizeof bits) == 0);
                for (uint32_t pair = 0; pair < 4u; ++pair) {
                    float u[2];
                    glsl_draw_pair(&table, kind, x, y, indices[i / NC / NC], domain, pair, shader);
                    bn_sample_pair(&s, x, y, indices[i / NC / NC], domain, pair, u);
                    CHECK(u[0] == float_of(shader[0]) && u[1] == float_of(shader[1]));
                    if (pair > 1u && kind == BN_SAMPLER_BLUE) continue;
                    CHECK(memcmp(bits + 2u * (pair & 1u), shader, sizeof bits / 2) == 0);
                }
            }
        }
    }
    test_choices();
    return check_result();
}
