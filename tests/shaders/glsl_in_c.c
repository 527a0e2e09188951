/* SPDX-License-Identifier: Apache-2.0
 * The functions of bn_draw.glsl, bn_path.glsl and bn_choose.glsl, for C. */
#include "glsl_in_c.h"
#include "draws_in_c.h"

static const float *glsl_cdf;

#define BN_CDF(i) glsl_cdf[i]
#define BN_CHOOSE_IN_C /* C has no `inout` and no casts that look like calls */
#define BN_CHOOSE_UINT uint
#define BN_CHOOSE_BOOL int
#define BN_CHOOSE_FALSE 0
#define BN_CHOOSE_FUNCTION static
#define BN_CHOOSE_U float *u
#define BN_CHOOSE_GET_U (*u)
#define BN_CHOOSE_TO_UINT(v) (uint)(v)
#define BN_CHOOSE_TO_FLOAT(v) (float)(v)
#define BN_CHOOSE_TABLE uint first,
#define BN_CHOOSE_LIMIT(i) BN_CDF(first + (i))
#include <bn/bn_choose.glsl>
#undef uint

static bn_uint2 seed_of(const glsl_table *table) {
    const bn_uint2 seed = {table->seed[0], table->seed[1]};
    glsl_words = table->words;
    return seed;
}

glsl_path glsl_path_words(const glsl_table *table, int32_t x, int32_t y, uint32_t index,
                          uint32_t frame, uint32_t ray, uint32_t k, uint32_t count,
                          uint32_t branch) {
    const bn_path path = bn_path_start((uint32_t)x, (uint32_t)y, index, frame);
    glsl_path found;
    const bn_uint2 seed = seed_of(table);
    found.ray = bn_path_ray_domain(path, ray);
    found.camera = bn_path_camera_domain(path);
    found.domain_1d = bn_ray_1d_domain(found.ray, k);
    found.pair_1d = bn_ray_1d_pair(k);
    found.domain_2d = bn_ray_2d_domain(found.ray, k);
    found.pair_2d = bn_ray_2d_pair(k);
    found.domain_4d = bn_ray_4d_domain(found.ray, k);
    found.split = bn_ray_split_domain(found.ray, k);
    const bn_path one = bn_path_branch(path, found.split, count, branch);
    found.branch_index = one.index;
    found.branch_domain = one.domain;
    found.branch_ray = bn_path_ray_domain(one, 0u);
    found.noise = bn_path_rng_bits(seed, path, found.split, branch);
    return found;
}

int glsl_choose(float probability, float *u) {
    return bn_choose(probability, u);
}

uint32_t glsl_choose_u32(uint32_t count, float *u) {
    return bn_choose_u32(count, u);
}

uint32_t glsl_choose_cdf(const float *cdf, uint32_t first, uint32_t count, float *u) {
    glsl_cdf = cdf;
    return bn_choose_cdf(first, count, u);
}

uint32_t glsl_word_count(void) {
    return BN_WORD_COUNT;
}

uint32_t glsl_domain_child(uint32_t domain, uint32_t key) {
    return bn_draw_domain_child(domain, key);
}

void glsl_draw_pair(const glsl_table *table, int32_t kind, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pair, uint32_t out[2]) {
    bn_uint2 v;
    const bn_uint2 seed = seed_of(table);
    if (kind == BN_SAMPLER_BLUE)
        v = bn_draw_blue_pair_bits(seed, (uint32_t)x, (uint32_t)y, index, domain, pair);
    else if (kind == BN_SAMPLER_SOBOL)
        v = bn_draw_sobol_pair_bits(seed, (uint32_t)x, (uint32_t)y, index, domain, pair);
    else
        v = bn_draw_white_pair_bits(seed, (uint32_t)x, (uint32_t)y, index, domain, pair);
    out[0] = v.x;
    out[1] = v.y;
}

void glsl_draw(const glsl_table *table, int32_t kind, int32_t x, int32_t y, uint32_t index,
               uint32_t domain, uint32_t out[4]) {
    bn_uint4 v;
    const bn_uint2 seed = seed_of(table);
    if (kind == BN_SAMPLER_BLUE)
        v = bn_draw_blue_bits(seed, (uint32_t)x, (uint32_t)y, index, domain);
    else if (kind == BN_SAMPLER_SOBOL)
        v = bn_draw_sobol_bits(seed, (uint32_t)x, (uint32_t)y, index, domain);
    else
        v = bn_draw_white_bits(seed, (uint32_t)x, (uint32_t)y, index, domain);
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
    out[3] = v.w;
}
