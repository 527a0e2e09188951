/* SPDX-License-Identifier: Apache-2.0
 * Makes the table behind BN_SAMPLER_BLUE.
 *
 * Every pixel of a tile owns a set of 256 points, a (0,8,2)-net given by a digital shift (two
 * bytes) of one Owen-scrambled Sobol' set and by its next eight digits (two bytes). The first 2^l
 * samples of a pixel are a dyadic block of its set, so the order of the samples is a path in a
 * binary tree of blocks. With the errors of every block for many test integrands (half-planes and
 * discs), and the errors of the neighbouring pixels weighted by the Gaussian the picture is seen
 * through, the best of all 256 orders is a shortest path in that tree. Coordinate descent over
 * pixels, orders and random proposals of other sets minimises the blurred error of all nine
 * prefixes together. (The energy is that of Georgiev and Fajardo, "Blue-noise Dithered Sampling",
 * 2016, and Heitz et al., "A Low-Discrepancy Sampler that Distributes Monte Carlo Errors as a Blue
 * Noise in Screen Space", 2019; the start is the hierarchical order of Ahmed and Wonka, 2020.)
 *
 * The result depends on the options alone, not on the number of threads or on interruptions; sums
 * are made in a fixed order without fused operations. Angles and logarithms come from the C
 * library, so another one may change last digits and with them single entries. */
#include "bake_tile.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* ---- Files --------------------------------------------------------------------------------- */

enum { PATH_SIZE = 4096 };

static int path_beside(char path[PATH_SIZE], const char *file, const char *ending) {
    return snprintf(path, PATH_SIZE, "%s%s", file, ending) < PATH_SIZE;
}

/* Little-endian entries and, when signature is not NULL, the state of the search behind them.
 * Written beside and renamed. */
static int write_table(const tile *t, const char *path, const char *signature,
                       uint32_t sweeps_done) {
    char temporary[PATH_SIZE];
    uint32_t count = t->opt.size * t->opt.size;
    if (!path_beside(temporary, path, ".part")) return 0;
    FILE *file = fopen(temporary, "wb");
    int good = file != NULL;
    for (uint32_t i = 0; good && i < count; ++i) {
        uint32_t v = t->entries[i];
        unsigned char bytes[4] = {(unsigned char)v, (unsigned char)(v >> 8),
                                  (unsigned char)(v >> 16), (unsigned char)(v >> 24)};
        good = fwrite(bytes, 1, 4, file) == 4;
    }
    if (good && signature != NULL) good = fprintf(file, "%s\n%u\n", signature, sweeps_done) > 0;
    if (file != NULL && fclose(file) != 0) good = 0;
    if (good && rename(temporary, path) != 0) good = 0;
    if (!good) {
        fprintf(stderr, "bn_bake_sampler: cannot write %s: %s\n", path, strerror(errno));
        remove(temporary);
    }
    return good;
}

/* Reads entries; with a signature, also the number of sweeps done, if the state behind the entries
 * is that of the same options. */
static int read_table(tile *t, const char *path, const char *signature, uint32_t *sweeps_done) {
    FILE *file = fopen(path, "rb");
    uint32_t count = t->opt.size * t->opt.size, *entries = allocate(count, sizeof *entries);
    int good = file != NULL;
    for (uint32_t i = 0; good && i < count; ++i) {
        unsigned char b[4];
        good = fread(b, 1, 4, file) == 4;
        if (good) entries[i] = b[0] | b[1] << 8 | b[2] << 16 | (uint32_t)b[3] << 24;
    }
    if (signature != NULL) {
        char line[1024];
        good = good && fgets(line, sizeof line, file) != NULL;
        if (good) line[strcspn(line, "\n")] = '\0';
        good = good && strcmp(line, signature) == 0 && fscanf(file, "%u", sweeps_done) == 1;
    } else {
        good = good && fgetc(file) == EOF;
    }
    if (file != NULL) fclose(file);
    if (good) memcpy(t->entries, entries, count * sizeof *entries);
    free(entries);
    if (good) count_cells(t);
    return good;
}

/* All options that decide the result, as text. */
static void make_signature(const options *o, char *text, size_t size) {
    int at =
        snprintf(text, size, "%u %u %u %u %u %llu %.17g %.17g %.17g %.17g %s", o->size, o->declared,
                 o->integrands, o->sweeps, o->proposals, (unsigned long long)o->seed, o->wide,
                 o->temperature, o->evenness, o->refresh, o->start != NULL ? o->start : "-");
    for (int level = 0; level < LEVELS && at > 0 && (size_t)at < size; ++level) {
        at += snprintf(text + at, size - (size_t)at, " %.17g %.17g", o->level_weight[level],
                       o->edges[level]);
    }
}

/* ---- Command line --------------------------------------------------------------------------- */

static const char usage[] =
    "usage: bn_bake_sampler [options] -o FILE\n"
    "  --size N            side of the tile, a power of two from 16 to 256 (128)\n"
    "  --integrands N      test integrands, a multiple of 16, at least 64 (512)\n"
    "  --sweeps N          visits of every pixel (14)\n"
    "  --proposals N       random other sets tried at every visit (1)\n"
    "  --seed N            (1)\n"
    "  --wide SHARE        weight of the blur of 2.1 pixels against that of 1.05 (0.4)\n"
    "  --level-weights W   nine weights for 1, 2, 4, ... 256 samples (1,1,1,1,1,1,1,1,1)\n"
    "  --refresh SHARE     integrands replaced before every sweep (0.08)\n"
    "  --temperature T     of the first sweep; falls to zero (0)\n"
    "  --edges W           nine weights of axis-aligned edges, along which errors add up\n"
    "                      (24,8,20,3,0.5,0,0,0,0)\n"
    "  --declared N        a table for this count, a power of two: start from blocks of N points\n"
    "                      along the curve (256)\n"
    "  --evenness W        weight of the evenness of first samples (0.4)\n"
    "  --start FILE        begin from this table instead of the hierarchical order\n"
    "  --threads N         (2)\n"
    "Progress is kept in FILE.progress every sweep; the same command goes on from there.\n";

