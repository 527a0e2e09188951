/* SPDX-License-Identifier: Apache-2.0
 * The default floating-point environment, in a file of its own so that compilers cannot see into
 * these calls. */
#include "base/float_environment.h"

void bn_float_environment_set(fenv_t *host) {
    fegetenv(host);
    fesetenv(FE_DFL_ENV);
}

void bn_float_environment_restore(const fenv_t *host) {
    fesetenv(host);
}
