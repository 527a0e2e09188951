/* SPDX-License-Identifier: Apache-2.0
 * examples/web/package/random.glsl over bn_draw.glsl and bn_path.glsl, as C++. */
#include "random_on_host.h"
#include "stand_ins.h"

typedef struct vec3 {
    float x, y, z;
    vec3(float x, float y, float z) : x(x), y(y), z(z) {}
    vec3(vec2 v, float z) : x(v.x), y(v.y), z(z) {}
} vec3;
static const uint32_t *glsl_words;
#define BN_WORD(i) glsl_words[i]
#include "bn/bn_draw.glsl"
#include "bn/bn_path.glsl"
#define BN_EFFECT_PIXEL RANDOM_PIXEL
#if RANDOM_WITH_LENS
#define BN_EFFECT_LENS RANDOM_LENS
#define BN_EFFECT_ENVIRONMENT RANDOM_ENVIRONMENT
#define BN_EFFECT_CHOICE RANDOM_CHOICE
#endif
#define BN_EFFECT_DIRECTION RANDOM_DIRECTION
#define BN_EFFECT_LIGHT RANDOM_LIGHT
#include "../../examples/web/package/random.glsl"

void random_glsl(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                 float out[RANDOM_NUMBERS]) {
    /* The last bounces by rngNextBounce(). */
    const uint32_t last = asked[3] < 3 ? asked[3] : 3;
    glsl_words = words;
    rngSeed(uvec2(asked[5], asked[6]));
    rngInit(uvec2(asked[0], asked[1]), asked[2], asked[3] - last);
    for (uint32_t i = 0; i < last; ++i) rngNextBounce();
    const vec2 two = rand2(asked[4]);
    const vec3 three = rand3(asked[4]);
    const vec4 four = rand4(asked[4]);
    const float all[] = {rand1(asked[4]), two.x,  two.y,  three.x, three.y,
                         three.z,         four.x, four.y, four.z,  four.w};
    for (int i = 0; i < RANDOM_NUMBERS; ++i) out[i] = all[i];
}
