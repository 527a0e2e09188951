/* SPDX-License-Identifier: Apache-2.0
 * Makes each of the library's allocations fail once. The call must then return BN_ERROR_OUT_OF_MEMORY,
 * leave its outputs unchanged and free all memory. The linker option --wrap, which requires the static
 * library, replaces malloc and free with the functions below. The test must not call anything else that
 * allocates. */
#include "check.h"
#include "masks.h"
#ifndef BN_NO_NEURAL
#include "neural.h"
#endif

void *__real_malloc(size_t size);
void __real_free(void *memory);
void *__wrap_malloc(size_t size);
void __wrap_free(void *memory);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);

static int calls, fail_at, living, counting;

void *__wrap_malloc(size_t size) {
    if (!counting) return __real_malloc(size);
    if (++calls == fail_at) return NULL;
    ++living;
    return __real_malloc(size);
}

void __wrap_free(void *memory) {
    if (counting && memory != NULL) --living;
    __real_free(memory);
}

/* The library allocates only through bn_allocate(), which calls malloc. */
void *__wrap_calloc(size_t count, size_t size) {
    CHECK(!counting);
    void *memory = __real_malloc(count * size);
    return memory != NULL ? memset(memory, 0, count * size) : NULL;
}

void *__wrap_realloc(void *memory, size_t size) {
    (void)size;
    CHECK(!counting);
    return memory;
}

enum { NO_MORE = 99 /* not a bn_result */, SIZE = 24, TEXELS = SIZE * SIZE };
static uint32_t ranks[2 * TEXELS], mask[TEXELS];
static float values[TEXELS], power[TEXELS];
static double error;

#ifndef BN_NO_NEURAL
static bn_result call_network(int only_open, uint32_t channels) {
    const fake_model model = {.radius = 1, .align = 1, .spacing = 400, .channels = channels};
    bn_neural *neural;
    bn_result result = open_model(&model, NULL, FAKE_RUNTIME, 1, &neural);
    if (result == BN_SUCCESS && !only_open) {
        bn_mask made = bn_mask_u32(ranks, SIZE, SIZE);
        made.channels = channels;
        result = bn_neural_mask(neural, &made, 1, NULL, NULL);
    }
    bn_neural_close(neural);
    return result;
}
#endif

static bn_result init_sampler(const bn_mask *given) {
    bn_sampler sampler = bn_sampler_make(7);
    const bn_sampler before = sampler;
    const bn_result result = bn_sampler_init_mask(&sampler, given, 0);
    CHECK((memcmp(&sampler, &before, sizeof sampler) == 0) == (result != BN_SUCCESS));
    return result;
}

static bn_result call(int function) {
    bn_anneal_options anneal = bn_anneal_options_default();
    bn_relax_options relax = bn_relax_options_default();
    bn_dither_options dither = bn_dither_options_default();
    anneal.sweeps = 1;
    relax.threads = 1;
    bn_mask made = bn_mask_u32(ranks, SIZE, SIZE);
    const bn_mask value = bn_mask_u32(mask, SIZE, SIZE);
    dither.mask = &value;
    switch (function) {
    case 0:
        return bn_void_and_cluster(NULL, &made, NULL, NULL);
    case 1:
        return bn_anneal(&anneal, &made, NULL, NULL);
    case 2:
        made.channels = 2;
        return bn_anneal(&anneal, &made, NULL, NULL);
    case 3:
        return bn_relax(&relax, &made, NULL, NULL);
    case 4:
        return bn_ranks_from_values(values, TEXELS, ranks);
    case 5:
        return bn_mask_error(&value, 1, &error, NULL, NULL);
    case 6:
        return bn_power_spectrum(&value, power, TEXELS, NULL, NULL);
    case 7:
        return bn_dither(&dither, values, SIZE, SIZE, 1, power, TEXELS);
    case 8:
        return init_sampler(&value);
    case 9:
        return bn_visible_noise(NULL, values, values, SIZE, SIZE, 1, TEXELS, power, TEXELS, NULL,
                                NULL);
#ifndef BN_NO_NEURAL
    case 10:
        return call_network(1, 2);
    case 11:
        return call_network(0, 2);
    case 12:
        return call_network(0, 1);
#endif
    default:
        return NO_MORE;
    }
}

int main(void) {
    fill_white(mask, TEXELS, 1);
    for (int function = 0; call(function) != NO_MORE; ++function) {
        int failures = 0;
        for (fail_at = 1;; ++fail_at) {
            memset(ranks, 0x5a, sizeof ranks);
            memset(power, 0x5a, sizeof power);
            error = -7;
            calls = living = 0;
            counting = 1;
            bn_result result = call(function);
            counting = 0;
            CHECK(living == 0);
            if (result == BN_SUCCESS) break;
            ++failures;
            CHECK(result == BN_ERROR_OUT_OF_MEMORY && error == -7);
            size_t touched = count_touched(ranks, sizeof ranks / sizeof *ranks);
            for (size_t i = 0; i < TEXELS; ++i) touched += memcmp(&power[i], &ranks[i], 4) != 0;
            CHECK(touched == 0);
        }
        /* The last call made fewer than fail_at allocations and succeeded. Earlier calls failed. */
        CHECK(failures > 0 && calls == fail_at - 1);
    }
    return check_result();
}
