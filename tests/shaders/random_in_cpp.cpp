// SPDX-License-Identifier: Apache-2.0
// examples/web/package/random.glsl over bn_draw.glsl and bn_path.glsl as a shader sees them: the words of GLSL
// that they use are defined for a C++ compiler. Compiled twice, with a lens and without.
#include "random_in_cpp.h"

namespace {

struct uvec2 {
    uint32_t x, y;
};
struct vec2 {
    float x, y;
    vec2(float a, float b) : x(a), y(b) {}
    vec2 operator*(float v) const { return vec2(x * v, y * v); }
};
struct vec3 {
    float x, y, z;
    vec3(float a, float b, float c) : x(a), y(b), z(c) {}
};
struct vec4 {
    float x, y, z, w;
    vec4(float a, float b, float c, float d) : x(a), y(b), z(c), w(d) {}
    vec4 operator*(float v) const { return vec4(x * v, y * v, z * v, w * v); }
};

const uint32_t *random_words;

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define BN_WORD(i) random_words[i]
#define uint uint32_t
#define BN_UINT uint
#define BN_FLOAT2 vec2
#define BN_FLOAT4 vec4
#define BN_FUNCTION
#define BN_TABLE
#define BN_PASS_TABLE
#define BN_EFFECT_PIXEL RANDOM_PIXEL
#if RANDOM_WITH_LENS
#define BN_EFFECT_LENS RANDOM_LENS
#define BN_EFFECT_ENVIRONMENT RANDOM_ENVIRONMENT
#define BN_EFFECT_CHOICE RANDOM_CHOICE
#endif
#define BN_EFFECT_DIRECTION RANDOM_DIRECTION
#define BN_EFFECT_LIGHT RANDOM_LIGHT
#include <bn/bn_draw.glsl>
#include <bn/bn_path.glsl>

#include "../../examples/web/package/random.glsl"
#undef uint

} // namespace

#if RANDOM_WITH_LENS
#define random_glsl random_glsl_with_lens
#endif

void random_glsl(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                 float out[RANDOM_NUMBERS]) {
    random_words = words;
    // One part of the bounces by rngNextBounce().
    const uint32_t later = asked[3] < 3 ? asked[3] : 3;
    rngInit(uvec2{asked[0], asked[1]}, asked[2], asked[3] - later);
    for (uint32_t i = 0; i < later; ++i) rngNextBounce();
    const vec2 two = rand2(asked[4]);
    const vec3 three = rand3(asked[4]);
    const vec4 four = rand4(asked[4]);
    const float all[] = {rand1(asked[4]), two.x,  two.y,  three.x, three.y,
                         three.z,         four.x, four.y, four.z,  four.w};
    for (int i = 0; i < RANDOM_NUMBERS; ++i) out[i] = all[i];
}
