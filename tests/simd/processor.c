/* SPDX-License-Identifier: Apache-2.0
 * The library finds the instruction set NAME if the compiler's own check does: simd_processor NAME. */
#include "simd/simd.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv) {
    const char *name = argc == 2 ? argv[1] : "";
    int supported = -1;
    __builtin_cpu_init();
    if (strcmp(name, "avx2") == 0) supported = __builtin_cpu_supports("avx2") != 0;
    if (strcmp(name, "avx512") == 0) {
        supported = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
    }
    setenv("BN_SIMD", name, 1);
    const int found = strcmp(bn_simd_get()->name, name) == 0;
    printf("%s: the library says %d, the compiler %d\n", name, found, supported);
    return found != supported;
}
