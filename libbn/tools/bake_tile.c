/* SPDX-License-Identifier: Apache-2.0
 * The table, its file format, random numbers, integrands and blurs of bn_bake_sampler. Loops run
 * over arrays with a fixed inner stride, so that compilers make vectors of them in a fixed order of
 * sums. Random numbers are counters hashed by splitmix64 (Steele, Lea and Flood, "Fast Splittable
 * Pseudorandom Number Generators", 2014). */
#include "bake_tile.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double TURN = 6.283185307179586;

void *bake_allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "bn_bake_sampler: no memory for %zu bytes; close other programs\n",
                count * size);
        exit(1);
    }
    return memory;
}

/* ---- Random numbers ---- */

uint64_t bake_mix(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

bake_random bake_random_make(uint64_t seed, uint64_t what, uint64_t which) {
    bake_random r = {bake_mix(bake_mix(bake_mix(seed) + what) + which), 0};
    return r;
}

uint64_t bake_random_bits(bake_random *r) {
    return bake_mix(r->key ^ bake_mix(r->counter++));
}

double bake_random_double(bake_random *r) {
    return (double)(bake_random_bits(r) >> 11) * (1.0 / 9007199254740992.0);
}

uint32_t bake_random_below(bake_random *r, uint32_t limit) {
    return (uint32_t)((bake_random_bits(r) >> 32) * limit >> 32);
}

int bake_count(const bake_options *options, double count, int least) {
    double scaled = options->effort * count;
    return scaled > least ? (int)scaled : least;
}

/* ---- The table ---- */

/* A random permutation of the four children of node (x, y) of a level, as p ^ flip after a linear map.
 * Without the map, the flip of columns is the same in both rows of the parent and that of rows in
 * both columns, which keeps pixels along a column or row apart. */
static uint32_t permuted(uint64_t seed, int level, uint32_t x, uint32_t y, int linear) {
    static const uint32_t maps[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 1, 3, 2},
                                        {0, 3, 1, 2}, {0, 2, 3, 1}, {0, 3, 2, 1}};
    const uint32_t child = (x >> level & 1u) | (y >> level & 1u) << 1;
    const uint32_t column = x >> (level + 1), row = y >> (level + 1);
    const uint64_t node = (uint64_t)level << 32;
    if (linear) {
        const uint64_t hash = bake_mix(bake_mix(seed + node) + (row << 16 | column));
        return maps[(hash >> 32) % 6][child] ^ (uint32_t)(hash & 3u);
    }
    const uint64_t along = bake_mix(bake_mix(seed + node + 1) + (row >> 1 << 16 | column));
    const uint64_t across = bake_mix(bake_mix(seed + node + 2) + (row << 16 | column >> 1));
    return child ^ (uint32_t)(along & 1u) ^ (uint32_t)(across & 1u) << 1;
}

void bake_tree_labels(uint16_t label[PIXELS], uint64_t seed, uint64_t within, int linear) {
    for (uint32_t p = 0; p < PIXELS; ++p) {
        uint32_t out = 0;
        for (int level = 5; level >= 0; --level) {
            out = out << 2 | permuted(level < 2 ? within : seed, level, p % SIDE, p / SIDE,
                                      linear && level < 2);
        }
        label[p] = (uint16_t)out;
    }
}

/* The upper halves of four coordinates in two words, and back. */
static void pack_digits(const uint32_t v[4], uint32_t out[2]) {
    out[0] = v[0] >> 16 | (v[1] & 0xffff0000u);
    out[1] = v[2] >> 16 | (v[3] & 0xffff0000u);
}

static void add_digits(uint32_t v[4], const uint32_t packed[2]) {
    for (int k = 0; k < 4; ++k) v[k] ^= (k & 1) ? packed[k / 2] & 0xffff0000u : packed[k / 2] << 16;
}

/* Where the points of the lowest eight bits of an index are, and those of four later bits. */
static uint32_t points_at(uint32_t member, uint32_t index) {
    return BN_POINTS_AT + ((bn_reverse_bits(index) >> 24) * MEMBERS + member) * 4u;
}

static uint32_t later_at(uint32_t member, uint32_t four, uint32_t bits) {
    return BN_LATER_AT + ((four * 16u + (bn_reverse_bits(bits) >> 28)) * MEMBERS + member) * 4u;
}

int bake_pixel_of(int block, int place) {
    return (block / 16 * 4 + place / 4) * SIDE + block % 16 * 4 + place % 4;
}

