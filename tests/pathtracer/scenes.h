// SPDX-License-Identifier: Apache-2.0
// What the tests make scenes and samplers of.
#pragma once

#include <memory>
#include <vector>

#include "sampler.h"
#include "scene.h"

// A sky that is equally bright all around.
inline std::shared_ptr<const Environment> even_environment(float radiance = 1) {
    return std::make_shared<const Environment>(
        environment_create(8, 4, std::vector<Vec3>(32, {radiance, radiance, radiance})));
}

inline SamplerPointer sampler_named(const char *name, uint64_t seed = 0) {
    SamplerSettings settings;
    settings.name = name;
    settings.seed = seed;
    return sampler_create(settings);
}
