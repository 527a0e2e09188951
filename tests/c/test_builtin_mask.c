/* SPDX-License-Identifier: Apache-2.0
 * The built-in masks contain every rank exactly once. */
#include "check.h"
#include "masks.h"

int main(void) {
    int found = 0;
    for (uint32_t size = 0; size <= 512; ++size) {
        const bn_mask mask = bn_builtin_mask(size);
        if (mask.ranks == NULL) {
            CHECK(size != 64 && size != 128);
            continue;
        }
        double error;
        ++found;
        CHECK(mask.rank_bits == 16 && mask.width == size && mask.height == size);
        CHECK(mask.depth == 1 && mask.channels == 1);
        /* This call fails if the ranks are not a permutation. */
        CHECK(bn_mask_error(&mask, 1, &error, NULL, NULL) == BN_SUCCESS);
    }
    CHECK(found >= 2);
    CHECK(bn_builtin_mask(UINT32_MAX).ranks == NULL);
    return check_result();
}