/* bn_draw.glsl has the layout. */
void bake_table_pack(const bake_table *table, uint32_t words[BN_WORD_COUNT]) {
    memset(words, 0, BN_WORD_COUNT * sizeof *words);
    for (uint32_t p = 0; p < PIXELS; ++p) {
        for (uint32_t a = 0; a < MEMBERS; ++a) {
            words[BN_PIXELS_AT + p] |= (table->label[a][p] & 15u) << (8 * a);
        }
    }
    for (uint32_t a = 0; a < MEMBERS; ++a) {
        const pole_vectors *v = &table->member[a];
        uint32_t sum[4];
        for (uint32_t b = 0; b < BLOCKS; ++b) {
            pole_label_shift(v, table->label[0][bake_pixel_of((int)b, 0)] & ~15u, sum);
            pack_digits(sum, words + BN_BLOCKS_AT + (b * MEMBERS + a) * 2u);
        }
        for (uint32_t i = 0; i < 16u; ++i) {
            pole_label_shift(v, i, sum);
            pack_digits(sum, words + BN_PLACES_AT + (a * 16u + i) * 2u);
        }
        for (uint32_t i = 0; i < 256u; ++i) pole_index_point(v, i, words + points_at(a, i));
        for (uint32_t i = 0; i < 6u * 16u; ++i) {
            pole_index_point(v, (i & 15u) << (8u + i / 16u * 4u),
                             words + later_at(a, i / 16u, i & 15u));
        }
    }
}

void bake_table_unpack_vectors(bake_table *table, const uint32_t words[BN_WORD_COUNT]) {
    memset(table->member, 0, sizeof table->member);
    for (uint32_t a = 0; a < MEMBERS; ++a) {
        pole_vectors *v = &table->member[a];
        for (uint32_t i = 0; i < 8; ++i) {
            memcpy(v->index[i], words + points_at(a, 1u << i), sizeof v->index[i]);
        }
        for (uint32_t i = 0; i < 24; ++i) {
            memcpy(v->index[8 + i], words + later_at(a, i / 4, 1u << i % 4), sizeof v->index[i]);
        }
        for (uint32_t i = 0; i < 4; ++i) {
            add_digits(v->label[i], words + BN_PLACES_AT + (a * 16u + (1u << i)) * 2u);
        }
        /* Of the blocks in the first row and the first column, by what they differ from the first one. */
        for (uint32_t i = 0; i < 8; ++i) {
            const uint32_t block = (i & 1 ? 16u : 1u) << i / 2;
            add_digits(v->label[4 + i], words + BN_BLOCKS_AT + a * 2u);
            add_digits(v->label[4 + i], words + BN_BLOCKS_AT + (block * MEMBERS + a) * 2u);
        }
    }
}

void bake_pair_make(bake_pair *pair, const pole_vectors *v, int which) {
    for (uint32_t i = 0; i < POINTS; ++i) {
        uint32_t bits[4];
        pole_index_point(v, i, bits);
        memcpy(pair->point[i], bits + 2 * which, sizeof pair->point[i]);
    }
    for (uint32_t m = 0; m < PIXELS; ++m) {
        uint32_t bits[4];
        pole_label_shift(v, m, bits);
        for (int c = 0; c < 2; ++c) pair->shift[m][c] = bits[2 * which + c] & 0xffff0000u;
    }
}

bake_key bake_key_make(bake_random *r) {
    uint64_t bits = bake_random_bits(r);
    bake_key key = {(uint32_t)bits, (uint32_t)(bits >> 32)};
    return key;
}

void bake_pair_points(const bake_pair *pair, uint32_t label, bake_key key, int count, float *x,
                      float *y) {
    uint32_t sx = pair->shift[label][0] ^ key.x, sy = pair->shift[label][1] ^ key.y;
    for (int i = 0; i < count; ++i) {
        x[i] = (float)(int32_t)((pair->point[i][0] ^ sx) >> 8) * (1.0f / 16777216.0f);
        y[i] = (float)(int32_t)((pair->point[i][1] ^ sy) >> 8) * (1.0f / 16777216.0f);
    }
}

const int bake_partial_count[PARTIALS] = {3, 5, 6, 7, 9, 10, 12, 14, 24};

/* The order of bn_draw_blue_digits(): an index with another shuffle in every domain. */
bake_sample_order bake_sample_order_make(bake_random *r) {
    bake_sample_order order = {{0}};
    uint32_t shuffle = (uint32_t)bake_random_bits(r);
    for (uint32_t i = 0; i < 64; ++i) {
        uint32_t digits = bn_draw_blue_digits(shuffle, bn_reverse_bits(i), bn_draw_flip(i));
        uint64_t sample = (uint64_t)1 << bn_reverse_bits(digits);
        for (int c = 0; c < PARTIALS; ++c) {
            if ((int)i < bake_partial_count[c]) order.mask[c] |= sample;
        }
    }
    return order;
}

