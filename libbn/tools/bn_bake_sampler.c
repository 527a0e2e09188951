/* SPDX-License-Identifier: Apache-2.0
 * Makes libbn/data/blue.u32, the table behind BN_SAMPLER_BLUE.
 *
 * Samples and pixels are in pole order (pole_order.h). Of what that leaves open, six stages
 * choose: maps of digits (bake_film.c), a scrambling of each pair (bake_scramble.c) and then of all
 * four coordinates (bake_smooth.c), the orders of the members of a family (bake_orders.c), which labels blocks of 4 x 4 pixels have (bake_blocks.c)
 * and which pixel in them has which (bake_labels.c), so that errors of neighbouring pixels cancel.
 * All moves keep the nets. Some twenty minutes on one core.
 *
 * The table depends on the seed and the effort alone; cosines, logarithms and exponentials come from
 * the C library, so another one may give another table of the same quality.
 */
#include "bake_tile.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_SIZE = 4096, LABEL_PARTS = 6, SINGLE_PARTS = 2 };

static const char usage[] = "usage: bn_bake_sampler [--seed N] [--effort SCALE] -o FILE\n"
                            "Makes a table of the sampler blue, in some twenty minutes, and says "
                            "on standard output what it does.\n"
                            "  --seed N        (1)\n"
                            "  --effort SCALE  of the search, from 0 to 100 (1)\n";

/* Little-endian words. */
static int write_table(const bake_table *table, FILE *file) {
    static uint32_t words[BN_WORD_COUNT];
    static unsigned char bytes[BN_WORD_COUNT * 4];
    bake_table_pack(table, words);
    for (uint32_t i = 0; i < BN_WORD_COUNT * 4; ++i) {
        bytes[i] = (unsigned char)(words[i / 4] >> 8 * (i % 4));
    }
    return fwrite(bytes, 1, sizeof bytes, file) == sizeof bytes;
}

static void say(const char *what, int number) {
    printf("%s of %d\n", what, number);
    fflush(stdout);
}

static void make(bake_table *table, const bake_options *options) {
    bake_start(table, options);
    for (int k = 0; k < 2 * MEMBERS; ++k) {
        say("scrambling", k);
        bake_scramble(table, options, k / 2, k % 2);
    }
    for (int a = 0; a < MEMBERS; ++a) {
        say("smooth integrands", a);
        bake_smooth(table, options, a);
    }
    for (int a = 1; a < MEMBERS; ++a) {
        say("order", a);
        bake_order(table, options, a);
    }
    bake_blocks(table, options);
    for (int which = 0; which < MEMBERS + 4; ++which) {
        const int parts = which < MEMBERS ? LABEL_PARTS : SINGLE_PARTS;
        say("labels", which);
        for (int k = 0; k < parts; ++k) bake_labels(table, options, which, k, parts);
    }
    bake_finish(table, options);
}

int main(int argc, char **argv) {
    static bake_table table;
    bake_options options = {.seed = 1, .effort = 1};
    const char *output = NULL;
    int good = argc % 2 == 1;
    for (int i = 1; good && i < argc; i += 2) {
        const char *name = argv[i], *value = argv[i + 1];
        char *end = NULL;
        double number = strtod(value, &end);
        int is_number = end != value && *end == '\0' && number >= 0 && number < 4e9;
        if (strcmp(name, "-o") == 0) {
            output = value;
        } else if (strcmp(name, "--seed") == 0 && is_number) {
            options.seed = (uint64_t)number;
        } else if (strcmp(name, "--effort") == 0 && is_number && number <= 100) {
            options.effort = number;
        } else {
            good = 0;
        }
    }
    if (!good || output == NULL || strlen(output) > PATH_SIZE - 8) {
        fputs(usage, stderr);
        return 2;
    }
    /* Written beside and renamed; what cannot be written is said before the search. */
    char beside[PATH_SIZE];
    snprintf(beside, sizeof beside, "%s.part", output);
    FILE *file = fopen(beside, "wb");
    if (file != NULL) {
        make(&table, &options);
        good = write_table(&table, file);
        good &= fclose(file) == 0;
        if (good && rename(beside, output) == 0) return 0;
    }
    fprintf(stderr, "bn_bake_sampler: cannot write %s: %s\n", output, strerror(errno));
    remove(beside);
    return 1;
}
