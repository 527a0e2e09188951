/* SPDX-License-Identifier: Apache-2.0
 * Stand-ins in C++ for what the tests take from Metal. */
#include <stdint.h>

#define device
#define thread
#define constant const
typedef uint32_t uint;
struct uint2 {
    uint x, y;
};
struct uint4 {
    uint x, y, z, w;
};
struct float4 {
    float x, y, z, w;
    float4(float x, float y, float z, float w) : x(x), y(y), z(z), w(w) {}
    float4 operator*(float s) const { return float4(x * s, y * s, z * s, w * s); }
};
struct float2 {
    float x, y;
    float2(float x, float y) : x(x), y(y) {}
    float2 operator*(float s) const { return float2(x * s, y * s); }
};
namespace metal {
static uint reverse_bits(uint v) {
    uint reversed = 0;
    for (int i = 0; i < 32; ++i) reversed |= (v >> i & 1u) << (31 - i);
    return reversed;
}
static uint mulhi(uint a, uint b) {
    return uint(uint64_t(a) * b >> 32);
}
} // namespace metal
