/* SPDX-License-Identifier: Apache-2.0
 * Masks and windows from a neural network, based on Giunchi, Sztrajman and Steed, "Fast Blue-Noise
 * Generation via Unsupervised Learning", 2022, but with one local network for all sizes.
 *
 * The network turns white noise into blue noise. Each output texel depends on the noise within `radius`
 * texels, so an image can be computed in tiles. The noise of a tile and its margin is a hash of the
 * coordinates (wrapped around for a mask but not for a window), so the tiles fit together seamlessly.
 * Each thread takes the next tile when it becomes free. Tiling bounds memory and does not change
 * results. The cost is that of running the network, margins included, and of ranking for a mask. */
#include "base/assert.h"
#include "base/check.h"
#include "base/float_environment.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/options.h"
#include "base/threads.h"
#include "masks/eliminate.h"
#include "neural/files.h"
#include "neural/model.h"
#include "neural/onnxruntime.h"
#include <bn/neural.h>
#include <string.h>

enum {
    /* The largest tiles have as many texels as a square of this extent. Measurements show that larger
     * tiles fall out of the cache. */
    BN_TILE_EXTENT = 256,
    BN_GPU_TILE_EXTENT = 1024,      /* only large tiles keep a GPU busy */
    BN_GPU_THREADS = 4,             /* make noise and copy results while the GPU works */
    BN_TILES_MOST_TEXELS = 1 << 21, /* in all threads' tiles: bounds memory */
    BN_TILE_LEAST_EXTENT = 32,
    BN_TILE_COST = 1 << 9 /* starting a tile takes as long as this many texels */
};
static const int64_t BN_WINDOW_FARTHEST = (int64_t)1 << 40;
static const int64_t BN_NOISE_FARTHEST = (int64_t)1 << 41; /* so that windows can have margins */

#if BN_BUILTIN_NETWORK
extern const uint8_t bn_data_neural[];
extern const size_t bn_data_neural_count;
extern const uint8_t bn_data_neural_vector[];
extern const size_t bn_data_neural_vector_count;
#endif

struct bn_neural { /* not changed once opened, so threads share it */
    bn_runtime *runtime;
    bn_model model;
    uint32_t threads; /* for each image */
    bn_provider provider;
};

/* ---- Noise */

static uint64_t noise_row(uint64_t seed, int64_t y) {
    return bn_mix64(bn_mix64(seed + 0x9e3779b97f4a7c15u) ^ (uint64_t)y);
}

static float noise_at(uint64_t row, int64_t x) {
    return (float)(bn_mix64(row ^ (uint64_t)x) >> 40) * 0x1p-24f;
}

static int64_t positive_remainder(int64_t value, int64_t divisor) {
    const int64_t remainder = value % divisor;
    return remainder < 0 ? remainder + divisor : remainder;
}

/* Noise for width x height texels from (x0, y0) on. It repeats with the periods, unless they are 0. */
static void fill_noise(uint64_t seed, int64_t x0, int64_t y0, uint32_t width, uint32_t height,
                       uint32_t period_x, uint32_t period_y, float *noise) {
    for (uint32_t i = 0; i < height; ++i) {
        const int64_t y = period_y == 0 ? y0 + i : positive_remainder(y0 + i, period_y);
        const uint64_t row = noise_row(seed, y);
        int64_t x = period_x == 0 ? x0 : positive_remainder(x0, period_x);
        for (uint32_t j = 0; j < width; ++j) {
            noise[(size_t)i * width + j] = noise_at(row, x);
            if (++x == period_x && period_x != 0) x = 0;
        }
    }
}

static int good_range(int64_t first, uint32_t extent, int64_t farthest) {
    return first >= -farthest && first <= farthest - (int64_t)extent;
}

