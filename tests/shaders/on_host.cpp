/* SPDX-License-Identifier: Apache-2.0
 * draw.comp on the host: the Metal code or, with -DGLSL, the GLSL code, compiled as C++ with stand-ins for features
 * of these languages. */
#include "run_on_host.h"
#include "stand_ins.h"
#include <string.h>

static const uint32_t *words;
static const float *cdf;

static uint floatBitsToUint(float v) {
    return as_type<uint>(v);
}

#ifdef GLSL
#define BN_WORD(i) words[i]
#include "bn/bn_draw.glsl"
#include "bn/bn_path.glsl"
/* C++ has no `inout`. */
#define BN_BOOL bool
#define BN_FALSE false
#define BN_CHOOSE_U float &u
#define BN_CHOOSE_GET_U u
#define BN_TO_UINT(v) uint(v)
#define BN_TO_FLOAT(v) float(v)
#define BN_CHOOSE_TABLE uint first,
#define BN_CHOOSE_LIMIT(i) cdf[first + (i)]
#include "bn/bn_choose.glsl"
#else
#define device
#define thread
#include "bn/bn_choose.metal"
#include "bn/bn_draw.metal"
#include "bn/bn_path.metal"
#undef device
#undef thread
/* In Metal, these functions take the tables as arguments. */
#define bn_draw_blue_bits(...) bn_draw_blue_bits(words, __VA_ARGS__)
#define bn_draw_blue_4d(...) bn_draw_blue_4d(words, __VA_ARGS__)
#define bn_draw_blue_pair_bits(...) bn_draw_blue_pair_bits(words, __VA_ARGS__)
#define bn_draw_blue_2d(...) bn_draw_blue_2d(words, __VA_ARGS__)
#define bn_ray_draw(...) bn_ray_draw(words, __VA_ARGS__)
#define bn_ray_draw_direction(...) bn_ray_draw_direction(words, __VA_ARGS__)
#define bn_ray_draw_end_light(...) bn_ray_draw_end_light(words, __VA_ARGS__)
#define bn_ray_draw_1d(...) bn_ray_draw_1d(words, __VA_ARGS__)
#define bn_ray_draw_2d(...) bn_ray_draw_2d(words, __VA_ARGS__)
#define bn_ray_draw_4d(...) bn_ray_draw_4d(words, __VA_ARGS__)
#define bn_path_first_light(...) bn_path_first_light(words, __VA_ARGS__)
#define bn_path_time_wavelength(...) bn_path_time_wavelength(words, __VA_ARGS__)
#define bn_loop_draw_1d(...) bn_loop_draw_1d(words, __VA_ARGS__)
#define bn_choose_cdf(first, ...) bn_choose_cdf(cdf + (first), __VA_ARGS__)
#endif

static float uintBitsToFloat(uint bits) {
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static const uint32_t *asked;
#define CASE(i) asked[i]
#define out
#include "answer.glsl"

void answer(const uint32_t *own_words, const float *own_cdf, const uint32_t *own_asked,
            uint32_t *result) {
    words = own_words;
    cdf = own_cdf;
    asked = own_asked;
    answer(result);
}
