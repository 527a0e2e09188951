// SPDX-License-Identifier: Apache-2.0
// Puts libbn in the place of OpenQMC's SobolBnSampler: this folder comes before OpenQMC's in the list of include folders.
#ifndef BN_OQMC_SOBOLBN_H
#define BN_OQMC_SOBOLBN_H

#include "../bn_oqmc.h"
#include <oqmc/gpu.h>

namespace oqmc {
using SobolBnSampler = bn::OpenQmcSampler;
} // namespace oqmc

#endif
