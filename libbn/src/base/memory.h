/* SPDX-License-Identifier: Apache-2.0
 * Allocation with overflow checks and alignment for the widest vectors. Tests can make it fail.
 *
 * Draws do not allocate. All other functions free what they allocate before they return, except bn_neural_open(),
 * whose network lives until bn_neural_close(). Any thread may call these functions. */
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
