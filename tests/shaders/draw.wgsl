/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in WGSL; the texts of the four files are put behind it. */
@group(0) @binding(0) var<storage, read> bn_words: array<u32>;
@group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
@group(0) @binding(2) var<storage, read> cases: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let at = 16u * id.x;
    if (at >= arrayLength(&cases)) {
        return;
    }
    let x = cases[at + 1u];
    let y = cases[at + 2u];
    let index = cases[at + 3u];
    let domain = bn_domain_child(cases[at + 4u], cases[at + 5u]);
    let pair = cases[at] >> 2u;
    let seed = vec2u(cases[at + 10u], cases[at + 11u]);
    var bits: vec4u;
    var v: vec2u;
    var draw: vec4f;
    var w: vec2f;
    switch (cases[at] & 3u) {
        case 0u: {
            bits = bn_draw_blue_bits(seed, x, y, index, domain);
            draw = bn_draw_blue_4d(seed, x, y, index, domain);
            v = bn_draw_blue_pair_bits(seed, x, y, index, domain, pair);
            w = bn_draw_blue_2d(seed, x, y, index, domain, pair);
        }
        case 1u: {
            bits = bn_draw_sobol_bits(seed, x, y, index, domain);
            draw = bn_draw_sobol_4d(seed, x, y, index, domain);
            v = bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair);
            w = bn_draw_sobol_2d(seed, x, y, index, domain, pair);
        }
        default: {
            bits = bn_draw_white_bits(seed, x, y, index, domain);
            draw = bn_draw_white_4d(seed, x, y, index, domain);
            v = bn_draw_white_pair_bits(seed, x, y, index, domain, pair);
            w = bn_draw_white_2d(seed, x, y, index, domain, pair);
        }
    }
    results[at] = domain;
    for (var d = 0u; d < 4u; d++) {
        results[at + 1u + d] = bits[d];
        results[at + 5u + d] = bitcast<u32>(draw[d]);
    }

    let probability = bitcast<f32>(cases[at + 6u]);
    let u = bitcast<f32>(cases[at + 7u]);
    var left = u;
    results[at + 9u] = u32(bn_choose(probability, &left));
    results[at + 10u] = bitcast<u32>(left);
    left = u;
    results[at + 11u] = bn_choose_u32(cases[at + 8u], &left);
    results[at + 12u] = bitcast<u32>(left);
    left = u;
    results[at + 13u] = bn_choose_cdf(cases[at + 9u] & 255u, cases[at + 9u] >> 8u, &left);
    results[at + 14u] = bitcast<u32>(left);
    let k = cases[at + 13u];
    let branches = cases[at + 14u];
    let path = bn_path_start(x, y, index, cases[at + 15u]);
    let ray = bn_path_ray_domain(path, cases[at + 12u]);
    let split = bn_ray_split_domain(ray, k);
    let branch = bn_path_branch(path, split, branches, k);
    let last = bn_path_branch(branch, split, branches, branches);
    let path_words = 9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray +
        19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray, k) + 23u * bn_ray_1d_pair(k) +
        25u * bn_ray_2d_domain(ray, k) + 27u * bn_ray_2d_pair(k) + 29u * bn_ray_4d_domain(ray, k) + 31u * split +
        33u * branch.x + 35u * branch.y + 37u * branch.index + 39u * branch.domain + 41u * last.index +
        43u * last.domain + 45u * bn_loop_bits(seed, branch, bn_ray_loop_domain(ray, k), k) +
        47u * bn_ray_child_domain(ray, k);
    results[at + 15u] = v.x + 3u * v.y + 5u * bitcast<u32>(w.x) + 7u * bitcast<u32>(w.y) + path_words;
}
