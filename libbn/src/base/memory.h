/* SPDX-License-Identifier: Apache-2.0
 * Allocation with checked products, aligned for the widest vectors, that tests can make fail. */
#ifndef BN_MEMORY_H
#define BN_MEMORY_H

#include <stddef.h>
#include <stdint.h>

/* count * size bytes, aligned to 64. NULL if the product is zero or overflows, or if out of
 * memory. */
void *bn_allocate(size_t count, size_t size);
void *bn_allocate_zero(size_t count, size_t size);
void bn_free(void *memory);

#endif