static int parse_weights(const char *text, double weights[LEVELS]) {
    for (int level = 0; level < LEVELS; ++level) {
        char *end;
        weights[level] = strtod(text, &end);
        if (end == text || !(weights[level] >= 0.0 && weights[level] < 1e6)) return 0;
        if (*end != (level + 1 < LEVELS ? ',' : '\0')) return 0;
        text = end + 1;
    }
    return 1;
}

static int parse(int argc, char **argv, options *opt) {
    for (int i = 1; i < argc; i += 2) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (value == NULL) return 0;
        char *end = NULL;
        double number = strtod(value, &end);
        int is_number = end != value && *end == '\0' && number >= 0.0 && number < 4e9;
        if (strcmp(name, "-o") == 0) {
            opt->output = value;
        } else if (strcmp(name, "--start") == 0) {
            opt->start = value;
        } else if (strcmp(name, "--level-weights") == 0) {
            if (!parse_weights(value, opt->level_weight)) return 0;
        } else if (strcmp(name, "--edges") == 0) {
            if (!parse_weights(value, opt->edges)) return 0;
        } else if (!is_number) {
            return 0;
        } else if (strcmp(name, "--size") == 0) {
            opt->size = (uint32_t)number;
        } else if (strcmp(name, "--integrands") == 0) {
            opt->integrands = (uint32_t)number;
        } else if (strcmp(name, "--sweeps") == 0) {
            opt->sweeps = (uint32_t)number;
        } else if (strcmp(name, "--proposals") == 0) {
            opt->proposals = (uint32_t)number;
        } else if (strcmp(name, "--threads") == 0) {
            opt->threads = (uint32_t)number;
        } else if (strcmp(name, "--declared") == 0) {
            opt->declared = (uint32_t)number;
        } else if (strcmp(name, "--seed") == 0) {
            opt->seed = (uint64_t)number;
        } else if (strcmp(name, "--wide") == 0) {
            opt->wide = number;
        } else if (strcmp(name, "--temperature") == 0) {
            opt->temperature = number;
        } else if (strcmp(name, "--evenness") == 0) {
            opt->evenness = number;
        } else if (strcmp(name, "--refresh") == 0) {
            opt->refresh = number;
        } else {
            return 0;
        }
    }
    uint32_t n = opt->size;
    return opt->output != NULL && n >= 16 && n <= 256 && (n & (n - 1)) == 0 &&
           opt->integrands >= 2 * STEPS && opt->integrands <= 8192 &&
           opt->integrands % LANES == 0 && opt->threads >= 1 && opt->threads <= 64 &&
           opt->proposals <= 256 && opt->declared >= 1 && opt->declared <= POINTS &&
           (opt->declared & (opt->declared - 1)) == 0 && opt->wide <= 1.0 && opt->refresh <= 1.0;
}

static double now(void) {
    struct timespec time;
    timespec_get(&time, TIME_UTC);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int main(int argc, char **argv) {
    options opt = {.size = 128,
                   .declared = POINTS,
                   .integrands = 512,
                   .sweeps = 14,
                   .proposals = 1,
                   .threads = 2,
                   .seed = 1,
                   .wide = 0.4,
                   .sigma = {1.05, 2.1},
                   .refresh = 0.08,
                   .edges = {24, 8, 20, 3, 0.5},
                   .evenness = 0.4};
    for (int level = 0; level < LEVELS; ++level) opt.level_weight[level] = 1.0;

    char progress[PATH_SIZE], signature[1024];
    if (!parse(argc, argv, &opt) || !path_beside(progress, opt.output, ".progress")) {
        fputs(usage, stderr);
        return 2;
    }
    make_signature(&opt, signature, sizeof signature);
    tile t;
    tile_create(&t, &opt);
    tile_set_integrands(&t, 0); /* also sets the weights, from the hierarchical order */
    uint32_t done = 0;
    if (opt.start != NULL && !read_table(&t, opt.start, NULL, NULL)) {
        fprintf(stderr, "bn_bake_sampler: %s holds no table of this size\n", opt.start);
        return 1;
    }
    if (read_table(&t, progress, signature, &done)) printf("going on after sweep %u\n", done);
    t.prepared = 0;
    double start = now();
    for (uint32_t sweep = done; sweep < opt.sweeps; ++sweep) {
        tile_set_integrands(&t, sweep);
        if (sweep == done) report(&t);
        tile_sweep(&t);
        if (!write_table(&t, progress, signature, sweep + 1)) return 1;
        double elapsed = now() - start, each = elapsed / (sweep + 1 - done);
        if (isatty(2)) {
            fprintf(stderr, "\rsweep %u of %u, %.1f s each, %.0f s left ", sweep + 1, opt.sweeps,
                    each, each * (opt.sweeps - sweep - 1));
        }
        if (sweep % 8 == 7) {
            printf("sweep %u, %.0f s\n", sweep + 1, elapsed);
            report(&t);
        }
    }
    printf("result\n");
    report(&t);
    if (!write_table(&t, opt.output, NULL, 0)) return 1;
    remove(progress);
    tile_destroy(&t);
    return 0;
}
