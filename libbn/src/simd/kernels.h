/* SPDX-License-Identifier: Apache-2.0
 * The inner loops, written once with the vector types of vec.h. Each .c file in this folder defines
 * an instruction set and includes this file. All sums are of integers and cannot overflow, so their
 * order, and with it the number of lanes, does not change results. */
#include "base/assert.h"
#include "simd/simd.h"
#include "simd/vec.h"

#ifndef BN_SIMD_DRAW_MANY
#define BN_SIMD_DRAW_MANY NULL
#endif

BN_INLINE void prefetch(const void *p) {
#if defined(__GNUC__)
    __builtin_prefetch(p, 1);
#else
    (void)p;
#endif
}

/* ---- Extremes of 64 values */

BN_INLINE int32_t lowest_of_64(const int32_t *values) {
    bn_i32v low = i32_load(values);
    for (int i = BN_I32_LANES; i < 64; i += BN_I32_LANES) low = i32_min(low, i32_load(values + i));
    return i32_lowest(low);
}

BN_INLINE int32_t highest_of_64(const int32_t *values) {
    bn_i32v high = i32_load(values);
    for (int i = BN_I32_LANES; i < 64; i += BN_I32_LANES)
        high = i32_max(high, i32_load(values + i));
    return i32_highest(high);
}

/* The position of the first of 64 values that equals `value` after an OR with `fill`. There must be
 * one. Compares all of them, because the branch for an early exit would be unpredictable. */
BN_INLINE uint32_t first_of_64(const int32_t *values, const int32_t *fill, int32_t value) {
    const bn_i32v wanted = i32_set(value);
    uint64_t bits = 0;
    for (uint32_t i = 0; i < 64; i += BN_I32_LANES) {
        bn_i32v v = i32_load(values + i);
        if (fill != NULL) v = i32_or(v, i32_load(fill + i));
        bits |= (uint64_t)i32_equal_bits(v, wanted) << i;
    }
    BN_ASSERT(bits != 0);
    return first_bit(bits);
}

/* ---- Energy field */

/* Adds or subtracts the kernel over one tile and finds its extremes. */
BN_INLINE void change_tile(bn_field *f, size_t index, const int32_t *kernel, uint32_t edge,
                           int sign, int extremes) {
    int32_t *energy = f->energy + index * BN_TILE_SIZE;
    const ptrdiff_t step = f->kernel_step;
    bn_i32v low = i32_set(INT32_MAX), high = i32_set(0);
    for (int i = 0; i < BN_TILE_SIZE; i += BN_I32_LANES) {
        bn_i32v value = i32_load(energy + i), add = i32_load_any(kernel + i / 8 * step);
        value = sign > 0 ? i32_add(value, add) : i32_subtract(value, add);
        if (edge != 0) value = i32_and(value, i32_load(f->edge_keep[edge] + i));
        i32_store(energy + i, value);
        if (extremes & BN_FIELD_HIGHEST) high = i32_max(high, value);
        if (extremes & BN_FIELD_LOWEST) {
            if (edge != 0) value = i32_or(value, i32_load(f->edge_fill[edge] + i));
            low = i32_min(low, value);
        }
    }
    if (extremes & BN_FIELD_LOWEST) f->lowest[0][index] = i32_lowest(low);
    if (extremes & BN_FIELD_HIGHEST) f->highest[0][index] = i32_highest(high);
    BN_ASSERT(i32_lowest(low) >= 0); /* clearing a texel subtracts what setting it has added */
}

/* A piece of an axis under the kernel: texels first .. last, at positions shifted by `shift`. */
typedef struct piece {
    int32_t first, last, shift;
} piece;

/* Splits the part of an axis under the kernel at c where the torus wraps; returns the number of
 * pieces. */
BN_INLINE int split(const bn_field *f, int axis, int32_t c, int32_t reach, piece pieces[2]) {
    const int32_t extent = (int32_t)f->extent[axis], first = c - reach, last = c + reach;
    if (f->folded[axis]) {
        pieces[0] = (piece){0, extent - 1, 0};
        return 1;
    }
    pieces[0] = (piece){first < 0 ? 0 : first, last < extent ? last : extent - 1, 0};
    if (first < 0) {
        pieces[1] = (piece){first + extent, extent - 1, -extent};
        return 2;
    }
    if (last >= extent) {
        pieces[1] = (piece){0, last - extent, extent};
        return 2;
    }
    return 1;
}

/* Adds a group of values to the list of those whose extremes this change may move, once. */
BN_INLINE void touch(bn_field *f, int level, size_t group, size_t *count) {
    if (f->stamp[level][group] == f->changes) return;
    f->stamp[level][group] = f->changes;
    f->touched[level][(*count)++] = (uint32_t)group;
}

/* Applies one change to one tile. */
typedef struct job {
    size_t index;
    const int32_t *kernel;
    uint32_t edge;
} job;

/* The distance from 0 to the nearest of first .. last. */
BN_INLINE int32_t distance(int32_t first, int32_t last) {
    return first > 0 ? first : last < 0 ? -last : 0;
}

