/* SPDX-License-Identifier: Apache-2.0
 * The visible noise of an image, from the means of two halves of its samples.
 *
 * A display clips the image; the eye then averages light over a blur and responds roughly as the sRGB curve
 * does. Let A and B be the displayed halves after the blur, M their displayed mean, and e() the curve in 8-bit
 * steps. The error of M is a random part, estimated by half of e(A) - e(B), and a shift of the mean, because
 * clipping is not linear. Halving the samples increases the shift, and e(M) minus the mean of e(A) and e(B)
 * shows by how much.
 *
 * Each row is blurred once along x into a ring of rows, which the blur along y reads. In large images, only every
 * second row is measured, because the blur makes neighbouring rows nearly identical. The squared noise is pooled in
 * integers, so running sums are exact and results do not depend on where a thread starts. Time is proportional to
 * the number of values times the blur's width, for any pooling window. */
#include "base/assert.h"
#include "base/check.h"
#include "base/float_environment.h"
#include "base/memory.h"
#include "base/options.h"
#include "base/portable_math.h"
#include "base/threads.h"
#include <float.h>

enum {
    IMAGES = 3,         /* the first half, the second half and the mean */
    LANES = 16,         /* values blurred side by side, in registers */
    TILE_ROWS = 256,    /* a thread takes tiles of the map, whose rows fit in its cache */
    TILE_VALUES = 1536, /* in a row of a tile; at least TILE_COLUMNS pixels */
    TILE_COLUMNS = 128,
    SMALL = 64,         /* rows of an image whose rows are all measured */
    REPORT = 16,        /* rows between two calls of `progress` */
    MOST_TAPS = 48 + 1, /* distances from 0 to the reach of the widest blur */
    MOST_WINDOW = 1023
};

static const double BN_MOST_SIGMA = 16, BN_REACH = 3; /* the blur ends at 3 sigma */
static const double BN_ENERGY_SCALE = 1 << 24;        /* of a squared step, as an integer */

typedef struct meter {
    const float *image[2]; /* the halves */
    float *map;
    uint32_t width, height, channels;
    int32_t reach;            /* of the blur, in pixels */
    int32_t step;             /* every step-th row is measured */
    int32_t around;           /* of the pooling window, in pixels */
    float kernel[MOST_TAPS];  /* weights at distances 0 to reach */
    float exposure, share[2]; /* the halves' shares of the samples */
    float noise_scale;        /* standard error of the mean over that of the halves' difference */
    uint32_t tile_columns, tiles_across;
    size_t most_pixels; /* in a row of a tile, with the pixels around it that are pooled */
    size_t padded;      /* values in a row of a ring */
    bn_progress progress;
    void *progress_user;
    int cancelled;
    char *memory;       /* of all threads */
    size_t each_memory; /* of one thread, in bytes */
} meter;

/* The memory of a thread, and the tile that it works on. */
typedef struct scratch {
    float *source[IMAGES]; /* a row before the blur, with mirrored ends */
    float *ring[IMAGES];   /* the last 2 reach + 1 rows, blurred along x */
    float *blurred[IMAGES];
    uint64_t *energy;     /* the last 2 around + 1 rows of squared noise */
    uint64_t *columns;    /* their sum */
    uint32_t left, right; /* the tile's columns of the map */
    uint32_t from, to;    /* the columns that are pooled for them */
} scratch;

/* The pixel that stands for one outside the image: the image repeats, mirrored. */
static uint32_t mirrored(int64_t at, uint32_t extent) {
    const int64_t end = extent;
    while (at < 0 || at >= end) at = at < 0 ? -1 - at : 2 * end - 1 - at;
    return (uint32_t)at;
}

static float displayed(float value) { /* NaN, from an infinity minus another, counts as black */
    const float positive = value > 0 ? value : 0;
    return positive < 1 ? positive : 1;
}

/* The sRGB curve for v in [0, 1], in steps of an 8-bit display. Above the linear part, a polynomial of the
 * fourth root, interpolated at Chebyshev nodes; it is off by at most 0.0006 steps. Has no branches, so that
 * compilers vectorise its loop. */
static float encoded(float v) {
    const float q = sqrtf(sqrtf(v)), line = v * (255 * 12.92f);
    float curve = 15.742248f;
    curve = curve * q - 75.033147f;
    curve = curve * q + 158.35558f;
    curve = curve * q - 210.44640f;
    curve = curve * q + 345.41603f;
    curve = curve * q + 36.199357f;
    curve = curve * q - 15.233448f;
    return v <= 0.0031308f ? line : curve;
}

