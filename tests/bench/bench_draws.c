/* SPDX-License-Identifier: Apache-2.0
 * Nanoseconds per 4-D draw on one core, as CSV on standard output:
 *
 *     sampler,form,nanoseconds,instances
 *
 * Forms: `single` calls bn_sample_4d() for four domains, each the child of the one before, of every
 * sample, as a path does; `inline` the same with bn_draw_4d(); `domain` calls bn_domain_child()
 * alone; `block` calls bn_sample_block() for 16 indices of 64 x 16 pixels. A time is the shortest
 * of many short ones, taken in turn, so that what else the machine does falls out; `instances` is
 * their number.
 *
 * Another library stands in the same table with --peer NAME=COMMAND: the command prints one number,
 * the nanoseconds of a 4-D draw measured in the same way. It runs several times in between, and the
 * least number counts. */
#if defined(__SSE2__)
#include <emmintrin.h> /* before bn_draw.h: its faster form */
#endif
#include <bn/bn_draw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 64, HEIGHT = 4, INDICES = 16, DEPTH = 4, MAX_PEERS = 16, KINDS = 5 };
enum { DRAWS = WIDTH * HEIGHT * INDICES * DEPTH };

static const char usage[] =
    "usage: bench_draws [--rounds N] [--peer NAME=COMMAND] ...\n"
    "  --rounds N           times each form is measured (400)\n"
    "  --peer NAME=COMMAND  a command that prints the nanoseconds of another library's 4-D draw\n";

static const char *const kind_names[KINDS] = {"blue", "sobol", "white", "zorder", "mask"};
static volatile float sink;

