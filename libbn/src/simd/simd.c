/* SPDX-License-Identifier: Apache-2.0
 * Chooses the instruction set at run time. */
#include "simd/simd.h"
#include <stdlib.h>
#include <string.h>
#if defined(BN_SIMD_X86)
#include <cpuid.h>
#endif

extern const bn_simd bn_simd_scalar, bn_simd_avx2, bn_simd_avx512, bn_simd_neon;

#if defined(BN_SIMD_X86)

enum { AVX2 = 1, AVX512 = 2 };

/* Instruction sets of the CPU whose registers the system saves. __builtin_cpu_supports() finds
 * nothing in programs that "zig cc" has linked. */
static int x86_sets(void) {
    const unsigned avx512 = bit_AVX512F | bit_AVX512BW | bit_AVX512VL | bit_AVX512DQ;
    const unsigned vectors = 0x06, masks_and_wide_vectors = 0xe6; /* in XCR0 */
    unsigned a, b, c, d, saved, upper;
    int sets = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d)) return 0;
    if (!(c & bit_OSXSAVE) || !(c & bit_AVX)) return sets;
    __asm__ volatile("xgetbv" : "=a"(saved), "=d"(upper) : "c"(0));
    if ((saved & vectors) != vectors || !__get_cpuid_count(7, 0, &a, &b, &c, &d)) return sets;
    if (b & bit_AVX2) sets |= AVX2;
    if ((saved & masks_and_wide_vectors) == masks_and_wide_vectors && (b & avx512) == avx512) {
        sets |= AVX512;
    }
    return sets;
}

#endif

/* From the least capable to the most; the build defines which files there are. */
static int available(const bn_simd *sets[3]) {
    int count = 0;
    sets[count++] = &bn_simd_scalar;
#if defined(BN_SIMD_X86)
    const int have = x86_sets();
    if (have & AVX2) sets[count++] = &bn_simd_avx2;
    if (have & AVX512) sets[count++] = &bn_simd_avx512;
#elif defined(BN_SIMD_ARM)
    sets[count++] = &bn_simd_neon;
#endif
    return count;
}

static const bn_simd *choose(void) {
    const bn_simd *sets[3];
    int count = available(sets);
    const char *limit = getenv("BN_SIMD");
    if (limit != NULL) {
        for (int i = 0; i < count; ++i) {
            if (strcmp(limit, sets[i]->name) == 0) return sets[i];
        }
    }
    return sets[count - 1];
}

/* Chosen once, because CPUID takes microseconds in a virtual machine. Threads that come at the same time
 * all find the same. */
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
