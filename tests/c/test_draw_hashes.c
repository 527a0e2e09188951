/* SPDX-License-Identifier: Apache-2.0
 * Detects changes to draws, choices and paths: hashes of 4,096 draws per sampler type, at ordinary and
 * extreme arguments, must match draw_hashes.txt. --print prints the new contents of that file. The test is
 * built once with the library's functions, and with the inline functions once with SSE2, once without SSE2
 * and once with -ffast-math. The Python and Rust tests compare with the same file. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_choose.h>
#include <bn/bn_path.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DRAWS = 4096, ROWS = 11, LINE = 80, MASK_WIDTH = 12, MASK_HEIGHT = 10 };

static const char table_path[] = BN_TESTS_DIR "/c/draw_hashes.txt";

/* SplitMix64, repeated here so that the arguments do not depend on the code under test. */
static uint64_t random_u64(uint64_t counter) {
    uint64_t v = (counter + 1u) * 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

/* Adds the bytes of a word to an FNV-1a hash, lowest byte first. */
static uint64_t add(uint64_t hash, uint32_t word) {
    for (int i = 0; i < 4; ++i) hash = (hash ^ (word >> 8 * i & 255u)) * 0x100000001b3u;
    return hash;
}

static int32_t coordinate(uint64_t random) {
    static const int32_t extremes[] = {0, -1, 1, 63, 64, INT32_MAX, INT32_MIN, -64};
    const uint32_t v = (uint32_t)(random >> 32);
    const int32_t small = (int32_t)(v & 1023u);
    const int32_t choices[] = {extremes[v & 7u], small, -small,
                               (int32_t)(v & 0x7fffffffu) - (int32_t)(v >> 31)};
    return choices[random & 3u];
}

static uint32_t sample_index(uint64_t random) {
    static const uint32_t extremes[] = {0, 1, 255, 256, 65535, 65536, 1u << 31, UINT32_MAX};
    const uint32_t v = (uint32_t)(random >> 32);
    const uint32_t choices[] = {extremes[v & 7u], v & 255u, v & 65535u, v};
    return choices[random & 3u];
}

/* One in four domains is an arbitrary number; the others are children. */
static uint32_t sample_domain(uint64_t random) {
    uint32_t v = (uint32_t)(random >> 32);
    return (random & 3u) == 0 ? v : bn_domain_child(v & 1023u, (uint32_t)random >> 2 & 15u);
}

/* Selects the library's draws or the inline draws. */
#ifdef BN_TEST_LIBRARY
#define DRAW(name) bn_sample_##name
#else
#define DRAW(name) bn_draw_##name
#endif

static uint64_t hash_draws(bn_sampler sampler) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint64_t i = 0; i < DRAWS; ++i) {
        const int32_t x = coordinate(random_u64(4 * i)), y = coordinate(random_u64(4 * i + 1));
        const uint32_t index = sample_index(random_u64(4 * i + 2)),
                       domain = sample_domain(random_u64(4 * i + 3));
        uint32_t bits[4];
        float pair[2];
        DRAW(4d_u32)(&sampler, x, y, index, domain, bits);
        DRAW(2d)(&sampler, x, y, index, domain, (uint32_t)i, pair);
        for (int d = 0; d < 4; ++d) hash = add(hash, bits[d]);
        for (int d = 0; d < 2; ++d) hash = add(hash, (uint32_t)(pair[d] * 16777216.0f));
    }
    return hash;
}

static uint64_t hash_domains(void) {
    uint64_t hash = 0xcbf29ce484222325u;
    uint32_t domain = BN_DOMAIN_ROOT;
    for (uint64_t i = 0; i < DRAWS; ++i) {
        domain = bn_domain_child(domain, (uint32_t)random_u64(i) >> (i % 32u));
        hash = add(hash, domain);
    }
    return hash;
}

