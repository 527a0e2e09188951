/* SPDX-License-Identifier: Apache-2.0
 * Screen-space error of samplers, as CSV on standard output:
 *
 *     sampler,figure,spp,sigma,rmse
 *
 * An integrand has the same form in every pixel of a picture of 128 x 128 pixels. The image of
 * per-pixel errors at n samples is blurred with a Gaussian, and its RMSE taken inside a margin that
 * the blur does not reach over; with sigma "inf" it is the error of the whole picture's mean. A row is the mean over 48 integrands in each of 16 domains, which
 * take turns as members of their families and have a seed each. Figures:
 *
 *     half-planes-01, half-planes-23   half-planes in a pair of dimensions
 *     products                         half-planes in both pairs of a domain, multiplied
 *     siblings                         half-planes in two domains of a family, multiplied: all six
 *                                      relations and all pairs in turn
 *     families                         the same in domains of two families of one parent
 *     singles                          u < c for a number of its own, all four in turn, in domains with
 *                                      keys 4 k
 *     steps                            x < c, blurred along columns only, and y < c, blurred along
 *                                      rows, in (0,1) of domains with keys 4 k: edges of a picture
 *                                      that are parallel to its sides
 *     discs, smooth                    discs and Gaussian bumps in (0,1)
 *     smooth-products                  Gaussian bumps in both pairs of a domain, multiplied
 *
 * Steps are at irrational places: nets are exact at multiples of 1/16. One run of a sampler is
 * stopped at every count; zorder, which is made for one count, gets a run of its own for each.
 * sobol4d is the path tracer's. OpenQMC's samplers are measured too in builds with -DBN_OPENQMC=DIR. --samples writes what a
 * sampler draws in second members of 16 families instead, as float32 [16][128][128][SPP][4]
 * without a header. The protocol is that of Heitz and Belcour, "Distributing Monte Carlo Errors as
 * a Blue Noise in Screen Space by Permuting Pixel Seeds Between Frames", 2019, widened. */
#include <bn/bn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/pathtracer/sobol4d.h"
#include "bench_openqmc.h"

enum { SIZE = 128, PIXELS = SIZE * SIZE, MARGIN = 8, INTEGRANDS = 48, DOMAINS = 16, MEMBERS = 4 };
enum { KINDS = 6, SIGMAS = 4, MOST = 256, COUNTS = 14 };
static const double sigmas[SIGMAS] = {2.1, 1.0, 0.0, INFINITY};
static const uint32_t counts[COUNTS] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, MOST};

typedef enum figure {
    HALF_PLANES_01,
    HALF_PLANES_23,
    PRODUCTS,
    SIBLINGS,
    FAMILIES,
    SINGLES,
    STEPS,
    DISCS,
    SMOOTH,
    SMOOTH_PRODUCTS,
    FIGURES
} figure;
static const char *const figure_names[FIGURES] = {
    "half-planes-01", "half-planes-23", "products", "siblings", "families",
    "singles",        "steps",          "discs",    "smooth",   "smooth-products"};

/* ---- Integrands */

/* a x + b y < c; its mean over the unit square. */
typedef struct half_plane {
    float a, b, c;
    double mean;
} half_plane;

static double fraction(double v) {
    return v - floor(v);
}

static double clamp01(double v) {
    return v < 0.0 ? 0.0 : v > 1.0 ? 1.0 : v;
}

/* At evenly spread angles, through well-spread points; a second set at other ones. */
static half_plane half_plane_make(int domain, int k, int set) {
    enum { COLUMNS = 4096 };
    int turned = (k * (set == 0 ? 1 : 7) + 11 * set) % INTEGRANDS;
    double angle = 6.283185307179586 * (turned + 0.41) / INTEGRANDS, mean = 0.0;
    double a = cos(angle), b = sin(angle), point = k + INTEGRANDS * (domain + DOMAINS * set);
    double c = a * fraction(0.5 + 0.7548776662466927 * point) +
               b * fraction(0.5 + 0.5698402909980532 * point);
    for (int i = 0; i < COLUMNS; ++i) {
        double height = clamp01((c - a * (i + 0.5) / COLUMNS) / b);
        mean += (b > 0.0 ? height : 1.0 - height) / COLUMNS;
    }
    return (half_plane){(float)a, (float)b, (float)c, mean};
}

