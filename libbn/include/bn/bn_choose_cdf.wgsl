/* SPDX-License-Identifier: Apache-2.0
 * bn_choose_cdf() in WGSL, for shaders that also contain bn_choose.wgsl and declare their tables.
 * `first` is the index of a table's first entry. Translated from bn_choose.glsl by
 * libbn/tools/make_wgsl.py.
 *
 *     @group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
 *
 *     let light = bn_choose_cdf(first, light_count, &u); */

fn bn_choose_cdf(first: u32, count: u32, u: ptr<function, f32>) -> u32 {
    let at = bn_choose_step(*u);
    var item = 0u;
    var last = select(0u, count - 1u, count > 0u);
    let end = last;
    var low = 0u;
    var high = BN_CHOOSE_STEPS;
    var sum = 1.0f;
    if (last > 0u) {
        sum = bn_cdf[first + last];
    }
    if (!bn_choose_positive(sum) || sum < 1e-30f || sum > 1e30f) {
        sum = 1.0f;
    }
    let unit = sum * (1.0f / 16777216.0f);
    while (item < last) {
        let middle = item + (last - item) / 2u;
        if (bn_choose_is_below(at, unit, bn_cdf[first + middle])) {
            last = middle;
        } else {
            item = middle + 1u;
        }
    }
    if (item > 0u) {
        low = bn_choose_steps_of(unit, bn_cdf[first + item - 1u]);
    }
    if (item < end) {
        high = bn_choose_steps_of(unit, bn_cdf[first + item]);
    }
    *u = bn_choose_float(bn_choose_stretch(at - low, high - low));
    return item;
}
