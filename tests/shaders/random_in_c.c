/* SPDX-License-Identifier: Apache-2.0
 * examples/web/package/random.glsl over bn_draw.glsl and bn_path.glsl, for C. */
#include "random_in_c.h"
#include "draws_in_c.h"
#include <stdbool.h>

typedef bn_uint2 uvec2;
typedef struct vec2 {
    float x, y;
} vec2;
typedef struct vec3 {
    float x, y, z;
} vec3;
typedef struct vec4 {
    float x, y, z, w;
} vec4;

static float random_float(uint32_t bits) {
    return (float)(bits >> 8) / (1 << 24);
}

static vec4 bn_draw_blue(bn_uint2 seed, uint32_t x, uint32_t y, uint32_t index, uint32_t domain) {
    const bn_uint4 v = bn_draw_blue_bits(seed, x, y, index, domain);
    const vec4 out = {random_float(v.x), random_float(v.y), random_float(v.z), random_float(v.w)};
    return out;
}

static vec2 bn_draw_blue_pair(bn_uint2 seed, uint32_t x, uint32_t y, uint32_t index,
                              uint32_t domain, uint32_t pair) {
    const bn_uint2 v = bn_draw_blue_pair_bits(seed, x, y, index, domain, pair);
    const vec2 out = {random_float(v.x), random_float(v.y)};
    return out;
}

static vec3 random_vec3(float x, float y, float z) {
    const vec3 out = {x, y, z};
    return out;
}

#define vec3(x, y, z) random_vec3(x, y, z)
#define uvec2(x, y)                                                                                \
    { x, y }
#define BN_EFFECT_PIXEL RANDOM_PIXEL
#if RANDOM_WITH_LENS
#define BN_EFFECT_LENS RANDOM_LENS
#define BN_EFFECT_ENVIRONMENT RANDOM_ENVIRONMENT
#define BN_EFFECT_CHOICE RANDOM_CHOICE
#endif
#define BN_EFFECT_DIRECTION RANDOM_DIRECTION
#define BN_EFFECT_LIGHT RANDOM_LIGHT
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wstrict-prototypes"
#endif
#include "../../examples/web/package/random.glsl"
#undef uint

void random_glsl(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                 float out[RANDOM_NUMBERS]) {
    /* The last bounces by rngNextBounce(). */
    const uint32_t last = asked[3] < 3 ? asked[3] : 3;
    const uvec2 pixel = {asked[0], asked[1]};
    const bn_uint2 seed = {asked[5], asked[6]};
    glsl_words = words;
    rngSeed(seed);
    rngInit(pixel, asked[2], asked[3] - last);
    for (uint32_t i = 0; i < last; ++i) rngNextBounce();
    const vec2 two = rand2(asked[4]);
    const vec3 three = rand3(asked[4]);
    const vec4 four = rand4(asked[4]);
    const float all[] = {rand1(asked[4]), two.x,  two.y,  three.x, three.y,
                         three.z,         four.x, four.y, four.z,  four.w};
    for (int i = 0; i < RANDOM_NUMBERS; ++i) out[i] = all[i];
}
