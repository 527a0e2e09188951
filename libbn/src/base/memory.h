/* SPDX-License-Identifier: Apache-2.0
 * Allocation with overflow checks and alignment for the widest vectors. Tests can make it fail. */
#ifndef BN_MEMORY_H
#define BN_MEMORY_H

#include <stddef.h>
#include <stdint.h>

/* Allocates count * size bytes, aligned to 64 bytes. Returns NULL if the product is zero or
 * overflows, or if memory runs out. */
void *bn_allocate(size_t count, size_t size);
void *bn_allocate_zero(size_t count, size_t size);
void bn_free(void *memory);

#endif
