// SPDX-License-Identifier: Apache-2.0
// The few Cycles names that blue.h uses, defined as in the CPU kernels.
#pragma once

#include <bn/bn.h>

#include <cstdint>
#include <cstring>
#include <vector>

#define CCL_NAMESPACE_BEGIN namespace ccl {
#define CCL_NAMESPACE_END }
#define ccl_device_inline [[maybe_unused]] static inline
#define kernel_data kg->data
#define kernel_data_fetch(name, index) kg->name[index]

namespace ccl {
typedef unsigned uint;
struct float2 {
    float x, y;
};
struct float3 {
    float x, y, z;
};
struct float4 {
    float x, y, z, w;
};
struct Globals {
    struct {
        struct {
            uint seed;
        } integrator;
    } data;
    std::vector<float> sample_pattern_lut;
};
typedef const Globals *KernelGlobals;

enum {
    PRNG_FILTER = 0,
    PRNG_LENS_TIME = 1,
    PRNG_TERMINATE = 0,
    PRNG_LIGHT = 1,
    PRNG_LIGHT_TERMINATE = 2,
    PRNG_SURFACE_BSDF = 3,
    PRNG_SURFACE_AO = 4,
    PRNG_SURFACE_BEVEL = 5,
    PRNG_SURFACE_BSDF_GUIDING = 6,
    PRNG_SURFACE_RIS_GUIDING_0 = 10,
    PRNG_SURFACE_RIS_GUIDING_1 = 11,
    PRNG_VOLUME_PHASE = 3,
    PRNG_VOLUME_PHASE_CHANNEL = 4,
    PRNG_VOLUME_PHASE_GUIDING_EQUIANGULAR = 9,
    PRNG_BOUNCE_NUM = 16
};

inline float2 make_float2(float x, float y) {
    return {x, y};
}
inline float3 make_float3(float x, float y, float z) {
    return {x, y, z};
}
inline float4 make_float4(float x, float y, float z, float w) {
    return {x, y, z, w};
}
inline uint __float_as_uint(float f) {
    uint u;
    std::memcpy(&u, &f, 4);
    return u;
}
inline uint reverse_integer_bits(uint v) {
    uint r = 0;
    for (int i = 0; i < 32; ++i) r |= (v >> i & 1) << (31 - i);
    return r;
}
} // namespace ccl