void bake_sobol_points(int p, uint32_t domain, int count, float *x, float *y) {
    bn_sampler sampler;
    bn_sampler_init(&sampler, BN_SAMPLER_SOBOL, 0);
    for (int i = 0; i < count; ++i) {
        float u[4];
        bn_sample_4d(&sampler, p % SIDE, p / SIDE, (uint32_t)i, domain, u);
        x[i] = u[0];
        y[i] = u[1];
    }
}

/* ---- Integrands ---- */

/* The area of a x + b y < c in the unit square, which is clipped. */
static double plane_mean(double a, double b, double c) {
    static const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double x[8], y[8], area = 0;
    int n = 0;
    for (int i = 0; i < 4; ++i) {
        const double *p = corner[i], *q = corner[(i + 1) % 4];
        double dp = a * p[0] + b * p[1] - c, dq = a * q[0] + b * q[1] - c;
        if (dp < 0) {
            x[n] = p[0];
            y[n++] = p[1];
        }
        if ((dp < 0) != (dq < 0)) {
            double t = dp / (dp - dq);
            x[n] = p[0] + t * (q[0] - p[0]);
            y[n++] = p[1] + t * (q[1] - p[1]);
        }
    }
    for (int i = 0; i < n; ++i) area += x[i] * y[(i + 1) % n] - x[(i + 1) % n] * y[i];
    return area / 2;
}

bake_plane bake_plane_make(bake_random *r, double turns) {
    double a = cos(TURN * turns), b = sin(TURN * turns);
    double x = bake_random_double(r), y = bake_random_double(r);
    double c = a * x + b * y;
    bake_plane plane = {(float)a, (float)b, (float)c, plane_mean(a, b, c)};
    return plane;
}

bake_plane bake_plane_step(int dimension, double place) {
    bake_plane plane = {dimension == 0, dimension == 1, (float)place, place};
    return plane;
}

void bake_plane_bits(const bake_plane *plane, const float *x, const float *y, int count,
                     uint64_t *bits) {
    float a = plane->a, b = plane->b, c = plane->c;
    for (int word = 0; word < count / 64; ++word, x += 64, y += 64) {
        unsigned char inside[64];
        for (int i = 0; i < 64; ++i) inside[i] = (unsigned char)(a * x[i] + b * y[i] < c);
        uint64_t v = 0;
        for (int k = 0; k < 8; ++k) {
            uint64_t eight = 0;
            for (int i = 0; i < 8; ++i) eight |= (uint64_t)inside[8 * k + i] << (8 * i);
            /* Gathers the lowest bits of eight bytes in the top byte. */
            v |= (eight * 0x0102040810204080u >> 56) << (8 * k);
        }
        bits[word] = v;
    }
}

void bake_prefix_errors(const uint64_t *bits, int levels, double mean, float *out, int stride) {
    int counts[LEVELS], total = 0;
    for (int word = 0; word < (levels > 7 ? 4 : 1); ++word) {
        uint64_t v = bits[word];
        if (word == 0) counts[0] = (int)(v & 1u);
        v = v - ((v >> 1) & 0x5555555555555555u);
        if (word == 0) counts[1] = (int)(v & 3u);
        v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
        if (word == 0) counts[2] = (int)(v & 7u);
        v = (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
        v *= 0x0101010101010101u; /* byte k: the sum of bytes 0 to k */
        if (word == 0) {
            counts[3] = (int)(v & 255u);
            counts[4] = (int)(v >> 8 & 255u);
            counts[5] = (int)(v >> 24 & 255u);
        }
        total += (int)(v >> 56);
        if (word == 0) counts[6] = total;
        if (word == 1) counts[7] = total;
        if (word == 3) counts[8] = total;
    }
    for (int l = 0; l < levels; ++l) {
        out[l * stride] = (float)(counts[l] / (double)(1 << l) - mean);
    }
}

/* ---- Images ---- */

double bake_mean_square(const float *image, int count) {
    float lane[16] = {0};
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += image[i + k] * image[i + k];
    }
    double sum = 0;
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum / count;
}

float bake_inner_product(const float *a, const float *b, int count) {
    float lane[16] = {0}, sum = 0;
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += a[i + k] * b[i + k];
    }
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum;
}
