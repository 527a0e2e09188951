/* SPDX-License-Identifier: Apache-2.0
 * Writes the data for the shader tests into a folder, as 32-bit words in native byte order:
 *
 *     words.bin     [BN_WORD_COUNT]: the words of bn_tables()
 *     cdf.bin       [CDF]: tables of cumulative weights
 *     cases.bin     [cases][16]: type + 4 pair, x, y, index, parent, key; probability, u, count, first + 256
 *                   cdf_count; the two words of a seed; a path's ray number, k, branch count and frame
 *     expected.bin  [cases][16]: the draws of the path's objects, from drawn_words(); the draw as bits and as
 *                   floats; the results of bn_choose(), bn_choose_u32() and bn_choose_cdf(), each followed by
 *                   its remainder of u; and a sum of v.x + 3 v.y + 5 w.x + 7 w.y and, from path_words() and
 *                   frame_words(), the domain, all words of the path, a pan and a film's frame, each
 *                   multiplied by a different odd number. v is the pair drawn alone, as bits, and w is the
 *                   same pair as floats. */
#include "../c/check.h"
#include "../c/samplers.h"
#include <bn/bn_choose.h>
#include <bn/bn_path.h>
#include <stdio.h>
#include <string.h>

enum { SEEDS = 3, SHADER_TYPES = 3, CDF = 64, RECORD = 16, RANDOM_CASES = 1 << 14 };

static const uint64_t seeds[SEEDS] = {0, 1, UINT64_MAX};
static const int32_t coordinates[] = {0, 5, -1, 127, 128, -129, INT32_MAX, INT32_MIN};
static const uint32_t indices[] = {0,   1,   2,   3,    30,       64,         200,
                                   255, 256, 257, 1000, 1u << 20, UINT32_MAX, 0x80000001u};
enum {
    COORDINATES = sizeof coordinates / sizeof *coordinates,
    INDICES = sizeof indices / sizeof *indices,
    EDGE_CASES = COORDINATES * COORDINATES * INDICES,
    CASES = SHADER_TYPES * (EDGE_CASES + RANDOM_CASES)
};

static uint32_t random_state = 1;

static uint32_t random_u32(void) {
    random_state = random_state * 1664525u + 1013904223u;
    uint32_t v = (random_state ^ random_state >> 16) * 0x21f0aaadu;
    v = (v ^ v >> 15) * 0xd35a2d97u;
    return v ^ v >> 15;
}

/* Numbers of all bit lengths are about equally frequent. */
static uint32_t random_size(void) {
    const uint32_t v = random_u32();
    return v >> (random_u32() & 31u);
}

/* Mostly multiples of 2^-24 in [0, 1), and sometimes 0, 1, other floats or floats outside [0, 1). NaNs and
 * subnormal numbers are excluded, because shaders may treat them differently. */
static float random_number(void) {
    static const float strange[] = {0.0f, -1.0f, 1.0f, 2.0f, 0.3f, 1e-30f, 1.0f - 1.0f / (1 << 24)};
    const uint32_t v = random_u32();
    return v % 8u == 0 ? strange[random_u32() % 7u] : (float)(random_size() >> 8) / (1 << 24);
}

static void choose(const float *cdf, uint32_t *record, uint32_t *expected) {
    const float u = random_number(), probability = random_number();
    record[6] = bits_of(probability);
    record[7] = bits_of(u);
    record[8] = random_size();
    const uint32_t first = random_u32() % (CDF / 2), items = random_u32() % (CDF / 2);
    record[9] = first | items << 8;
    float left = u;
    expected[9] = (uint32_t)bn_choose(probability, &left);
    expected[10] = bits_of(left);
    left = u;
    expected[11] = bn_choose_u32(record[8], &left);
    expected[12] = bits_of(left);
    left = u;
    expected[13] = bn_choose_cdf(cdf + first, items, &left);
    expected[14] = bits_of(left);
}

static void draw(uint64_t seed, uint32_t at, uint32_t *record, uint32_t *expected) {
    bn_sampler sampler;
    bn_sampler_init(&sampler, (int32_t)(at % SHADER_TYPES), seed);
    const uint32_t pair = random_u32() >> 30;
    bn_sampler_seed(&sampler, record + 10);
    const uint32_t edge = at / SHADER_TYPES;
    const int far = edge < EDGE_CASES;
    const int32_t x = far ? coordinates[edge % COORDINATES] : (int32_t)random_u32();
    const int32_t y = far ? coordinates[edge / COORDINATES % COORDINATES] : (int32_t)random_size();
    record[0] = at % SHADER_TYPES | pair << 2;
    record[1] = (uint32_t)x;
    record[2] = (uint32_t)y;
    record[3] = far ? indices[edge / COORDINATES / COORDINATES] : random_size();
    record[4] = at % 16u < 4u ? BN_DOMAIN_ROOT : random_u32();
    record[5] = random_size();
    expected[0] = bn_domain_child(record[4], record[5]);
    bn_sample_4d_u32(&sampler, x, y, record[3], expected[0], expected + 1);
    float u[4];
    bn_sample_4d(&sampler, x, y, record[3], expected[0], u);
    for (int d = 0; d < 4; ++d) expected[5 + d] = bits_of(u[d]);
    bn_uint2 v = {expected[1 + 2 * (pair & 1u)], expected[2 + 2 * (pair & 1u)]};
    if (at % SHADER_TYPES == BN_SAMPLER_BLUE) {
        v = bn_draw_blue_pair_bits(bn_tables(NULL, NULL), bn_draw_seed(&sampler), record[1],
                                   record[2], record[3], expected[0], pair);
    }
    bn_sample_2d(&sampler, x, y, record[3], expected[0], pair, u);
    expected[15] = v.x + 3u * v.y + 5u * bits_of(u[0]) + 7u * bits_of(u[1]);
}

