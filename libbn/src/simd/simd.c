/* SPDX-License-Identifier: Apache-2.0
 * Chooses the instruction set at run time: AVX2 where the CPU and the system have it, NEON on 64-bit Arm, which
 * always has it, and otherwise plain C. */
#include "simd/simd.h"
#include <stdlib.h>
#include <string.h>
#if defined(BN_SIMD_X86)
#include <cpuid.h>
#endif

extern const bn_simd bn_simd_scalar, bn_simd_avx2, bn_simd_neon;

#if defined(BN_SIMD_X86)

/* Whether the CPU has AVX2 and the system saves its registers. __builtin_cpu_supports() detects nothing
 * in programs linked by "zig cc". */
static int has_avx2(void) {
    const unsigned vectors = 0x06; /* in XCR0 */
    unsigned a, b, c, d, saved, upper;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_AVX)) return 0;
    __asm__ volatile("xgetbv" : "=a"(saved), "=d"(upper) : "c"(0));
    return (saved & vectors) == vectors && __get_cpuid_count(7, 0, &a, &b, &c, &d) &&
           (b & bit_AVX2) != 0;
}

#endif

static const bn_simd *choose(void) {
    const char *limit = getenv("BN_SIMD");
    if (limit != NULL && strcmp(limit, "scalar") == 0) return &bn_simd_scalar;
#if defined(BN_SIMD_X86)
    if (has_avx2()) return &bn_simd_avx2;
#elif defined(BN_SIMD_ARM)
    return &bn_simd_neon;
#endif
    return &bn_simd_scalar;
}

/* Chosen once, because CPUID takes microseconds in a virtual machine. Concurrent threads all get the same
 * result. */
const bn_simd *bn_simd_get(void) {
#if defined(__GNUC__)
    static const bn_simd *chosen;
    const bn_simd *simd = __atomic_load_n(&chosen, __ATOMIC_RELAXED);
    if (simd == NULL) {
        simd = choose();
        __atomic_store_n(&chosen, simd, __ATOMIC_RELAXED);
    }
    return simd;
#else
    return choose();
#endif
}
