/* SPDX-License-Identifier: Apache-2.0
 * Notices a change of any bit of any draw: hashes of 4,096 draws of every kind, at ordinary and
 * extreme arguments, must equal draw_hashes.txt. --print prints that file. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { DRAWS = 4096, ROWS = 9, LINE = 80, MASK_WIDTH = 12, MASK_HEIGHT = 10 };

static const char path[] = BN_TESTS_DIR "/c/draw_hashes.txt";

/* SplitMix64, written here so that the arguments do not depend on what is tested. */
static uint64_t random_u64(uint64_t counter) {
    uint64_t v = (counter + 1u) * 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

/* FNV-1a over the bytes of a word, the lowest first. */
static uint64_t add(uint64_t hash, uint32_t word) {
    for (int i = 0; i < 4; ++i) hash = (hash ^ (word >> 8 * i & 255u)) * 0x100000001b3u;
    return hash;
}

static int32_t coordinate(uint64_t random) {
    static const int32_t extremes[] = {0, -1, 1, 63, 64, INT32_MAX, INT32_MIN, -64};
    uint32_t v = (uint32_t)(random >> 32);
    switch (random & 3u) {
    case 0:
        return extremes[v & 7u];
    case 1:
        return (int32_t)(v & 1023u);
    case 2:
        return -(int32_t)(v & 1023u);
    default:
        return (int32_t)(v & 0x7fffffffu) - (int32_t)(v >> 31);
    }
}

static uint32_t sample_index(uint64_t random) {
    static const uint32_t extremes[] = {0, 1, 255, 256, 65535, 65536, 1u << 31, UINT32_MAX};
    uint32_t v = (uint32_t)(random >> 32);
    switch (random & 3u) {
    case 0:
        return extremes[v & 7u];
    case 1:
        return v & 255u;
    case 2:
        return v & 65535u;
    default:
        return v;
    }
}

/* Every fourth domain is an arbitrary number, the others are children. */
static uint32_t sample_domain(uint64_t random) {
    uint32_t v = (uint32_t)(random >> 32);
    return (random & 3u) == 0 ? v : bn_domain_child(v & 1023u, (uint32_t)random >> 2 & 15u);
}

static uint64_t hash_draws(bn_sampler_options options) {
    const bn_sampler sampler = sampler_of(&options);
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint64_t i = 0; i < DRAWS; ++i) {
        const int32_t x = coordinate(random_u64(4 * i)), y = coordinate(random_u64(4 * i + 1));
        const uint32_t index = sample_index(random_u64(4 * i + 2)),
                       domain = sample_domain(random_u64(4 * i + 3));
        uint32_t bits[4];
        float pair[2];
        bn_sample_4d_u32(&sampler, x, y, index, domain, bits);
        bn_sample_pair(&sampler, x, y, index, domain, 2u + (uint32_t)(i & 1u), pair);
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

/* The lines of the file. */
static int print_rows(char rows[ROWS][LINE]) {
    static const struct {
        const char *name;
        int32_t kind;
        uint32_t samples_per_pixel;
    } samplers[] = {{"blue", BN_SAMPLER_BLUE, 0},         {"blue_declared_16", BN_SAMPLER_BLUE, 16},
                    {"sobol", BN_SAMPLER_SOBOL, 0},       {"white", BN_SAMPLER_WHITE, 0},
                    {"zorder_16", BN_SAMPLER_ZORDER, 16}, {"zorder_256", BN_SAMPLER_ZORDER, 256},
                    {"mask_builtin", BN_SAMPLER_MASK, 0}};
    enum { SAMPLERS = sizeof samplers / sizeof *samplers };
    uint32_t ranks[MASK_WIDTH * MASK_HEIGHT];
    int count = 0;
    bn_sampler_options o = bn_sampler_options_default();
    o.seed = 0x123456789abcdef0u;
    for (int i = 0; i < SAMPLERS; ++i) {
        o.kind = samplers[i].kind;
        o.samples_per_pixel = samplers[i].samples_per_pixel;
        snprintf(rows[count++], LINE, "%s %016" PRIx64, samplers[i].name, hash_draws(o));
    }
    for (uint32_t i = 0; i < MASK_WIDTH * MASK_HEIGHT; ++i) {
        ranks[i] = (i * 49u + 7u) % (MASK_WIDTH * MASK_HEIGHT);
    }
    o.mask_ranks = ranks;
    o.mask_width = MASK_WIDTH;
    o.mask_height = MASK_HEIGHT;
    snprintf(rows[count++], LINE, "mask_given %016" PRIx64, hash_draws(o));
    snprintf(rows[count++], LINE, "domains %016" PRIx64, hash_domains());
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
    FILE *file = fopen(path, "r");
    if (argc != 1 || file == NULL) {
        printf("usage: test_draw_hashes [--print]; reads %s\n", path);
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
            "Draws have changed. If that is meant, raise BN_DRAW_TABLE_VERSION in bn_draw.h, say "
            "so in CHANGELOG.md,\nbuild, and run: %s --print > %s\n",
            argv[0], path);
    }
    return check_result();
}
