/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BN_GLSL_IN_C_H
#define BN_GLSL_IN_C_H

#include <bn/bn.h>

/* What a shader is given. */
typedef struct glsl_table {
    const uint32_t *words;
    uint32_t seed[2];
} glsl_table;

uint32_t glsl_word_count(void);
uint32_t glsl_domain_child(uint32_t domain, uint32_t key);
/* Kinds BLUE, SOBOL and WHITE. */
void glsl_draw(const glsl_table *table, int32_t kind, int32_t x, int32_t y, uint32_t index,
               uint32_t domain, uint32_t out[4]);
void glsl_draw_pair(const glsl_table *table, int32_t kind, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pair, uint32_t out[2]);
/* What bn_path.glsl says of sample `index` of a pixel and of number, pair, four, split or loop k of a
 * ray. */
typedef struct glsl_path {
    uint32_t ray, camera, domain_1d, pair_1d, domain_2d, pair_2d, domain_4d, split;
    uint32_t branch_index, branch_domain; /* of branch `branch` of `count` */
    uint32_t branch_ray;                  /* the domain of its ray 0 */
    uint32_t noise;                       /* the bits of number `branch` of loop k */
} glsl_path;
glsl_path glsl_path_words(const glsl_table *table, int32_t x, int32_t y, uint32_t index,
                          uint32_t frame, uint32_t ray, uint32_t k, uint32_t count,
                          uint32_t branch);
int glsl_choose(float probability, float *u);
uint32_t glsl_choose_u32(uint32_t count, float *u);
uint32_t glsl_choose_cdf(const float *cdf, uint32_t first, uint32_t count, float *u);

#endif
