/* SPDX-License-Identifier: Apache-2.0
 * Time and error of the mask makers, as CSV on standard output:
 *
 *     method,options,width,height,depth,threads,repeats,seconds,cpu_seconds,e_0.75,e_1,e_1.5,e_2
 *
 * `seconds` is the median of the repeats, each with a seed of its own, by the wall clock,
 * `cpu_seconds` that of the processor time of all threads. Errors are means over the seeds (from
 * 512 texels on, of one), empty for masks of three dimensions. With --quick only the small sizes
 * run. */
#define _POSIX_C_SOURCE 200809L
#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_REPEATS = 64, ERRORS = 4 };
static const double sigmas[ERRORS] = {0.75, 1, 1.5, 2};

typedef struct job {
    const char *method;
    double sigma;
    uint32_t work; /* sweeps or steps; 0 steps: the learned schedule of relaxation */
    uint32_t width, height, depth, threads;
    int repeats;
} job;

static double now(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bn_result make(const job *j, uint64_t seed, uint32_t *ranks, size_t count, float *noise) {
    if (strcmp(j->method, "void-and-cluster") == 0) {
        bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
        options.sigma = j->sigma;
        options.seed = seed;
        return bn_void_and_cluster(&options, j->width, j->height, j->depth, ranks, count);
    }
    if (strcmp(j->method, "relax") == 0) {
        bn_relax_options options = bn_relax_options_default();
        options.threads = j->threads;
        options.seed = seed;
        return bn_relax(&options, j->width, j->height, ranks, count);
    }
    if (strcmp(j->method, "anneal") == 0) {
        bn_anneal_options options = bn_anneal_options_default();
        options.sweeps = j->work;
        options.seed = seed;
        return bn_anneal(&options, j->width, j->height, 1, ranks, count);
    }
    if (strcmp(j->method, "builtin") == 0) return bn_builtin_mask_copy(j->width, ranks, count);
    for (size_t i = 0; i < count; ++i) noise[i] = (float)rand();
    return bn_ranks_from_values(noise, count, ranks);
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int run(const job *j) {
    const size_t count = (size_t)j->width * j->height * j->depth;
    uint32_t *ranks = malloc(count * sizeof *ranks);
    float *noise = malloc(count * sizeof *noise);
    double seconds[MOST_REPEATS], cpu[MOST_REPEATS], errors[ERRORS] = {0};
    /* Errors of large masks take longer than the masks, and hardly differ between seeds. */
    const int seeds = j->width >= 512 ? 1 : j->repeats;
    bn_result result = ranks == NULL || noise == NULL ? BN_ERROR_OUT_OF_MEMORY : BN_SUCCESS;
    /* The first is not counted: it meets cold memory. */
    for (int i = -1; i < j->repeats && result == BN_SUCCESS; ++i) {
        const double begun = now(CLOCK_MONOTONIC), cpu_begun = now(CLOCK_PROCESS_CPUTIME_ID);
        result = make(j, (uint64_t)(i < 0 ? 0 : i), ranks, count, noise);
        if (i < 0) continue;
        seconds[i] = now(CLOCK_MONOTONIC) - begun;
        cpu[i] = now(CLOCK_PROCESS_CPUTIME_ID) - cpu_begun;
        if (j->depth > 1 || i >= seeds) continue;
        for (int e = 0; e < ERRORS && result == BN_SUCCESS; ++e) {
            double error = 0;
            result =
                bn_mask_error(ranks, j->width, j->height, count, sigmas[e], &error, NULL, NULL);
            errors[e] += error / seeds;
        }
    }
    free(ranks);
    free(noise);
    if (result != BN_SUCCESS) {
        fprintf(stderr, "bench_masks: %s %ux%ux%u: %s\n", j->method, j->width, j->height, j->depth,
                bn_result_string(result));
        return 1;
    }
    qsort(seconds, (size_t)j->repeats, sizeof *seconds, compare);
    qsort(cpu, (size_t)j->repeats, sizeof *cpu, compare);
    printf("%s,", j->method);
    if (strcmp(j->method, "void-and-cluster") == 0) printf("sigma %g", j->sigma);
    if (j->work != 0)
        printf("%u %s", j->work, strcmp(j->method, "relax") == 0 ? "steps" : "sweeps");
    printf(",%u,%u,%u,%u,%d,%.6f,%.6f", j->width, j->height, j->depth, j->threads, j->repeats,
           seconds[j->repeats / 2], cpu[j->repeats / 2]);
    for (int e = 0; e < ERRORS; ++e) {
        if (j->depth == 1) {
            printf(",%.5f", errors[e]);
        } else {
            printf(",");
        }
    }
    printf("\n");
    fflush(stdout);
    return 0;
}

int main(int argc, char **argv) {
    const int quick = argc == 2 && strcmp(argv[1], "--quick") == 0;
    if (argc > 1 && !quick) {
        fprintf(stderr, "Usage: bench_masks [--quick]\n");
        return 2;
    }
    const uint32_t most = quick ? 256 : 1024;
    int status = 0;
    printf("method,options,width,height,depth,threads,repeats,seconds,cpu_seconds,e_0.75,e_1,e_1.5,"
           "e_2\n");
    for (uint32_t size = 64; size <= most && status == 0; size *= 2) {
        const int repeats = size <= 128 ? 20 : size == 256 ? 9 : size == 512 ? 5 : 3;
        const job jobs[] = {
            {"white", 0, 0, size, size, 1, 1, repeats},
            {"void-and-cluster", 1.5, 0, size, size, 1, 1, repeats},
            {"void-and-cluster", 1.9, 0, size, size, 1, 1, repeats},
            {"relax", 0, 0, size, size, 1, 1, repeats},
            {"relax", 0, 0, size, size, 1, 2, repeats},
        };
        for (size_t i = 0; i < sizeof jobs / sizeof *jobs && status == 0; ++i)
            status = run(&jobs[i]);
        for (uint32_t sweeps = 100; sweeps <= (quick ? 100u : 10000u) && size <= 128 && status == 0;
             sweeps *= 10) {
            const job anneal = {"anneal", 0, sweeps, size, size, 1, 1, sweeps > 100 ? 1 : 3};
            status = run(&anneal);
        }
    }
    for (uint32_t size = 16; size <= 256 && status == 0; size *= 2) {
        const job builtin = {"builtin", 0, 0, size, size, 1, 1, 1};
        if (bn_builtin_mask(size) != NULL) status = run(&builtin);
    }
    const job cube = {"void-and-cluster", 1.5, 0, 64, 64, 64, 1, 3};
    if (!quick && status == 0) status = run(&cube);
    return status;
}
