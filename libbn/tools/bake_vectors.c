/* SPDX-License-Identifier: Apache-2.0
 * The first stage of bn_bake_sampler: the vectors of each member.
 *
 * Three types of moves preserve every net: they add a coordinate's digit to a less significant digit, an
 * index bit's vector to that of a higher bit, or a pair's label vectors to vectors of the same or a coarser
 * level. Annealing minimises the mean logarithm of errors, after blurs of 2.1 and 1 pixels and in single
 * pixels. The integrands are half-planes that are constant or drift across the screen, their products over
 * both pairs and over two members, choices between half-planes with a third number, half-spaces in three
 * dimensions, edges parallel to the sides of the screen (member 0), and smooth functions. A random quadtree
 * assigns labels to pixels. Positions have 15 bits, so sums do not depend on the compiler. A trial takes
 * about ten milliseconds. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SETS = 4, /* sets of integrands that share a domain */
    EACH = 8, /* integrands in a set */
    INTEGRANDS = SETS * EACH,
    SAMPLES = 64,
    COUNTS = 7, /* 1, 2, 4 ... 64 samples */
    STEPS = 6   /* per dimension in a set */
};

/* The types of integrands: each pair, both pairs, a choice with a third number, half-spaces, two members,
 * steps parallel to the sides of the screen, and steps in single numbers. */
enum { FIRST, SECOND, BOTH, CHOICE, SPACE, MEMBER, STEP, SINGLE, KINDS };

/* 2^14 (a u + b v + c w) < limit, with 15-bit coordinates; the limit may drift. */
typedef struct {
    int16_t factor[3], limit[PIXELS];
    float mean[PIXELS];
} edge;

typedef struct {
    edge plane[2], other, space; /* for both pairs; a second one for pair 0; in three dimensions */
    int third;                   /* the dimension that chooses */
    int16_t below;               /* its limit */
    int earlier, earlier_pair, pair;
    int16_t inside[SAMPLES][PIXELS]; /* marks of the earlier member's half-plane */
} integrand;

typedef struct {
    uint16_t key[4];
    integrand f[EACH];
    int16_t step[4][STEPS];
} integrand_set;

typedef struct {
    integrand_set set[SETS];
    const uint16_t *label;
    const double *count_weight;
    int member, others; /* the number of other members to form products with */
    bake_smooth_judge *smooth;
    double blurred[KINDS][COUNTS], narrow[KINDS][COUNTS], raw[KINDS][COUNTS];
} vector_judge;

/* Wider vectors double the speed, and the results are bit-identical. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define BAKE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define BAKE_WIDE
#endif

/* ---- Integrands ---- */

static double cube(double v) {
    return v > 0 ? v * v * v : 0;
}

/* The volume of n . u < d in the unit cube; a component of zero makes it an area. */
static double half_space_mean(const double n[3], double d) {
    double size[3], sum = 0, product = 6;
    for (int k = 0; k < 3; ++k) {
        if (n[k] < 0) d -= n[k];
        size[k] = fmax(fabs(n[k]), 1e-3);
        d += (size[k] - fabs(n[k])) / 2;
        product *= size[k];
    }
    for (int corner = 0; corner < 8; ++corner) {
        double at = d;
        int odd = 0;
        for (int k = 0; k < 3; ++k) {
            if (corner >> k & 1) {
                at -= size[k];
                odd ^= 1;
            }
        }
        sum += odd ? -cube(at) : cube(at);
    }
    return fmin(fmax(sum / product, 0), 1);
}

/* Sets an edge at one pixel to n . u < d. */
static void edge_set(edge *e, int pixel, const double n[3], double d) {
    e->limit[pixel] = (int16_t)lround(fmin(fmax(d, -1.9), 1.9) * 16384);
    e->mean[pixel] = (float)half_space_mean(n, d);
}