bn_result bn_neural_noise(int64_t x0, int64_t y0, uint32_t width, uint32_t height, uint64_t seed,
                          float *noise, size_t count) {
    const uint32_t extents[4] = {width, height, 1, 1};
    uint64_t product;
    if (noise == NULL || width == 0 || height == 0 || !good_range(x0, width, BN_NOISE_FARTHEST) ||
        !good_range(y0, height, BN_NOISE_FARTHEST)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    if (!bn_product(extents, SIZE_MAX / sizeof *noise, &product)) return BN_ERROR_OUT_OF_MEMORY;
    if (count != product) return BN_ERROR_SIZE_MISMATCH;
    fill_noise(seed, x0, y0, width, height, 0, 0, noise);
    return BN_SUCCESS;
}

/* ---- Opening */

/* Runs the model once on a small input to check the radius and alignment it declares. */
static bn_result try_model(const bn_neural *n) {
    const uint32_t align = n->model.align, extent = (16 + align - 1) / align * align;
    const uint32_t outer = extent + 2 * n->model.radius;
    const size_t count = (size_t)n->model.channels * extent * extent;
    float *noise = bn_allocate((size_t)outer * outer, sizeof *noise);
    float *values = bn_allocate(count, sizeof *values);
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    if (noise != NULL && values != NULL) {
        const bn_tensor input = {noise, 1, outer, outer};
        const bn_tensor output = {values, n->model.channels, extent, extent};
        fill_noise(0, 0, 0, outer, outer, 0, 0, noise);
        result = bn_runtime_run(n->runtime, &input, n->model.output, &output);
        /* A CPU can run every valid model; a GPU may fail. */
        if (result != BN_SUCCESS && n->provider == BN_PROVIDER_CPU) result = BN_ERROR_BAD_DATA;
        if (result == BN_SUCCESS && bn_largest_bits(values, count) >= BN_INFINITY_BITS) {
            result = BN_ERROR_BAD_DATA;
        }
    }
    bn_free(noise);
    bn_free(values);
    return result;
}

static bn_result open_model(bn_neural *n, const bn_neural_options *o) {
    const void *bytes = o->model;
    size_t size = o->model_size;
    unsigned char *from_file = NULL;
    bn_result result = BN_SUCCESS;
    if (o->model_path != NULL) {
        result = bn_file_read(o->model_path, BN_MODEL_MOST_BYTES, &from_file, &size);
        if (result != BN_SUCCESS) return result;
        bytes = from_file;
    } else if (bytes == NULL) {
#if BN_BUILTIN_NETWORK
        bytes = o->channels == 2 ? bn_data_neural_vector : bn_data_neural;
        size = o->channels == 2 ? bn_data_neural_vector_count : bn_data_neural_count;
#else
        return BN_ERROR_UNSUPPORTED;
#endif
    }
    if (size > BN_MODEL_MOST_BYTES) result = BN_ERROR_BAD_DATA;
    if (result == BN_SUCCESS) {
        result = bn_runtime_open(o->runtime_path, n->provider, bytes, size, &n->runtime);
    }
    if (result == BN_SUCCESS) result = bn_model_read(n->runtime, &n->model);
    if (result == BN_SUCCESS && o->channels != 0 && o->channels != n->model.channels) {
        result = BN_ERROR_INVALID_ARGUMENT;
    }
    if (result == BN_SUCCESS) result = try_model(n);
    bn_free(from_file);
    return result;
}

/* Whether there is a provider of that name. */
static int read_provider(const char *name, bn_provider *provider) {
    const int cuda = name != NULL && strcmp(name, "cuda") == 0;
    *provider = cuda ? BN_PROVIDER_CUDA : BN_PROVIDER_CPU;
    return cuda || name == NULL || strcmp(name, "cpu") == 0;
}

bn_result bn_neural_open(const bn_neural_options *given, bn_neural **neural) {
    bn_neural_options o = bn_neural_options_default();
    bn_provider provider;
    if (neural == NULL) return BN_ERROR_INVALID_ARGUMENT;
    *neural = NULL;
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result != BN_SUCCESS) return result;
    if ((o.model == NULL) != (o.model_size == 0) || (o.model != NULL && o.model_path != NULL) ||
        (o.model_path != NULL && *o.model_path == 0) ||
        (o.runtime_path != NULL && *o.runtime_path == 0) || !read_provider(o.provider, &provider) ||
        (o.model == NULL && o.model_path == NULL && o.channels > 2)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    bn_neural *n = bn_allocate_zero(1, sizeof *n);
    if (n == NULL) return BN_ERROR_OUT_OF_MEMORY;
    n->provider = provider;
    n->threads = bn_team_threads(o.threads);
    if (o.threads == 0 && provider != BN_PROVIDER_CPU && n->threads > BN_GPU_THREADS) {
        n->threads = BN_GPU_THREADS;
    }
    result = open_model(n, &o);
    if (result != BN_SUCCESS) {
        bn_neural_close(n);
        return result;
    }
    *neural = n;
    return BN_SUCCESS;
}

void bn_neural_close(bn_neural *n) {
    if (n == NULL) return;
    bn_runtime_close(n->runtime);
    bn_free(n);
}

uint32_t bn_neural_channels(const bn_neural *n) {
    return n != NULL ? n->model.channels : 0;
}

/* ---- Images in tiles */

typedef struct image {
    const bn_neural *neural;
    bn_progress progress; /* or NULL */
    void *progress_user;
    uint64_t seed;
    int64_t x0, y0;              /* the first texel */
    uint32_t width, height;      /* size of `values`, per channel */
    uint32_t period_x, period_y; /* the noise's periods; 0 for none */
    int window;                  /* make values uniform in [0, 1) */
    float *values;
    uint64_t area_width, area_height; /* covered by tiles; starts at an aligned texel */
    uint32_t tile_width, tile_height, columns, rows; /* of tiles; the last ones overlap others */
    bn_result results[BN_TEAM_MOST];
} image;

static uint64_t round_up(uint64_t value, uint64_t to) {
    return (value + to - 1) / to * to;
}

/* The next number of tiles to try along an axis: all small numbers, then steps of about 1/16. */
static uint64_t next_division(uint64_t division) {
    return division + 1 + division / 16;
}

/* Chooses the tile size that minimises the total time of all threads.
 *
 * All tiles have the same size, so the total time is the time of one tile times the number of rounds
 * (the tiles per thread, rounded up). Small tiles waste work on margins: the first layers compute the
 * full margin of `radius` texels on every side and the last ones none, which averages radius / 2. So a
 * tile of w x h texels costs about (w + radius) * (h + radius), plus a fixed cost to start it. Large
 * tiles leave threads idle in the last round and fall out of the cache. The loops estimate the cost of
 * dividing the area into `across` x `down` tiles, from one tile to tiles of the smallest extent, and
 * keep the fastest division that fits the memory limits.
 *
 * A GPU runs tiles one after another, like a single thread. */
static void choose_tiles(image *m, uint32_t threads) {
    const bn_model *model = &m->neural->model;
    const uint64_t width = m->area_width, height = m->area_height;
    const uint64_t smallest = round_up(BN_TILE_LEAST_EXTENT, model->align);
    uint64_t most = BN_TILE_EXTENT * BN_TILE_EXTENT, least_time = UINT64_MAX;
    if (m->neural->provider != BN_PROVIDER_CPU) {
        most = BN_GPU_TILE_EXTENT * BN_GPU_TILE_EXTENT;
        threads = 1;
    } else if (most > BN_TILES_MOST_TEXELS / threads) {
        most = BN_TILES_MOST_TEXELS / threads;
    }
    for (uint64_t across = 1;; across = next_division(across)) {
        const uint64_t w = round_up((width + across - 1) / across, model->align);
        const uint64_t columns = (width + w - 1) / w;
        for (uint64_t down = 1;; down = next_division(down)) {
            const uint64_t h = round_up((height + down - 1) / down, model->align);
            const uint64_t rows = (height + h - 1) / h;
            const uint64_t rounds = (rows * columns + threads - 1) / threads;
            const uint64_t time =
                rounds * ((w + model->radius) * (h + model->radius) + BN_TILE_COST);
            if (time < least_time && (w * h <= most || (w <= smallest && h <= smallest))) {
                least_time = time;
                m->tile_width = (uint32_t)w;
                m->tile_height = (uint32_t)h;
                m->columns = (uint32_t)columns;
                m->rows = (uint32_t)rows;
            }
            if (h <= smallest) break;
        }
        if (w <= smallest) break;
    }
}

_Static_assert(((BN_MODEL_QUANTILES - 1) & (BN_MODEL_QUANTILES - 2)) == 0,
               "bisection needs 2^n steps");

/* Converts an output to a window's value in [0, 1). If the model has quantiles, this is the
 * fraction of the network's outputs below it. */
static float window_value(const bn_model *model, float value) {
    if (model->has_quantiles) {
        const float *q = model->quantiles;
        uint32_t below = 0; /* the last quantile up to the value, except for the largest */
        for (uint32_t step = (BN_MODEL_QUANTILES - 1) / 2; step > 0; step /= 2) {
            if (q[below + step] <= value) below += step;
        }
        const float width = q[below + 1] - q[below];
        const float part = width > 0 ? (value - q[below]) / width : 0.5f;
        value = ((float)below + (part < 0 ? 0 : part > 1 ? 1 : part)) / (BN_MODEL_QUANTILES - 1);
    }
    return value < 0 ? 0 : value > 1 - 0x1p-24f ? 1 - 0x1p-24f : value;
}

/* Copies the part of a tile that lies in the image, starting at the tile's column first_x and row
 * first_y. Other tiles supply the texels before those. */
static bn_result keep(image *m, const float *tile, int64_t tile_x, int64_t tile_y, int64_t first_x,
                      int64_t first_y) {
    const size_t tile_count = (size_t)m->tile_width * m->tile_height;
    const uint32_t channels = m->neural->model.channels;
    if (bn_largest_bits(tile, tile_count * channels) >= BN_INFINITY_BITS) return BN_ERROR_BAD_DATA;
    for (uint32_t c = 0; c < channels; ++c) {
        for (int64_t i = first_y; i < m->tile_height; ++i) {
            const int64_t y = tile_y + i - m->y0;
            if (y < 0 || y >= m->height) continue;
            const int64_t outside = m->x0 - tile_x;
            const int64_t skipped = outside > first_x ? outside : first_x;
            const int64_t x = tile_x + skipped - m->x0;
            int64_t count = m->tile_width - skipped;
            if (count > m->width - x) count = m->width - x;
            if (count <= 0) continue;
            BN_ASSERT(x >= 0 && x + count <= m->width && skipped + count <= m->tile_width);
            const float *from = tile + c * tile_count + (size_t)i * m->tile_width + skipped;
            float *to = m->values + ((size_t)c * m->height + (size_t)y) * m->width + x;
            for (int64_t j = 0; j < count; ++j) {
                to[j] = m->window ? window_value(&m->neural->model, from[j]) : from[j];
            }
        }
    }
    return BN_SUCCESS;
}

static int cancelled(const image *m, double fraction) {
    return m->progress != NULL && m->progress(m->progress_user, fraction) != 0;
}

static void work(void *user, bn_team *team, uint32_t index, uint32_t size) {
    image *m = user;
    const bn_neural *n = m->neural;
    const uint32_t radius = n->model.radius;
    const uint32_t outer_width = m->tile_width + 2 * radius,
                   outer_height = m->tile_height + 2 * radius;
    const size_t tile_count = (size_t)n->model.channels * m->tile_width * m->tile_height;
    float *noise = bn_allocate((size_t)outer_width * outer_height, sizeof *noise);
    float *tile = bn_allocate(tile_count, sizeof *tile);
    bn_result result = noise != NULL && tile != NULL ? BN_SUCCESS : BN_ERROR_OUT_OF_MEMORY;
    const int64_t align = n->model.align;
    const int64_t left = m->x0 - positive_remainder(m->x0, align);
    const int64_t top = m->y0 - positive_remainder(m->y0, align);
    const uint32_t tiles = m->columns * m->rows;
    (void)size;
    while (result == BN_SUCCESS) {
        const uint32_t next = bn_team_next(team);
        if (next >= tiles) break;
        if (index == 0 && cancelled(m, (double)next / tiles)) {
            result = BN_ERROR_CANCELLED;
            break;
        }
        /* The last tiles overlap the ones before them, so that all have the same size. */
        const int64_t last_x = (int64_t)m->area_width - m->tile_width;
        const int64_t last_y = (int64_t)m->area_height - m->tile_height;
        const int64_t from_x = (int64_t)(next % m->columns) * m->tile_width;
        const int64_t from_y = (int64_t)(next / m->columns) * m->tile_height;
        const int64_t x = left + (from_x < last_x ? from_x : last_x);
        const int64_t y = top + (from_y < last_y ? from_y : last_y);
        BN_ASSERT(positive_remainder(x, align) == 0 && positive_remainder(y, align) == 0);
        const bn_tensor input = {noise, 1, outer_height, outer_width};
        const bn_tensor output = {tile, n->model.channels, m->tile_height, m->tile_width};
        fill_noise(m->seed, x - radius, y - radius, outer_width, outer_height, m->period_x,
                   m->period_y, noise);
        result = bn_runtime_run(n->runtime, &input, n->model.output, &output);
        if (result == BN_SUCCESS) result = keep(m, tile, x, y, left + from_x - x, top + from_y - y);
    }
    if (result != BN_SUCCESS) bn_team_stop(team);
    m->results[index] = result;
    bn_free(noise);
    bn_free(tile);
}

/* Fills m->values. The caller has set the fields of the image up to `values`. */
static bn_result fill_image(image *m) {
    const int64_t align = m->neural->model.align;
    uint32_t threads = m->neural->threads;
    m->area_width =
        round_up((uint64_t)positive_remainder(m->x0, align) + m->width, (uint64_t)align);
    m->area_height =
        round_up((uint64_t)positive_remainder(m->y0, align) + m->height, (uint64_t)align);
    choose_tiles(m, threads);
    BN_ASSERT((uint64_t)m->columns * m->tile_width >= m->area_width &&
              (uint64_t)m->rows * m->tile_height >= m->area_height);
    const uint64_t tiles = (uint64_t)m->columns * m->rows;
    if (threads > tiles) threads = (uint32_t)tiles;
    /* Checks at least once, because other threads might take all the tiles. */
    if (cancelled(m, 0)) return BN_ERROR_CANCELLED;
    bn_team_run(threads, work, m);
    for (uint32_t i = 0; i < threads; ++i) {
        if (m->results[i] != BN_SUCCESS) return m->results[i];
    }
    return BN_SUCCESS;
}

static BN_NOINLINE bn_result eliminate_ends(const bn_neural *n, uint32_t width, uint32_t height,
                                            uint64_t seed, uint32_t *ranks) {
    const uint32_t extent[3] = {width, height, 1};
    return bn_eliminate_ends(extent, n->model.sparse_spacing / 100.0, seed, n->threads, ranks,
                             (size_t)width * height, 1, NULL, NULL);
}

/* Orders the first and last ranks of a mask, whose points are too far apart for the network to space
 * them well. */
static bn_result order_ends(const bn_neural *n, uint32_t width, uint32_t height, uint64_t seed,
                            uint32_t *ranks) {
    if (n->model.sparse_spacing == 0) return BN_SUCCESS;
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(eliminate_ends(n, width, height, seed, ranks));
}

bn_result bn_neural_mask(const bn_neural *n, const bn_mask *mask, uint64_t seed,
                         bn_progress progress, void *progress_user) {
    size_t count;
    bn_result result = bn_check_new_mask(mask, &count);
    if (result != BN_SUCCESS) return result;
    if (n == NULL || mask->depth != 1 || mask->channels != n->model.channels)
        return BN_ERROR_INVALID_ARGUMENT;
    const uint32_t width = mask->width, height = mask->height, channels = mask->channels;
    const size_t texels = count / channels;
    float *values = bn_allocate(count, sizeof *values);
    /* On failure, the caller's ranks stay unchanged. */
    uint32_t *made = bn_allocate(count, sizeof *made);
    result = BN_ERROR_OUT_OF_MEMORY;
    if (values != NULL && made != NULL) {
        image m = {n, progress, progress_user, seed, .width = width, .height = height};
        m.values = values;
        m.period_x = width;
        m.period_y = height;
        result = fill_image(&m);
    }
    for (uint32_t c = 0; c < channels && result == BN_SUCCESS; ++c) {
        uint32_t *to = made + c * texels;
        result = bn_ranks_from_values(values + c * texels, texels, to);
        if (result == BN_SUCCESS) result = order_ends(n, width, height, seed, to);
    }
    if (result == BN_SUCCESS) bn_mask_write(mask, made, count);
    bn_free(values);
    bn_free(made);
    return result;
}

bn_result bn_neural_window(const bn_neural *n, int64_t x0, int64_t y0, uint32_t width,
                           uint32_t height, uint64_t seed, float *values, size_t count,
                           bn_progress progress, void *progress_user) {
    if (n == NULL || values == NULL || width == 0 || height == 0 ||
        !good_range(x0, width, BN_WINDOW_FARTHEST) || !good_range(y0, height, BN_WINDOW_FARTHEST)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    const bn_result result = bn_check_extents(width, height, 1, n->model.channels, count);
    if (result != BN_SUCCESS) return result;
    image m = {n, progress, progress_user, seed, .width = width, .height = height};
    m.values = values;
    m.x0 = x0;
    m.y0 = y0;
    m.window = 1;
    return fill_image(&m);
}
