// SPDX-License-Identifier: Apache-2.0
// Replaces OpenQMC's SobolBnSampler with libbn's sampler. Put this folder before OpenQMC's in the include path.
#ifndef BN_OQMC_SOBOLBN_H
#define BN_OQMC_SOBOLBN_H

#include "../bn_oqmc.h"
#include <oqmc/gpu.h>

namespace oqmc {
using SobolBnSampler = bn::OpenQmcSampler;
} // namespace oqmc

#endif
