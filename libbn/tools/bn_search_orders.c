/* SPDX-License-Identifier: Apache-2.0
 * Searches the orders of the four domains of a family: the constants of bn_draw_member() in
 * bn/bn_draw.h. A minute on one core; the same constants on every machine for a seed.
 *
 * An order is a linear map of the eight digits of an index of which no digit reaches a later one.
 * What two domains do to each other depends on the relation of their orders alone. For functions
 * of one pair each, f and g, and point sets moved by random scrambles, the variance of the error of
 * f g beyond what f and g have on their own is the sum of |f'(k)|^2 |g'(l)|^2 over the pairs of
 * Walsh waves k, l, neither zero, that are constant on the first 2^m points (Owen, "Scrambled Net
 * Variance for Integrals of Smooth Functions", 1997). With f and g random half-planes this is a sum
 * of 2^m products for each m, and unrelated orders give 1 on average. The search anneals the mean
 * over relations, and sees to it that no two of the sixteen dimensions of a family share their
 * first digit from 32 samples on, which would correlate them.
 *
 * Prints the constants, and for every relation the error that remains relative to unrelated
 * orders, at 2, 4, ... 256 samples. */
#include <bn/bn_draw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { DIGITS = 8, VALUES = 256, MEMBERS = 4, PLANES = 1500, RESTARTS = 8, STEPS = 400000 };

/* The image of each digit alone; digit 0 is bit 7. */
typedef struct map {
    uint8_t image[DIGITS];
} map;

static uint64_t state;

static uint32_t random_u32(void) {
    state += 0x9e3779b97f4a7c15u;
    return bn_hash32((uint32_t)(state >> 32) ^ bn_hash32((uint32_t)state));
}

static double random_unit(void) {
    return random_u32() * 0x1p-32;
}

static uint8_t digit(uint32_t k) {
    return (uint8_t)(128u >> k);
}

static uint8_t apply(const map *a, uint32_t v) {
    uint8_t result = 0;
    for (uint32_t k = 0; k < DIGITS; ++k) result ^= v & digit(k) ? a->image[k] : 0;
    return result;
}

/* First b, then a. */
static map compose(const map *a, const map *b) {
    map result;
    for (uint32_t k = 0; k < DIGITS; ++k) result.image[k] = apply(a, b->image[k]);
    return result;
}

static map inverse(const map *a) {
    map result;
    for (uint32_t k = 0; k < DIGITS; ++k) {
        uint8_t v = digit(k), found = 0;
        for (uint32_t j = DIGITS; j-- > 0;) {
            if (v & digit(j)) {
                found |= digit(j);
                v ^= a->image[j];
            }
        }
        result.image[k] = found;
    }
    return result;
}

/* The digits of the inner product of every column with v: what a wave v becomes. */
static uint8_t transposed(const map *a, uint32_t v) {
    uint8_t result = 0;
    for (uint32_t k = 0; k < DIGITS; ++k) {
        uint32_t both = a->image[k] & v;
        both ^= both >> 4;
        both ^= both >> 2;
        result |= (both ^ both >> 1) & 1u ? digit(k) : 0;
    }
    return result;
}

/* ---- Waves ---- */

static map second_coordinate, second_pair[2];
/* Of a pair, by what the wave does to the first m digits of the index: the energy. */
static double energy[DIGITS + 1][VALUES];

static uint32_t last_digit(uint32_t wave) {
    uint32_t last = 0;
    for (uint32_t k = 0; k < DIGITS; ++k) last = wave & digit(k) ? k + 1 : last;
    return last;
}

/* Walsh transform along one axis of a square. */
static void transform(float *image, uint32_t size, uint32_t step, uint32_t line_step) {
    for (uint32_t half = 1; half < size; half *= 2) {
        for (uint32_t line = 0; line < size; ++line) {
            for (uint32_t i = 0; i < size; ++i) {
                if (i & half) continue;
                float *a = image + line * line_step + i * step, *b = a + half * step;
                float sum = *a + *b, difference = *a - *b;
                *a = sum;
                *b = difference;
            }
        }
    }
}

/* The mean energy of half-planes by the last digits of the waves along x and y, spread evenly over
 * the waves of a class, as random scrambles do. */
