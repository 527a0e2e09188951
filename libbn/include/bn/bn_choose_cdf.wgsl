/* SPDX-License-Identifier: Apache-2.0
 * bn_choose_cdf() in WGSL, for shaders that also contain bn_choose.wgsl and say where their tables are.
 * `first` is where a table begins. Translated from bn_choose.glsl by libbn/tools/make_wgsl.py.
 *
 *     @group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
 *
 *     let light = bn_choose_cdf(first, light_count, &u); */

fn bn_choose_cdf(first: u32, count: u32, u: ptr<function, f32>) -> u32 {
    let place = bn_choose_step(*u);
    var item = 0u;
    var last = select(0u, count - 1u, count > 0u);
    var low = 0u;
    var high = BN_CHOOSE_STEPS; /* of the item, as far as they are known */
    while (item < last) {
        let middle = item + (last - item) / 2u;
        let limit = bn_choose_steps_below(bn_cdf[first + middle]);
        if (place < limit) {
            last = middle;
            high = limit;
        } else {
            item = middle + 1u;
            low = limit;
        }
    }
    *u = bn_choose_float(bn_choose_stretch(place - low, high - low));
    return item;
}
