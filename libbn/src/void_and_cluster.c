/* SPDX-License-Identifier: Apache-2.0
 * Void-and-cluster (Ulichney, "The void-and-cluster method for dither array generation", 1993).
 *
 * Phases two and three are one: with a linear filter the tightest cluster of the zeros is the
 * largest void of the ones. */
#include "hash.h"
#include "memory.h"
#include "options.h"
#include <math.h>
#include <string.h>

typedef struct field {
    uint32_t extent[3], kernel_extent[3];
    int32_t reach[3];
    size_t count, rows;
    double *energy, *kernel, *row_min, *row_max;
    uint8_t *one;
} field;

static void scan_row(field *f, size_t row) {
    double least = INFINITY, most = -INFINITY;
    for (size_t i = row * f->extent[0]; i < (row + 1) * f->extent[0]; ++i) {
        if (f->one[i]) {
            if (f->energy[i] > most) most = f->energy[i];
        } else if (f->energy[i] < least) {
            least = f->energy[i];
        }
    }
    f->row_min[row] = least;
    f->row_max[row] = most;
}

static void change(field *f, size_t at, double sign) {
    uint32_t x = (uint32_t)(at % f->extent[0]), y = (uint32_t)(at / f->extent[0] % f->extent[1]);
    uint32_t z = (uint32_t)(at / f->extent[0] / f->extent[1]);
    const double *k = f->kernel;
    f->one[at] = sign > 0;
    for (uint32_t dz = 0; dz < f->kernel_extent[2]; ++dz) {
        size_t cz = (z + f->extent[2] * 64ull + dz - f->reach[2]) % f->extent[2];
        for (uint32_t dy = 0; dy < f->kernel_extent[1]; ++dy) {
            size_t row =
                cz * f->extent[1] + (y + f->extent[1] * 64ull + dy - f->reach[1]) % f->extent[1];
            size_t cx = (x + f->extent[0] * 64ull - f->reach[0]) % f->extent[0];
            for (uint32_t dx = 0; dx < f->kernel_extent[0]; ++dx) {
                f->energy[row * f->extent[0] + cx] += sign * *k++;
                if (++cx == f->extent[0]) cx = 0;
            }
            scan_row(f, row);
        }
    }
}

static size_t find(const field *f, int one) {
    size_t row = 0;
    const double *extreme = one ? f->row_max : f->row_min;
    for (size_t i = 1; i < f->rows; ++i) {
        if (one ? extreme[i] > extreme[row] : extreme[i] < extreme[row]) row = i;
    }
    for (size_t i = row * f->extent[0];; ++i) {
        if (f->one[i] == one && f->energy[i] == extreme[row]) return i;
    }
}

