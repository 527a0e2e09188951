/* SPDX-License-Identifier: Apache-2.0
 * Makes floating-point arithmetic independent of the host's settings, such as directed rounding,
 * flush-to-zero, denormals-are-zero and traps. A public function that computes with floats ends with
 * BN_RETURN_IN_DEFAULT_ENVIRONMENT(), which sets the default environment, calls the function that does the work,
 * and restores the host's environment with its exception flags. The inner function is BN_NOINLINE, so that no
 * computation is moved out of it. Threads started inside inherit the default environment. */
#ifndef BN_FLOAT_ENVIRONMENT_H
#define BN_FLOAT_ENVIRONMENT_H

#include <bn/bn.h>
#include <fenv.h>

#if (defined(__i386__) && !defined(__SSE2_MATH__)) || (defined(_M_IX86_FP) && _M_IX86_FP < 2)
#error                                                                                             \
    "On 32-bit x86, libbn needs SSE2, as x87 arithmetic gives other bits: add -msse2 -mfpmath=sse"
#endif

/* NaN checks examine bits, so they still work, but sums may be reordered. */
#if (defined(__FAST_MATH__) || defined(_M_FP_FAST)) && !defined(BN_ALLOW_FAST_MATH)
#pragma message(                                                                                   \
    "libbn is compiled with -ffast-math: masks and dithering may have other bits than elsewhere. Add -fno-fast-math, or -DBN_ALLOW_FAST_MATH to hide this")
#endif

#if defined(_MSC_VER)
#define BN_NOINLINE __declspec(noinline)
#else
#define BN_NOINLINE __attribute__((noinline))
#endif

typedef struct bn_float_environment {
    fenv_t fenv;
    unsigned mxcsr; /* SSE's control register, which MinGW's <fenv.h> ignores */
} bn_float_environment;

void bn_float_environment_set(bn_float_environment *host);
void bn_float_environment_restore(const bn_float_environment *host);

#define BN_RETURN_IN_DEFAULT_ENVIRONMENT(call)                                                     \
    do {                                                                                           \
        bn_float_environment host;                                                                 \
        bn_float_environment_set(&host);                                                           \
        const bn_result result = (call);                                                           \
        bn_float_environment_restore(&host);                                                       \
        return result;                                                                             \
    } while (0)

#endif
