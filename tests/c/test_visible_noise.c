/* SPDX-License-Identifier: Apache-2.0
 * Visible noise: its definition, known values, crops, threads, hard images, invalid input. */
#include "check.h"
#include "masks.h"
#include <math.h>
#include <stdlib.h>

enum { MOST = 64 * 48 * 3 };

static double shown(double v) {
    return v > 0 ? v < 1 ? v : 1 : 0;
}

static double curve(double v) {
    return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
}

static int inside(int at, int extent) {
    while (at < 0 || at >= extent) at = at < 0 ? -1 - at : 2 * extent - 1 - at;
    return at;
}

/* One value of an image after the blur, by direct summation. */
static double blurred(const double *image, int width, int height, int channels, int x, int y, int c,
                      double sigma) {
    const int reach = (int)ceil(3 * sigma);
    double sum = 0, total = 0;
    for (int j = -reach; j <= reach; ++j) {
        for (int i = -reach; i <= reach; ++i) {
            const double weight =
                i == 0 && j == 0 ? 1 : exp(-0.5 * (i * i + j * j) / (sigma * sigma));
            const int at = (inside(y + j, height) * width + inside(x + i, width)) * channels + c;
            sum += weight * image[at];
            total += weight;
        }
    }
    return sum / total;
}

/* The map by its definition, in double precision. */
static void expected(const bn_visible_noise_options *o, const float *first, const float *second,
                     int width, int height, int channels, double *map) {
    const int count = width * height * channels, around = (int)o->window / 2;
    const double share = o->first_share;
    double *a = malloc(5 * (size_t)count * sizeof *a), *b = a + count, *mean = b + count,
           *energy = mean + count;
    for (int i = 0; i < count; ++i) {
        const double one = first[i] * o->exposure, other = second[i] * o->exposure;
        a[i] = shown(one);
        b[i] = shown(other);
        mean[i] = shown(share * one + (1 - share) * other);
    }
    const int step = height > 64 && o->sigma >= 1.5 && o->window >= 9 ? 2 : 1;
    for (int p = 0; p < width * height; ++p) {
        energy[p] = 0;
        for (int c = 0; c < channels; ++c) {
            double v[3];
            const double *const images[3] = {a, b, mean};
            for (int k = 0; k < 3; ++k)
                v[k] = curve(
                    blurred(images[k], width, height, channels, p % width, p / width, c, o->sigma));
            const double noise = sqrt(share * (1 - share)) * (v[0] - v[1]);
            const double shift = v[2] - share * v[0] - (1 - share) * v[1];
            energy[p] += (noise * noise + shift * shift) / channels;
        }
    }
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            double sum = 0;
            int pixels = 0;
            for (int j = y - around; j <= y + around; ++j) {
                if (j % step != 0) continue;
                for (int i = x - around; i <= x + around; ++i)
                    if (i >= 0 && i < width && j >= 0 && j < height) {
                        sum += energy[j * width + i];
                        ++pixels;
                    }
            }
            map[y * width + x] = sqrt(sum / pixels);
        }
    }
    free(a);
}

/* Bright values, so that some clip, and negative ones. */
static void fill(float *values, int count, uint32_t seed) {
    for (int i = 0; i < count; ++i) {
        const float u = (float)(next_random(&seed) >> 8) * 0x1p-24f;
        values[i] = i % 17 == 0 ? 6 * u : i % 13 == 0 ? -u : 0.7f * u * u;
    }
}

static bn_result measure(const bn_visible_noise_options *o, const float *first, const float *second,
                         uint32_t width, uint32_t height, uint32_t channels, float *map) {
    return bn_visible_noise(o, first, second, width, height, channels,
                            (size_t)width * height * channels, map, (size_t)width * height, NULL,
                            NULL);
}