/* Blurs a multiple of LANES values. before[j] and after[j] are at distance j; both are at 0 for j = 0. */
static void blur(const meter *m, const float *const *before, const float *const *after, float *to,
                 size_t count) {
    for (size_t i = 0; i < count; i += LANES) {
        float sum[LANES];
        const float *centre = before[0] + i;
        for (int lane = 0; lane < LANES; ++lane) sum[lane] = m->kernel[0] * centre[lane];
        for (int32_t j = 1; j <= m->reach; ++j) {
            const float weight = m->kernel[j], *a = before[j] + i, *b = after[j] + i;
            for (int lane = 0; lane < LANES; ++lane) sum[lane] += weight * (a[lane] + b[lane]);
        }
        for (int lane = 0; lane < LANES; ++lane) to[i + (size_t)lane] = sum[lane];
    }
}

/* The halves and their mean as displayed. */
static void display(const meter *m, const float *first, const float *second, float *restrict a,
                    float *restrict b, float *restrict mean, size_t count) {
    const float exposure = m->exposure, share = m->share[0], rest = m->share[1];
    for (size_t i = 0; i < count; ++i) {
        const float one = first[i] * exposure, other = second[i] * exposure;
        a[i] = displayed(one);
        b[i] = displayed(other);
        mean[i] = displayed(share * one + rest * other);
    }
}

/* Squared noise, from the blurred images, in place of the first. */
static void square(const meter *m, float *restrict a, const float *restrict b,
                   const float *restrict mean, size_t count) {
    const float scale = m->noise_scale, share = m->share[0], rest = m->share[1];
    for (size_t i = 0; i < count; ++i) {
        const float one = encoded(a[i]), other = encoded(b[i]);
        const float noise = scale * (one - other);
        const float shift = encoded(mean[i]) - (share * one + rest * other);
        a[i] = noise * noise + shift * shift;
    }
}

/* Blurs row y of the displayed images along x into the rings. */
static void blur_row(const meter *m, const scratch *s, uint32_t y) {
    const size_t channels = m->channels, row = (size_t)y * m->width * channels;
    const int64_t from = s->from, to = s->to, width = m->width;
    const int64_t begin = from - m->reach, end = to + m->reach;
    /* All pixels inside the image at once, then those outside, one by one. */
    for (int64_t x = begin, next; x < end; x = next) {
        next = x < 0 || x >= width ? x + 1 : end < width ? end : width;
        const float *first = m->image[0] + row + mirrored(x, m->width) * channels;
        const float *second = m->image[1] + row + mirrored(x, m->width) * channels;
        const size_t at = (size_t)(x - begin) * channels, count = (size_t)(next - x) * channels;
        display(m, first, second, s->source[0] + at, s->source[1] + at, s->source[2] + at, count);
    }
    const size_t slot = y % (2 * (uint32_t)m->reach + 1);
    for (int k = 0; k < IMAGES; ++k) {
        const float *centre = s->source[k] + (size_t)m->reach * channels;
        const float *before[MOST_TAPS], *after[MOST_TAPS];
        for (int32_t j = 0; j <= m->reach; ++j) {
            before[j] = centre - (size_t)j * channels;
            after[j] = centre + (size_t)j * channels;
        }
        blur(m, before, after, s->ring[k] + slot * m->padded, m->padded);
    }
}

/* Computes row y of the squared noise from the rings. */
static void measure_row(const meter *m, const scratch *s, uint32_t y) {
    const uint32_t taps = 2 * (uint32_t)m->reach + 1;
    size_t above[MOST_TAPS], below[MOST_TAPS];
    for (int32_t j = 0; j <= m->reach; ++j) {
        above[j] = mirrored((int64_t)y - j, m->height) % taps * m->padded;
        below[j] = mirrored((int64_t)y + j, m->height) % taps * m->padded;
    }
    for (int k = 0; k < IMAGES; ++k) {
        const float *before[MOST_TAPS], *after[MOST_TAPS];
        for (int32_t j = 0; j <= m->reach; ++j) {
            before[j] = s->ring[k] + above[j];
            after[j] = s->ring[k] + below[j];
        }
        blur(m, before, after, s->blurred[k], m->padded);
    }
    const size_t pixels = s->to - s->from;
    BN_ASSERT(pixels <= m->most_pixels);
    float *a = s->blurred[0];
    square(m, a, s->blurred[1], s->blurred[2], pixels * m->channels);
    uint64_t *energy = s->energy + y % (2 * (uint32_t)m->around + 1) * m->most_pixels;
    const double scale = BN_ENERGY_SCALE / m->channels;
    for (size_t x = 0; x < pixels; ++x) {
        double sum = 0;
        for (size_t c = 0; c < m->channels; ++c) sum += (double)a[x * m->channels + c];
        BN_ASSERT(sum * scale <
                  0x1p43); /* a window has less than 2^20 pixels, whose sum has a sign */
        energy[x] = (uint64_t)(int64_t)(sum * scale); /* converts faster than without a sign */
        s->columns[x] += energy[x];
    }
}

