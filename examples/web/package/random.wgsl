/* SPDX-License-Identifier: Apache-2.0
 * Random numbers for a path tracer in a shader, requested by decision. Needs bn_draw.wgsl and bn_path.wgsl, in any
 * order. random.glsl is the same in GLSL, and documents the effects.
 *
 *     rngInit(pixel, sampleNumber, 0u);
 *     let jitter = rand2(PIXEL);
 *
 * The six effects with a role in the layout of bn_path.h are constants declared elsewhere; BN_NO_EFFECT marks an
 * effect that a renderer does not use. */

const BN_NO_EFFECT = 0xffffffffu;

var<private> bn_rng_seed = vec2u(0x7b1dcdafu, 0xe220a839u); /* seed 0 */
var<private> bn_rng_path: bn_path;
var<private> bn_rng_bounce: u32;

/* The seed comes from seedWords() in index.js or from bn_sampler_seed(). Different seeds give independent images. */
fn rngSeed(seed: vec2u) {
    bn_rng_seed = seed;
}

/* Starts sample pathIndex of a pixel at bounce 0, or at the bounce where a later pass continues it. */
fn rngInit(pixel: vec2u, pathIndex: u32, bounceIndex: u32) {
    bn_rng_path = bn_path_start(pixel.x, pixel.y, pathIndex, 0u);
    bn_rng_bounce = bounceIndex;
}

fn rngNextBounce() {
    bn_rng_bounce += 1u;
}

fn bn_rng_domain(effect: u32) -> u32 {
    return bn_ray_child_domain(bn_path_ray_domain(bn_rng_path, bn_rng_bounce), effect);
}

fn bn_rng_pair(domain: u32, pair: u32) -> vec2f {
    return bn_draw_blue_2d(bn_rng_seed, bn_rng_path.x, bn_rng_path.y, bn_rng_path.index, domain, pair);
}

fn rand4(effect: u32) -> vec4f {
    return bn_draw_blue_4d(bn_rng_seed, bn_rng_path.x, bn_rng_path.y, bn_rng_path.index, bn_rng_domain(effect));
}

fn rand2(effect: u32) -> vec2f {
    let first = bn_rng_bounce == 0u;
    if (effect == BN_EFFECT_DIRECTION) {
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, bn_rng_bounce + 1u), 0u);
    }
    if (first && effect == BN_EFFECT_PIXEL) {
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, 0u), 0u);
    }
    if (first && effect == BN_EFFECT_LENS) {
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, 0u), 1u);
    }
    if (effect == BN_EFFECT_LIGHT || effect == BN_EFFECT_ENVIRONMENT) {
        if (first && BN_EFFECT_LENS != BN_NO_EFFECT) {
            return bn_rng_pair(bn_path_camera_domain(bn_rng_path), 0u);
        }
        return bn_rng_pair(bn_path_ray_domain(bn_rng_path, bn_rng_bounce), 1u);
    }
    return bn_rng_pair(bn_rng_domain(effect), 0u);
}

fn rand1(effect: u32) -> f32 {
    if (effect == BN_EFFECT_CHOICE) {
        return bn_rng_pair(bn_rng_domain(BN_EFFECT_LIGHT), 1u).y;
    }
    return bn_rng_pair(bn_rng_domain(effect), 0u).x;
}

fn rand3(effect: u32) -> vec3f {
    if (effect == BN_EFFECT_LENS && bn_rng_bounce == 0u) {
        return vec3f(rand2(effect), rand1(effect));
    }
    let u = rand4(effect);
    if (effect == BN_EFFECT_LIGHT) {
        return u.zxy;
    }
    return u.xyz;
}
