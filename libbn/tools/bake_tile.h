/* SPDX-License-Identifier: Apache-2.0
 * The tile that bn_bake_sampler optimises, and what its parts offer each other. */
#ifndef BN_BAKE_TILE_H
#define BN_BAKE_TILE_H

#include <bn/bn_draw.h>

enum {
    LEVELS = 9,
    POINTS = 256,
    LANES = 16,
    PARTITIONS = 10,
    MAX_CELLS = 1 << 14,
    BLOCKS = 4,
    STEPS = 2 * LANES
};

typedef struct options {
    uint32_t size;
    uint32_t integrands;
    uint32_t sweeps;
    uint32_t proposals;
    uint32_t threads;
    uint32_t declared; /* the count the table is for */
    uint64_t seed;
    double wide;     /* weight of the wider of the two blurs, the rest is the narrow one's */
    double sigma[2]; /* the two blurs, in pixels */
    double level_weight[LEVELS];
    double temperature;   /* at the first sweep; falls to zero over the sweeps */
    double edges[LEVELS]; /* weights of the errors along axis-aligned edges */
    double evenness;      /* weight of the evenness of the first samples over the tile */
    double refresh;       /* share of the integrands that is replaced before each sweep */
    const char *output;
    const char *start; /* a table to begin from, or NULL */
} options;

/* Random numbers: a counter hashed with SplitMix64. */
static inline uint64_t mix(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

typedef struct random_state {
    uint64_t key, counter;
} random_state;

static inline uint64_t random_u64(random_state *state) {
    return mix(state->key ^ mix(state->counter++));
}
static inline double random_double(random_state *state) {
    return (double)(random_u64(state) >> 11) * 0x1p-53;
}

/* A half-plane a x + b y < c, or with r > 0 the disc (x - a)^2 + (y - b)^2 < r. */
typedef struct integrand {
    double a, b, c, r, mean;
} integrand;

typedef struct neighbour {
    int dx, dy;
    float weight;
} neighbour;

typedef struct partition {
    int bits_x, bits_y;
    float scale; /* one over the mean count of a cell */
} partition;

typedef struct tile {
    options opt;
    partition partitions[PARTITIONS];
    uint8_t second[256];  /* the first eight digits of y for those of the index */
    uint32_t *entries;    /* [size][size], the table that is made */
    float *errors;        /* [size][size][LEVELS][integrands] */
    float *a, *b, *c, *r; /* the same, one array per parameter */
    float *mean;
    neighbour *neighbours,
        *line; /* of all integrands; of the first STEPS, along rows and columns */
    int neighbour_count, line_count;
    float level_weight[LEVELS];
    int32_t (*occupied)[MAX_CELLS]; /* [PARTITIONS]: entries in every cell of every partition */
    int32_t (*changes)[PARTITIONS][MAX_CELLS]; /* of each block of the colour being visited */
    uint32_t sweep;
    int prepared; /* the errors are those of the present entries and integrands */
    bn_digit_tables digits;
} tile;

/* bake_tile.c: memory, test integrands, point sets, the start. */
void *allocate(size_t count, size_t size);
void integrand_finish(integrand *f);
double integrand_value(const integrand *f, double x, double y);
integrand integrand_make(uint64_t seed, uint64_t index);
integrand step_make(uint64_t index, int axis, int k);
uint32_t entry_make(uint32_t sx, uint32_t sy, uint32_t fx, uint32_t fy);
uint32_t entry_key(uint32_t entry);
void set_point(const tile *t, uint32_t j, uint32_t key, uint32_t fx, uint32_t fy, float *x,
               float *y);
void tile_create(tile *t, const options *opt);
void tile_destroy(tile *t);

/* bake_evenness.c: how evenly the first samples of the tile fill the unit square. */
void make_partitions(tile *t);
void count_cells(tile *t);
float crowding(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry);
void count_entry(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry, int32_t by);
double worst_crowding(const tile *t);

/* bake_search.c: the descent. */
void tile_set_integrands(tile *t, uint32_t sweep);
void tile_sweep(tile *t);

/* bake_report.c */
void report(const tile *t);

#endif
