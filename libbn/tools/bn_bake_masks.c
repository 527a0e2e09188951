/* SPDX-License-Identifier: Apache-2.0
 * Bakes a built-in mask from a void-and-cluster mask by long annealing, in steps of falling temperature. */
#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 40, PATH_SIZE = 1024 };
static const double START_TEMPERATURE = 4e-4, END_TEMPERATURE = 2e-6;

static int fail(const char *what, const char *name) {
    fprintf(stderr, "bn_bake_masks: %s %s\n", what, name);
    return 1;
}

/* Writes ranks as little-endian 16-bit numbers to a temporary file, and renames it. */
static int write_ranks(const char *path, const uint32_t *ranks, size_t count) {
    char beside[PATH_SIZE + 8];
    snprintf(beside, sizeof beside, "%s.tmp", path);
    FILE *file = fopen(beside, "wb");
    if (file == NULL) return 0;
    int good = 1;
    for (size_t i = 0; i < count; ++i) {
        good &=
            fputc((int)(ranks[i] & 0xff), file) != EOF && fputc((int)(ranks[i] >> 8), file) != EOF;
    }
    good &= fclose(file) == 0;
    return good && rename(beside, path) == 0;
}

/* start * ratio^step without the C library's pow(), which differs between machines. */
static double temperature(int step) {
    static const double ratio = 0.8759; /* (END / START)^(1 / STEPS), rounded */
    double t = START_TEMPERATURE;
    for (int i = 0; i < step; ++i) t *= ratio;
    return t > END_TEMPERATURE ? t : END_TEMPERATURE;
}

static void print_quality(const bn_mask *mask) {
    static const double sigmas[] = {0.75, 1, 1.5, 2};
    printf("%u:", mask->width);
    for (int i = 0; i < 4; ++i) {
        double error = 0;
        if (bn_mask_error(mask, sigmas[i], &error, NULL, NULL) == BN_SUCCESS) {
            printf(" E_%g %.5f", sigmas[i], error);
        }
    }
    printf("\n");
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr,
                "Usage: bn_bake_masks SIZE SWEEPS OUTPUT.u16\n"
                "SIZE is 2 to 256; SWEEPS in all, in %d steps\n",
                STEPS);
        return 2;
    }
    const uint32_t size = (uint32_t)strtoul(argv[1], NULL, 10);
    const uint32_t sweeps = (uint32_t)strtoul(argv[2], NULL, 10);
    if (size < 2 || size > 256) return fail("SIZE must be 2 to 256, not", argv[1]);
    if (sweeps < STEPS) return fail("too few SWEEPS:", argv[2]);
    if (strlen(argv[3]) >= PATH_SIZE) return fail("OUTPUT is too long:", argv[3]);
    const size_t count = (size_t)size * size;
    uint32_t *ranks = malloc(count * sizeof *ranks);
    if (ranks == NULL) return fail("no memory for SIZE", argv[1]);
    const bn_mask mask = bn_mask_u32(ranks, size, size);
    bn_result result = bn_void_and_cluster(NULL, &mask, NULL, NULL);
    for (int step = 0; step < STEPS && result == BN_SUCCESS; ++step) {
        bn_anneal_options options = bn_anneal_options_default();
        options.start_from_ranks = 1;
        options.start_temperature = temperature(step);
        options.end_temperature = temperature(step + 1);
        options.sweeps = sweeps / STEPS;
        options.seed = (uint64_t)step;
        options.order_ends = step + 1 == STEPS;
        result = bn_anneal(&options, &mask, NULL, NULL);
    }
    if (result != BN_SUCCESS) return fail("cannot make the mask:", bn_result_string(result));
    if (!write_ranks(argv[3], ranks, count)) return fail("cannot write", argv[3]);
    print_quality(&mask);
    free(ranks);
    return 0;
}