/* In x for even k, in y for odd k, at an irrational place. */
static half_plane step_make(int domain, int k) {
    double c = fraction(0.2 + 0.6180339887498949 * (k / 2 + INTEGRANDS / 2 * domain));
    return (half_plane){k % 2 == 0, k % 2 != 0, (float)c, c};
}

/* The integral of exp(-(x - centre)^2 / (2 sigma^2)) over [0, 1]. */
static double bump_mean(double centre, double sigma) {
    const double scale = sigma * sqrt(2.0);
    return sigma * sqrt(1.5707963267948966) * (erf((1.0 - centre) / scale) + erf(centre / scale));
}

/* (x - a)^2 + (y - b)^2 < c in discs, which lie within the square, and exp(-c ((x - a)^2 +
 * (y - b)^2)) in bumps. */
static half_plane round_make(figure what, int domain, int k) {
    const double point = k + INTEGRANDS * domain, u = fraction(0.5 + 0.7548776662466927 * point),
                 v = fraction(0.5 + 0.5698402909980532 * point);
    if (what == SMOOTH || what == SMOOTH_PRODUCTS) {
        const double sigma = 0.1 + 0.3 * (k + 0.5) / INTEGRANDS;
        return (half_plane){(float)u, (float)v, (float)(0.5 / (sigma * sigma)),
                            bump_mean(u, sigma) * bump_mean(v, sigma)};
    }
    const double r = 0.1 + 0.35 * (k + 0.5) / INTEGRANDS;
    return (half_plane){(float)(r + (1.0 - 2.0 * r) * u), (float)(r + (1.0 - 2.0 * r) * v),
                        (float)(r * r), 3.141592653589793 * r * r};
}

enum { ALONG_ROWS = 1, ALONG_COLUMNS = 2 };

/* Beside the members of a family: single numbers of its first one, and a member of another family. */
enum { SINGLE = MEMBERS, OTHER_FAMILY, DOMAINS_AT_ONCE };

/* One half-plane or what round_make() makes, or two half-planes multiplied; `at` is 4 times the
 * place among DOMAINS_AT_ONCE plus the first dimension. */
typedef struct integrand {
    figure what;
    half_plane first, second;
    int at[2];
    int product;
    int directions; /* of the blur */
    double mean;
} integrand;

