/* SPDX-License-Identifier: Apache-2.0
 * Arguments are checked consistently: every function returns the same error for the same mistake. */
#include "check.h"
#include "masks.h"
#include <bn/bn.h>
#ifndef BN_NO_NEURAL
#include <bn/neural.h>
#endif
#include <float.h>
#include <math.h>
#include <stddef.h>

enum { MOST = 64, LARGE = 512 * 512 };
static uint32_t ranks[LARGE];
static float values[MOST], outputs[LARGE];
static double error;

/* The functions that generate a mask, followed by those that read one. */
enum { VOID_AND_CLUSTER, RELAX, ANNEAL, ANNEAL_FROM, ERROR, SPECTRUM, DITHER, SAMPLER };
enum { FUNCTIONS = SAMPLER + 1, FIRST_THAT_READS = ANNEAL_FROM };

static bn_result call_on(int function, const bn_mask *mask, size_t count, bn_progress progress,
                         void *user) {
    bn_relax_options relax = bn_relax_options_default();
    bn_anneal_options anneal = bn_anneal_options_default();
    bn_dither_options dither = bn_dither_options_default();
    bn_sampler sampler;
    relax.threads = 3;
    anneal.sigma = 0.5; /* a small window, for speed */
    anneal.far_weight = 0;
    anneal.sweeps = 2;
    anneal.start_from_ranks = function == ANNEAL_FROM;
    dither.mask = mask;
    switch (function) {
    case VOID_AND_CLUSTER:
        return bn_void_and_cluster(NULL, mask, progress, user);
    case RELAX:
        return bn_relax(&relax, mask, progress, user);
    case ANNEAL:
    case ANNEAL_FROM:
        return bn_anneal(&anneal, mask, progress, user);
    case ERROR:
        return bn_mask_error(mask, 1, &error, progress, user);
    case SPECTRUM:
        return bn_power_spectrum(mask, outputs, count, progress, user);
    case DITHER:
        return bn_dither(&dither, values, 2, 2, 1, outputs, 4);
    default:
        return bn_sampler_init_mask(&sampler, mask, 0);
    }
}

static bn_result call(int function, const uint32_t *of, uint32_t width, uint32_t height,
                      size_t count) {
    const bn_mask mask = bn_mask_u32(of, width, height);
    return call_on(function, &mask, count, NULL, NULL);
}

static void test_extents(void) {
    static const struct {
        uint32_t width, height;
        size_t count;
        bn_result expected;
    } cases[] = {
        {8, 8, 64, BN_SUCCESS},
        {1, 1, 1, BN_SUCCESS},
        {0, 8, 0, BN_ERROR_INVALID_ARGUMENT},
        {8, 0, 0, BN_ERROR_INVALID_ARGUMENT},
        {0, 0, 0, BN_ERROR_INVALID_ARGUMENT},
        {UINT32_MAX, 0, 0, BN_ERROR_INVALID_ARGUMENT},
        {32768, 65536, 64, BN_ERROR_OUT_OF_MEMORY}, /* 2^31 texels, one more than allowed */
        {65536, 65536, 64, BN_ERROR_OUT_OF_MEMORY}, /* overflows to 0 in 32 bits */
        {UINT32_MAX, UINT32_MAX, 1, BN_ERROR_OUT_OF_MEMORY},
        {1u << 31, 1u << 31, 0, BN_ERROR_OUT_OF_MEMORY},
        {8, 8, 63, BN_ERROR_SIZE_MISMATCH},
        {8, 8, 65, BN_ERROR_SIZE_MISMATCH},
        {8, 8, 0, BN_ERROR_SIZE_MISMATCH},
        {46340, 46340, 64, BN_ERROR_SIZE_MISMATCH}, /* the largest square below 2^31 texels */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        for (int function = 0; function < FUNCTIONS; ++function) {
            if (cases[i].expected == BN_ERROR_SIZE_MISMATCH && function != SPECTRUM) continue;
            fill_white(ranks, cases[i].count == 1 ? 1 : MOST, 3);
            const bn_result found =
                call(function, ranks, cases[i].width, cases[i].height, cases[i].count);
            if (found != cases[i].expected) {
                printf("function %d, %lu x %lu: %s\n", function, (unsigned long)cases[i].width,
                       (unsigned long)cases[i].height, bn_result_string(found));
            }
            CHECK(found == cases[i].expected);
        }
    }
}

static void test_invalid_masks(void) {
    for (int function = 0; function < FUNCTIONS; ++function) {
        CHECK(call(function, NULL, 8, 8, 64) == BN_ERROR_INVALID_ARGUMENT);
        if (function < FIRST_THAT_READS) continue;
        for (int mistake = 0; mistake < 3; ++mistake) {
            fill_white(ranks, MOST, 4);
            ranks[mistake * 31] = mistake == 1 ? MOST : ranks[5]; /* out of range, or a duplicate */
            if (mistake == 2) ranks[62] = UINT32_MAX;
            CHECK(call(function, ranks, 8, 8, 64) == BN_ERROR_BAD_DATA);
        }
    }
}

