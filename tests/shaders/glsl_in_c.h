/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BN_GLSL_IN_C_H
#define BN_GLSL_IN_C_H

#include <bn/bn.h>

uint32_t glsl_word_count(void);
uint32_t glsl_domain_child(uint32_t domain, uint32_t key);
/* Kinds BLUE, SOBOL and WHITE. */
void glsl_draw(const uint32_t *words, int32_t kind, int32_t x, int32_t y, uint32_t index,
               uint32_t domain, uint32_t out[4]);
void glsl_draw_pair(const uint32_t *words, int32_t kind, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pair, uint32_t out[2]);
int glsl_choose(float probability, float *u);
uint32_t glsl_choose_u32(uint32_t count, float *u);
uint32_t glsl_choose_cdf(const float *cdf, uint32_t first, uint32_t count, float *u);

#endif
