/* SPDX-License-Identifier: Apache-2.0
 * Makes libbn/data/blue.u32, the table behind BN_SAMPLER_BLUE.
 *
 * Samples and pixels are in pole order (pole_order.h). Of what that leaves open, three stages choose:
 * the vectors of each member of a family (bake_vectors.c), the quadtree down to blocks of 4 x 4 pixels
 * (bake_blocks.c) and inside them (bake_labels.c), so that errors of neighbouring pixels cancel. All
 * moves keep the nets. Half an hour on one core. Vectors decide nearly all of the errors, the quadtree
 * how visible its own pattern is: --vectors searches another quadtree in five minutes.
 *
 * The table depends on the seed and the effort alone, not on interruptions; cosines, logarithms and
 * exponentials come from the C library, so another one may give another table of the same quality.
 */
#include "bake_tile.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    PATH_SIZE = 4096,
    VECTORS_END = 1 + (BAKE_VECTOR_PARTS + BAKE_AGAIN_PARTS) * MEMBERS,
    PARTS = (BAKE_VECTOR_PARTS + BAKE_AGAIN_PARTS + BAKE_LABEL_PARTS) * MEMBERS + 3
};

static const char usage[] =
    "usage: bn_bake_sampler [--seed N] [--effort SCALE] [--vectors TABLE] [--stop-after PARTS] -o "
    "FILE\n"
    "  -o FILE             makes a table of the sampler blue\n"
    "  --seed N            (1)\n"
    "  --effort SCALE      of the search, from 0 to 100 (1: half an hour)\n"
    "  --vectors TABLE     takes the vectors from this table, and searches the quadtree alone\n"
    "  --stop-after PARTS  ends after this many of the parts of the work\n"
    "Progress is kept in FILE.progress after every part; the same command goes on from there.\n";

/* ---- Files ---- */

static int path_beside(char path[PATH_SIZE], const char *file, const char *ending) {
    return snprintf(path, PATH_SIZE, "%s%s", file, ending) < PATH_SIZE;
}

static int fail(const char *what, const char *path) {
    fprintf(stderr, "bn_bake_sampler: cannot %s %s: %s\n", what, path, strerror(errno));
    return 1;
}

/* A line of text, unless it is NULL, and bytes; written beside and renamed. */
static int write_file(const char *path, const char *line, const void *bytes, size_t size) {
    char beside[PATH_SIZE];
    if (!path_beside(beside, path, ".part")) return 0;
    FILE *file = fopen(beside, "wb");
    int good = file != NULL && (line == NULL || fputs(line, file) >= 0) &&
               fwrite(bytes, size, 1, file) == 1;
    if (file != NULL && fclose(file) != 0) good = 0;
    if (good && rename(beside, path) == 0) return 1;
    fail("write", path);
    remove(beside);
    return 0;
}

/* Little-endian words. */
static int write_table(const bake_table *table, const char *path) {
    static uint32_t words[BN_WORD_COUNT];
    static unsigned char bytes[sizeof words];
    bake_table_pack(table, words);
    for (size_t i = 0; i < sizeof bytes; ++i) {
        bytes[i] = (unsigned char)(words[i / 4] >> (8 * (i % 4)));
    }
    return write_file(path, NULL, bytes, sizeof bytes);
}

static int read_table(const char *path, uint32_t words[BN_WORD_COUNT]) {
    static unsigned char bytes[4 * BN_WORD_COUNT];
    FILE *file = fopen(path, "rb");
    if (file == NULL) return !fail("read", path);
    const int whole = fread(bytes, sizeof bytes, 1, file) == 1 && fgetc(file) == EOF;
    fclose(file);
    if (!whole) {
        fprintf(stderr, "bn_bake_sampler: %s is no table of %zu bytes\n", path, sizeof bytes);
        return 0;
    }
    memset(words, 0, BN_WORD_COUNT * sizeof *words);
    for (size_t i = 0; i < sizeof bytes; ++i) words[i / 4] |= (uint32_t)bytes[i] << (8 * (i % 4));
    return 1;
}

/* How many parts of the same work are done, with the table they left; 0 when there is none. */
static int read_progress(bake_table *table, const char *path, const char *signature) {
    FILE *file = fopen(path, "rb");
    if (file == NULL) return 0;
    char line[256];
    int done = 0;
    size_t length = strlen(signature);
    if (fgets(line, sizeof line, file) != NULL && strncmp(line, signature, length) == 0) {
        char *end;
        long parts = strtol(line + length, &end, 10);
        if (*end == '\n' && parts > 0 && parts <= PARTS &&
            fread(table, sizeof *table, 1, file) == 1 && fgetc(file) == EOF) {
            done = (int)parts;
        }
    }
    fclose(file);
    return done;
}

/* ---- Parts, and the progress in them ---- */