/* Calls void-and-cluster or annealing with one changed numeric option. */
static bn_result call_with(int function, size_t option, double number) {
    bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
    bn_anneal_options a = bn_anneal_options_default();
    char *const options = function == ANNEAL ? (char *)&a : (char *)&v;
    memcpy(options + option, &number, sizeof number);
    const bn_mask mask = bn_mask_u32(ranks, 8, 8);
    return function == ANNEAL ? bn_anneal(&a, &mask, NULL, NULL)
                              : bn_void_and_cluster(&v, &mask, NULL, NULL);
}

/* Options outside their ranges, infinities and NaNs are rejected. Other tests cover values at the limits. */
static void test_numeric_options(void) {
    static const double bad[] = {NAN, -NAN, INFINITY, -INFINITY, -1, -DBL_MIN};
    static const struct {
        int function;
        size_t option;
        double below, above;
    } cases[] = {
        {VOID_AND_CLUSTER, offsetof(bn_void_and_cluster_options, sigma), 0.2, 17},
        {VOID_AND_CLUSTER, offsetof(bn_void_and_cluster_options, initial_fraction), 0, 0.6},
        {ANNEAL, offsetof(bn_anneal_options, sigma), 0.1, 5},
        {ANNEAL, offsetof(bn_anneal_options, far_sigma), 0.1, 5},
        {ANNEAL, offsetof(bn_anneal_options, far_weight), -1, -1},
        {ANNEAL, offsetof(bn_anneal_options, value_sigma), 0, 101},
        {ANNEAL, offsetof(bn_anneal_options, start_temperature), 0, 5},
        {ANNEAL, offsetof(bn_anneal_options, end_temperature), 0, 5},
    };
    error = -7;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const int function = cases[i].function;
        const bn_result invalid = BN_ERROR_INVALID_ARGUMENT;
        CHECK(call_with(function, cases[i].option, cases[i].below) == invalid);
        CHECK(call_with(function, cases[i].option, cases[i].above) == invalid);
        for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
            CHECK(call_with(function, cases[i].option, bad[k]) == invalid);
        }
    }
    const bn_mask mask = bn_mask_u32(ranks, 8, 8);
    fill_white(ranks, MOST, 5);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        CHECK(bn_mask_error(&mask, bad[i], &error, NULL, NULL) == BN_ERROR_INVALID_ARGUMENT);
        values[3] = (float)bad[i];
        if (i < 2) CHECK(bn_dither(NULL, values, 8, 8, 1, outputs, MOST) == BN_ERROR_BAD_DATA);
    }
    CHECK(error == -7);
    values[3] = INFINITY; /* clamped to 1 */
    CHECK(bn_dither(NULL, values, 8, 8, 1, outputs, MOST) == BN_SUCCESS && outputs[3] == 1);
    values[3] = 0;
}

/* Every function rejects mask shapes that it does not support. */
static void test_unsupported_shapes(void) {
    static const struct {
        uint32_t rank_bits, width, depth, channels;
        unsigned good; /* bit f: accepted by function f */
    } shapes[] = {{32, 4, 0, 1, 0},
                  {32, 4, 1, 0, 0},
                  {32, 4, 2, 1, 1 << VOID_AND_CLUSTER},
                  {32, 4, 1, 4, 1 << ANNEAL | 1 << ANNEAL_FROM},
                  {32, 4, 1, 5, 0},
                  {8, 4, 1, 1, 0},
                  {16, 4, 1, 1, (1 << FUNCTIONS) - 1},
                  {16, (1 << 16) / 4 + 1, 1, 1, 0}}; /* more ranks than 16 bits can hold */
    static uint16_t narrow[(1 << 16) + 4];
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
        for (int function = 0; function < FUNCTIONS; ++function) {
            const void *memory = shapes[i].rank_bits == 16 ? (void *)narrow : (void *)ranks;
            const bn_mask mask = {memory, shapes[i].rank_bits, shapes[i].width,
                                  4,      shapes[i].depth,     shapes[i].channels};
            for (uint32_t k = 0; k < 64; ++k) narrow[k] = (uint16_t)(ranks[k] = k % 16);
            const bn_result result = call_on(function, &mask, 16, NULL, NULL);
            CHECK((result == BN_SUCCESS) == (shapes[i].good >> function & 1));
            if (shapes[i].width == 4)
                CHECK(result == BN_SUCCESS || result == BN_ERROR_INVALID_ARGUMENT);
        }
    }
    bn_anneal_options from = bn_anneal_options_default();
    from.start_from_ranks = 1; /* the second channel lacks a rank */
    for (uint32_t i = 0; i < 32; ++i) ranks[i] = i < 31 ? i % 16 : 16;
    bn_mask mask = bn_mask_u32(ranks, 4, 4);
    mask.channels = 2;
    CHECK(bn_anneal(&from, &mask, NULL, NULL) == BN_ERROR_BAD_DATA && ranks[31] == 16);
}