static uint32_t words_of(uint32_t factor, const float v[2]) {
    return factor * bits_of(v[0]) + (factor + 2) * bits_of(v[1]);
}

/* The draws from bn_path.h that shaders provide under the same names. */
static uint32_t drawn_words(const bn_path *path, const uint32_t seed[2], uint32_t number,
                            uint32_t k, uint32_t count, const bn_path *branch) {
    float u[4], first[2], time[2], direction[2], light[2], four[4], pair[2], one = 0;
    bn_sampler sampler = bn_sampler_make(0);
    const bn_ray ray = bn_path_ray(path, number), part = bn_ray_child(&ray, k);
    memcpy(sampler.seed, seed, sizeof sampler.seed);
    bn_loop loop = bn_ray_draw_loop(&sampler, &ray, k);
    bn_ray_draw(&sampler, &part, u);
    bn_ray_draw_direction(&sampler, &ray, direction);
    bn_ray_draw_end_light(&sampler, &ray, light);
    bn_ray_draw_2d(&sampler, &ray, k, pair);
    bn_ray_draw_4d(&sampler, &ray, k, four);
    bn_path_first_light(&sampler, path, count, k, first);
    bn_path_time_wavelength(&sampler, path, time);
    for (uint32_t i = 0; i <= (k & 15u); ++i) one = bn_loop_next_1d(&loop);
    return 49u * branch->index + 51u * branch->domain + words_of(53u, direction) +
           words_of(57u, light) + 61u * bits_of(u[0]) + 63u * bits_of(u[3]) +
           65u * bits_of(four[1]) + 67u * bits_of(four[2]) + words_of(69u, pair) +
           73u * bits_of(bn_ray_draw_1d(&sampler, &ray, k)) + words_of(75u, first) +
           words_of(79u, time) + 83u * bits_of(one);
}

/* Everything bn_path.glsl computes for sample `index` of the pixel. The objects of bn_path.h draw from the
 * same domains. */
static uint32_t path_words(uint32_t *record, uint32_t *expected) {
    const bn_uint2 seed = {record[10], record[11]};
    const uint32_t number = random_size() >> 4, k = random_size() >> 4;
    const uint32_t count = random_u32() % 8u == 0 ? 0
                           : random_u32() % 4u    ? 1 + k % 9u
                                                  : random_size();
    const uint32_t frame = random_u32() % 2u * random_size();
    record[12] = number;
    record[13] = k;
    record[14] = count;
    record[15] = frame;
    const bn_path path = bn_path_start((int32_t)record[1], (int32_t)record[2], record[3], frame);
    bn_ray ray = bn_path_ray(&path, number);
    ray.splits = k;
    const bn_split split =
        count > 0 ? bn_ray_next_split(&ray, count) : bn_ray_next_split_from(&ray, path.index);
    const bn_path branch = bn_split_path(&split, k);
    const bn_path last = bn_path_branch(branch, split.domain, count, count);
    const uint32_t domain = expected[0];
    expected[0] = drawn_words(&path, record + 10, number, k, count, &branch);
    return 9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray.domain +
           19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray.domain, k) +
           23u * bn_ray_1d_pair(k) + 25u * bn_ray_2d_domain(ray.domain, k) +
           27u * bn_ray_2d_pair(k) + 29u * bn_ray_4d_domain(ray.domain, k) + 31u * split.domain +
           33u * branch.x + 35u * branch.y + 37u * branch.index + 39u * branch.domain +
           41u * last.index + 43u * last.domain +
           45u * bn_loop_later_bits(seed, branch, bn_ray_loop_domain(ray.domain, k), k) +
           47u * bn_ray_child(&ray, k).domain + 49u * domain;
}

/* A pan followed by any float, NaN included, and by a small one; and a film's frame. */
static uint32_t frame_words(const uint32_t *record) {
    bn_pan pan = {record[1], record[2], (record[5] & 0xffffffu) - 0x800000u,
                  (record[3] & 0xffffffu) - 0x800000u};
    pan = bn_follow(pan, float_of(record[4]), -16.0f * float_of(record[7]));
    return 85u * pan.x + 87u * pan.y + 89u * pan.x_rest + 91u * pan.y_rest +
           93u * bn_frame_index(record[3], record[8]) + 95u * bn_frame_stream(record[3], record[8]);
}

static void put(const char *folder, const char *name, const void *data, size_t size) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL && fwrite(data, 1, size, file) == size && fclose(file) == 0);
}

int main(int count, char **arguments) {
    static uint32_t records[SEEDS][CASES][RECORD], expected[SEEDS][CASES][RECORD];
    float cdf[CDF];
    if (count != 2) {
        fprintf(stderr, "usage: shader_cases FOLDER\n");
        return 2;
    }
    for (int i = 0; i < CDF; ++i) cdf[i] = (float)(i % 16 + i % 3) / 17.0f;
    for (int seed = 0; seed < SEEDS; ++seed) {
        for (uint32_t at = 0; at < CASES; ++at) {
            draw(seeds[seed], at, records[seed][at], expected[seed][at]);
            choose(cdf, records[seed][at], expected[seed][at]);
            expected[seed][at][15] += path_words(records[seed][at], expected[seed][at]);
            expected[seed][at][15] += frame_words(records[seed][at]);
        }
    }
    put(arguments[1], "words.bin", bn_tables(NULL, NULL), BN_WORD_COUNT * sizeof(uint32_t));
    put(arguments[1], "cdf.bin", cdf, sizeof cdf);
    put(arguments[1], "cases.bin", records, sizeof records);
    put(arguments[1], "expected.bin", expected, sizeof expected);
    printf("%d cases for each of %d seeds\n", CASES, SEEDS);
    return check_result();
}