static double now(void) {
    struct timespec time;
    timespec_get(&time, TIME_UTC);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

/* Loops of their own functions: what the compiler makes of one does not depend on the others. */
typedef float form(const bn_sampler *sampler, int32_t y0, float *block);

static float draw_single(const bn_sampler *sampler, int32_t y0, float *block) {
    float sum = 0.0f;
    (void)block;
    for (int32_t y = y0; y < y0 + HEIGHT; ++y) {
        for (int32_t x = 0; x < WIDTH; ++x) {
            for (uint32_t index = 0; index < INDICES; ++index) {
                uint32_t domain = BN_DOMAIN_ROOT;
                for (uint32_t depth = 0; depth < DEPTH; ++depth) {
                    float u[4];
                    domain = bn_domain_child(domain, depth);
                    bn_sample_4d(sampler, x, y, index, domain, u);
                    sum += u[0] + u[1] + u[2] + u[3];
                }
            }
        }
    }
    return sum;
}

static float draw_inline(const bn_sampler *sampler, int32_t y0, float *block) {
    const bn_draw_table *table = bn_sampler_table(sampler);
    float sum = 0.0f;
    (void)block;
    for (int32_t y = y0; y < y0 + HEIGHT; ++y) {
        for (int32_t x = 0; x < WIDTH; ++x) {
            for (uint32_t index = 0; index < INDICES; ++index) {
                uint32_t domain = BN_DOMAIN_ROOT;
                for (uint32_t depth = 0; depth < DEPTH; ++depth) {
                    float u[4];
                    domain = bn_draw_domain_child(domain, depth);
                    bn_draw_4d(table, x, y, index, domain, u);
                    sum += u[0] + u[1] + u[2] + u[3];
                }
            }
        }
    }
    return sum;
}

static float draw_domain(const bn_sampler *sampler, int32_t y0, float *block) {
    uint32_t domain = (uint32_t)y0;
    (void)sampler;
    (void)block;
    for (uint32_t i = 0; i < DRAWS; ++i) domain = bn_domain_child(domain, i);
    return (float)domain;
}

static float draw_block(const bn_sampler *sampler, int32_t y0, float *block) {
    if (bn_sample_block(sampler, 0, y0, WIDTH, HEIGHT * DEPTH, 0, INDICES, 1, block, 4 * DRAWS) !=
        BN_SUCCESS) {
        exit(1);
    }
    return block[0] + block[4 * DRAWS - 1];
}

typedef struct row {
    const char *sampler, *form_name;
    form *draw;
    const bn_sampler *instance;
    const char *command; /* of a peer */
    double best;
} row;

/* The number that a peer's command prints; negative when it does not. */
static double ask_peer(const char *command) {
    char line[256], *end = line;
    double value = -1.0;
    FILE *pipe = popen(command, "r");
    if (pipe == NULL) return -1.0;
    if (fgets(line, sizeof line, pipe) != NULL) value = strtod(line, &end);
    while (fgets(line, sizeof line, pipe) != NULL) continue;
    return pclose(pipe) == 0 && end != line && value > 0.0 ? value : -1.0;
}

static void measure(row *r, unsigned round, float *block) {
    double start = now(), elapsed;
    sink = r->draw(r->instance, (int32_t)(round % 16u * HEIGHT), block);
    elapsed = (now() - start) / DRAWS;
    if (elapsed < r->best) r->best = elapsed;
}

int main(int argc, char **argv) {
    static row rows[4 * KINDS + MAX_PEERS];
    bn_sampler *samplers[KINDS];
    unsigned rounds = 400, peer_rounds = 5;
    int count = 0, peers = 0;
    float *block = malloc(4 * DRAWS * sizeof *block);
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        bn_sampler_options options = bn_sampler_options_default();
        options.kind = kind;
        if (block == NULL || bn_sampler_create(&options, &samplers[kind]) != BN_SUCCESS) {
            fprintf(stderr, "bench_draws: out of memory\n");
            return 1;
        }
        rows[count++] = (row){kind_names[kind], "single", draw_single, samplers[kind], NULL, 1e30};
        /* The inline form of the others is a call of the library. */
        if (kind <= BN_SAMPLER_WHITE) {
            rows[count++] =
                (row){kind_names[kind], "inline", draw_inline, samplers[kind], NULL, 1e30};
        }
        rows[count++] = (row){kind_names[kind], "block", draw_block, samplers[kind], NULL, 1e30};
    }
    rows[count++] = (row){"-", "domain", draw_domain, samplers[0], NULL, 1e30};
    for (int i = 1; i < argc; i += 2) {
        char *value = i + 1 < argc ? argv[i + 1] : NULL, *end = value;
        if (value != NULL && strcmp(argv[i], "--rounds") == 0) {
            rounds = (unsigned)strtoul(value, &end, 10);
            if (end == value || *end != '\0' || rounds == 0) value = NULL;
        } else if (value != NULL && strcmp(argv[i], "--peer") == 0 && peers < MAX_PEERS) {
            end = strchr(value, '=');
            if (end != NULL) {
                *end = '\0';
                rows[count++] = (row){value, "peer", NULL, NULL, end + 1, 1e30};
                ++peers;
            } else {
                value = NULL;
            }
        } else {
            value = NULL;
        }
        if (value == NULL) {
            fputs(usage, stderr);
            return 2;
        }
    }
    for (unsigned round = 0; round < rounds; ++round) {
        for (int i = 0; i < count; ++i) {
            if (rows[i].command == NULL) {
                measure(&rows[i], round, block);
            } else if (round % ((rounds + peer_rounds - 1) / peer_rounds) == 0) {
                double value = ask_peer(rows[i].command);
                if (value < 0.0) {
                    fprintf(stderr, "bench_draws: this prints no number of nanoseconds: %s\n",
                            rows[i].command);
                    return 1;
                }
                if (value < rows[i].best) rows[i].best = value;
            }
        }
    }
    printf("sampler,form,nanoseconds,instances\n");
    for (int i = 0; i < count; ++i) {
        printf("%s,%s,%.2f,%u\n", rows[i].sampler, rows[i].form_name, rows[i].best,
               rows[i].command == NULL ? rounds : peer_rounds);
    }
    for (int kind = 0; kind < KINDS; ++kind) bn_sampler_destroy(samplers[kind]);
    free(block);
    return 0;
}
