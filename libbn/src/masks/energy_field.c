/* SPDX-License-Identifier: Apache-2.0
 * Sets up an energy field: tiles, kernel and levels (simd/field.h). The kernel is a product of one Gaussian
 * per axis, wrapped around narrow axes and cut off at a sphere. Its scale makes the sum over the torus almost
 * 2^30, so that no energy can reach BN_FIELD_SET. simd/kernels.h does the work. */
#include "masks/energy_field.h"
#include "base/assert.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/portable_math.h"
#include <string.h>

/* The Gaussian is cut off at this many standard deviations, where it is below 0.4% of its maximum.
 * A larger reach changes no quality measure; a smaller one reduces quality at sigma 1.9. */
static const double BN_KERNEL_CUTOFF = 10.0 / 3;

static uint32_t divide_up(uint32_t a, uint32_t b) {
    return a / b + (a % b != 0);
}

/* Tiles are stored in bands of eight rows, column by column, so that 64 consecutive tiles usually
 * form a square. */
static size_t tile_index(const bn_field *f, uint32_t tx, uint32_t ty, uint32_t z) {
    uint32_t band = ty & ~7u, rows = f->tiles[1] - band < 8 ? f->tiles[1] - band : 8;
    return ((size_t)z * f->tiles[1] + band) * f->tiles[0] + (size_t)tx * rows + (ty & 7u);
}

/* Lays out the tiles, and fills the energies with random numbers below `noise`. Lanes of texels that do not
 * exist hold 0 in `energy`, and `edge_fill` hides them from searches for the lowest value. */
static int create_tiles(bn_field *f, uint64_t seed, uint32_t noise) {
    for (int axis = 0; axis < 2; ++axis) {
        f->tiles[axis] = divide_up(f->extent[axis], f->tile_extent[axis]);
    }
    f->tile_count = (size_t)f->tiles[0] * f->tiles[1] * f->extent[2];
    f->tile = bn_allocate(f->tile_count, sizeof *f->tile);
    f->energy = bn_allocate(f->tile_count, BN_TILE_SIZE * sizeof *f->energy);
    if (f->tile == NULL || f->energy == NULL) return 0;

    /* The texels of the last tile along x and y that exist. */
    const uint32_t used[2] = {f->extent[0] - (f->tiles[0] - 1) * f->tile_extent[0],
                              f->extent[1] - (f->tiles[1] - 1) * f->tile_extent[1]};
    f->edge[0] = used[0] < f->tile_extent[0] ? 1 : 0;
    f->edge[1] = used[1] < f->tile_extent[1] ? 2 : 0;
    for (uint32_t edge = 0; edge < 4; ++edge) {
        for (uint32_t lane = 0; lane < BN_TILE_SIZE; ++lane) {
            uint32_t x = lane % f->tile_extent[0], y = lane / f->tile_extent[0];
            int exists = !((edge & 1) && x >= used[0]) && !((edge & 2) && y >= used[1]);
            f->edge_keep[edge][lane] = exists ? -1 : 0;
            f->edge_fill[edge][lane] = exists ? 0 : INT32_MAX;
        }
    }
    for (uint32_t z = 0; z < f->extent[2]; ++z) {
        for (uint32_t ty = 0; ty < f->tiles[1]; ++ty) {
            for (uint32_t tx = 0; tx < f->tiles[0]; ++tx) {
                size_t i = tile_index(f, tx, ty, z);
                bn_field_tile t = {tx * f->tile_extent[0], ty * f->tile_extent[1], z, 0};
                t.edge = (tx + 1 == f->tiles[0] ? f->edge[0] : 0) |
                         (ty + 1 == f->tiles[1] ? f->edge[1] : 0);
                f->tile[i] = t;
                for (uint32_t lane = 0; lane < BN_TILE_SIZE; ++lane) {
                    uint64_t key = bn_mix64(seed + (uint64_t)i * BN_TILE_SIZE + lane);
                    f->energy[i * BN_TILE_SIZE + lane] =
                        (int32_t)((key >> 32) * noise >> 32) & f->edge_keep[t.edge][lane];
                }
            }
        }
    }
    return 1;
}

static int32_t kernel_radius(double sigma) {
    return (int32_t)ceil(BN_KERNEL_CUTOFF * sigma);
}

