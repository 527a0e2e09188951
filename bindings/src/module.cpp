/* SPDX-License-Identifier: Apache-2.0
 * The extension module bluenoise._core: libbn on NumPy arrays, without the interpreter lock. The
 * Python files beside it check and convert the arguments of users; what arrives here has its type
 * and range. */
#include "core.hpp"

/* Everything behind this module is immutable or belongs to one call, so it needs no global lock. */
PYBIND11_MODULE(_core, module, pybind11::mod_gil_not_used()) {
    module.doc() = "libbn on NumPy arrays; use the package bluenoise.";
    module.attr("__version__") = bn_version_string();
    bluenoise::bind_errors(module);
    bluenoise::bind_sampler(module);
    bluenoise::bind_masks(module);
    bluenoise::bind_images(module);
#ifndef BN_NO_NEURAL
    bluenoise::bind_neural(module);
#endif
}
