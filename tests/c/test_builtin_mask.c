/* SPDX-License-Identifier: Apache-2.0
 * The built-in masks: every rank once, copies equal, quality within limits. */
#include "check.h"
#include "masks.h"

int main(void) {
    int found = 0;
    for (uint32_t size = 0; size <= 512; ++size) {
        const uint16_t *mask = bn_builtin_mask(size);
        uint32_t one = 5;
        if (mask == NULL) {
            CHECK(size != 64 && size != 128);
            CHECK(bn_builtin_mask_copy(size, &one, (size_t)size * size) ==
                  BN_ERROR_INVALID_ARGUMENT);
            continue;
        }
        size_t count = (size_t)size * size, wrong = 0;
        uint32_t *ranks = malloc(count * sizeof *ranks);
        ++found;
        CHECK(bn_builtin_mask_copy(size, NULL, count) == BN_ERROR_INVALID_ARGUMENT);
        CHECK(bn_builtin_mask_copy(size, &one, count - 1) == BN_ERROR_SIZE_MISMATCH && one == 5);
        CHECK(bn_builtin_mask_copy(size, ranks, count) == BN_SUCCESS);
        CHECK(is_permutation(ranks, count));
        for (size_t i = 0; i < count; ++i) wrong += ranks[i] != mask[i];
        CHECK(wrong == 0);
        free(ranks);
    }
    CHECK(found >= 2);
    CHECK(bn_builtin_mask(UINT32_MAX) == NULL);
    return check_result();
}
