/* SPDX-License-Identifier: Apache-2.0
 * Sets the default floating-point environment, in functions that compilers cannot see into. They
 * are not inlined even if the whole library is compiled as one file. */
#include "base/float_environment.h"
#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#define HAS_MXCSR 1
#endif

BN_NOINLINE void bn_float_environment_set(bn_float_environment *host) {
#if defined(HAS_MXCSR)
    host->mxcsr = _mm_getcsr();
#endif
    fegetenv(&host->fenv);
    fesetenv(FE_DFL_ENV);
#if defined(HAS_MXCSR)
    _mm_setcsr(0x1f80); /* the CPU's default: rounds to nearest, flushes and traps nothing */
#endif
}

BN_NOINLINE void bn_float_environment_restore(const bn_float_environment *host) {
    fesetenv(&host->fenv);
#if defined(HAS_MXCSR)
    _mm_setcsr(host->mxcsr);
#endif
}
