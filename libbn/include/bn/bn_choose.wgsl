/* SPDX-License-Identifier: Apache-2.0
 * bn_choose() and bn_choose_u32() in WGSL, translated from bn_choose.glsl by libbn/tools/make_wgsl.py.
 * Concatenate this file with your shader, with or without bn_draw.wgsl. bn_choose.h documents them.
 *
 *     var u = draw.x;
 *     let light = bn_choose_u32(light_count, &u); // u is now the remainder
 *
 * WGSL compilers may flush subnormal numbers to 0 and treat NaN as any value. */

const BN_CHOOSE_STEPS = 0x1000000u; /* steps of 2^-24 in [0, 1) */

/* No comparison is true for NaN. */
fn bn_choose_positive(v: f32) -> bool {
    return v > 0.0f;
}

/* The step that contains u; 0 for NaN. */
fn bn_choose_step(u: f32) -> u32 {
    if (!bn_choose_positive(u)) {
        return 0u;
    }
    return select(BN_CHOOSE_STEPS - 1u, u32(u * 16777216.0f), u < 1.0f);
}

/* The number of steps below a limit: those for which u < limit. */
fn bn_choose_steps_below(limit: f32) -> u32 {
    if (!bn_choose_positive(limit)) {
        return 0u;
    }
    let steps = select(1.0f, limit, limit < 1.0f) * 16777216.0f;
    let whole = u32(steps);
    return select(whole, whole + 1u, f32(whole) < steps);
}

/* (at + 1/2) / width in steps, rounded down, by long division. Requires at < width <=
 * 2^24. */
fn bn_choose_stretch(at: u32, width: u32) -> u32 {
    var rest = 2u * at + 1u;
    var quotient = rest / width;
    rest = (rest - quotient * width) << 8u;
    quotient = (quotient << 8u) | (rest / width);
    rest = (rest - rest / width * width) << 8u;
    quotient = (quotient << 8u) | (rest / width);
    rest = (rest - rest / width * width) << 7u;
    return (quotient << 7u) | (rest / width);
}

/* The upper half of the 64-bit product, computed from half-word products. */
fn bn_multiply_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let left = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let right = (a & 0xffffu) * (b >> 16u) + (left & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u);
}

fn bn_choose_float(at: u32) -> f32 {
    return f32(at) * (1.0f / 16777216.0f);
}

fn bn_choose(probability: f32, u: ptr<function, f32>) -> bool {
    let at = bn_choose_step(*u);
    let limit = bn_choose_steps_below(probability);
    let low = select(limit, 0u, at < limit);
    let width = select(BN_CHOOSE_STEPS - limit, limit, at < limit);
    *u = bn_choose_float(bn_choose_stretch(at - low, width));
    return at < limit;
}

/* Multiplies the step's centre by count: the integer part is the choice, and the fraction is the
 * remainder. */
fn bn_choose_u32(count: u32, u: ptr<function, f32>) -> u32 {
    let n = select(1u, count, count > 0u);
    let middle = 2u * bn_choose_step(*u) + 1u;
    let low = middle * n;
    *u = bn_choose_float((low >> 1u) & (BN_CHOOSE_STEPS - 1u));
    return (bn_multiply_high(middle, n) << 7u) | (low >> 25u);
}

/* Whether a step, in a table's units, lies below a limit. */
fn bn_choose_is_below(at: u32, unit: f32, limit: f32) -> bool {
    if (!bn_choose_positive(limit)) {
        return false;
    }
    return f32(at) * unit < limit;
}

/* The number of steps below a limit. GPU quotients may be off by a few steps; products are not. */
fn bn_choose_steps_of(unit: f32, limit: f32) -> u32 {
    var at = BN_CHOOSE_STEPS;
    if (bn_choose_is_below(BN_CHOOSE_STEPS - 1u, unit, limit)) {
        return at;
    }
    if (!bn_choose_positive(limit)) {
        return 0u;
    }
    let quotient = limit / unit;
    if (quotient < 16777216.0f) {
        at = u32(quotient);
    }
    while (at > 0u && !bn_choose_is_below(at - 1u, unit, limit)) {
        at -= 1u;
    }
    while (bn_choose_is_below(at, unit, limit)) {
        at += 1u;
    }
    return at;
}
