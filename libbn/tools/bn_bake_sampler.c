/* SPDX-License-Identifier: Apache-2.0
 * Makes libbn/data/blue.u32, the table behind BN_SAMPLER_BLUE.
 *
 * Samples and pixels are in pole order (pole_order.h). Of what that leaves open, three stages choose:
 * the vectors of each member of a family (bake_vectors.c), the quadtree down to blocks of 4 x 4 pixels
 * (bake_blocks.c) and inside them (bake_labels.c), so that errors of neighbouring pixels cancel. All
 * moves keep the nets. Half an hour on one core. Vectors decide nearly all of the errors, the quadtree
 * how visible its own pattern is: --vectors searches another quadtree in five minutes.
 *
 * The table depends on the seed and the effort alone; cosines, logarithms and exponentials come from
 * the C library, so another one may give another table of the same quality.
 */
#include "bake_tile.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, PARTS = 2 * MEMBERS + 1 + MEMBERS };

static const char usage[] =
    "usage: bn_bake_sampler [--seed N] [--effort SCALE] [--vectors TABLE] -o FILE\n"
    "  -o FILE             makes a table of the sampler blue\n"
    "  --seed N            (1)\n"
    "  --effort SCALE      of the search, from 0 to 100 (1: half an hour)\n"
    "  --vectors TABLE     takes the vectors from this table, and searches the quadtree alone\n";

/* ---- Files ---- */

static int fail(const char *what, const char *path) {
    fprintf(stderr, "bn_bake_sampler: cannot %s %s: %s\n", what, path, strerror(errno));
    return 1;
}

/* Little-endian words. */
static int write_table(const bake_table *table, FILE *file) {
    static uint32_t words[BN_WORD_COUNT];
    static unsigned char bytes[sizeof words];
    bake_table_pack(table, words);
    for (size_t i = 0; i < sizeof bytes; ++i) {
        bytes[i] = (unsigned char)(words[i / 4] >> (8 * (i % 4)));
    }
    const int whole = fwrite(bytes, sizeof bytes, 1, file) == 1;
    return (fclose(file) == 0) & whole;
}

static int read_table(const char *path, uint32_t words[BN_WORD_COUNT]) {
    static unsigned char bytes[4 * BN_WORD_COUNT];
    FILE *file = fopen(path, "rb");
    if (file == NULL) return !fail("read", path);
    const int whole = fread(bytes, sizeof bytes, 1, file) == 1 && fgetc(file) == EOF;
    fclose(file);
    if (!whole) {
        fprintf(stderr, "bn_bake_sampler: %s is not a table of %zu bytes\n", path, sizeof bytes);
        return 0;
    }
    memset(words, 0, BN_WORD_COUNT * sizeof *words);
    for (size_t i = 0; i < sizeof bytes; ++i) words[i / 4] |= (uint32_t)bytes[i] << (8 * (i % 4));
    return 1;
}

/* ---- Progress ---- */

static struct {
    int index;
    time_t shown;
} here;

/* On a terminal only. */
static void show_progress(double share) {
    if (!isatty(2) || time(NULL) == here.shown) return;
    here.shown = time(NULL);
    fprintf(stderr, "\rpart %d of %d: %.0f %%\033[K", here.index + 1, PARTS, 100 * share);
}

static void run(bake_stage *stage, bake_table *table, const bake_options *options, int members,
                int number) {
    for (int member = 0; member < members; ++member, ++here.index) {
        show_progress(0);
        stage(table, options, member, number);
    }
}

/* ---- Command line ---- */

static int make(const char *output, const char *vectors, bake_options *options) {
    static bake_table table;
    static uint32_t words[BN_WORD_COUNT];
    char beside[PATH_SIZE];
    if (vectors != NULL && !read_table(vectors, words)) return 1;
    if (snprintf(beside, PATH_SIZE, "%s.part", output) >= PATH_SIZE) {
        errno = ENAMETOOLONG;
        return fail("write", output);
    }
    FILE *file = fopen(beside, "wb"); /* before all of the work */
    if (file == NULL) return fail("write", output);
    options->progress = show_progress;
    bake_start(&table, options, 0, 0);
    if (vectors != NULL) {
        bake_table_unpack_vectors(&table, words);
        here.index = 2 * MEMBERS;
    } else {
        run(bake_vectors, &table, options, MEMBERS, 0);
        run(bake_vectors, &table, options, MEMBERS, 1);
    }
    run(bake_blocks, &table, options, 1, 0);
    run(bake_labels, &table, options, MEMBERS, 0);
    bake_finish(&table, options, 0, 0);
    if (isatty(2)) fprintf(stderr, "\r\033[K");
    if (write_table(&table, file) && rename(beside, output) == 0) return 0;
    fail("write", output);
    remove(beside);
    return 1;
}

int main(int argc, char **argv) {
    bake_options options = {.seed = 1, .effort = 1};
    const char *output = NULL, *vectors = NULL;
    int good = argc % 2 == 1;
    for (int i = 1; good && i < argc; i += 2) {
        const char *name = argv[i], *value = argv[i + 1];
        char *end = NULL;
        double number = strtod(value, &end);
        int is_number = end != value && *end == '\0' && number >= 0 && number < 4e9;
        if (strcmp(name, "-o") == 0) {
            output = value;
        } else if (strcmp(name, "--vectors") == 0) {
            vectors = value;
        } else if (!is_number) {
            good = 0;
        } else if (strcmp(name, "--seed") == 0) {
            options.seed = (uint64_t)number;
        } else if (strcmp(name, "--effort") == 0 && number <= 100) {
            options.effort = number;
        } else {
            good = 0;
        }
    }
    if (!good || output == NULL) {
        fputs(usage, stderr);
        return 2;
    }
    return make(output, vectors, &options);
}
