/* SPDX-License-Identifier: Apache-2.0
 * Allocation for the mask algorithms. */
#include "base/memory.h"
#include <stdlib.h>
#include <string.h>

enum { BN_ALIGNMENT = 64 };

void *bn_allocate(size_t count, size_t size) {
    if (count == 0 || size == 0 || count > (SIZE_MAX - 2 * BN_ALIGNMENT) / size) return NULL;
    /* The start of the block malloc gave stands right before what is handed out. */
    char *block = malloc(count * size + BN_ALIGNMENT + sizeof(void *));
    if (block == NULL) return NULL;
    uintptr_t start = (uintptr_t)block + sizeof(void *);
    char *memory = block + sizeof(void *) + (size_t)(-start & (BN_ALIGNMENT - 1));
    memcpy(memory - sizeof(void *), &block, sizeof block);
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

int bn_is_permutation(const uint32_t *ranks, size_t count) {
    uint64_t *seen = bn_allocate_zero(count / 64 + 1, sizeof *seen);
    if (seen == NULL) return -1;
    int good = 1;
    for (size_t i = 0; i < count && good; ++i) {
        uint32_t rank = ranks[i];
        good = rank < count && !(seen[rank / 64] >> rank % 64 & 1);
        if (good) seen[rank / 64] |= (uint64_t)1 << rank % 64;
    }
    bn_free(seen);
    return good;
}