/* Lists the tiles that the kernel reaches in one slice of the torus, and prefetches them. In that
 * slice the kernel is a circle of squared radius `limit`, and `kernel` is its value at offset (0,
 * 0). At most BN_FIELD_JOBS tiles lie under it. */
BN_INLINE uint32_t list_jobs(const bn_field *f, size_t slice, const int32_t c[2], int32_t reach,
                             int32_t limit, const int32_t *kernel, job *jobs) {
    const int line = f->tile_extent[1] == 1, log_x = line ? 6 : 3, log_y = line ? 0 : 3;
    const int32_t tiles_x = (int32_t)f->tiles[0], tiles_y = (int32_t)f->tiles[1];
    piece px[2], py[2];
    const int nx = split(f, 0, c[0], reach, px), ny = split(f, 1, c[1], reach, py);
    uint32_t count = 0;
    for (int iy = 0; iy < ny; ++iy) {
        for (int32_t ty = py[iy].first >> log_y; ty <= py[iy].last >> log_y; ++ty) {
            const int32_t dy = ty * (1 << log_y) + py[iy].shift - c[1];
            const int32_t near_y = distance(dy, dy + (1 << log_y) - 1);
            const int32_t *row = kernel + dy * f->kernel_stride;
            const int32_t band = ty & ~7, rows = tiles_y - band < 8 ? tiles_y - band : 8;
            const size_t base =
                (slice * f->tiles[1] + (uint32_t)band) * f->tiles[0] + (uint32_t)(ty & 7);
            const uint32_t edge_y = ty + 1 == tiles_y ? f->edge[1] : 0;
            for (int ix = 0; ix < nx; ++ix) {
                for (int32_t tx = px[ix].first >> log_x; tx <= px[ix].last >> log_x; ++tx) {
                    const int32_t dx = tx * (1 << log_x) + px[ix].shift - c[0];
                    const int32_t near_x = distance(dx, dx + (1 << log_x) - 1);
                    BN_ASSERT(count < BN_FIELD_JOBS && tx < tiles_x && ty < tiles_y);
                    /* The tile lies inside the kernel and the zeros around it. */
                    BN_ASSERT(dx >= -f->reach[0] - (1 << log_x) + 1 && dx <= f->reach[0] &&
                              dy >= -f->reach[1] - (1 << log_y) + 1 && dy <= f->reach[1]);
                    job *j = &jobs[count];
                    j->index = base + (size_t)tx * (uint32_t)rows;
                    j->kernel = row + dx;
                    j->edge = edge_y | (tx + 1 == tiles_x ? f->edge[0] : 0);
                    for (int i = 0; i < BN_TILE_SIZE; i += 16) {
                        prefetch(f->energy + j->index * BN_TILE_SIZE + i);
                    }
                    /* Tiles at the corners may lie beyond the kernel's circle. */
                    count += near_x * near_x + near_y * near_y <= limit;
                }
            }
        }
    }
    return count;
}

/* Applies a change at c to one slice, at distance dz from the changed texel. `kernel` is its value at offset (0, 0). */
BN_INLINE void change_slice(bn_field *f, size_t slice, const int32_t c[2], int32_t dz,
                            const int32_t *kernel, int sign, int extremes, size_t *touched) {
    job jobs[BN_FIELD_JOBS];
    const int32_t limit = f->circle[dz < 0 ? -dz : dz].square;
    const int32_t reach = f->circle[dz < 0 ? -dz : dz].reach;
    const uint32_t count = list_jobs(f, slice, c, reach, limit, kernel, jobs);
    for (uint32_t i = 0; i < count; ++i) {
        const size_t index = jobs[i].index;
        const int32_t low = f->lowest[0][index], high = f->highest[0][index];
        change_tile(f, index, jobs[i].kernel, jobs[i].edge, sign, extremes);
        if (f->levels == 1) continue;
        /* When energies only grow, the lowest value of a group can change only if this tile had it;
         * likewise for the highest when they only fall. */
        const size_t group = index / BN_FIELD_FANOUT;
        if (extremes == BN_FIELD_LOWEST && sign > 0 && low != f->lowest[1][group]) continue;
        if (extremes == BN_FIELD_HIGHEST && sign < 0 && high != f->highest[1][group]) continue;
        touch(f, 1, group, touched);
    }
}