typedef struct {
    const char *name;
    bake_stage *run;
    int member, number;
    double cost; /* in seconds of the full effort, about */
} part;

static part plan[PARTS];

static void make_plan(void) {
    int n = 0;
    plan[n++] = (part){"start", bake_start, 0, 0, 0};
    for (int k = 0; k < MEMBERS * BAKE_VECTOR_PARTS; ++k) {
        plan[n++] =
            (part){"vectors", bake_vectors, k / BAKE_VECTOR_PARTS, k % BAKE_VECTOR_PARTS, 33};
    }
    for (int k = 0; k < MEMBERS * BAKE_AGAIN_PARTS; ++k) {
        plan[n++] = (part){"vectors again", bake_vectors, k / BAKE_AGAIN_PARTS,
                           BAKE_VECTOR_PARTS + k % BAKE_AGAIN_PARTS, 45};
    }
    plan[n++] = (part){"blocks", bake_blocks, 0, 0, 40};
    for (int k = 0; k < MEMBERS * BAKE_LABEL_PARTS; ++k) {
        plan[n++] = (part){"labels", bake_labels, k / BAKE_LABEL_PARTS, k % BAKE_LABEL_PARTS, 12};
    }
    plan[n++] = (part){"lower digits", bake_finish, 0, 0, 0};
}

static struct {
    int index;
    double cost_before, started, shown;
} here;

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* On a terminal only. */
static void show_progress(double share) {
    double time = now(), done = share * plan[here.index].cost, all = 0;
    if (!isatty(2) || time < here.shown + 0.5) return;
    here.shown = time;
    for (int i = 0; i < here.index; ++i) done += plan[i].cost;
    for (int i = 0; i < PARTS; ++i) all += plan[i].cost;
    fprintf(stderr, "\r%s of member %d, part %d of %d: %.0f %%", plan[here.index].name,
            plan[here.index].member, here.index + 1, PARTS, 100 * done / all);
    double rate = (done - here.cost_before) / (time - here.started + 1e-9);
    if (time - here.started > 5 && rate > 0) {
        fprintf(stderr, ", %.1f %% a minute, %.0f s left", 6000 * rate / all, (all - done) / rate);
    }
    fprintf(stderr, "\033[K");
}

/* ---- Command line ---- */

static int make(const char *output, const char *vectors, bake_options *options, int stop_after) {
    static bake_table table;
    static uint32_t words[BN_WORD_COUNT];
    uint64_t hash = 0;
    char progress[PATH_SIZE], signature[128], line[160];
    if (!path_beside(progress, output, ".progress.part") ||
        !path_beside(progress, output, ".progress")) {
        fprintf(stderr, "bn_bake_sampler: the name of FILE is too long\n");
        return 1;
    }
    if (vectors != NULL) {
        if (!read_table(vectors, words)) return 1;
        for (uint32_t i = 0; i < BN_WORD_COUNT; ++i) hash = bake_mix(hash ^ words[i]);
    }
    snprintf(signature, sizeof signature, "blue seed %llu effort %.17g vectors %016llx parts ",
             (unsigned long long)options->seed, options->effort, (unsigned long long)hash);
    int done = read_progress(&table, progress, signature);
    make_plan();
    here.started = now();
    for (int i = 0; i < done; ++i) here.cost_before += plan[i].cost;
    if (done > 0 && isatty(2)) fprintf(stderr, "going on after part %d of %d\n", done, PARTS);
    options->progress = show_progress;
    if (vectors != NULL && done == 0) {
        bake_start(&table, options, 0, 0);
        bake_table_unpack_vectors(&table, words);
        here.cost_before = 0;
        for (done = 0; done < VECTORS_END; ++done) here.cost_before += plan[done].cost;
    }
    for (int i = done; i < PARTS && i < stop_after; ++i) {
        here.index = i;
        show_progress(0);
        plan[i].run(&table, options, plan[i].member, plan[i].number);
        snprintf(line, sizeof line, "%s%d\n", signature, i + 1);
        if (!write_file(progress, line, &table, sizeof table)) return 1;
    }
    if (isatty(2)) fprintf(stderr, "\r\033[K");
    if (stop_after < PARTS) return 0;
    if (!write_table(&table, output)) return 1;
    remove(progress);
    return 0;
}

int main(int argc, char **argv) {
    bake_options options = {.seed = 1, .effort = 1};
    const char *output = NULL, *vectors = NULL;
    int stop_after = PARTS, good = argc % 2 == 1;
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
        } else if (strcmp(name, "--stop-after") == 0) {
            stop_after = number < PARTS ? (int)number : PARTS;
        } else {
            good = 0;
        }
    }
    if (!good || output == NULL) {
        fputs(usage, stderr);
        return 2;
    }
    return make(output, vectors, &options, stop_after);
}