/* 16-bit masks contain the same ranks as 32-bit masks, and nothing is written past their end. */
static void test_rank_bits(void) {
    for (int function = VOID_AND_CLUSTER; function <= ANNEAL_FROM; ++function) {
        const uint32_t channels = function >= ANNEAL ? 2 : 1, count = 16 * channels;
        uint16_t narrow[33];
        for (uint32_t i = 0; i < 33; ++i) narrow[i] = (uint16_t)(ranks[i] = i * 5 % 16);
        bn_mask wide = {ranks, 32, 4, 4, 1, channels}, mask = {narrow, 16, 4, 4, 1, channels};
        CHECK(call_on(function, &wide, 16, NULL, NULL) == BN_SUCCESS);
        CHECK(call_on(function, &mask, 16, NULL, NULL) == BN_SUCCESS);
        int moved = 0;
        for (uint32_t i = 0; i < count; ++i) {
            CHECK(narrow[i] == ranks[i]);
            moved += ranks[i] != i * 5 % 16;
        }
        CHECK(moved > 0 && narrow[count] == count * 5 % 16);
    }
}

static void test_result_and_version_strings(void) {
    for (bn_result a = -2; a < 12; ++a) {
        CHECK(bn_result_string(a) != NULL && bn_result_string(a)[0] != '\0');
        for (bn_result b = 0; b < a && a <= BN_ERROR_CANCELLED; ++b) {
            CHECK(strcmp(bn_result_string(a), bn_result_string(b)) != 0);
        }
    }
    char version[64];
    snprintf(version, sizeof version, "%d.%d.%d", BN_VERSION_MAJOR, BN_VERSION_MINOR,
             BN_VERSION_PATCH);
    CHECK(strcmp(version, bn_version_string()) == 0);
}

/* A struct_size smaller than the structure is rejected, including one that ends inside an option. A larger
 * struct_size is accepted if the additional bytes are zero. */
#define CHECK_SIZES(type, options_default, call)                                                   \
    do {                                                                                           \
        union {                                                                                    \
            type o;                                                                                \
            unsigned char bytes[4200];                                                             \
        } u;                                                                                       \
        memset(&u, 0, sizeof u);                                                                   \
        u.o = options_default();                                                                   \
        for (size_t size = 0; size < sizeof u; ++size) {                                           \
            u.o.struct_size = size;                                                                \
            if (size > sizeof(type) + 32 && size < 4090) continue;                                 \
            const int good = size >= sizeof(type) && size <= 4096;                                 \
            CHECK(((call) == BN_ERROR_INVALID_ARGUMENT) == !good);                                 \
        }                                                                                          \
        u.o.struct_size = SIZE_MAX;                                                                \
        CHECK((call) == BN_ERROR_INVALID_ARGUMENT);                                                \
        u.o.struct_size = sizeof(type) + 8;                                                        \
        u.bytes[sizeof(type) + 7] = 1;                                                             \
        CHECK((call) == BN_ERROR_UNSUPPORTED);                                                     \
    } while (0)

static void test_struct_sizes(void) {
    const bn_sampler sampler = bn_sampler_make(0);
    const bn_mask mask = bn_mask_u32(ranks, 8, 8);
    CHECK_SIZES(bn_void_and_cluster_options, bn_void_and_cluster_options_default,
                bn_void_and_cluster(&u.o, &mask, NULL, NULL));
    CHECK_SIZES(bn_relax_options, bn_relax_options_default, bn_relax(&u.o, &mask, NULL, NULL));
    CHECK_SIZES(bn_anneal_options, bn_anneal_options_default, bn_anneal(&u.o, &mask, NULL, NULL));
    CHECK_SIZES(bn_dither_options, bn_dither_options_default,
                bn_dither(&u.o, values, 8, 8, 1, outputs, MOST));
    CHECK_SIZES(bn_visible_noise_options, bn_visible_noise_options_default,
                bn_visible_noise(&u.o, values, values, 8, 8, 1, MOST, outputs, MOST, NULL, NULL));
    CHECK_SIZES(bn_wavefront, bn_wavefront_default,
                (u.o.out[0] = outputs, bn_sample_wavefront(&sampler, &u.o)));
#ifndef BN_NO_NEURAL
    bn_neural *neural;
    CHECK_SIZES(bn_neural_options, bn_neural_options_default,
                (u.o.runtime_path = "/nowhere", bn_neural_open(&u.o, &neural)));
#endif
}

