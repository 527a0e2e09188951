/* SPDX-License-Identifier: Apache-2.0
 * Allocation. Only this file calls malloc and free, so a test can make any allocation fail. Each block is
 * larger than requested by the alignment and one pointer: the aligned memory follows malloc's address. */
#include "base/memory.h"
#include "base/assert.h"
#include <stdlib.h>
#include <string.h>

enum { BN_ALIGNMENT = 64 }; /* a cache line, and two vectors of AVX2 */

void *bn_allocate(size_t count, size_t size) {
    if (count == 0 || size == 0 || count > (SIZE_MAX - 2 * BN_ALIGNMENT) / size) return NULL;
    char *block = malloc(count * size + BN_ALIGNMENT + sizeof(void *));
    if (block == NULL) return NULL;
    uintptr_t start = (uintptr_t)block + sizeof(void *);
    char *memory = block + sizeof(void *) + (size_t)(-start & (BN_ALIGNMENT - 1));
    memcpy(memory - sizeof(void *), &block, sizeof block); /* for bn_free() */
    BN_ASSERT((uintptr_t)memory % BN_ALIGNMENT == 0);
    return memory;
}

void *bn_allocate_zero(size_t count, size_t size) {
    void *memory = bn_allocate(count, size);
    return memory != NULL ? memset(memory, 0, count * size) : NULL;
}

void bn_free(void *memory) {
    void *block;
    if (memory == NULL) return;
    memcpy(&block, (char *)memory - sizeof(void *), sizeof block);
    free(block);
}