static void measure_energy(void) {
    enum { LOG = 7, SIZE = 1 << LOG };
    static float image[SIZE * SIZE];
    static double classes[DIGITS + 1][DIGITS + 1];
    for (int plane = 0; plane < PLANES; ++plane) {
        double angle = 6.283185307179586 * random_unit(), a = cos(angle), b = sin(angle);
        double c = a * random_unit() + b * random_unit();
        for (uint32_t i = 0; i < SIZE * SIZE; ++i) {
            image[i] = a * (i % SIZE + 0.5) / SIZE + b * (i / SIZE + 0.5) / SIZE > c;
        }
        transform(image, SIZE, 1, SIZE);
        transform(image, SIZE, SIZE, 1);
        for (uint32_t i = 1; i < SIZE * SIZE; ++i) {
            double v = (double)image[i] / (SIZE * SIZE);
            /* Positions have their first digit in bit LOG - 1. */
            classes[last_digit(i % SIZE << 1)][last_digit(i / SIZE << 1)] += v * v / PLANES;
        }
    }
    for (uint32_t x = 0; x < VALUES; x += 2) {
        for (uint32_t y = 0; y < VALUES; y += 2) {
            uint32_t cx = last_digit(x), cy = last_digit(y);
            uint32_t wave = x ^ transposed(&second_coordinate, y);
            double waves = (cx ? 1u << (cx - 1) : 1u) * (cy ? 1u << (cy - 1) : 1u);
            for (uint32_t m = 1; (x | y) != 0 && m <= DIGITS; ++m) {
                energy[m][wave >> (DIGITS - m)] += classes[cx][cy] / waves;
            }
        }
    }
}

/* variance[m]: of the products of two pairs in this relation, relative to unrelated orders. */
static void measure_relation(const map *relation, double variance[DIGITS + 1]) {
    uint8_t waves[VALUES];
    for (uint32_t v = 0; v < VALUES; ++v) {
        uint32_t lowest = v & (0u - v);
        waves[v] = lowest == v ? transposed(relation, v) : waves[v ^ lowest] ^ waves[lowest];
    }
    for (uint32_t m = 1; m <= DIGITS; ++m) {
        double sum = 0.0, total = 0.0;
        for (uint32_t v = 0; v < 1u << m; ++v) {
            sum += energy[m][waves[v << (DIGITS - m)] >> (DIGITS - m)] * energy[m][v];
            total += energy[m][v];
        }
        variance[m] = sum * (1u << m) / (total * total);
    }
}

static double cost_of_relation(const map *relation) {
    static const double weights[DIGITS + 1] = {0, 0, 0.4, 0.8, 1, 1, 1.2, 1, 1};
    double variance[DIGITS + 1], cost = 0.0;
    measure_relation(relation, variance);
    for (uint32_t m = 2; m <= DIGITS; ++m) {
        cost += weights[m] * (variance[m] + 0.35 * log(variance[m]) + fmax(variance[m] - 1.2, 0.0));
    }
    return cost;
}

/* ---- Families ---- */

/* What the first digits of dimension d of a member are made of: a set of digits of the index for
 * each of three. */
static void first_digits(const map *member, uint32_t d, int which, uint8_t digits[3]) {
    map all = d >= 2 ? compose(&second_pair[which], member) : *member;
    if (d & 1u) all = compose(&second_coordinate, &all);
    for (uint32_t k = 0; k < 3; ++k) digits[k] = transposed(&all, digit(k));
}

/* Digits that two dimensions share correlate them: by 0.75 for the first of both, by a half less
 * for each further. */
static double cost_of_correlation(const map *a, const map *b) {
    double cost = 0.0;
    for (int which = 0; which < 2; ++which) {
        uint8_t digits[2][4][3];
        for (uint32_t d = 0; d < 4; ++d) {
            first_digits(a, d, which, digits[0][d]);
            first_digits(b, d, which, digits[1][d]);
        }
        for (uint32_t pair = 0; pair < 16; ++pair) {
            for (uint32_t k = 0; k < 3; ++k) {
                for (uint32_t l = 0; k + l < 3; ++l) {
                    uint32_t differ = digits[0][pair & 3u][k] ^ digits[1][pair >> 2][l];
                    for (uint32_t m = 4; m <= DIGITS && differ >> (DIGITS - m) == 0; ++m) {
                        double share = m == 4 ? 0.02 : k + l == 0 ? 10.0 : 0.25;
                        cost += 0.5 * share * pow(0.25, k + l) * (1u << m) / 32.0;
                    }
                }
            }
        }
    }
    return cost;
}

/* Two members: their first pairs, and the first of one with the second of the other. The first
 * members count more: the first decisions of a path. */
static double cost_of_members(const map members[MEMBERS], int a, int b) {
    map back = inverse(&members[a]), relation = compose(&back, &members[b]);
    double weight = 1.0 / ((1.0 + 0.3 * (b - a - 1)) * (1.0 + 0.2 * a));
    double cost = 3.0 * cost_of_relation(&relation);
    for (int which = 0; which < 2; ++which) {
        map unpair = inverse(&second_pair[which]);
        relation = compose(&second_pair[which], &members[b]);
        relation = compose(&back, &relation);
        cost += (a == 0 ? 0.3 : 0.2) * cost_of_relation(&relation);
        relation = compose(&unpair, &members[b]);
        relation = compose(&back, &relation);
        cost += (a == 0 ? 0.5 : 0.2) * cost_of_relation(&relation);
    }
    return weight * cost + cost_of_correlation(&members[a], &members[b]);
}