/* Removes row y, which is still in the ring, from the sum over the window's rows. */
static void drop_row(const meter *m, const scratch *s, uint32_t y) {
    const uint64_t *energy = s->energy + y % (2 * (uint32_t)m->around + 1) * m->most_pixels;
    for (size_t x = 0; x < s->to - s->from; ++x) {
        BN_ASSERT(s->columns[x] >= energy[x]);
        s->columns[x] -= energy[x];
    }
}

/* Writes a row of the map: the root mean square over the part of the window inside the image. */
static void pool_row(const meter *m, const scratch *s, uint32_t y, uint32_t rows) {
    const int64_t around = m->around, from = s->from, to = s->to;
    uint64_t sum = 0;
    int64_t left = from, right = from; /* of the window, half-open */
    for (int64_t x = s->left; x < s->right; ++x) {
        for (; right < to && right <= x + around; ++right) sum += s->columns[right - from];
        for (; left < x - around; ++left) sum -= s->columns[left - from];
        BN_ASSERT(left < right && rows > 0 && sum <= INT64_MAX);
        const double pixels = (double)(right - left) * rows;
        m->map[(size_t)y * m->width + (size_t)x] =
            (float)sqrt((double)(int64_t)sum / (pixels * BN_ENERGY_SCALE));
    }
}

/* The row of the image nearest to y. */
static int32_t clamped_row(const meter *m, int64_t y) {
    return (int32_t)(y < 0 ? 0 : y < m->height ? y : m->height - 1);
}

/* Computes a tile of the map, row by row. Returns 0 if cancelled; only member 0 can be. */
static int measure_tile(const meter *m, scratch *s, uint32_t index, uint32_t tile, uint32_t tiles) {
    const uint32_t first = tile / m->tiles_across * TILE_ROWS, around = (uint32_t)m->around;
    const uint32_t last = m->height - first < TILE_ROWS ? m->height : first + TILE_ROWS;
    s->left = tile % m->tiles_across * m->tile_columns;
    s->right = m->width - s->left < m->tile_columns ? m->width : s->left + m->tile_columns;
    s->from = s->left < around ? 0 : s->left - around;
    s->to = m->width - s->right < around ? m->width : s->right + around;
    int32_t top = clamped_row(m, (int64_t)first - m->around); /* of the window */
    uint32_t rows = 0;                                        /* measured in the window */
    /* The next rows to measure and to blur. The rings hold the rows that these still need. */
    int32_t next = top, next_blurred = clamped_row(m, (int64_t)top - m->reach);
    for (size_t x = 0; x < m->most_pixels; ++x) s->columns[x] = 0;
    for (uint32_t y = first; y < last; ++y) {
        const int32_t bottom = clamped_row(m, (int64_t)y + m->around);
        for (; top < (int64_t)y - m->around; ++top)
            if (top % m->step == 0) rows -= 1, drop_row(m, s, (uint32_t)top);
        for (; next <= bottom; ++next) {
            if (next % m->step != 0) continue;
            ++rows;
            const int32_t until = clamped_row(m, (int64_t)next + m->reach);
            for (; next_blurred <= until; ++next_blurred) blur_row(m, s, (uint32_t)next_blurred);
            measure_row(m, s, (uint32_t)next);
        }
        pool_row(m, s, y, rows);
        const double done = (tile + (double)(y - first) / (last - first)) / tiles;
        if (index == 0 && m->progress != NULL && (y - first) % REPORT == 0 &&
            m->progress(m->progress_user, done) != 0) {
            return 0;
        }
    }
    return 1;
}

/* Divides a thread's memory, and returns its size. */
static size_t scratch_divide(const meter *m, char *memory, scratch *s) {
    size_t used = 0;
    const size_t margin = 2 * (size_t)m->reach * m->channels;
    const size_t ring = 2 * (size_t)m->reach + 1, window = 2 * (size_t)m->around + 1;
    const size_t floats[3] = {m->padded + margin, ring * m->padded, m->padded};
    float **const to[3] = {s->source, s->ring, s->blurred};
    for (int part = 0; part < 3; ++part) {
        for (int k = 0; k < IMAGES; ++k) {
            to[part][k] = memory ? (float *)(void *)(memory + used) : NULL;
            used += (floats[part] * sizeof(float) + 63) / 64 * 64;
        }
    }
    s->energy = memory ? (uint64_t *)(void *)(memory + used) : NULL;
    s->columns = memory ? s->energy + window * m->most_pixels : NULL;
    return used + ((window + 1) * m->most_pixels * sizeof(uint64_t) + 63) / 64 * 64;
}

