/* SPDX-License-Identifier: Apache-2.0
 * C++ stand-ins for the types and functions of GLSL and Metal that the tests use. */
#include <stdint.h>
#include <string.h>

typedef uint32_t uint;
struct uint2 {
    uint x, y;
    uint2(uint x = 0, uint y = 0) : x(x), y(y) {}
};
struct uint4 {
    uint x, y, z, w;
};
struct float4 {
    float x, y, z, w;
    float4(float x = 0, float y = 0, float z = 0, float w = 0) : x(x), y(y), z(z), w(w) {}
    float4 operator*(float s) const { return float4(x * s, y * s, z * s, w * s); }
    float operator[](int i) const { return (&x)[i]; }
};
struct float2 {
    float x, y;
    float2(float x = 0, float y = 0) : x(x), y(y) {}
    float2 operator*(float s) const { return float2(x * s, y * s); }
};
typedef uint2 uvec2;
typedef uint4 uvec4;
typedef float2 vec2;
typedef float4 vec4;

template <class To>
static inline To as_type(float v) {
    To bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

namespace metal {
static inline uint reverse_bits(uint v) {
    uint reversed = 0;
    for (int i = 0; i < 32; ++i) reversed |= (v >> i & 1u) << (31 - i);
    return reversed;
}
static inline uint mulhi(uint a, uint b) {
    return uint(uint64_t(a) * b >> 32);
}
} // namespace metal
