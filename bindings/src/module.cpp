/* SPDX-License-Identifier: Apache-2.0
 * The extension module bluenoise._core, which runs libbn on NumPy arrays without the GIL. The
 * package's Python files check and convert all arguments, so types and ranges are valid here. */
#include "core.hpp"

PYBIND11_MODULE(_core, module) {
    module.doc() = "libbn on NumPy arrays; use the bluenoise package.";
    module.attr("__version__") = bn_version_string();
    bluenoise::bind_errors(module);
    bluenoise::bind_sampler(module);
    bluenoise::bind_masks(module);
#ifndef BN_NO_NEURAL
    bluenoise::bind_neural(module);
#endif
}
