/* SPDX-License-Identifier: Apache-2.0
 * The labels of BLUE are as the search left them: a minimum of its energy. Nets cannot tell, as any
 * exchange of two labels inside a block of 4 x 4 pixels keeps them all.
 *
 *     test_labels MEMBER
 *
 * tries all 30,720 exchanges in the labels of one member. One in a thousand lowers the energy, by
 * little, as the search ends at a temperature above zero. An exchange by mistake is noticed if it
 * raises the energy by more than that, since undoing it then lowers the energy by as much: the
 * program prints the share of exchanges that do. Nothing is random. */
#include "bake_tile.h"
#include <bn/bn.h>
#include <bn/bn_draw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 64, LANES = 16, EXCHANGES = BLOCKS * 120 };

/* Those that made libbn/data/blue.u32. Labels are compared by the same integrands at any greater
 * effort. */
static const bake_options options = {.seed = 2, .effort = 1};

/* What an exchange may gain: 8.7 was found. */
static const double MOST_GAIN = 12;

static bake_table table;
static double costs[EXCHANGES]; /* what each adds to the energy */

/* Whether the library draws with the labels of the table: the upper 16 digits of all pixels. */
static int is_built_in(void) {
    const uint32_t *words = bn_tables(NULL, NULL);
    int different = 0;
    for (uint32_t i = 0; i < MEMBERS * PIXELS && !different; ++i) {
        const uint32_t member = i / PIXELS, p = i % PIXELS,
                       block = p / SIDE / 4 * 16 + p % SIDE / 4;
        const uint32_t place = words[BN_PIXELS_AT + p] >> 8 * member & 15u;
        uint32_t digits[4];
        pole_label_shift(&table.member[member], table.label[member][p], digits);
        for (uint32_t pair = 0; pair < 2; ++pair) {
            const uint32_t both = words[BN_PLACES_AT + (member * 16 + place) * 2 + pair] ^
                                  words[BN_BLOCKS_AT + (block * MEMBERS + member) * 2 + pair];
            different += both != (digits[2 * pair] >> 16 | (digits[2 * pair + 1] & 0xffff0000u));
        }
    }
    return !different;
}

static void read_table(void) {
    static unsigned char bytes[BN_WORD_COUNT * 4];
    static uint32_t words[BN_WORD_COUNT];
    FILE *file = fopen(BN_BLUE_FILE, "rb");
    if (file == NULL || fread(bytes, 1, sizeof bytes, file) != sizeof bytes) {
        printf("cannot read %s\n", BN_BLUE_FILE);
        exit(1);
    }
    fclose(file);
    for (uint32_t i = 0; i < BN_WORD_COUNT; ++i) {
        const unsigned char *b = bytes + 4 * i;
        words[i] = b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    }
    if (!bake_table_unpack(&table, words)) exit(1);
}

/* ---- A part of a term: up to WIDTH of its columns */

typedef float image[PIXELS][WIDTH];

typedef struct {
    const bake_term *term;
    bake_features rows;
    int member, from, columns;
} term_part;

/* The errors of a pixel with a label. */
static const float *errors_at(const term_part *t, int pixel, uint32_t label) {
    size_t row = label;
    if (t->term->what == FEATURES_OF_TWO) {
        row = (row & ~(size_t)15) << 4 | (table.label[t->term->other][pixel] & 15u) << 4 |
              (row & 15u);
    }
    return t->rows.rows + row * (size_t)t->rows.width + t->from;
}

/* The Gaussians of bake_kernel_add(), by their number: a wide one, and a narrow one. */
static double gaussian(int number, int distance) {
    return exp(-distance * distance / (number == 0 ? 4 * SIGMA * SIGMA : 4.0));
}

static double share_of(const bake_term *term, int number) {
    return number == 0 ? 1 - term->narrow : term->narrow;
}

/* Adds `scale` times the image, blurred along rows (1), columns (2) or both (3), to `out`. */
static void add_blurred(float out[PIXELS][WIDTH], float in[PIXELS][WIDTH], int number, int axes,
                        float scale) {
    static image rows;
    float tap[BAKE_TAPS];
    for (int d = 0; d < BAKE_TAPS; ++d) {
        const double k = gaussian(number, d - BAKE_REACH);
        tap[d] = k < BAKE_LEAST_TAP ? 0.0f : (float)k;
    }
    for (int p = 0; p < PIXELS; ++p) {
        memset(rows[p], 0, sizeof rows[p]);
        for (int d = 0; d < BAKE_TAPS; ++d) {
            const float k = axes & 1 ? tap[d] : d == BAKE_REACH ? 1.0f : 0.0f;
            const float *from = in[p / SIDE * SIDE + ((p + d - BAKE_REACH) & (SIDE - 1))];
            if (k == 0.0f) continue;
            for (int i = 0; i < WIDTH; ++i) rows[p][i] += k * from[i];
        }
    }
    for (int p = 0; p < PIXELS; ++p) {
        for (int d = 0; d < BAKE_TAPS; ++d) {
            const float k = axes & 2 ? tap[d] : d == BAKE_REACH ? 1.0f : 0.0f;
            const float *from = rows[(p + (d - BAKE_REACH) * SIDE) & (PIXELS - 1)];
            if (k == 0.0f) continue;
            for (int i = 0; i < WIDTH; ++i) out[p][i] += scale * k * from[i];
        }
    }
}

