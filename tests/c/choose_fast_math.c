/* SPDX-License-Identifier: Apache-2.0
 * Compiled with -ffast-math. */
#include "choose_fast_math.h"

int fast_choose(float probability, float *u) {
    return bn_choose(probability, u);
}

uint32_t fast_choose_u32(uint32_t count, float *u) {
    return bn_choose_u32(count, u);
}

uint32_t fast_choose_cdf(const float *cdf, uint32_t count, float *u) {
    return bn_choose_cdf(cdf, count, u);
}

void fast_draw_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]) {
    bn_sample_4d(sampler, x, y, index, domain, out);
}