static double cost_of_member(const map members[MEMBERS], int m) {
    double cost = 0.0;
    for (int other = 0; other < MEMBERS; ++other) {
        if (other < m) cost += cost_of_members(members, other, m);
        if (other > m) cost += cost_of_members(members, m, other);
    }
    return cost;
}

static void change(map *member) {
    uint32_t k = 1 + random_u32() % (DIGITS - 1);
    member->image[k] ^= digit(random_u32() % k);
}

/* Annealing; the first member keeps the order of the point set. */
static double search(map members[MEMBERS], long steps, int restart, time_t start) {
    double total = 0.0;
    for (int m = 0; m < MEMBERS; ++m) {
        for (uint32_t k = 0; k < DIGITS; ++k) {
            uint32_t earlier = m == 0 ? 0u : random_u32() & (0u - 2u * digit(k)) & 255u;
            members[m].image[k] = (uint8_t)(digit(k) | earlier);
        }
    }
    for (int m = 1; m < MEMBERS; ++m) {
        for (int other = 0; other < m; ++other) total += cost_of_members(members, other, m);
    }
    for (long step = 0; step < steps; ++step) {
        double temperature = 3.0 * pow(0.01, (double)step / (double)steps);
        int m = 1 + (int)(random_u32() % (MEMBERS - 1));
        map before = members[m];
        double cost = cost_of_member(members, m), difference;
        change(&members[m]);
        if (random_u32() % 3u == 0) change(&members[m]);
        difference = cost_of_member(members, m) - cost;
        if (difference < 0.0 || random_unit() < exp(-difference / temperature)) {
            total += difference;
        } else {
            members[m] = before;
        }
        if (step % 1024 == 0 && isatty(2)) {
            double share = (restart + (double)step / (double)steps) / RESTARTS;
            fprintf(stderr, "\r%3.0f %%, cost %.2f, %.0f s left ", 100.0 * share, total,
                    (double)(time(NULL) - start) * (1.0 / fmax(share, 1e-3) - 1.0));
        }
    }
    return total;
}

static void print_relation(const char *name, int a, int b, const map *relation) {
    double variance[DIGITS + 1];
    measure_relation(relation, variance);
    printf("%s %d %d:", name, a, b);
    for (uint32_t m = 1; m <= DIGITS; ++m) printf(" %.3f", sqrt(variance[m]));
    printf("\n");
}

static void print_members(const map members[MEMBERS]) {
    for (int m = 0; m < MEMBERS; ++m) {
        const uint8_t *i = members[m].image;
        printf("{0x%02x%02x%02x%02xu, 0x%02x%02x%02x%02xu},\n", i[3], i[2], i[1], i[0], i[7], i[6],
               i[5], i[4]);
    }
    for (int which = 0; which < 2; ++which) {
        print_relation("both pairs of a domain, form", which, 0, &second_pair[which]);
    }
    for (int a = 0; a < MEMBERS; ++a) {
        for (int b = a + 1; b < MEMBERS; ++b) {
            map back = inverse(&members[a]), relation = compose(&back, &members[b]);
            print_relation("first pairs of members", a, b, &relation);
        }
    }
}

int main(int argc, char **argv) {
    map members[MEMBERS], best[MEMBERS] = {{{0}}};
    double least = INFINITY;
    const time_t start = time(NULL);
    char *end = NULL;
    unsigned long seed = argc == 2 ? strtoul(argv[1], &end, 10) : 1;
    if (argc > 2 || (argc == 2 && (*argv[1] == '\0' || *end != '\0'))) {
        fprintf(stderr, "usage: bn_search_orders [SEED]\n");
        return 2;
    }
    state = seed;
    for (uint32_t k = 0; k < DIGITS; ++k) {
        uint32_t d = (uint32_t)digit(k) << 24;
        second_coordinate.image[k] = (uint8_t)(bn_sobol_second(d) >> 24);
        for (uint32_t which = 0; which < 2; ++which) {
            second_pair[which].image[k] = (uint8_t)(bn_draw_second_pair(d, which) >> 24);
        }
    }
    measure_energy();
    for (int restart = 0; restart < RESTARTS; ++restart) {
        double cost = search(members, STEPS / RESTARTS, restart, start);
        if (cost < least) {
            least = cost;
            memcpy(best, members, sizeof best);
        }
    }
    if (isatty(2)) fprintf(stderr, "\r%40s\r", "");
    printf("cost %.2f\n", least);
    print_members(best);
    return 0;
}