/* The Gaussian along one axis for offsets from 0 to reach, wrapped around a narrow torus. */
static double *create_profile(bn_field *f, int axis, double sigma) {
    const int32_t radius = kernel_radius(sigma), extent = (int32_t)f->extent[axis];
    f->folded[axis] = 2 * (int64_t)radius + 1 > extent;
    f->reach[axis] = f->folded[axis] ? extent - 1 : radius;
    double *profile = bn_allocate_zero((size_t)f->reach[axis] + 1, sizeof *profile);
    if (profile == NULL) return NULL;
    for (int32_t d = -radius; d <= radius; ++d) {
        double g = bn_portable_exp(-(double)d * d / (2 * sigma * sigma));
        if (f->folded[axis]) {
            profile[((d % extent) + extent) % extent] += g;
        } else if (d >= 0) {
            profile[d] = g;
        }
    }
    return profile;
}

/* Whether an offset lies outside the sphere at which the Gaussian is cut off. */
static int outside(const bn_field *f, const int32_t offset[3], int32_t radius) {
    int64_t square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!f->folded[axis]) square += (int64_t)offset[axis] * offset[axis];
    }
    return square > (int64_t)radius * radius;
}

/* Fills the kernel; *centre becomes its value at offset 0, minus BN_FIELD_SET. */
static int create_kernel(bn_field *f, double sigma, int32_t *centre) {
    const int32_t radius = kernel_radius(sigma);
    double *profile[3] = {NULL, NULL, NULL}, sum = 1;
    int good = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double line = 0;
        profile[axis] = create_profile(f, axis, sigma);
        if (profile[axis] == NULL) goto done;
        /* A profile that is not folded is one half of the Gaussian. */
        for (int32_t d = 0; d <= f->reach[axis]; ++d) {
            line += d == 0 || f->folded[axis] ? profile[axis][d] : 2 * profile[axis][d];
        }
        sum *= line;
    }
    /* A tile may extend beyond the kernel by all but one of its texels. */
    const int32_t margin[2] = {(int32_t)f->tile_extent[0] - 1, (int32_t)f->tile_extent[1] - 1};
    f->kernel_stride = 2 * (f->reach[0] + margin[0]) + 1;
    f->kernel_rows = 2 * (f->reach[1] + margin[1]) + 1;
    f->kernel_step = f->tile_extent[1] == 1 ? 8 : f->kernel_stride;
    const size_t slices = 2 * (size_t)f->reach[2] + 1, rows = (size_t)f->kernel_rows;
    f->kernel_block =
        bn_allocate_zero(slices * rows, (size_t)f->kernel_stride * sizeof *f->kernel_block);
    f->circle = bn_allocate((size_t)f->reach[2] + 1, sizeof *f->circle);
    if (f->kernel_block == NULL || f->circle == NULL) goto done;
    int32_t *origin = f->kernel_block +
                      (f->reach[2] * f->kernel_rows + f->reach[1] + margin[1]) * f->kernel_stride +
                      f->reach[0] + margin[0];
    /* Leaves room for the noise and for rounding each value up. */
    const double scale = (BN_FIELD_SET - (1 << 20)) / sum;
    for (int32_t z = -f->reach[2]; z <= f->reach[2]; ++z) {
        for (int32_t y = -f->reach[1]; y <= f->reach[1]; ++y) {
            for (int32_t x = -f->reach[0]; x <= f->reach[0]; ++x) {
                const int32_t d[3] = {x, y, z};
                double g = scale;
                for (int axis = 0; axis < 3; ++axis) {
                    int32_t a = d[axis];
                    if (a < 0) a = f->folded[axis] ? a + (int32_t)f->extent[axis] : -a;
                    g *= profile[axis][a];
                }
                if (outside(f, d, radius)) g = 0;
                origin[((ptrdiff_t)z * f->kernel_rows + y) * f->kernel_stride + x] = (int32_t)g;
            }
        }
    }
    for (int32_t z = 0; z <= f->reach[2]; ++z) {
        const int32_t square = radius * radius - (f->folded[2] ? 0 : z * z);
        bn_field_circle circle = {radius, square};
        while (circle.reach * circle.reach > square) --circle.reach;
        /* Along a folded axis the kernel reaches every tile, at any distance. */
        if (f->folded[0] || f->folded[1]) circle.square = INT32_MAX;
        f->circle[z] = circle;
    }
    BN_ASSERT(origin[0] > 0 && origin[0] < BN_FIELD_SET);
    *centre = origin[0];
    origin[0] += BN_FIELD_SET;
    f->kernel = origin;
    good = 1;
done:
    for (int axis = 0; axis < 3; ++axis) bn_free(profile[axis]);
    return good;
}