static void test_definition(void) {
    static const struct {
        int width, height, channels;
        double sigma, exposure, share;
        uint32_t window;
    } cases[] = {
        {31, 23, 3, 2.1, 1, 0.5, 33}, {31, 23, 1, 2.1, 0.3, 0.25, 5},
        {40, 7, 2, 3.3, 2, 0.5, 1},   {5, 3, 3, 2.1, 1, 0.5, 3}, /* narrower than the blur */
        {1, 1, 4, 16, 1, 0.5, 33},    {1, 37, 1, 1, 1, 0.7, 7},
        {64, 1, 5, 0.4, 1.7, 0.5, 9}, {20, 20, 3, 0, 1, 0.5, 1},    /* no blur */
        {33, 29, 1, 4, 1, 0.5, 1023}, {21, 80, 2, 2.1, 1, 0.5, 9},  /* every second row */
        {150, 2, 1, 2.1, 1, 0.5, 33}, {200, 3, 12, 2.1, 1, 0.5, 5}, /* several tiles */
        {2, 67, 3, 1.5, 1, 0.5, 301}, {3, 300, 2, 2.1, 1, 0.5, 11},
        {9, 8, 1, 0.02, 1, 0.5, 3},   {9, 8, 1, 1e-200, 1, 0.5, 3}};
    static float first[MOST], second[MOST], map[MOST];
    static double exact[MOST];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        const int width = cases[k].width, height = cases[k].height, channels = cases[k].channels;
        bn_visible_noise_options o = bn_visible_noise_options_default();
        o.sigma = cases[k].sigma;
        o.exposure = cases[k].exposure;
        o.first_share = cases[k].share;
        o.window = cases[k].window;
        fill(first, width * height * channels, 1 + (uint32_t)k);
        fill(second, width * height * channels, 100 + (uint32_t)k);
        CHECK(measure(&o, first, second, (uint32_t)width, (uint32_t)height, (uint32_t)channels,
                      map) == BN_SUCCESS);
        expected(&o, first, second, width, height, channels, exact);
        int wrong = 0; /* NaN counts */
        for (int p = 0; p < width * height; ++p)
            wrong += !(fabs((double)map[p] - exact[p]) < 0.002);
        CHECK(wrong == 0);
    }
}

/* White noise of a known amplitude: 255 e'(v) * deviation / (2 sqrt(pi) sigma) after the blur. The map is the
 * root mean square over 700 independent values, so its own deviation is 3%; six of them are allowed, a false
 * alarm of 1e-8. Alternating pixels are invisible. */
static void test_amplitude(void) {
    enum { size = 200 };
    static float first[size * size], second[size * size], map[size * size];
    const double deviation = 0.1, value = 0.4, slope = 255 * 1.055 / 2.4 * pow(value, 1 / 2.4 - 1);
    uint32_t state = 5;
    bn_visible_noise_options o = bn_visible_noise_options_default();
    o.window = 2 * size + 1;
    for (int half = 0; half < 2; ++half)
        for (int i = 0; i < size * size; ++i) {
            const double u = (double)(next_random(&state) >> 8) * 0x1p-24 - 0.5;
            (half ? second : first)[i] = (float)(value + sqrt(12 * 2) * deviation * u);
        }
    CHECK(measure(&o, first, second, size, size, 1, map) == BN_SUCCESS);
    const double right = slope * deviation / (2 * sqrt(3.14159265) * 2.1);
    CHECK(fabs((double)map[0] / right - 1) < 0.18);
    CHECK(map[0] == map[size * size - 1]);
    for (int i = 0; i < size * size; ++i) {
        first[i] = (i % size + i / size) % 2 ? 0.5f : 0.3f;
        second[i] = 0.8f - first[i];
    }
    CHECK(measure(&o, first, second, size, size, 1, map) == BN_SUCCESS);
    CHECK(map[0] < 0.05f);
}

/* Clipping: the mean of 2 and 0 is white, but the displayed halves are white and black. */
static void test_clipping(void) {
    const float first[2] = {2, 2}, second[2] = {0, 0}, black[2] = {0, -3}, white[2] = {1e30f, 5};
    const float most[2] = {INFINITY, INFINITY}, least[2] = {-INFINITY, -INFINITY};
    float map[2];
    CHECK(measure(NULL, first, second, 2, 1, 1, map) == BN_SUCCESS);
    CHECK(fabs((double)map[0] - sqrt(2) * 127.5) < 0.01);
    CHECK(measure(NULL, black, black, 2, 1, 1, map) == BN_SUCCESS && map[0] == 0 && map[1] == 0);
    CHECK(measure(NULL, white, white, 2, 1, 1, map) == BN_SUCCESS && map[0] == 0);
    CHECK(measure(NULL, most, most, 2, 1, 1, map) == BN_SUCCESS && map[0] == 0);
    CHECK(measure(NULL, most, least, 2, 1, 1, map) == BN_SUCCESS && isfinite(map[0]));
}