/* Makes an edge through a point near the middle. With a period, it moves back and forth across the screen. */
static void edge_make(edge *e, bake_random *r, int dimensions, int period) {
    double n[3] = {0}, length = 0, through = 0, waves[2] = {0};
    for (int k = 0; k < dimensions; ++k) {
        n[k] = cos(TURN * bake_random_double(r)) * sqrt(-2 * log(1 - bake_random_double(r)));
        length += n[k] * n[k];
    }
    length = sqrt(length) * (dimensions == 3 ? 1.1 : 1);
    for (int k = 0; k < dimensions; ++k) {
        n[k] /= length;
        through += n[k] * (0.2 + 0.6 * bake_random_double(r));
        e->factor[k] = (int16_t)lround(n[k] * 32767);
    }
    const double turns = bake_random_double(r), phase = bake_random_double(r);
    if (period > 0) {
        waves[0] = round(cos(TURN * turns) * SIDE / period);
        waves[1] = round(sin(TURN * turns) * SIDE / period);
        if (waves[0] == 0 && waves[1] == 0) waves[0] = 1;
    }
    for (int p = 0; p < PIXELS; ++p) {
        double along = (waves[0] * (p % SIDE) + waves[1] * (p / SIDE)) / SIDE + phase;
        edge_set(e, p, n, through + (period > 0 ? 0.35 * sin(TURN * along) : 0));
    }
}

/* Makes a moving edge, where dimension 2 is time: it starts at a position on the screen and moves by up to
 * 16 pixels. Pixels it does not touch have no error. */
static void moving_edge_make(edge *e, bake_random *r) {
    const double turns = bake_random_double(r), way = cos(TURN * bake_random_double(r));
    const double speed = pow(16, bake_random_double(r)) * way;
    double n[3] = {cos(TURN * turns), sin(TURN * turns), speed};
    const double through = n[0] * SIDE * (0.3 + 0.4 * bake_random_double(r)) +
                           n[1] * SIDE * (0.3 + 0.4 * bake_random_double(r)) + speed / 2;
    const double scale = 1 / fmax(fabs(n[0]) + fabs(n[1]) + fabs(n[2]), 1);
    const double scaled[3] = {scale * n[0], scale * n[1], scale * n[2]};
    for (int p = 0; p < PIXELS; ++p) {
        edge_set(e, p, scaled, scale * (through - n[0] * (p % SIDE) - n[1] * (p / SIDE)));
    }
    for (int k = 0; k < 3; ++k) e->factor[k] = (int16_t)lround(scaled[k] * 32767);
}

static const int PERIODS[EACH] = {0, 64, 0, 32, 0, 64, 0, 21};

static void integrand_make(integrand *f, bake_random *r, int which, int member, int others) {
    for (int k = 0; k < 2; ++k) edge_make(&f->plane[k], r, 2, PERIODS[which]);
    edge_make(&f->other, r, 2, PERIODS[which]);
    f->third = which % 4 == 3 ? 3 : 2;
    if (member == 0 && f->third == 2) { /* the position in the pixel, and a time */
        moving_edge_make(&f->space, r);
    } else {
        edge_make(&f->space, r, 3, PERIODS[(which + 1) % EACH]);
    }
    f->below = (int16_t)(32768 * (0.25 + 0.5 * bake_random_double(r)));
    f->earlier = others > 0 ? (int)bake_random_below(r, (uint32_t)others) : 0;
    if (f->earlier >= member) ++f->earlier;
    f->pair = which & 1;
    f->earlier_pair = which >> 1 & 1;
}

/* ---- Samples: 15 bits of a label's sum, a sample's sum and a key ---- */

/* The upper 16 digits at every pixel of the tile. */
typedef uint16_t coordinates[4][PIXELS];

static void label_coordinates(coordinates out, const bake_sums *s, const uint16_t *label,
                              const uint16_t key[4]) {
    for (int p = 0; p < PIXELS; ++p) {
        for (int d = 0; d < 4; ++d) out[d][p] = (uint16_t)(s->label[label[p]][d] >> 16 ^ key[d]);
    }
}

