/* SPDX-License-Identifier: Apache-2.0
 * Computes the results of one case, in the layout described in shader_cases.c. CASE(i) is word i of the case. */
void answer(out uint result[16]) {
    uint x = CASE(1u), y = CASE(2u), index = CASE(3u);
    uint domain = bn_domain_child(CASE(4u), CASE(5u));
    uint pair = CASE(0u) >> 2u, kind = CASE(0u) & 3u;
    bn_uint2 seed;
    seed.x = CASE(10u);
    seed.y = CASE(11u);
    bn_uint4 bits;
    bn_uint2 v;
    vec4 draw;
    vec2 w;
    if (kind == 0u) {
        bits = bn_draw_blue_bits(seed, x, y, index, domain);
        draw = bn_draw_blue_4d(seed, x, y, index, domain);
        v = bn_draw_blue_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_blue_2d(seed, x, y, index, domain, pair);
    } else if (kind == 1u) {
        bits = bn_draw_sobol_bits(seed, x, y, index, domain);
        draw = bn_draw_sobol_4d(seed, x, y, index, domain);
        v = bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_sobol_2d(seed, x, y, index, domain, pair);
    } else {
        bits = bn_draw_white_bits(seed, x, y, index, domain);
        draw = bn_draw_white_4d(seed, x, y, index, domain);
        v = bn_draw_white_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_white_2d(seed, x, y, index, domain, pair);
    }
    result[0] = 0u;
    result[1] = bits.x;
    result[2] = bits.y;
    result[3] = bits.z;
    result[4] = bits.w;
    result[5] = floatBitsToUint(draw.x);
    result[6] = floatBitsToUint(draw.y);
    result[7] = floatBitsToUint(draw.z);
    result[8] = floatBitsToUint(draw.w);

    float probability = uintBitsToFloat(CASE(6u));
    float u = uintBitsToFloat(CASE(7u));
    float left = u;
    result[9] = bn_choose(probability, left) ? 1u : 0u;
    result[10] = floatBitsToUint(left);
    left = u;
    result[11] = bn_choose_u32(CASE(8u), left);
    result[12] = floatBitsToUint(left);
    left = u;
    result[13] = bn_choose_cdf(CASE(9u) & 255u, CASE(9u) >> 8u, left);
    result[14] = floatBitsToUint(left);
    result[15] = v.x + 3u * v.y + 5u * floatBitsToUint(w.x) + 7u * floatBitsToUint(w.y);

    uint k = CASE(13u), count = CASE(14u);
    bn_path path = bn_path_start(x, y, index, CASE(15u));
    uint ray = bn_path_ray_domain(path, CASE(12u));
    uint split = bn_ray_split_domain(ray, k);
    bn_path branch = bn_path_branch(path, split, count, k);
    bn_path last = bn_path_branch(branch, split, count, count);
    result[15] += 9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray
        + 19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray, k) + 23u * bn_ray_1d_pair(k)
        + 25u * bn_ray_2d_domain(ray, k) + 27u * bn_ray_2d_pair(k) + 29u * bn_ray_4d_domain(ray, k) + 31u * split
        + 33u * branch.x + 35u * branch.y + 37u * branch.index + 39u * branch.domain + 41u * last.index
        + 43u * last.domain + 45u * bn_loop_later_bits(seed, branch, bn_ray_loop_domain(ray, k), k)
        + 47u * bn_ray_child_domain(ray, k) + 49u * domain;

    bn_pan pan;
    pan.x = x;
    pan.y = y;
    pan.x_rest = (CASE(5u) & 0xffffffu) - 0x800000u;
    pan.y_rest = (index & 0xffffffu) - 0x800000u;
    pan = bn_follow(pan, uintBitsToFloat(CASE(4u)), -16.0 * uintBitsToFloat(CASE(7u)));
    result[15] += 85u * pan.x + 87u * pan.y + 89u * pan.x_rest + 91u * pan.y_rest + 93u * bn_frame_index(index, CASE(8u))
        + 95u * bn_frame_stream(index, CASE(8u));

#ifndef NO_PATH_DRAWS
    bn_ray object = bn_path_ray(path, CASE(12u));
    bn_ray part = bn_ray_child(object, k);
    bn_split ways = bn_ray_draw_split(object, k, count);
    if (count == 0u) ways = bn_ray_draw_split_from(object, k, index);
    bn_path way = bn_split_path(ways, k);
    bn_loop walk = bn_ray_draw_loop(object, k);
    vec4 all = bn_ray_draw(seed, part);
    vec4 four = bn_ray_draw_4d(seed, object, k);
    vec2 direction = bn_ray_draw_direction(seed, object);
    vec2 light = bn_ray_draw_end_light(seed, object);
    vec2 two = bn_ray_draw_2d(seed, object, k);
    vec2 first = bn_path_first_light(seed, path, count, k);
    vec2 time = bn_path_time_wavelength(seed, path);
    result[0] = 49u * way.index + 51u * way.domain + 53u * floatBitsToUint(direction.x) + 55u * floatBitsToUint(direction.y)
        + 57u * floatBitsToUint(light.x) + 59u * floatBitsToUint(light.y) + 61u * floatBitsToUint(all.x)
        + 63u * floatBitsToUint(all.w) + 65u * floatBitsToUint(four.y) + 67u * floatBitsToUint(four.z)
        + 69u * floatBitsToUint(two.x) + 71u * floatBitsToUint(two.y) + 73u * floatBitsToUint(bn_ray_draw_1d(seed, object, k))
        + 75u * floatBitsToUint(first.x) + 77u * floatBitsToUint(first.y) + 79u * floatBitsToUint(time.x)
        + 81u * floatBitsToUint(time.y) + 83u * floatBitsToUint(bn_loop_draw_1d(seed, walk, k & 15u));
#endif
}