static uint64_t add_choices(uint64_t hash, float probability, uint32_t count, const float cdf[8],
                            float u) {
    float left = u;
    hash = add(hash, (uint32_t)bn_choose(probability, &left));
    hash = add(hash, bits_of(left));
    left = u;
    hash = add(hash, bn_choose_u32(count, &left));
    hash = add(hash, bits_of(left));
    left = u;
    hash = add(hash, bn_choose_cdf(cdf, 8, &left));
    return add(hash, bits_of(left));
}

/* Choices with valid draws, probabilities, counts and tables. */
static uint64_t hash_choices(void) {
    static const float limits[8] = {0.0f, 0.125f, 0.125f, 0.25f, 0.3125f, 0.75f, 0.875f, 1.0f};
    static const float sums[4] = {1.0f, 3.0f, 0.75f, 1e10f};
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint64_t i = 0; i < DRAWS; ++i) {
        const uint64_t a = random_u64(2 * i), b = random_u64(2 * i + 1);
        const uint32_t step = i % 16 == 0 ? 0 : i % 16 == 1 ? 0xffffffu : (uint32_t)(a >> 40);
        float cdf[8];
        for (int k = 0; k < 8; ++k) cdf[k] = limits[k] * sums[i % 4];
        hash = add_choices(hash, (float)(b >> 40) * 0x1p-24f,
                           1u + ((uint32_t)(b & 0xffffffu) >> i % 24), cdf, (float)step * 0x1p-24f);
    }
    return hash;
}

/* Choices with special values and arbitrary bits as arguments. */
static uint64_t hash_strange_choices(void) {
    static const float special[] = {NAN, INFINITY, -INFINITY, -0.0f, 1.0f, -1.0f, 1e-40f, 2.0f};
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint64_t i = 0; i < DRAWS; ++i) {
        float v[10];
        for (uint64_t k = 0; k < 10; ++k) {
            const uint64_t random = random_u64(10 * i + k);
            v[k] = random % 3 == 0 ? special[random >> 61] : float_of((uint32_t)(random >> 32));
        }
        hash = add_choices(hash, v[0], (uint32_t)random_u64(i) >> i % 32, v + 2, v[1]);
    }
    return hash;
}

static void add_float(uint32_t *hash, float v) {
    *hash = (*hash ^ bits_of(v)) * 0x01000193u;
}

static void add_floats(uint32_t *hash, const float *v, int count) {
    for (int i = 0; i < count; ++i) add_float(hash, v[i]);
}

static void add_ray(uint32_t *hash, const bn_sampler *sampler, const bn_path *path,
                    uint32_t depth) {
    bn_ray ray = bn_path_ray(path, depth);
    float v[4];
    bn_ray_draw(sampler, &ray, v);
    add_floats(hash, v, 4);
    for (int i = 0; i < 5; ++i) add_float(hash, bn_ray_next_1d(sampler, &ray));
    for (int i = 0; i < 3; ++i) {
        bn_ray_next_2d(sampler, &ray, v);
        add_floats(hash, v, 2);
    }
    bn_ray_next_4d(sampler, &ray, v);
    add_floats(hash, v, 4);
    bn_loop rng = bn_ray_next_loop(sampler, &ray);
    for (int i = 0; i < 6; ++i) add_float(hash, bn_loop_next_1d(&rng));
    const bn_split split = bn_ray_next_split(&ray, 3), from = bn_ray_next_split_from(&ray, 9);
    for (uint32_t k = 0; k < 6; ++k) {
        const bn_path branch = bn_split_path(k < 4 ? &split : &from, k % 4);
        const bn_ray first = bn_path_ray(&branch, k < 4);
        bn_ray_draw(sampler, &first, v);
        add_float(hash, v[k < 4 ? 2 : 0]);
    }
    bn_ray keyed = bn_ray_child(&ray, 77);
    add_float(hash, bn_ray_next_1d(sampler, &keyed));
}

/* Combines one hash for each of 96 paths, which covers the path's first eight rays. */
static uint64_t hash_paths(void) {
    static const uint32_t indices[] = {0, 1, 5, 255, 256, 70000};
    const bn_sampler sampler = bn_sampler_make(1);
    uint64_t hash = 0xcbf29ce484222325u;
    for (int32_t pixel = 0; pixel < 16; ++pixel) {
        for (int i = 0; i < 6; ++i) {
            const bn_path path = bn_path_start(3 * pixel - 20, 100 - 37 * pixel, indices[i], 0);
            uint32_t own = 0;
            for (uint32_t depth = 0; depth < 8; ++depth) add_ray(&own, &sampler, &path, depth);
            hash = add(hash, own);
        }
    }
    return hash;
}

