/* SPDX-License-Identifier: Apache-2.0
 * draw.comp in WGSL. The tests add the texts of the four libbn files and a translation of answer.glsl. */
@group(0) @binding(0) var<storage, read> bn_words: array<u32>;
@group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
@group(0) @binding(2) var<storage, read> cases: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

var<private> at: u32;
var<private> result: array<u32, 16>;

fn CASE(i: u32) -> u32 {
    return cases[at + i];
}

fn floatBitsToUint(v: f32) -> u32 {
    return bitcast<u32>(v);
}

fn uintBitsToFloat(v: u32) -> f32 {
    return bitcast<f32>(v);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    at = 16u * id.x;
    if (at >= arrayLength(&cases)) {
        return;
    }
    answer();
    for (var i = 0u; i < 16u; i++) {
        results[at + i] = result[i];
    }
}