static inline int16_t coordinate(uint16_t label, uint32_t point) {
    return (int16_t)((uint16_t)(label ^ point >> 16) >> 1);
}

static inline int16_t times(int16_t a, int16_t u) {
    return (int16_t)((int32_t)a * u >> 16);
}

/* -1 inside, otherwise 0. */
static inline int16_t below(int16_t value, int16_t limit) {
    return (int16_t) - (value < limit);
}

/* Marks the pixels whose sample lies inside an edge in the dimensions x, y and, for half-spaces, z. */
BAKE_WIDE static void mark_edge(int16_t *mark, const edge *e, const coordinates at,
                                const uint32_t point[4], int x, int y, int z) {
    const int16_t a = e->factor[0], b = e->factor[1], c = e->factor[2];
    for (int p = 0; p < PIXELS; ++p) {
        const int16_t u = coordinate(at[x][p], point[x]), v = coordinate(at[y][p], point[y]);
        const int16_t w = coordinate(at[z][p], point[z]);
        mark[p] = below((int16_t)(times(a, u) + times(b, v) + times(c, w)), e->limit[p]);
    }
}

/* Marks the pixels whose sample is below a limit in one dimension. */
BAKE_WIDE static void mark_step(int16_t *mark, const uint16_t *x, uint32_t point, int16_t limit) {
    for (int p = 0; p < PIXELS; ++p) mark[p] = below(coordinate(x[p], point), limit);
}

BAKE_WIDE static void add_marks(int16_t *count, const int16_t *mark) {
    for (int p = 0; p < PIXELS; ++p) count[p] = (int16_t)(count[p] - mark[p]);
}

/* Takes one sample in every pixel, and adds those inside to the counts. */
BAKE_WIDE static void count_sample(int16_t count[STEP][PIXELS], const integrand *f,
                                   const coordinates at, const uint32_t point[4],
                                   const int16_t *inside) {
    static int16_t mark[STEP][PIXELS], other[PIXELS], choice[PIXELS];
    const int16_t *first = mark[FIRST], *second = mark[SECOND], *own = mark[f->pair];
    mark_edge(mark[FIRST], &f->plane[0], at, point, 0, 1, 0);
    mark_edge(mark[SECOND], &f->plane[1], at, point, 2, 3, 2);
    mark_edge(other, &f->other, at, point, 0, 1, 0);
    mark_edge(mark[SPACE], &f->space, at, point, 0, 1, f->third);
    mark_step(choice, at[f->third], point[f->third], f->below);
    for (int p = 0; p < PIXELS; ++p) {
        mark[BOTH][p] = first[p] & second[p];
        mark[CHOICE][p] = (int16_t)((first[p] & choice[p]) | (other[p] & ~choice[p]));
        mark[MEMBER][p] = own[p] & inside[p];
    }
    for (int kind = 0; kind < STEP; ++kind) add_marks(count[kind], mark[kind]);
}

/* ---- Errors ---- */

enum { RADIUS = 7, HALF = SIDE / 2 };

/* Row y of an image after a blur along columns, with RADIUS repeated values at both ends. */
BAKE_WIDE static void blur_columns(float line[SIDE + 2 * RADIUS], const float *image, int y,
                                   const float *kernel, int radius) {
    float *middle = line + RADIUS;
    memset(middle, 0, SIDE * sizeof *middle);
    for (int d = -radius; d <= radius; ++d) {
        const float *from = image + ((y + d) & (SIDE - 1)) * SIDE, w = kernel[d + radius];
        for (int x = 0; x < SIDE; ++x) middle[x] += w * from[x];
    }
    memcpy(line, middle + SIDE - RADIUS, RADIUS * sizeof *line);
    memcpy(middle + SIDE, middle, RADIUS * sizeof *line);
}

/* The mean square after a blur of 2.1 pixels along rows (1), columns (2) or both (3). Evaluates every
 * second pixel each way, because the blur removes all frequencies this loses. */