/* Writes the lines of draw_hashes.txt that contain hashes. Returns how many there are. */
static int print_rows(char rows[ROWS][LINE]) {
    static const struct {
        const char *name;
        int32_t type;
        uint32_t samples_per_pixel;
    } samplers[] = {{"blue", BN_SAMPLER_BLUE, 0},           {"sobol", BN_SAMPLER_SOBOL, 0},
                    {"white", BN_SAMPLER_WHITE, 0},         {"zorder_16", BN_SAMPLER_ZORDER, 16},
                    {"zorder_256", BN_SAMPLER_ZORDER, 256}, {"mask_builtin", BN_SAMPLER_MASK, 0}};
    enum { SAMPLERS = sizeof samplers / sizeof *samplers };
    uint32_t ranks[MASK_WIDTH * MASK_HEIGHT];
    int count = 0;
    const uint64_t seed = 0x123456789abcdef0u;
    for (int i = 0; i < SAMPLERS; ++i) {
        const bn_sampler sampler =
            make_sampler(samplers[i].type, samplers[i].samples_per_pixel, seed);
        snprintf(rows[count++], LINE, "%s %016" PRIx64, samplers[i].name, hash_draws(sampler));
    }
    for (uint32_t i = 0; i < MASK_WIDTH * MASK_HEIGHT; ++i) {
        ranks[i] = (i * 49u + 7u) % (MASK_WIDTH * MASK_HEIGHT);
    }
    const bn_mask mask = bn_mask_u32(ranks, MASK_WIDTH, MASK_HEIGHT);
    bn_sampler given;
    CHECK(bn_sampler_init_mask(&given, &mask, seed) == BN_SUCCESS);
    snprintf(rows[count++], LINE, "mask_given %016" PRIx64, hash_draws(given));
    snprintf(rows[count++], LINE, "domains %016" PRIx64, hash_domains());
    snprintf(rows[count++], LINE, "choices %016" PRIx64, hash_choices());
    snprintf(rows[count++], LINE, "strange_choices %016" PRIx64, hash_strange_choices());
    snprintf(rows[count++], LINE, "paths %016" PRIx64, hash_paths());
    return count;
}

int main(int argc, char **argv) {
    char rows[ROWS][LINE], version[LINE], line[LINE];
    int count = print_rows(rows), changed = 0;
    snprintf(version, LINE, "BN_DRAW_TABLE_VERSION %u", BN_DRAW_TABLE_VERSION);
    if (argc == 2 && strcmp(argv[1], "--print") == 0) {
        puts(version);
        for (int i = 0; i < count; ++i) puts(rows[i]);
        return 0;
    }
    FILE *file = fopen(table_path, "r");
    if (argc != 1 || file == NULL) {
        printf("usage: test_draw_hashes [--print]; reads %s\n", table_path);
        return 2;
    }
    CHECK(count == ROWS);
    for (int i = -1; i < count; ++i) {
        const char *expected = i < 0 ? version : rows[i];
        if (fgets(line, LINE, file) == NULL) line[0] = '\0';
        line[strcspn(line, "\r\n")] = '\0';
        CHECK(strcmp(line, expected) == 0);
        if (strcmp(line, expected) != 0) {
            printf("  is \"%s\", was \"%s\"\n", expected, line);
            ++changed;
        }
    }
    CHECK(fgets(line, LINE, file) == NULL);
    fclose(file);
    if (changed > 0) {
        printf(
            "Draws have changed. If this is intended, increase BN_DRAW_TABLE_VERSION in bn_draw.h, "
            "mention it in CHANGELOG.md,\nbuild, and run: %s --print > %s\n",
            argv[0], table_path);
    }
    return check_result();
}
