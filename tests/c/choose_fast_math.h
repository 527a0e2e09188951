/* SPDX-License-Identifier: Apache-2.0
 * The inline functions, as a program that is compiled with -ffast-math has them. */
#ifndef CHOOSE_FAST_MATH_H
#define CHOOSE_FAST_MATH_H

#include <bn/bn_choose.h>
#include <bn/bn_draw.h>

int fast_choose(float probability, float *u);
uint32_t fast_choose_u32(uint32_t count, float *u);
uint32_t fast_choose_cdf(const float *cdf, uint32_t count, float *u);
void fast_draw_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]);

#endif
