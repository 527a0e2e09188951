/* SPDX-License-Identifier: Apache-2.0
 * Random numbers for a path tracer in a shader, requested by decision. Needs bn_draw.glsl and bn_path.glsl before it.
 * GLSL ES 3.00 and GLSL 3.30; make_texts.py translates it to WGSL.
 *
 *     rngInit(uvec2(gl_FragCoord.xy), sampleNumber, 0u);
 *     vec2 jitter = rand2(PIXEL);
 *     for (each bounce) {
 *         ... rand2(LIGHT), rand1(ROULETTE), rand2(DIRECTION), rand1(ALPHA + primitive) ...
 *         rngNextBounce();
 *     }
 *
 * `effect` is a number below 2^32 - 1 that identifies the decision. The same effect at the same bounce always gives
 * the same numbers, so use each effect for one decision and in only one of the four functions. An effect draws from
 * bn_ray_child_domain() of the ray that ends at the bounce, unless a macro gives it a role in the layout of
 * bn_path.h:
 *
 *     BN_EFFECT_PIXEL        rand2: the pixel position, at bounce 0
 *     BN_EFFECT_LENS         rand2: the lens, at bounce 0; rand3: the same plus one number. With a lens,
 *                            the first light moves to the camera's domain
 *     BN_EFFECT_DIRECTION    rand2: the direction in which the path continues
 *     BN_EFFECT_LIGHT        rand2: a point on a light; rand3: the light, then the point
 *     BN_EFFECT_ENVIRONMENT  rand2: the same numbers as BN_EFFECT_LIGHT, for paths that sample either this or a light
 *     BN_EFFECT_CHOICE       rand1: the choice between the two, in the same domain as rand3(BN_EFFECT_LIGHT)
 *
 * index.js defines these macros, as BN_NO_EFFECT for decisions that a renderer does not make. */

#define BN_NO_EFFECT 0xffffffffu

uvec2 bn_rng_seed = uvec2(0x7b1dcdafu, 0xe220a839u); /* seed 0 */
bn_path bn_rng_path;
uint bn_rng_bounce;

/* The seed comes from seedWords() in index.js or from bn_sampler_seed(). Different seeds give independent images. */
void rngSeed(uvec2 seed) {
    bn_rng_seed = seed;
}

/* Starts sample pathIndex of a pixel at bounce 0, or at the bounce where a later pass continues it. */
void rngInit(uvec2 pixel, uint pathIndex, uint bounceIndex) {
    bn_rng_path = bn_path_start(pixel.x, pixel.y, pathIndex, 0u);
    bn_rng_bounce = bounceIndex;
}

void rngNextBounce() {
    bn_rng_bounce += 1u;
}

uint bn_rng_domain(uint effect) {
    return bn_ray_child_domain(bn_path_ray_domain(bn_rng_path, bn_rng_bounce), effect);
}

vec2 bn_rng_pair(uint domain, uint pair) {
    return bn_draw_blue_2d(bn_rng_seed, bn_rng_path.x, bn_rng_path.y, bn_rng_path.index, domain, pair);
}

vec4 rand4(uint effect) {
    return bn_draw_blue_4d(bn_rng_seed, bn_rng_path.x, bn_rng_path.y, bn_rng_path.index, bn_rng_domain(effect));
}

vec2 rand2(uint effect) {
    bool first = bn_rng_bounce == 0u;
    if (effect == BN_EFFECT_DIRECTION)
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, bn_rng_bounce + 1u), 0u);
    if (first && effect == BN_EFFECT_PIXEL)
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, 0u), 0u);
    if (first && effect == BN_EFFECT_LENS)
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, 0u), 1u);
    if (effect == BN_EFFECT_LIGHT || effect == BN_EFFECT_ENVIRONMENT) {
        if (first && BN_EFFECT_LENS != BN_NO_EFFECT)
            return bn_rng_pair(bn_path_camera_domain(bn_rng_path), 0u);
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, bn_rng_bounce), 1u);
    }
    return bn_rng_pair(bn_rng_domain(effect), 0u);
}

float rand1(uint effect) {
    if (effect == BN_EFFECT_CHOICE)
        return bn_rng_pair(bn_rng_domain(BN_EFFECT_LIGHT), 1u).y;
    return bn_rng_pair(bn_rng_domain(effect), 0u).x;
}

vec3 rand3(uint effect) {
    if (effect == BN_EFFECT_LENS && bn_rng_bounce == 0u) {
        vec2 lens = rand2(effect);
        return vec3(lens.x, lens.y, rand1(effect));
    }
    vec4 u = rand4(effect);
    if (effect == BN_EFFECT_LIGHT) return vec3(u.z, u.x, u.y);
    return vec3(u.x, u.y, u.z);
}