/* Builds the tree of extremes, up to a level that one search can read. */
static int create_levels(bn_field *f) {
    size_t count = f->tile_count;
    for (f->levels = 0; f->levels == 0 || f->level_count[f->levels - 1] > BN_FIELD_FANOUT;
         ++f->levels) {
        const int level = f->levels;
        BN_ASSERT(level < BN_FIELD_LEVELS);
        if (level > 0) count = (count + BN_FIELD_FANOUT - 1) / BN_FIELD_FANOUT;
        /* Allocates whole groups, so that scans need no bounds check. */
        size_t room = (count + BN_FIELD_FANOUT - 1) / BN_FIELD_FANOUT * BN_FIELD_FANOUT;
        f->level_count[level] = count;
        f->lowest[level] = bn_allocate(room, sizeof(int32_t));
        f->highest[level] = bn_allocate(room, sizeof(int32_t));
        f->stamp[level] = bn_allocate_zero(count, sizeof(uint32_t));
        f->touched[level] = bn_allocate(count, sizeof(uint32_t));
        if (!f->lowest[level] || !f->highest[level] || !f->stamp[level] || !f->touched[level]) {
            ++f->levels;
            return 0;
        }
        for (size_t i = 0; i < room; ++i) {
            f->lowest[level][i] = INT32_MAX;
            f->highest[level][i] = 0;
        }
    }
    return 1;
}

int bn_field_create(bn_field *f, const uint32_t extent[3], double sigma, uint64_t seed) {
    int32_t centre = 0;
    memset(f, 0, sizeof *f);
    memcpy(f->extent, extent, sizeof f->extent);
    f->tile_extent[0] = f->extent[1] == 1 ? 64 : 8;
    f->tile_extent[1] = f->extent[1] == 1 ? 1 : 8;
    if (!create_kernel(f, sigma, &centre)) return 0;
    /* Far below the smallest values of the kernel, but large enough to make ties rare. */
    uint32_t noise = (uint32_t)centre >> 16;
    return create_tiles(f, seed, noise < 4 ? 4 : noise) && create_levels(f);
}

void bn_field_destroy(bn_field *f) {
    bn_free(f->tile);
    bn_free(f->energy);
    bn_free(f->kernel_block);
    bn_free(f->circle);
    for (int level = 0; level < f->levels; ++level) {
        bn_free(f->lowest[level]);
        bn_free(f->highest[level]);
        bn_free(f->stamp[level]);
        bn_free(f->touched[level]);
    }
}

void bn_field_refresh(bn_field *f) {
    for (size_t i = 0; i < f->tile_count; ++i) {
        const int32_t *energy = f->energy + i * BN_TILE_SIZE, *fill = f->edge_fill[f->tile[i].edge];
        int32_t low = INT32_MAX, high = 0;
        for (int lane = 0; lane < BN_TILE_SIZE; ++lane) {
            int32_t value = energy[lane] | fill[lane];
            if (value < low) low = value;
            if (energy[lane] > high) high = energy[lane];
        }
        f->lowest[0][i] = low;
        f->highest[0][i] = high;
    }
    for (int level = 1; level < f->levels; ++level) {
        for (size_t i = 0; i < f->level_count[level]; ++i) {
            int32_t low = INT32_MAX, high = 0;
            for (size_t j = i * BN_FIELD_FANOUT; j < (i + 1) * BN_FIELD_FANOUT; ++j) {
                if (f->lowest[level - 1][j] < low) low = f->lowest[level - 1][j];
                if (f->highest[level - 1][j] > high) high = f->highest[level - 1][j];
            }
            f->lowest[level][i] = low;
            f->highest[level][i] = high;
        }
    }
}

size_t bn_field_index(const bn_field *f, bn_field_texel texel) {
    BN_ASSERT(texel.tile < f->tile_count && texel.lane < BN_TILE_SIZE);
    const bn_field_tile *t = &f->tile[texel.tile];
    size_t x = t->x + (texel.lane & (f->tile_extent[0] - 1));
    size_t y = t->y + (f->tile_extent[1] == 1 ? 0 : texel.lane >> 3);
    return (t->z * (size_t)f->extent[1] + y) * f->extent[0] + x;
}

bn_field_texel bn_field_at(const bn_field *f, size_t index) {
    uint32_t x = (uint32_t)(index % f->extent[0]);
    size_t line = index / f->extent[0];
    uint32_t y = (uint32_t)(line % f->extent[1]), z = (uint32_t)(line / f->extent[1]);
    bn_field_texel texel;
    texel.tile = (uint32_t)tile_index(f, x / f->tile_extent[0], y / f->tile_extent[1], z);
    texel.lane = y % f->tile_extent[1] * f->tile_extent[0] + x % f->tile_extent[0];
    BN_ASSERT(bn_field_index(f, texel) == index);
    return texel;
}