/* Applies a change to all slices that the kernel reaches, then updates the tree of extremes, level by level. */
BN_INLINE void change(bn_field *f, bn_field_texel texel, int sign, int extremes) {
    const bn_field_tile *home = &f->tile[texel.tile];
    const int32_t c[2] = {(int32_t)(home->x + (texel.lane & (f->tile_extent[0] - 1))),
                          (int32_t)(home->y + (f->tile_extent[1] == 1 ? 0 : texel.lane >> 3))};
    const int32_t cz = (int32_t)home->z;
    const ptrdiff_t slice_size = f->kernel_rows * f->kernel_stride;
    size_t touched = 0;
    ++f->changes;
    if (f->extent[2] == 1) {
        change_slice(f, 0, c, 0, f->kernel, sign, extremes, &touched);
    } else {
        piece pz[2];
        const int nz = split(f, 2, cz, f->reach[2], pz);
        for (int iz = 0; iz < nz; ++iz) {
            for (int32_t z = pz[iz].first; z <= pz[iz].last; ++z) {
                const int32_t dz = z + pz[iz].shift - cz;
                change_slice(f, (size_t)z, c, dz, f->kernel + dz * slice_size, sign, extremes,
                             &touched);
            }
        }
    }
    for (int level = 1; level < f->levels; ++level) {
        size_t above = 0;
        for (size_t i = 0; i < touched; ++i) {
            const size_t group = f->touched[level][i], first = group * BN_FIELD_FANOUT;
            if (extremes & BN_FIELD_LOWEST) {
                f->lowest[level][group] = lowest_of_64(f->lowest[level - 1] + first);
            }
            if (extremes & BN_FIELD_HIGHEST) {
                f->highest[level][group] = highest_of_64(f->highest[level - 1] + first);
            }
            if (level + 1 < f->levels) touch(f, level + 1, group / BN_FIELD_FANOUT, &above);
        }
        touched = above;
    }
}

/* Compiled separately for each use: filling, emptying and moving texels. */
static void field_change(bn_field *f, bn_field_texel texel, int sign, int extremes) {
    if (sign > 0 && extremes == BN_FIELD_LOWEST) {
        change(f, texel, 1, BN_FIELD_LOWEST);
    } else if (sign > 0) {
        change(f, texel, 1, BN_FIELD_LOWEST | BN_FIELD_HIGHEST);
    } else if (extremes == BN_FIELD_HIGHEST) {
        change(f, texel, -1, BN_FIELD_HIGHEST);
    } else {
        change(f, texel, -1, BN_FIELD_LOWEST | BN_FIELD_HIGHEST);
    }
}

static bn_field_texel field_find(const bn_field *f, int extreme) {
    const int low = extreme == BN_FIELD_LOWEST;
    int32_t *const *values = low ? f->lowest : f->highest;
    const int top = f->levels - 1;
    /* The top level has up to 64 values, padded with neutral ones. */
    bn_i32v best = i32_load(values[top]);
    for (size_t i = BN_I32_LANES; i < f->level_count[top]; i += BN_I32_LANES) {
        const bn_i32v more = i32_load(values[top] + i);
        best = low ? i32_min(best, more) : i32_max(best, more);
    }
    const int32_t value = low ? i32_lowest(best) : i32_highest(best);
    size_t index = first_of_64(values[top], NULL, value);
    for (int level = top - 1; level >= 0; --level) {
        index *= BN_FIELD_FANOUT;
        index += first_of_64(values[level] + index, NULL, value);
    }
    BN_ASSERT(index < f->tile_count);
    const uint32_t edge = f->tile[index].edge;
    bn_field_texel texel = {(uint32_t)index,
                            first_of_64(f->energy + index * BN_TILE_SIZE,
                                        edge != 0 ? f->edge_fill[edge] : NULL, value)};
    return texel;
}

/* ---- Annealing */

static int32_t window_difference(const int16_t *first, const int16_t *second, size_t stride,
                                 const int16_t *weights, uint32_t rows, uint32_t row_lanes,
                                 int16_t low, int16_t high) {
    BN_ASSERT(low <= high && row_lanes % BN_WINDOW_LANES == 0);
    const bn_i16x16 lows = i16_set(low), highs = i16_set(high);
    bn_i32v plus = i32_set(0), minus = i32_set(0);
    for (uint32_t y = 0; y < rows; ++y) {
        for (uint32_t x = 0; x < row_lanes; x += BN_WINDOW_LANES) {
            bn_i16x16 weight = i16_load(weights + x);
            minus = i16_multiply_add(minus, i16_clamp(i16_load(first + x), lows, highs), weight);
            plus = i16_multiply_add(plus, i16_clamp(i16_load(second + x), lows, highs), weight);
        }
        first += stride;
        second += stride;
        weights += row_lanes;
    }
    return i32_sum(i32_subtract(plus, minus));
}

/* ---- Relaxation */

static void relax_row(const int16_t *centre, const ptrdiff_t *offsets, const int16_t *weights,
                      uint32_t pairs, uint32_t columns, int16_t limit, int32_t shift,
                      int16_t *gradient) {
    const bn_i16x16 low = i16_set((int16_t)-limit), high = i16_set(limit);
    for (uint32_t x = 0; x < columns; x += BN_WINDOW_LANES) {
        const bn_i16x16 here = i16_load(centre + x);
        bn_i16x16 sum = i16_set(0);
        for (uint32_t k = 0; k < pairs; ++k) {
            bn_i16x16 d = i16_subtract_saturated(here, i16_load(centre + x + offsets[k]));
            d = i16_shift_left(i16_clamp(d, low, high), shift);
            sum = i16_add(sum, i16_multiply_upper(d, i16_load(weights + k * BN_WINDOW_LANES)));
        }
        i16_store(gradient + x, sum);
    }
}

const bn_simd BN_SIMD_TABLE = {field_change, field_find, window_difference, relax_row,
                               BN_SIMD_DRAW_MANY};