static void work(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    meter *m = user;
    scratch s;
    (void)threads;
    scratch_divide(m, m->memory + index * m->each_memory, &s);
    const uint32_t tiles = m->tiles_across * ((m->height - 1) / TILE_ROWS + 1);
    for (uint32_t tile; (tile = bn_team_next(team)) < tiles;) {
        if (!measure_tile(m, &s, index, tile, tiles)) {
            m->cancelled = 1; /* member 0 is the caller's thread */
            bn_team_stop(team);
        }
    }
}

static BN_NOINLINE bn_result visible_noise(const bn_visible_noise_options *given,
                                           const float *first, const float *second, uint32_t width,
                                           uint32_t height, uint32_t channels, size_t count,
                                           float *map, size_t map_count, bn_progress progress,
                                           void *user) {
    bn_visible_noise_options o = bn_visible_noise_options_default();
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result != BN_SUCCESS) return result;
    if (first == NULL || second == NULL || map == NULL || width == 0 || height == 0 ||
        channels == 0 || !bn_in_range(o.sigma, 0, BN_MOST_SIGMA) ||
        !bn_in_range(o.exposure, 1e-30, 1e30) || !bn_in_range(o.first_share, 0.001, 0.999) ||
        o.window % 2 == 0 || o.window > MOST_WINDOW) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    const uint32_t extents[4] = {width, height, channels, 1}, flat[4] = {width, height, 1, 1};
    uint64_t product, pixels;
    if (!bn_product(extents, SIZE_MAX / sizeof *first, &product) ||
        !bn_product(flat, BN_MOST_TEXELS, &pixels) || channels > INT32_MAX / 4096) {
        return BN_ERROR_OUT_OF_MEMORY;
    }
    if (count != product || map_count != pixels) return BN_ERROR_SIZE_MISMATCH;
    if (bn_largest_bits(first, count) > BN_INFINITY_BITS ||
        bn_largest_bits(second, count) > BN_INFINITY_BITS) {
        return BN_ERROR_BAD_DATA;
    }

    meter m = {.image = {first, second},
               .map = map,
               .width = width,
               .height = height,
               .channels = channels,
               .reach = (int32_t)ceil(BN_REACH * o.sigma),
               .step = height > SMALL && o.sigma >= 1.5 && o.window >= 9 ? 2 : 1,
               .around = (int32_t)(o.window / 2),
               .exposure = (float)o.exposure,
               .share = {(float)o.first_share, (float)(1 - o.first_share)},
               .noise_scale = (float)sqrt(o.first_share * (1 - o.first_share)),
               .progress = progress,
               .progress_user = user};
    m.tile_columns = TILE_VALUES / channels > TILE_COLUMNS ? TILE_VALUES / channels : TILE_COLUMNS;
    if (m.tile_columns < 4 * (uint32_t)m.around) m.tile_columns = 4 * (uint32_t)m.around;
    m.tiles_across = (width - 1) / m.tile_columns + 1;
    m.most_pixels = (size_t)m.tile_columns + 2 * (size_t)m.around;
    if (m.most_pixels > width) m.most_pixels = width;
    m.padded = (m.most_pixels * channels + LANES - 1) / LANES * LANES;
    BN_ASSERT(m.reach + 1 <= MOST_TAPS);
    double weights[MOST_TAPS] = {1}, total = 1;
    for (int32_t j = 1; j <= m.reach; ++j) {
        const double exponent = -0.5 * j * j / (o.sigma * o.sigma);
        weights[j] = exponent < -700 ? 0 : bn_portable_exp(exponent);
        total += 2 * weights[j];
    }
    for (int32_t j = 0; j <= m.reach; ++j) m.kernel[j] = (float)(weights[j] / total);

    uint32_t threads = bn_team_threads(o.threads);
    const uint32_t tiles = m.tiles_across * ((height - 1) / TILE_ROWS + 1);
    if (threads > tiles) threads = tiles;
    /* Asks at least once, because other threads might take all the tiles. */
    if (progress != NULL && progress(user, 0) != 0) return BN_ERROR_CANCELLED;
    scratch unused;
    m.each_memory = scratch_divide(&m, NULL, &unused);
    m.memory = bn_allocate_zero(threads, m.each_memory);
    if (m.memory == NULL) return BN_ERROR_OUT_OF_MEMORY;
    bn_team_run(threads, work, &m);
    bn_free(m.memory);
    return m.cancelled ? BN_ERROR_CANCELLED : BN_SUCCESS;
}

bn_result bn_visible_noise(const bn_visible_noise_options *options, const float *first,
                           const float *second, uint32_t width, uint32_t height, uint32_t channels,
                           size_t count, float *map, size_t map_count, bn_progress progress,
                           void *user) {
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(visible_noise(options, first, second, width, height, channels,
                                                   count, map, map_count, progress, user));
}