/* What pixels at this distance add to the energy for each other. */
static double kernel_at(const bake_term *term, int dx, int dy) {
    double sum = 0;
    for (int k = 0; k < 2; ++k) {
        if ((term->axes[k] & 1 ? 0 : dx) != 0 || (term->axes[k] & 2 ? 0 : dy) != 0) continue;
        for (int n = 0; n < 2 && term->axes[k] != 0; ++n) {
            sum += share_of(term, n) * gaussian(n, dx) * gaussian(n, dy);
        }
    }
    return sum;
}

/* ---- Exchanges */

/* Inner products of rows: f a + g b, a a + b b, and a b. */
static void products(const float *f, const float *g, const float *a, const float *b,
                     double out[3]) {
    float first[LANES] = {0}, squares[LANES] = {0}, both[LANES] = {0};
    for (int i = 0; i < WIDTH; i += LANES) {
        for (int k = 0; k < LANES; ++k) {
            first[k] += f[i + k] * a[i + k] + g[i + k] * b[i + k];
            squares[k] += a[i + k] * a[i + k] + b[i + k] * b[i + k];
            both[k] += a[i + k] * b[i + k];
        }
    }
    memset(out, 0, 3 * sizeof *out);
    for (int k = 0; k < LANES; ++k) {
        out[0] += first[k];
        out[1] += squares[k];
        out[2] += both[k];
    }
}

static int pixel_of(int block, int place) {
    return (block / 16 * 4 + place / 4) * SIDE + block % 16 * 4 + place % 4;
}

/* Adds the part's share of what each exchange costs. */
static void add_costs(const term_part *t) {
    static image own, field;
    const uint16_t *label = table.label[t->member];
    const size_t size = (size_t)t->columns * sizeof(float);
    for (int p = 0; p < PIXELS; ++p) {
        memset(own[p], 0, sizeof own[p]);
        memcpy(own[p], errors_at(t, p, label[p]), size);
    }
    memset(field, 0, sizeof field);
    for (int k = 0; k < 2 && t->term->axes[k] != 0; ++k) {
        for (int n = 0; n < 2; ++n) {
            const double share = share_of(t->term, n);
            if (share > 0) add_blurred(field, own, n, t->term->axes[k], (float)share);
        }
    }
    double *cost = costs;
    for (int block = 0; block < BLOCKS; ++block) {
        for (int i = 1; i < 16; ++i) {
            for (int j = 0; j < i; ++j) {
                const int p = pixel_of(block, i), q = pixel_of(block, j);
                float a[WIDTH] = {0}, b[WIDTH] = {0};
                double sum[3];
                memcpy(a, errors_at(t, p, label[q]), size);
                memcpy(b, errors_at(t, q, label[p]), size);
                for (int k = 0; k < WIDTH; ++k) {
                    a[k] -= own[p][k];
                    b[k] -= own[q][k];
                }
                products(field[p], field[q], a, b, sum);
                const double between = kernel_at(t->term, i % 4 - j % 4, i / 4 - j / 4);
                *cost++ += t->term->weight *
                           (2 * sum[0] + kernel_at(t->term, 0, 0) * sum[1] + 2 * between * sum[2]);
            }
        }
    }
}

static void measure(int member) {
    bake_term terms[BAKE_MOST_TERMS];
    const int count = bake_terms(member, terms);
    for (int i = 0; i < count; ++i) {
        term_part t = {&terms[i], {0, NULL}, member, 0, 0};
        if (terms[i].what == FEATURES_OF_TWO) {
            bake_errors_of_two(&t.rows, &table, &options, terms[i].other, member);
        } else {
            bake_errors_of_label(&t.rows, &table, &options, member, terms[i].what);
        }
        for (; t.from < t.rows.width; t.from += WIDTH) {
            t.columns = t.rows.width - t.from < WIDTH ? t.rows.width - t.from : WIDTH;
            add_costs(&t);
        }
        free(t.rows.rows);
    }
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv) {
    if (argc != 2 || argv[1][0] < '0' || argv[1][0] > '3' || argv[1][1] != '\0') return 2;
    read_table();
    if (!is_built_in()) {
        printf("the library draws with other labels than those of %s\n", BN_BLUE_FILE);
        return 1;
    }
    bake_exchange(&table);
    measure(argv[1][0] - '0');
    qsort(costs, EXCHANGES, sizeof *costs, compare);
    const double most = costs[0] < 0 ? -costs[0] : 0;
    int lower = 0, noticed = 0;
    for (int i = 0; i < EXCHANGES; ++i) {
        lower += costs[i] < 0;
        noticed += costs[i] > MOST_GAIN;
    }
    printf(
        "%d of %d exchanges of two labels lower the energy, by %.2f at most; the median raises it "
        "by %.0f; %.1f %% would be noticed\n",
        lower, EXCHANGES, most, costs[EXCHANGES / 2], 100.0 * noticed / EXCHANGES);
    return !(most < MOST_GAIN) || lower > EXCHANGES / 500 || noticed < 0.95 * EXCHANGES;
}
