/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in WGSL; the texts of the four files are put behind it. */
@group(0) @binding(0) var<storage, read> bn_words: array<u32>;
@group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
@group(0) @binding(2) var<storage, read> cases: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

fn words_of(factor: u32, v: vec2f) -> u32 {
    return factor * bitcast<u32>(v.x) + (factor + 2u) * bitcast<u32>(v.y);
}

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
        43u * last.domain + 45u * bn_loop_later_bits(seed, branch, bn_ray_loop_domain(ray, k), k) +
        47u * bn_ray_child_domain(ray, k) + 49u * domain;
    let object = bn_path_ray(path, cases[at + 12u]);
    let part = bn_ray_child(object, k);
    var ways = bn_ray_draw_split(object, k, branches);
    if (branches == 0u) {
        ways = bn_ray_draw_split_from(object, k, index);
    }
    let way = bn_split_path(ways, k);
    let all = bn_ray_draw(seed, part);
    let four = bn_ray_draw_4d(seed, object, k);
    results[at] = 49u * way.index + 51u * way.domain + words_of(53u, bn_ray_draw_direction(seed, object)) +
        words_of(57u, bn_ray_draw_end_light(seed, object)) + 61u * bitcast<u32>(all.x) + 63u * bitcast<u32>(all.w) +
        65u * bitcast<u32>(four.y) + 67u * bitcast<u32>(four.z) + words_of(69u, bn_ray_draw_2d(seed, object, k)) +
        73u * bitcast<u32>(bn_ray_draw_1d(seed, object, k)) + words_of(75u, bn_path_first_light(seed, path, branches, k)) +
        words_of(79u, bn_path_time_wavelength(seed, path)) +
        83u * bitcast<u32>(bn_loop_draw_1d(seed, bn_ray_draw_loop(object, k), k & 15u));
    results[at + 15u] = v.x + 3u * v.y + 5u * bitcast<u32>(w.x) + 7u * bitcast<u32>(w.y) + path_words;
}
