/* SPDX-License-Identifier: Apache-2.0
 * Draws, masks, ranks, dithering and visible noise do not depend on the host's rounding mode, flush-to-zero,
 * denormals-are-zero or floating-point traps. The library restores the host's settings. */
#include "check.h"
#include "masks.h"
#include "samplers.h"
#include <fenv.h>
#if defined(__SSE2__) || defined(_M_X64)
#include <pmmintrin.h>
#define HAS_MXCSR 1
#endif

enum { SIDE = 40, TEXELS = SIDE * SIDE };

static uint64_t mixed(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

/* One hash per sampler type and per computation. */
enum { VOID_AND_CLUSTER = TYPES, RELAX, ANNEAL, VECTORS, RANKS, DITHER, NOISE, RESULTS };

static void compute(uint64_t hash[RESULTS]) {
    enum { DRAWS = 2000, MANY = 70000 };
    static uint32_t ranks[2 * TEXELS], many_ranks[MANY];
    static float image[TEXELS], out[TEXELS], many_values[MANY], many[DRAWS][4];
    static int32_t x[DRAWS], y[DRAWS];
    static uint32_t index[DRAWS], domain[DRAWS];
    memset(hash, 0, RESULTS * sizeof *hash);
    for (int32_t type = 0; type < TYPES; ++type) {
        const bn_sampler s = make_sampler(type, 0, 9);
        for (uint32_t i = 0; i < DRAWS; ++i) {
            float u[4];
            x[i] = (int32_t)(i * 2654435761u);
            y[i] = (int32_t)(i * 40503u);
            index[i] = i * i;
            domain[i] = i;
            bn_sample_4d(&s, x[i], y[i], index[i], domain[i], u);
            hash[type] = mixed(hash[type], u, sizeof u);
        }
        bn_wavefront w = bn_wavefront_default();
        w.count = DRAWS;
        w.x = x;
        w.y = y;
        w.index = index;
        w.domain = domain;
        for (int d = 0; d < 4; ++d) w.out[d] = &many[0][d];
        w.stride = 4;
        CHECK(bn_sample_wavefront(&s, &w) == BN_SUCCESS);
        hash[type] = mixed(hash[type], many, sizeof many);
    }
    bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
    for (uint32_t i = 0; i < 4; ++i) {
        v.sigma = 0.7 + 0.61 * i;
        v.initial_fraction = 0.07 + 0.013 * i;
        const size_t count = (size_t)(SIDE - i) * SIDE;
        const bn_mask made = bn_mask_u32(ranks, SIDE - i, SIDE);
        CHECK(bn_void_and_cluster(&v, &made, NULL, NULL) == BN_SUCCESS);
        hash[VOID_AND_CLUSTER] = mixed(hash[VOID_AND_CLUSTER], ranks, count * sizeof *ranks);
    }
    const bn_mask mask = bn_mask_u32(ranks, SIDE, SIDE);
    CHECK(bn_relax(NULL, &mask, NULL, NULL) == BN_SUCCESS);
    hash[RELAX] = mixed(0, ranks, TEXELS * sizeof *ranks);
    bn_anneal_options anneal = bn_anneal_options_default();
    anneal.start_temperature = 0.01;
    for (uint32_t channels = 1; channels <= 2; ++channels) {
        const size_t count = (size_t)channels * TEXELS;
        anneal.sweeps = channels == 1 ? 20 : 4;
        CHECK(anneal_channels(&anneal, SIDE, SIDE, channels, ranks) == BN_SUCCESS);
        hash[channels == 1 ? ANNEAL : VECTORS] = mixed(0, ranks, count * sizeof *ranks);
    }

    /* Subnormal values, and values that directed rounding would move across a threshold. */
    for (uint32_t i = 0; i < MANY; ++i) {
        many_values[i] = float_of((i % 64 * 0x200000u + i / 64) ^ (i & 1) << 31);
    }
    CHECK(bn_ranks_from_values(many_values, MANY, many_ranks) == BN_SUCCESS);
    hash[RANKS] = mixed(0, many_ranks, sizeof many_ranks);
    for (uint32_t i = 1; i < 1u << 20; i += i / 3 + 1) {
        for (uint32_t j = 0; j < 100; ++j) {
            const float value = bn_rank_to_float(i * j / 100, i);
            hash[RANKS] = mixed(hash[RANKS], &value, sizeof value);
        }
    }
    /* The values (2 i + 1) / (2 TEXELS) often lie exactly on a threshold. */
    for (uint32_t i = 0; i < TEXELS; ++i) image[i] = bn_rank_to_float(i, TEXELS);
    fill_white(ranks, TEXELS, 7);
    for (uint32_t levels = 2; levels <= 256; levels += 127) {
        bn_dither_options d = bn_dither_options_default();
        d.levels = levels;
        d.srgb = levels > 2;
        d.mask = &mask;
        CHECK(bn_dither(&d, image, SIDE, SIDE, 1, out, TEXELS) == BN_SUCCESS);
        hash[DITHER] = mixed(hash[DITHER], out, sizeof out);
    }
    static float map[TEXELS];
    CHECK(bn_visible_noise(NULL, image, out, SIDE, SIDE, 1, TEXELS, map, TEXELS, NULL, NULL) ==
          BN_SUCCESS);
    hash[NOISE] = mixed(hash[NOISE], map, sizeof map);
}

static void compare(const uint64_t expected[RESULTS], const char *setting) {
    uint64_t hash[RESULTS];
    compute(hash);
    for (int i = 0; i < RESULTS; ++i) {
        CHECK(hash[i] == expected[i]);
        if (hash[i] != expected[i]) printf("  result %d with %s\n", i, setting);
    }
}

int main(void) {
    uint64_t expected[RESULTS];
    compute(expected);
    static const struct {
        const char *name;
        int mode;
    } modes[] = {
#if defined(FE_UPWARD)
        {"upward rounding", FE_UPWARD},
#endif
#if defined(FE_DOWNWARD)
        {"downward rounding", FE_DOWNWARD},
#endif
#if defined(FE_TOWARDZERO)
        {"rounding towards zero", FE_TOWARDZERO},
#endif
        {"rounding to nearest", FE_TONEAREST}
    };
    for (size_t i = 0; i < sizeof modes / sizeof *modes; ++i) {
        CHECK(fesetround(modes[i].mode) == 0);
        feclearexcept(FE_ALL_EXCEPT);
        feraiseexcept(FE_OVERFLOW);
        compare(expected, modes[i].name);
        CHECK(fegetround() == modes[i].mode);
        CHECK(fetestexcept(FE_OVERFLOW) != 0);
    }
    fesetenv(FE_DFL_ENV);
#if defined(HAS_MXCSR)
    const unsigned before = _mm_getcsr();
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    compare(expected, "flush-to-zero and denormals-are-zero");
    CHECK(_MM_GET_FLUSH_ZERO_MODE() == _MM_FLUSH_ZERO_ON);
    CHECK(_MM_GET_DENORMALS_ZERO_MODE() == _MM_DENORMALS_ZERO_ON);
    _mm_setcsr(before);
    /* The host traps on inexact results, which occur everywhere. A trap would end the program. */
    bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
    uint32_t ranks[64];
    const bn_mask mask = bn_mask_u32(ranks, 8, 8);
    _MM_SET_EXCEPTION_MASK(_MM_MASK_MASK & ~_MM_MASK_INEXACT);
    const unsigned trapping = _mm_getcsr();
    const bn_result result = bn_void_and_cluster(&v, &mask, NULL, NULL);
    const unsigned after = _mm_getcsr();
    _mm_setcsr(before);
    CHECK(result == BN_SUCCESS && after == trapping);
#endif
    return check_result();
}
