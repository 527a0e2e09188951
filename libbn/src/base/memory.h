/* SPDX-License-Identifier: Apache-2.0
 * Allocation with checked products, aligned for the widest vectors, that tests can make fail. */
#ifndef BN_MEMORY_H
#define BN_MEMORY_H

#include <stddef.h>
#include <stdint.h>

/* count * size bytes, aligned to 64; NULL when that is zero, overflows or is not to be had. */
void *bn_allocate(size_t count, size_t size);
void *bn_allocate_zero(size_t count, size_t size);
void bn_free(void *memory);

/* The product of three extents in *count; 0 when one is zero or the product is above `limit`. */
static inline int bn_extent_product(uint32_t width, uint32_t height, uint32_t depth, uint64_t limit,
                                    uint64_t *count) {
    uint64_t plane = (uint64_t)width * height;
    if (plane == 0 || depth == 0 || plane > limit / depth) return 0;
    *count = plane * depth;
    return 1;
}

/* 1 when ranks holds 0 .. count - 1 once each, 0 when not, -1 when memory is short. */
int bn_is_permutation(const uint32_t *ranks, size_t count);

#endif