BAKE_WIDE static double wide_square(const float *image, int axes) {
    static float kernel[2 * RADIUS + 1];
    static const float none = 1;
    if (kernel[0] == 0.0f) {
        double k[2 * RADIUS + 1], all = 0;
        for (int d = -RADIUS; d <= RADIUS; ++d) {
            all += k[d + RADIUS] = exp(-d * d / (2 * SIGMA * SIGMA));
        }
        for (int d = 0; d <= 2 * RADIUS; ++d) kernel[d] = (float)(k[d] / all);
    }
    const int columns = (axes & 2) != 0, step = columns ? 2 : 1;
    double square = 0;
    for (int y = 0; y < SIDE; y += step) {
        float line[SIDE + 2 * RADIUS], out[HALF] = {0};
        blur_columns(line, image, y, columns ? kernel : &none, columns ? RADIUS : 0);
        if (axes == 2) {
            square = bake_add_squares(square, line + RADIUS, SIDE);
            continue;
        }
        for (int d = 0; d <= 2 * RADIUS; ++d) {
            const float *from = line + d, w = kernel[d];
            for (int x = 0; x < HALF; ++x) out[x] += w * from[2 * x];
        }
        square = bake_add_squares(square, out, HALF);
    }
    return square / (SIDE / step * (axes == 2 ? SIDE : HALF));
}

