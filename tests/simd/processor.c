/* SPDX-License-Identifier: Apache-2.0
 * The library finds AVX2 if the compiler's own check does. */
#include "simd/simd.h"
#include <stdio.h>
#include <string.h>

int main(void) {
    __builtin_cpu_init();
    const int found = strcmp(bn_simd_get()->name, "avx2") == 0;
    const int supported = __builtin_cpu_supports("avx2") != 0;
    printf("AVX2: the library says %d, the compiler %d\n", found, supported);
    return found != supported;
}