/* Any number of threads gives the same bits, and so does a crop, away from its edges. */
static void test_threads_and_crops(void) {
    enum { width = 90, height = 1100, left = 20, top = 101, part = 60, margin = 7 + 2 };
    static float first[width * height], second[width * height], map[width * height],
        other[width * height], a[part * part], b[part * part];
    bn_visible_noise_options o = bn_visible_noise_options_default();
    o.window = 5;
    fill(first, width * height, 7);
    fill(second, width * height, 8);
    for (uint32_t threads = 1; threads <= 70; threads = 3 * threads + 1) {
        watch w = {0};
        o.threads = threads;
        CHECK(bn_visible_noise(&o, first, second, width, height, 1, width * height, other,
                               width * height, watch_progress, &w) == BN_SUCCESS &&
              w.backwards == 0);
        CHECK(threads > 1 || w.calls >= 20);
        if (threads == 1) memcpy(map, other, sizeof map);
        CHECK(memcmp(map, other, sizeof map) == 0);
        /* The first call comes before any work, so no thread can be ahead of it. */
        w = (watch){.cancel_at = 1};
        other[0] = other[width * height - 1] = -1;
        CHECK(bn_visible_noise(&o, first, second, width, height, 1, width * height, other,
                               width * height, watch_progress, &w) == BN_ERROR_CANCELLED);
        CHECK(other[0] == -1 && other[width * height - 1] == -1);
    }
    for (int i = 0; i < part * part; ++i) {
        const int at = (top + i / part) * width + left + i % part;
        a[i] = first[at];
        b[i] = second[at];
    }
    CHECK(measure(&o, a, b, part, part, 1, other) == BN_SUCCESS);
    int differing = 0;
    for (int y = margin; y < part - margin; ++y)
        for (int x = margin; x < part - margin; ++x)
            differing += other[y * part + x] != map[(top + y) * width + left + x];
    CHECK(differing == 0);
    uint64_t hash = 0;
    for (int i = 0; i < width * height; ++i) {
        hash = (hash ^ bits_of(map[i])) * 0x100000001b3u;
    }

    CHECK(hash == 0xe67c569c73205cc3u);
}

static void test_bad_input(void) {
    float first[6] = {0, 0.5f, 1, 2, -1, 0.25f}, second[6] = {0}, map[2] = {7, 7};
    const float *const none = NULL;
    CHECK(bn_visible_noise(NULL, none, second, 1, 2, 3, 6, map, 2, NULL, NULL) ==
          BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_visible_noise(NULL, first, none, 1, 2, 3, 6, map, 2, NULL, NULL) ==
          BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_visible_noise(NULL, first, second, 1, 2, 3, 6, NULL, 2, NULL, NULL) ==
          BN_ERROR_INVALID_ARGUMENT);
    for (int zero = 0; zero < 3; ++zero)
        CHECK(bn_visible_noise(NULL, first, second, zero != 0, zero != 1, zero != 2, 0, map, 0,
                               NULL, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_visible_noise(NULL, first, second, 1, 2, 3, 5, map, 2, NULL, NULL) ==
          BN_ERROR_SIZE_MISMATCH);
    CHECK(bn_visible_noise(NULL, first, second, 1, 2, 3, 6, map, 6, NULL, NULL) ==
          BN_ERROR_SIZE_MISMATCH);
    CHECK(bn_visible_noise(NULL, first, second, 1u << 20, 1u << 20, 1, 6, map, 6, NULL, NULL) ==
          BN_ERROR_OUT_OF_MEMORY);
    CHECK(bn_visible_noise(NULL, first, second, 1u << 31, 1u << 31, 1u << 31, 6, map, 6, NULL,
                           NULL) == BN_ERROR_OUT_OF_MEMORY);
    static const double wrong[4][4] = {
        {-0.1, 16.1, NAN, INFINITY}, {0, -1, NAN, INFINITY}, {0, 1, NAN, -0.5}, {0, 2, 1024, 1025}};
    for (int field = 0; field < 4; ++field)
        for (int i = 0; i < 4; ++i) {
            bn_visible_noise_options o = bn_visible_noise_options_default();
            if (field == 3)
                o.window = (uint32_t)wrong[field][i];
            else
                *(field == 0   ? &o.sigma
                  : field == 1 ? &o.exposure
                               : &o.first_share) = wrong[field][i];
            CHECK(measure(&o, first, second, 1, 2, 3, map) == BN_ERROR_INVALID_ARGUMENT);
        }
    second[5] = NAN;
    CHECK(measure(NULL, first, second, 1, 2, 3, map) == BN_ERROR_BAD_DATA);
    CHECK(measure(NULL, second, first, 1, 2, 3, map) == BN_ERROR_BAD_DATA);
    CHECK(map[0] == 7 && map[1] == 7);
}

int main(void) {
    test_definition();
    test_amplitude();
    test_clipping();
    test_threads_and_crops();
    test_bad_input();
    return check_result();
}