static integrand integrand_make(figure what, int domain, int k) {
    static const int siblings[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    const int own = 4 * (domain % MEMBERS), pairs = k / 6 % 4;
    integrand f = {what,
                   half_plane_make(domain, k, 0),
                   half_plane_make(domain, k, 1),
                   {own, own + 2},
                   what == PRODUCTS || what == SIBLINGS || what == FAMILIES ||
                       what == SMOOTH_PRODUCTS,
                   ALONG_ROWS | ALONG_COLUMNS,
                   0.0};
    if (what == DISCS || what == SMOOTH || what == SMOOTH_PRODUCTS) {
        f.first = round_make(what, domain, k);
        f.second = round_make(what, domain, (k + INTEGRANDS / 3) % INTEGRANDS);
    } else if (what == STEPS) {
        f.first = step_make(domain, k);
        f.directions = k % 2 == 0 ? ALONG_COLUMNS : ALONG_ROWS;
        f.at[0] = 0;
    } else if (what == HALF_PLANES_23) {
        f.at[0] = own + 2;
    } else if (what == SINGLES) {
        f.first = step_make(domain, k);
        f.at[0] = 4 * SINGLE + 2 * (k / 2 % 2);
    } else if (what == FAMILIES) {
        f.at[0] = own + 2 * (pairs % 2);
        f.at[1] = 4 * OTHER_FAMILY + 2 * (pairs / 2);
    } else if (what == SIBLINGS) {
        f.at[0] = 4 * siblings[k % 6][0] + 2 * (pairs % 2);
        f.at[1] = 4 * siblings[k % 6][1] + 2 * (pairs / 2);
    }
    f.mean = f.first.mean * (f.product ? f.second.mean : 1.0);
    return f;
}

/* ---- Sources of samples */

typedef struct source {
    const char *name;
    int32_t kind;
    const bench_peer *peer; /* or null: libbn's sampler of this kind */
} source;

static void sobol4d_read_row(uint32_t seed, uint32_t parent, uint32_t key, int32_t y, int32_t width,
                             uint32_t count, float *out) {
    (void)parent; /* the key of its child is different for every parent here */
    for (int32_t x = 0; x < width; ++x) {
        for (uint32_t index = 0; index < count; ++index, out += 4)
            sobol4d_draw(seed, x, y, index, key, out);
    }
}

static const bench_peer sobol4d = {"sobol4d", NULL, sobol4d_read_row};

static int is_declared(const source *s) {
    return s->peer == NULL && s->kind == BN_SAMPLER_ZORDER;
}

static bn_sampler open_sampler(const source *s, int domain, uint32_t declared) {
    bn_sampler sampler;
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = s->peer == NULL ? s->kind : BN_SAMPLER_WHITE;
    options.seed = (uint64_t)domain + 1u;
    options.samples_per_pixel = declared;
    if (bn_sampler_init(&sampler, &options) != BN_SUCCESS) exit(1);
    return sampler;
}

/* A row of the picture, in a member of a domain's family or at another of DOMAINS_AT_ONCE:
 * [SIZE][count][4]. */
static void read_row(const source *s, const bn_sampler *sampler, int domain, int place, int row,
                     uint32_t count, float *out) {
    const int member = place < MEMBERS   ? place
                       : place == SINGLE ? 0
                                         : domain % MEMBERS + 4 * DOMAINS;
    const uint32_t parent = (uint32_t)domain + 1u, key = (uint32_t)(4 * domain + member);
    if (s->peer != NULL) {
        s->peer->read_row(parent, parent, key, row, SIZE, count, out);
    } else if (place == SINGLE) {
        const uint32_t own = bn_domain_child(bn_domain_child(BN_DOMAIN_ROOT, parent), key);
        for (uint32_t i = 0; i < SIZE * count; ++i) {
            const int32_t x = (int32_t)(i / count);
            bn_sample_pair(sampler, x, row, i % count, own, 2, out + 4 * (size_t)i);
            bn_sample_pair(sampler, x, row, i % count, own, 3, out + 4 * (size_t)i + 2);
        }
    } else if (bn_sample_block(sampler, 0, row, SIZE, 1, 0, count,
                               bn_domain_child(bn_domain_child(BN_DOMAIN_ROOT, parent), key), out,
                               (size_t)SIZE * count * 4) != BN_SUCCESS) {
        exit(1);
    }
}

static int write_samples(const source *s, uint32_t count) {
    size_t size = (size_t)SIZE * count * 4;
    float *samples = malloc(size * sizeof *samples);
    int ok = samples != NULL;
    for (int domain = 0; domain < DOMAINS && ok; ++domain) {
        const bn_sampler sampler = open_sampler(s, domain, is_declared(s) ? count : 0);
        for (int row = 0; row < SIZE && ok; ++row) {
            read_row(s, &sampler, domain, 1, row, count, samples);
            ok = fwrite(samples, sizeof *samples, size, stdout) == size;
        }
    }
    free(samples);
    return ok && fflush(stdout) == 0 ? 0 : 1;
}

/* ---- Errors */

static float images[INTEGRANDS][COUNTS][PIXELS];

static float squared_distance(float x, float y, const half_plane *g) {
    return (x - g->a) * (x - g->a) + (y - g->b) * (y - g->b);
}

/* The sum over the samples from `i` to `end`; u is [dimension][MOST]. */
static double sum_values(const integrand *f, float u[][MOST], uint32_t i, uint32_t end) {
    const float *x = u[f->at[0]], *y = u[f->at[0] + 1], *z = u[f->at[1]], *w = u[f->at[1] + 1];
    const half_plane g = f->first, h = f->second;
    uint32_t sum = 0;
    if (f->what == SMOOTH) {
        double bumps = 0.0;
        for (; i < end; ++i) bumps += expf(-g.c * squared_distance(x[i], y[i], &g));
        return bumps;
    }
    if (f->what == SMOOTH_PRODUCTS) {
        double bumps = 0.0;
        for (; i < end; ++i) {
            bumps += expf(-g.c * squared_distance(x[i], y[i], &g) -
                          h.c * squared_distance(z[i], w[i], &h));
        }
        return bumps;
    }
    if (f->what == DISCS) {
        for (; i < end; ++i) sum += (uint32_t)(squared_distance(x[i], y[i], &g) < g.c);
    } else if (f->product) {
        for (; i < end; ++i)
            sum += (uint32_t)((g.a * x[i] + g.b * y[i] < g.c) & (h.a * z[i] + h.b * w[i] < h.c));
    } else {
        for (; i < end; ++i) sum += (uint32_t)(g.a * x[i] + g.b * y[i] < g.c);
    }
    return sum;
}

/* The error images of one run at the counts number `first` to `end - 1`. */
static void make_images(const source *s, int domain, uint32_t declared, const integrand *f,
                        int first, int end) {
    static float row[DOMAINS_AT_ONCE][(size_t)SIZE * MOST * 4], u[4 * DOMAINS_AT_ONCE][MOST];
    const bn_sampler sampler = open_sampler(s, domain, declared);
    const uint32_t last = counts[end - 1];
    int used[DOMAINS_AT_ONCE] = {0};
    for (int k = 0; k < INTEGRANDS; ++k) {
        used[f[k].at[0] / 4] = 1;
        if (f[k].product) used[f[k].at[1] / 4] = 1;
    }
    for (int p = 0; p < PIXELS; ++p) {
        for (int m = 0; m < DOMAINS_AT_ONCE; ++m) {
            if (!used[m]) continue;
            if (p % SIZE == 0) read_row(s, &sampler, domain, m, p / SIZE, last, row[m]);
            const float *own = row[m] + (size_t)(p % SIZE) * last * 4;
            for (uint32_t i = 0; i < last; ++i) {
                for (int d = 0; d < 4; ++d) u[4 * m + d][i] = own[4 * i + (uint32_t)d];
            }
        }
        for (int k = 0; k < INTEGRANDS; ++k) {
            double sum = 0.0;
            uint32_t i = 0;
            for (int c = first; c < end; ++c) {
                sum += sum_values(&f[k], u, i, counts[c]);
                i = counts[c];
                images[k][c][p] = (float)(sum / i - f[k].mean);
            }
        }
    }
}

static double blurred_rmse(const float *errors, double sigma, int directions) {
    static float scratch[PIXELS];
    float kernel[MARGIN + 1], sums[SIZE];
    double total = 0.0, square = 0.0;
    if (isinf(sigma)) {
        for (int p = 0; p < PIXELS; ++p) total += errors[p];
        return fabs(total / PIXELS);
    }
    const int radius = sigma > 0.0 ? MARGIN : 0;
    const int across = directions & ALONG_ROWS ? radius : 0;
    const int down = directions & ALONG_COLUMNS ? radius : 0;
    for (int d = 0; d <= radius; ++d) {
        kernel[d] = sigma > 0.0 ? (float)exp(-d * d / (2.0 * sigma * sigma)) : 1.0f;
        total += d == 0 ? kernel[d] : 2.0 * kernel[d];
    }
    for (int d = 0; d <= radius; ++d) kernel[d] /= (float)total;
    const float middle_across = across > 0 ? kernel[0] : 1.0f;
    const float middle_down = down > 0 ? kernel[0] : 1.0f;
    for (int y = 0; y < SIZE; ++y) {
        const float *in = errors + y * SIZE;
        float *out = scratch + y * SIZE;
        for (int x = 0; x < SIZE; ++x) out[x] = middle_across * in[x];
        for (int d = 1; d <= across; ++d) {
            for (int x = MARGIN; x < SIZE - MARGIN; ++x)
                out[x] += kernel[d] * (in[x - d] + in[x + d]);
        }
    }
    for (int y = MARGIN; y < SIZE - MARGIN; ++y) {
        const float *in = scratch + y * SIZE;
        for (int x = 0; x < SIZE; ++x) sums[x] = middle_down * in[x];
        for (int d = 1; d <= down; ++d) {
            for (int x = 0; x < SIZE; ++x)
                sums[x] += kernel[d] * (in[x - d * SIZE] + in[x + d * SIZE]);
        }
        for (int x = MARGIN; x < SIZE - MARGIN; ++x) square += (double)sums[x] * sums[x];
    }
    return sqrt(square / ((SIZE - 2 * MARGIN) * (SIZE - 2 * MARGIN)));
}

/* Mean RMSE of a figure at the first n counts. */
static void measure(const source *s, figure what, int domains, int n, double rmse[COUNTS][SIGMAS]) {
    memset(rmse, 0, COUNTS * sizeof *rmse);
    for (int domain = 0; domain < domains; ++domain) {
        integrand f[INTEGRANDS];
        for (int k = 0; k < INTEGRANDS; ++k) f[k] = integrand_make(what, domain, k);
        if (is_declared(s)) {
            for (int c = 0; c < n; ++c) make_images(s, domain, counts[c], f, c, c + 1);
        } else {
            make_images(s, domain, 0, f, 0, n);
        }
        for (int k = 0; k < INTEGRANDS; ++k) {
            for (int c = 0; c < n; ++c) {
                for (int i = 0; i < SIGMAS; ++i) {
                    rmse[c][i] += blurred_rmse(images[k][c], sigmas[i], f[k].directions) /
                                  (INTEGRANDS * domains);
                }
            }
        }
    }
}

/* ---- The command line */

static const char usage[] = "usage: bench_samplers [--max-spp N] [--domains N] [--sampler NAME]\n"
                            "       bench_samplers --samples NAME SPP\n";

static int refuse(void) {
    fputs(usage, stderr);
    return 2;
}

int main(int argc, char **argv) {
    source known[KINDS + BENCH_PEERS] = {
        {"white", BN_SAMPLER_WHITE, NULL}, {"sobol", BN_SAMPLER_SOBOL, NULL},
        {"sobol4d", 0, &sobol4d},          {"zorder", BN_SAMPLER_ZORDER, NULL},
        {"mask", BN_SAMPLER_MASK, NULL},   {"blue", BN_SAMPLER_BLUE, NULL}};
    int known_count = KINDS, n = 0;
    unsigned long max_spp = MOST, domains = DOMAINS;
    const char *sampler = NULL;
    char *end = "";
    for (int i = 0; i < bench_peer_count; ++i)
        known[known_count++] = (source){bench_peers[i].name, 0, &bench_peers[i]};
    if (argc == 4 && strcmp(argv[1], "--samples") == 0) {
        unsigned long count = strtoul(argv[3], &end, 10);
        for (int i = 0; i < known_count && *end == '\0' && count > 0 && count <= 4096; ++i) {
            if (strcmp(argv[2], known[i].name) == 0)
                return write_samples(&known[i], (uint32_t)count);
        }
        return refuse();
    }
    for (int a = 1; a < argc; a += 2) {
        if (a + 1 == argc) return refuse();
        if (strcmp(argv[a], "--max-spp") == 0)
            max_spp = strtoul(argv[a + 1], &end, 10);
        else if (strcmp(argv[a], "--domains") == 0)
            domains = strtoul(argv[a + 1], &end, 10);
        else if (strcmp(argv[a], "--sampler") == 0)
            sampler = argv[a + 1];
        else
            return refuse();
        if (*end != '\0') return refuse();
    }
    while (n < COUNTS && counts[n] <= max_spp) ++n;
    if (n == 0 || domains == 0 || domains > DOMAINS) return refuse();

    printf("sampler,figure,spp,sigma,rmse\n");
    for (int s = 0; s < known_count; ++s) {
        for (int what = 0; what < FIGURES; ++what) {
            double rmse[COUNTS][SIGMAS];
            if (sampler != NULL && strcmp(sampler, known[s].name) != 0) continue;
            measure(&known[s], (figure)what, (int)domains, n, rmse);
            for (int c = 0; c < n; ++c) {
                for (int i = 0; i < SIGMAS; ++i) {
                    printf("%s,%s,%u,%.1f,%.6g\n", known[s].name, figure_names[what], counts[c],
                           sigmas[i], rmse[c][i]);
                }
            }
            fflush(stdout);
        }
    }
    return 0;
}
