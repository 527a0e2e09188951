/* SPDX-License-Identifier: Apache-2.0
 * Chooses the instruction set at run time. */
#include "simd/simd.h"
#include <stdlib.h>
#include <string.h>

extern const bn_simd bn_simd_scalar, bn_simd_sse41, bn_simd_avx2, bn_simd_avx512, bn_simd_neon;

/* From the least capable to the most; the build defines which files there are. */
static int available(const bn_simd *sets[5]) {
    int count = 0;
    sets[count++] = &bn_simd_scalar;
#if defined(BN_SIMD_X86)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("sse4.1")) sets[count++] = &bn_simd_sse41;
    if (__builtin_cpu_supports("avx2")) sets[count++] = &bn_simd_avx2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")) {
        sets[count++] = &bn_simd_avx512;
    }
#elif defined(BN_SIMD_ARM)
    sets[count++] = &bn_simd_neon;
#endif
    return count;
}

const bn_simd *bn_simd_get(void) {
    const bn_simd *sets[5];
    int count = available(sets);
    const char *limit = getenv("BN_SIMD");
    if (limit != NULL) {
        for (int i = 0; i < count; ++i) {
            if (strcmp(limit, sets[i]->name) == 0) return sets[i];
        }
    }
    return sets[count - 1];
}