/* Progress never decreases and is reported often. Any call can cancel, which leaves the outputs unchanged. */
static void test_progress(void) {
    static const struct {
        int function;
        uint32_t width, height, channels;
        int least_calls;
    } cases[] = {{VOID_AND_CLUSTER, 128, 120, 1, 3},
                 {RELAX, 128, 120, 1, 20}, /* one call per relaxation step */
                 {RELAX, 512, 512, 1, 24}, /* many first and last ranks to reorder */
                 {ANNEAL, 128, 120, 1, 3},
                 {ANNEAL, 128, 60, 2, 3},
                 {ERROR, 128, 120, 1, 3},
                 {SPECTRUM, 128, 120, 1, 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const size_t count = (size_t)cases[i].width * cases[i].height;
        const int function = cases[i].function, makes = function < FIRST_THAT_READS;
        bn_mask mask = bn_mask_u32(ranks, cases[i].width, cases[i].height);
        watch all = {0};
        mask.channels = cases[i].channels;
        fill_white(ranks, count, 2);
        CHECK(call_on(function, &mask, count, watch_progress, &all) == BN_SUCCESS);
        CHECK(all.calls >= cases[i].least_calls && all.backwards == 0);
        /* Relaxation treats odd and even steps differently. */
        for (int at = 1; at <= all.calls; at += all.calls < 40 ? 1 : 1 + all.calls / 4) {
            watch w = {.cancel_at = at};
            error = outputs[0] = outputs[count - 1] = -7;
            if (makes) memset(ranks, 0x5a, sizeof ranks);
            CHECK(call_on(function, &mask, count, watch_progress, &w) == BN_ERROR_CANCELLED);
            CHECK(w.calls == at && (!makes || count_touched(ranks, LARGE) == 0));
            CHECK(error == -7 && outputs[0] == -7 && outputs[count - 1] == -7);
        }
    }
}

/* far_weight 0 turns the second blur off whatever far_sigma is, and a large far_weight the first, so these
 * options all give blue masks. */
static void test_far_weights(void) {
    static const double sigmas[] = {0, -1, 1e-200, 1e300, (double)NAN, (double)INFINITY};
    static uint32_t expected[32 * 32], made[32 * 32];
    const bn_mask mask = bn_mask_u32(made, 32, 32);
    bn_anneal_options o = bn_anneal_options_default();
    o.sweeps = 20, o.sigma = 0.5, o.far_weight = 0, o.far_sigma = 0.5;
    CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
    memcpy(expected, made, sizeof made);
    for (size_t i = 0; i < sizeof sigmas / sizeof *sigmas; ++i) {
        o.far_sigma = sigmas[i];
        CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
        CHECK(memcmp(made, expected, sizeof made) == 0);
    }
    o.far_sigma = 0.5, o.far_weight = 1e20; /* so large that the first blur has no effect */
    CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
    CHECK(memcmp(made, expected, sizeof made) == 0);
    o.far_sigma = 1;
    CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
    memcpy(expected, made, sizeof made);
    for (int power = 70; power < 1024; power += 53) {
        o.far_weight = ldexp(1, power);
        CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
        CHECK(memcmp(made, expected, sizeof made) == 0);
    }
    o.far_sigma = 0.5, o.far_weight = DBL_MAX; /* far_weight / far_sigma^2 would overflow */
    CHECK(bn_anneal(&o, &mask, NULL, NULL) == BN_SUCCESS);
    CHECK(bn_mask_error(&mask, 1, &error, NULL, NULL) == BN_SUCCESS && error < 0.06);
}

/* far_sigma is checked only if it is used: with one channel and a nonzero far_weight. */
static void test_unused_far_sigma(void) {
    static uint32_t mask[2 * 64];
    bn_anneal_options o = bn_anneal_options_default();
    bn_mask made = bn_mask_u32(mask, 8, 8);
    o.sigma = 2, o.sweeps = 1;
    CHECK(bn_anneal(&o, &made, NULL, NULL) == BN_ERROR_INVALID_ARGUMENT);
    o.far_weight = 0;
    CHECK(bn_anneal(&o, &made, NULL, NULL) == BN_SUCCESS);
    o.far_weight = 1, made.channels = 2;
    CHECK(bn_anneal(&o, &made, NULL, NULL) == BN_SUCCESS);
}

int main(void) {
    test_extents();
    test_invalid_masks();
    test_numeric_options();
    test_unsupported_shapes();
    test_rank_bits();
    test_result_and_version_strings();
    test_progress();
    test_unused_far_sigma();
    test_far_weights();
    test_struct_sizes();
    return check_result();
}
