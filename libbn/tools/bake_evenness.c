/* SPDX-License-Identifier: Apache-2.0
 * The estimate of a whole picture must not be biased: over the tile, the first samples have to fill
 * the unit square evenly, and so then do all others, which are digital shifts of them. The
 * elementary intervals of several shapes count the entries in them, and crowded ones cost energy.
 */
#include "bake_tile.h"
#include <string.h>

/* Five shapes with 4 entries per cell and five with 64, for a tile of 2^log2 pixels. */
void make_partitions(tile *t) {
    int log2 = 0;
    while (1u << log2 < t->opt.size * t->opt.size) ++log2;
    for (int i = 0; i < PARTITIONS; ++i) {
        int bits = i < 5 ? log2 - 2 : log2 - 6;
        int bits_x = bits / 2 + (i % 5 - 2) * (i < 5 ? 1 : 2);
        if (bits_x > (bits < 8 ? bits : 8)) bits_x = bits < 8 ? bits : 8;
        if (bits_x < 0) bits_x = 0;
        int bits_y = bits - bits_x > 8 ? 8 : bits - bits_x;
        float scale = (float)(1 << (bits_x + bits_y)) / (float)(t->opt.size * t->opt.size);
        t->partitions[i] = (partition){bits_x, bits_y, scale};
    }
    for (uint32_t d = 0; d < 256; ++d) t->second[d] = (uint8_t)(bn_sobol_second(d << 24) >> 24);
}

static uint32_t cell_of(const tile *t, int i, uint32_t entry) {
    partition p = t->partitions[i];
    uint32_t x = entry & 255u, y = t->second[entry >> 8 & 255u];
    return x >> (8 - p.bits_x) << p.bits_y | y >> (8 - p.bits_y);
}

void count_cells(tile *t) {
    memset(t->occupied, 0, PARTITIONS * sizeof *t->occupied);
    for (int i = 0; i < PARTITIONS; ++i) {
        for (uint32_t pixel = 0; pixel < t->opt.size * t->opt.size; ++pixel) {
            ++t->occupied[i][cell_of(t, i, t->entries[pixel])];
        }
    }
}

/* The energy of one more entry: how full its cells are, relative to the mean. */
float crowding(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry) {
    float sum = 0.0f;
    for (int i = 0; i < PARTITIONS; ++i) {
        uint32_t cell = cell_of(t, i, entry);
        sum += (float)(t->occupied[i][cell] + change[i][cell]) * t->partitions[i].scale;
    }
    return sum * (float)t->opt.evenness;
}

void count_entry(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry, int32_t by) {
    for (int i = 0; i < PARTITIONS; ++i) change[i][cell_of(t, i, entry)] += by;
}

/* Chi-square over degrees of freedom of the most uneven shape: about 1 for random entries. */
double worst_crowding(const tile *t) {
    double pixels = t->opt.size * t->opt.size;
    double worst = 0.0;
    for (int i = 0; i < PARTITIONS; ++i) {
        partition p = t->partitions[i];
        double cells = 1 << (p.bits_x + p.bits_y), mean = pixels / cells, chi = 0.0;
        for (int c = 0; c < 1 << (p.bits_x + p.bits_y); ++c) {
            double excess = t->occupied[i][c] - mean;
            chi += excess * excess / mean;
        }
        if (chi / cells > worst) worst = chi / cells;
    }
    return worst;
}