bn_result bn_void_and_cluster(const bn_void_and_cluster_options *given, uint32_t width,
                              uint32_t height, uint32_t depth, uint32_t *ranks, size_t count) {
    bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
    bn_result result = bn_options_read(&options, sizeof options, given);
    uint64_t product;
    if (result != BN_SUCCESS) return result;
    if (ranks == NULL || width == 0 || height == 0 || depth == 0) return BN_ERROR_INVALID_ARGUMENT;
    if (!(options.sigma >= 0.25 && options.sigma <= 16)) return BN_ERROR_INVALID_ARGUMENT;
    if (!(options.initial_fraction > 0 && options.initial_fraction <= 0.5)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    if (!bn_extent_product(width, height, depth, INT32_MAX, &product))
        return BN_ERROR_OUT_OF_MEMORY;
    if (count != product) return BN_ERROR_SIZE_MISMATCH;

    field f = {.extent = {width, height, depth}, .count = count, .rows = (size_t)height * depth};
    size_t kernel_count = 1;
    int32_t radius = (int32_t)ceil(6 * options.sigma);
    for (int axis = 0; axis < 3; ++axis) {
        uint32_t full = 2 * (uint32_t)radius + 1;
        f.kernel_extent[axis] = f.extent[axis] < full ? f.extent[axis] : full;
        f.reach[axis] = (int32_t)(f.kernel_extent[axis] / 2);
        kernel_count *= f.kernel_extent[axis];
    }
    f.energy = bn_allocate_zero(count, sizeof *f.energy);
    f.kernel = bn_allocate(kernel_count, sizeof *f.kernel);
    f.row_min = bn_allocate(f.rows, sizeof *f.row_min);
    f.row_max = bn_allocate(f.rows, sizeof *f.row_max);
    f.one = bn_allocate_zero(count, 1);
    uint32_t *work = bn_allocate(count, sizeof *work);
    size_t *initial = bn_allocate(count, sizeof *initial);
    uint8_t *start = bn_allocate(count, 1);
    double *kept = bn_allocate(count, sizeof *kept);
    if (!f.energy || !f.kernel || !f.row_min || !f.row_max || !f.one || !work || !initial ||
        !start || !kept) {
        result = BN_ERROR_OUT_OF_MEMORY;
        goto done;
    }
    double *k = f.kernel;
    for (uint32_t z = 0; z < f.kernel_extent[2]; ++z) {
        for (uint32_t y = 0; y < f.kernel_extent[1]; ++y) {
            for (uint32_t x = 0; x < f.kernel_extent[0]; ++x) {
                double dx = (double)x - f.reach[0], dy = (double)y - f.reach[1];
                double dz = (double)z - f.reach[2];
                *k++ = exp(-(dx * dx + dy * dy + dz * dz) / (2 * options.sigma * options.sigma));
            }
        }
    }
    for (size_t i = 0; i < count; ++i) {
        initial[i] = i;
        f.energy[i] = 1e-9 * (double)(bn_mix64(options.seed ^ bn_mix64(i)) >> 40) * 0x1p-24;
    }
    for (size_t row = 0; row < f.rows; ++row) scan_row(&f, row);
    size_t ones = (size_t)((double)count * options.initial_fraction);
    if (ones == 0) ones = 1;
    uint64_t state = options.seed;
    for (size_t i = 0; i < ones; ++i) {
        size_t other = i + bn_mix64(++state * 0x9e3779b97f4a7c15u) % (count - i),
               p = initial[other];
        initial[other] = initial[i];
        initial[i] = p;
        change(&f, p, 1);
    }
    for (size_t steps = 0; ones < count && steps < 100 * ones; ++steps) {
        size_t cluster = find(&f, 1), empty;
        change(&f, cluster, -1);
        empty = find(&f, 0);
        if (f.energy[empty] >= f.energy[cluster]) empty = cluster;
        change(&f, empty, 1);
        if (empty == cluster) break;
    }
    memcpy(start, f.one, count);
    memcpy(kept, f.energy, count * sizeof *kept);
    for (size_t rank = ones; rank-- > 0;) {
        size_t cluster = find(&f, 1);
        work[cluster] = (uint32_t)rank;
        change(&f, cluster, -1);
    }
    memcpy(f.one, start, count);
    memcpy(f.energy, kept, count * sizeof *kept);
    for (size_t row = 0; row < f.rows; ++row) scan_row(&f, row);
    for (size_t rank = ones; rank < count; ++rank) {
        if (options.progress != NULL && rank % 1024 == 0 &&
            options.progress(options.progress_user, (double)rank / (double)count) != 0) {
            result = BN_ERROR_CANCELLED;
            goto done;
        }
        size_t empty = find(&f, 0);
        work[empty] = (uint32_t)rank;
        change(&f, empty, 1);
    }
    memcpy(ranks, work, count * sizeof *ranks);
done:
    bn_free(f.energy);
    bn_free(f.kernel);
    bn_free(f.row_min);
    bn_free(f.row_max);
    bn_free(f.one);
    bn_free(work);
    bn_free(initial);
    bn_free(start);
    bn_free(kept);
    return result;
}