/* The mean square after a blur of one pixel, with binomial weights 1 4 6 4 1 each way. */
BAKE_WIDE static double narrow_square(const float *image) {
    static const float w[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
    double square = 0;
    for (int y = 0; y < SIDE; ++y) {
        float line[SIDE + 2 * RADIUS], out[SIDE];
        blur_columns(line, image, y, w, 2);
        for (int x = 0; x < SIDE; ++x) {
            const float *at = line + RADIUS - 2 + x;
            out[x] = w[0] * (at[0] + at[4]) + w[1] * (at[1] + at[3]) + w[2] * at[2];
        }
        square = bake_add_squares(square, out, SIDE);
    }
    return square / PIXELS;
}

BAKE_WIDE static void image_of(float *image, const int16_t *count, float scale, const float *mean) {
    for (int p = 0; p < PIXELS; ++p) image[p] = (float)count[p] * scale - mean[p];
}

static void add_errors(vector_judge *j, int kind, int level, const float *image) {
    j->blurred[kind][level] += wide_square(image, 3) / INTEGRANDS;
    j->narrow[kind][level] += narrow_square(image) / INTEGRANDS;
    j->raw[kind][level] += bake_add_squares(0, image, PIXELS) / PIXELS / INTEGRANDS;
}

static void judge_integrand(vector_judge *j, const integrand *f, const coordinates at,
                            const uint32_t point[][4]) {
    static int16_t count[STEP][PIXELS];
    static float image[PIXELS], mean[STEP][PIXELS];
    const float share = (float)f->below / 32768;
    memset(count, 0, sizeof count);
    for (int p = 0; p < PIXELS; ++p) {
        const float first = f->plane[0].mean[p], second = f->plane[1].mean[p];
        mean[FIRST][p] = first;
        mean[SECOND][p] = second;
        mean[BOTH][p] = mean[MEMBER][p] = first * second;
        mean[CHOICE][p] = share * first + (1 - share) * f->other.mean[p];
        mean[SPACE][p] = f->space.mean[p];
    }
    for (int i = 0, level = 0; i < SAMPLES; ++i) {
        count_sample(count, f, at, point[i], f->inside[i]);
        if ((i & (i + 1)) != 0) continue;
        for (int kind = 0; kind < (j->others > 0 ? STEP : MEMBER); ++kind) {
            image_of(image, count[kind], 1.0f / (float)(i + 1), mean[kind]);
            add_errors(j, kind, level, image);
        }
        ++level;
    }
}

/* Judges steps in single numbers. Member 0 also blurs steps in x along columns, and steps in y along rows. */
static void judge_steps(vector_judge *j, const integrand_set *s, const coordinates at,
                        const uint32_t point[][4]) {
    static int16_t count[PIXELS], mark[PIXELS];
    static float image[PIXELS], mean[PIXELS];
    for (int d = 0; d < 4; ++d) {
        for (int k = 0; k < STEPS; ++k) {
            memset(count, 0, sizeof count);
            for (int p = 0; p < PIXELS; ++p) mean[p] = (float)s->step[d][k] / 32768;
            for (int i = 0, level = 0; i < SAMPLES; ++i) {
                mark_step(mark, at[d], point[i][d], s->step[d][k]);
                add_marks(count, mark);
                if ((i & (i + 1)) != 0) continue;
                image_of(image, count, 1.0f / (float)(i + 1), mean);
                j->blurred[SINGLE][level] += wide_square(image, 3) / (SETS * 4 * STEPS);
                if (d < 2)
                    j->blurred[STEP][level] += wide_square(image, 2 - d) / (SETS * 2 * STEPS);
                ++level;
            }
        }
    }
}

static const double KIND_WEIGHT[KINDS] = {1, 1, 1.6, 0.7, 0.6, 2.0, 1.3, 0.6};
static const double RAW_WEIGHT[KINDS] = {0.35, 0.35, 0.4, 0.2, 0.2, 0.5, 0, 0};
static const double COUNT_WEIGHT[2][COUNTS] = {{1.25, 1.05, 1, 1, 1, 0.75, 0.95},
                                               {1.15, 1, 1, 1.1, 1, 1, 1.35}};

/* The mean logarithm of the errors. */
static double judge_vectors(vector_judge *j, const bake_sums *sums) {
    static coordinates at;
    double sum = 0, weights = 0;
    memset(j->blurred, 0, sizeof j->blurred);
    memset(j->narrow, 0, sizeof j->narrow);
    memset(j->raw, 0, sizeof j->raw);
    for (int s = 0; s < SETS; ++s) {
        const integrand_set *set = &j->set[s];
        label_coordinates(at, sums, j->label, set->key);
        for (int k = 0; k < EACH; ++k) {
            judge_integrand(j, &set->f[k], (const uint16_t(*)[PIXELS])at, sums->point);
        }
        judge_steps(j, set, (const uint16_t(*)[PIXELS])at, sums->point);
    }
    for (int kind = 0; kind < KINDS; ++kind) {
        if (kind == MEMBER ? j->others == 0 : kind == STEP && j->member != 0) continue;
        for (int l = 0; l < COUNTS; ++l) {
            double e = log(j->blurred[kind][l] + 0.06 * j->narrow[kind][l]) / 2;
            if (kind < STEP) e += RAW_WEIGHT[kind] * log(j->raw[kind][l]) / 2;
            sum += KIND_WEIGHT[kind] * j->count_weight[l] * e;
        }
        weights += KIND_WEIGHT[kind] * COUNTS;
    }
    return sum / weights;
}

/* ---- Ties ---- */

/* Counts the dimensions in which two members' first digits agree over the first 2^m samples. If they agree
 * over 32 samples, the pair never reaches all four quarters. */
static double clash(const pole_vectors *first, const pole_vectors *second) {
    static const double weight[6] = {0, 0, 0, 0.02, 0.15, 3};
    double sum = 0;
    for (int d = 0; d < 16; ++d) {
        const uint32_t differ = pole_first_digit(first, d & 3) ^ pole_first_digit(second, d >> 2);
        for (int m = 3; m <= 5; ++m) {
            if ((differ & ((1u << m) - 1)) == 0) sum += weight[m];
        }
    }
    return sum;
}

/* ---- The stage ---- */

static void move(pole_vectors *v, bake_random *r, int member) {
    const uint32_t kind = bake_random_below(r, 100);
    if (kind < 55) {
        const int d = (int)bake_random_below(r, 4);
        const int from = (int)(13 * bake_random_double(r) * bake_random_double(r));
        const int to =
            from + 1 + (int)((15 - from) * bake_random_double(r) * bake_random_double(r));
        pole_add_digit(v, d, from, to);
    } else if (kind < (member > 0 ? 80 : 92)) {
        pole_mix_labels(v, (int)bake_random_below(r, 2), bake_random_bits(r));
    } else {
        const int to = 1 + (int)bake_random_below(r, 7);
        pole_add_index(v, (int)bake_random_below(r, (uint32_t)to), to);
    }
}

static void judge_begin(vector_judge *j, const bake_table *table, int member, int others,
                        bake_random *r) {
    static coordinates at;
    static bake_sums sums;
    j->member = member;
    j->others = others;
    j->label = table->label[member];
    for (int s = 0; s < SETS; ++s) {
        integrand_set *set = &j->set[s];
        for (int d = 0; d < 4; ++d) set->key[d] = (uint16_t)bake_random_bits(r);
        for (int d = 0; d < 4; ++d) {
            for (int k = 0; k < STEPS; ++k) {
                set->step[d][k] = (int16_t)(32768 * (k + bake_random_double(r)) / STEPS);
            }
        }
        for (int k = 0; k < EACH; ++k) {
            integrand *f = &set->f[k];
            uint16_t key[4];
            integrand_make(f, r, k, member, others);
            if (others == 0) continue;
            for (int d = 0; d < 4; ++d) key[d] = (uint16_t)bake_random_bits(r);
            bake_sums_make(&sums, &table->member[f->earlier]);
            label_coordinates(at, &sums, table->label[f->earlier], key);
            for (int i = 0; i < SAMPLES; ++i) {
                const int d = 2 * f->earlier_pair;
                mark_edge(f->inside[i], &f->plane[!f->pair], (const uint16_t(*)[PIXELS])at,
                          sums.point[i], d, d + 1, d);
            }
        }
    }
    j->smooth = bake_smooth_begin(r);
}

void bake_vectors(bake_table *table, const bake_options *options, int member, int again) {
    enum { SMOOTH_WEIGHT_PERCENT = 22, START_MOVES = 400, PARTS = 8, AGAIN_PARTS = 2 };
    const int others = again ? MEMBERS - 1 : member, trials = bake_count(options, 1600, 1);
    const int first = again ? PARTS : 0, end = again ? PARTS + AGAIN_PARTS : PARTS;
    static bake_sums sums;
    vector_judge *j = bake_allocate(1, sizeof *j);
    bake_random r = bake_random_make(options->seed, 2, (uint64_t)(member + again * MEMBERS));
    judge_begin(j, table, member, others, &r);
    j->count_weight = COUNT_WEIGHT[again];
    for (int part = first; part < end; ++part) {
        r = bake_random_make(options->seed, 3, (uint64_t)(member * 64 + part));
        pole_vectors now = table->member[member], best;
        for (int i = 0; i < START_MOVES && part == 0; ++i) move(&now, &r, member);
        double energy = 1e30, least = 1e30;
        best = now;
        for (int trial = 0; trial < trials; ++trial) {
            const double done = (part + (double)trial / trials) / PARTS;
            const double heat = again ? 0.0004 : 0.012 * pow(0.008, done);
            const double limit = energy - heat * log(1 - bake_random_double(&r));
            pole_vectors v = now;
            for (uint32_t n = trial > 0 ? 1 + bake_random_below(&r, 3) : 0; n > 0; --n) {
                move(&v, &r, member);
            }
            bake_sums_make(&sums, &v);
            double e = 0.01 * SMOOTH_WEIGHT_PERCENT * bake_smooth_energy(j->smooth, sums.point);
            for (int a = 0; a <= others; ++a) {
                if (a != member) e += 0.05 * clash(&table->member[a], &v);
            }
            e += judge_vectors(j, &sums);
            if (e <= limit) {
                now = v;
                energy = e;
            }
            if (e < least) {
                least = e;
                best = v;
            }
        }
        /* The last part ends with the best state, the others with the current state. */
        table->member[member] = part + 1 == end ? best : now;
    }
    free(j->smooth);
    free(j);
}
