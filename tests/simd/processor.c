/* SPDX-License-Identifier: Apache-2.0
 * The library finds the instruction sets that the compiler's own check finds. */
#include "simd/simd.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures;

static void expect(const char *name, int supported) {
    setenv("BN_SIMD", name, 1);
    const int found = strcmp(bn_simd_get()->name, name) == 0;
    if (found == !supported) {
        printf("%s: the library says %d, the compiler %d\n", name, found, supported);
        ++failures;
    }
}

int main(void) {
    __builtin_cpu_init();
    expect("sse4.1", __builtin_cpu_supports("sse4.1") != 0);
    expect("avx2", __builtin_cpu_supports("avx2") != 0);
    expect("avx512", __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"));
    return failures != 0;
}
