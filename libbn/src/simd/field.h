/* SPDX-License-Identifier: Apache-2.0
 * The kernels' data: the energy of a binary pattern on a torus, and its extremes, which every change
 * updates. masks/energy_field.h creates it.
 *
 * Energies are fixed-point integers. The kernel's sum is below 2^30, and setting a texel adds 2^30 to
 * its energy, so the lowest value is the largest void and the highest value the tightest cluster.
 * Texels are stored in tiles of 64 (8 x 8, or 64 x 1 if there is only one axis). Each tile is 256
 * contiguous bytes. One pass over the tiles under the kernel adds it and finds their new extremes.
 * Above the tiles is a tree of extremes, each over 64 values of the level below. A change takes time
 * proportional to the kernel's area; a search reads 64 values per level. */
#ifndef BN_SIMD_FIELD_H
#define BN_SIMD_FIELD_H

#include <stddef.h>
#include <stdint.h>

enum {
    BN_TILE_SIZE = 64,
    BN_FIELD_FANOUT = 64,
    BN_FIELD_LEVELS = 6, /* 64^6 values are enough for 2^31 texels */
    BN_FIELD_SET = 1 << 30,
    /* The maximum number of tiles under the kernel in a slice. The kernel reaches 54 texels each
     * way at sigma 16, and a folded axis is no longer than that, so there are at most 15 tiles
     * along an axis, and one more where the torus wraps. */
    BN_FIELD_JOBS = 16 * 16
};

/* The extremes that a change updates or a search finds. */
enum { BN_FIELD_LOWEST = 1, BN_FIELD_HIGHEST = 2 };

typedef struct bn_field_tile {
    uint32_t x, y, z; /* its first texel */
    uint32_t edge;    /* the axes along which it extends beyond the torus; 0: all texels exist */
} bn_field_tile;

/* A slice of the kernel: along axes that are not folded, it is zero outside this circle. */
typedef struct bn_field_circle {
    int32_t reach, square;
} bn_field_circle;

typedef struct bn_field {
    uint32_t extent[3];      /* texels; axes of extent 1 come last */
    uint32_t tile_extent[2]; /* texels of a tile: 8 x 8 or 64 x 1 */
    uint32_t tiles[2];       /* tiles along x and y */
    size_t tile_count;
    bn_field_tile *tile;
    int32_t *energy; /* [tile_count][BN_TILE_SIZE] */

    /* The kernel, with BN_FIELD_SET added at its centre: its value at offset (dx, dy, dz) is
     * kernel[(dz * kernel_rows + dy) * kernel_stride + dx]. There are zeros around it. */
    int32_t *kernel_block;
    const int32_t *kernel;
    ptrdiff_t kernel_rows, kernel_stride,
        kernel_step;         /* step: between the 8-texel rows of a tile */
    int32_t reach[3];        /* offsets run from -reach to reach */
    bn_field_circle *circle; /* the kernel's slices by |dz|; it is cut off at a sphere */
    int folded[3];           /* the kernel is wider than the torus and wrapped around it */

    /* Whether the last tiles of an axis extend beyond the torus: bit 0 for x, bit 1 for y. */
    uint32_t edge[2];
    _Alignas(64) int32_t edge_keep[4][BN_TILE_SIZE]; /* -1 where the texel exists */
    _Alignas(64) int32_t edge_fill[4][BN_TILE_SIZE]; /* the largest integer where it does not */

    int levels;
    size_t level_count[BN_FIELD_LEVELS];
    int32_t *lowest[BN_FIELD_LEVELS], *highest[BN_FIELD_LEVELS]; /* level 0: of tiles */
    uint32_t *stamp[BN_FIELD_LEVELS],
        *touched[BN_FIELD_LEVELS]; /* scratch for one change, for levels above 0 */
    uint32_t changes;
} bn_field;

/* A texel's location: its tile, and its position within the tile. */
typedef struct bn_field_texel {
    uint32_t tile, lane;
} bn_field_texel;

#endif
