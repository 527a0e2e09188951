/* SPDX-License-Identifier: Apache-2.0
 * The inline functions of bn_path.h as symbols, which Rust needs. src/lib.rs repeats their types, so
 * a change of one must not go unnoticed. */
#include "bn.h"
#include <stddef.h>

#define BN_SAME(condition) _Static_assert(condition, "src/lib.rs has another type: " #condition)
BN_SAME(sizeof(bn_path) == 16 && offsetof(bn_path, index) == 8 && offsetof(bn_path, domain) == 12);
BN_SAME(sizeof(bn_ray) == 40 && offsetof(bn_ray, domain) == 16 && offsetof(bn_ray, splits) == 32);
BN_SAME(sizeof(bn_split) == 24 && offsetof(bn_split, domain) == 16);
BN_SAME(sizeof(bn_rng) == 36 && offsetof(bn_rng, counter) == 16 && offsetof(bn_rng, drawn) == 32);
BN_SAME(sizeof(void *) != 8 || (sizeof(bn_sampler) == 48 && offsetof(bn_sampler, mask) == 16));
BN_SAME(sizeof(void *) != 8 || offsetof(bn_sampler, mask_low_digits) == 32);
BN_SAME(sizeof(void *) != 8 || sizeof(bn_sampler_options) == 40);
BN_SAME(sizeof(void *) != 8 || offsetof(bn_sampler_options, mask_width) == 32);

bn_sampler bn_rs_sampler_make(int32_t kind, uint64_t seed) {
    return bn_sampler_make(kind, seed);
}

bn_path bn_rs_path_start(int32_t x, int32_t y, uint32_t index, uint32_t frame) {
    return bn_path_start(x, y, index, frame);
}

bn_ray bn_rs_path_ray(const bn_path *path, uint32_t ray) {
    return bn_path_ray(path, ray);
}

bn_ray bn_rs_ray_keyed(const bn_ray *ray, uint32_t key) {
    return bn_ray_keyed(ray, key);
}

bn_split bn_rs_ray_split(bn_ray *ray, uint32_t count) {
    return bn_ray_split(ray, count);
}

bn_split bn_rs_ray_split_from(bn_ray *ray, uint32_t first) {
    return bn_ray_split_from(ray, first);
}

bn_path bn_rs_split_path(const bn_split *split, uint32_t k) {
    return bn_split_path(split, k);
}

void bn_rs_ray_draw(const bn_sampler *sampler, const bn_ray *ray, float out[4]) {
    bn_ray_draw(sampler, ray, out);
}

void bn_rs_ray_draw_where(const bn_sampler *sampler, const bn_ray *ray, float out[2]) {
    bn_ray_draw_where(sampler, ray, out);
}

void bn_rs_ray_draw_light(const bn_sampler *sampler, const bn_ray *ray, float out[2]) {
    bn_ray_draw_light(sampler, ray, out);
}

float bn_rs_ray_1d(const bn_sampler *sampler, bn_ray *ray) {
    return bn_ray_1d(sampler, ray);
}

void bn_rs_ray_2d(const bn_sampler *sampler, bn_ray *ray, float out[2]) {
    bn_ray_2d(sampler, ray, out);
}

void bn_rs_ray_4d(const bn_sampler *sampler, bn_ray *ray, float out[4]) {
    bn_ray_4d(sampler, ray, out);
}

float bn_rs_ray_1d_at(const bn_sampler *sampler, const bn_ray *ray, uint32_t k) {
    return bn_ray_1d_at(sampler, ray, k);
}

void bn_rs_ray_2d_at(const bn_sampler *sampler, const bn_ray *ray, uint32_t k, float out[2]) {
    bn_ray_2d_at(sampler, ray, k, out);
}

void bn_rs_ray_4d_at(const bn_sampler *sampler, const bn_ray *ray, uint32_t k, float out[4]) {
    bn_ray_4d_at(sampler, ray, k, out);
}

bn_split bn_rs_ray_split_at(const bn_ray *ray, uint32_t k, uint32_t count) {
    return bn_ray_split_at(ray, k, count);
}

bn_rng bn_rs_ray_rng_at(const bn_sampler *sampler, const bn_ray *ray, uint32_t k) {
    return bn_ray_rng_at(sampler, ray, k);
}

void bn_rs_path_first_light(const bn_sampler *sampler, const bn_path *path, uint32_t count,
                            uint32_t k, float out[2]) {
    bn_path_first_light(sampler, path, count, k, out);
}

void bn_rs_path_time(const bn_sampler *sampler, const bn_path *path, float out[2]) {
    bn_path_time(sampler, path, out);
}

bn_rng bn_rs_ray_rng(const bn_sampler *sampler, bn_ray *ray) {
    return bn_ray_rng(sampler, ray);
}

float bn_rs_rng_1d(bn_rng *rng) {
    return bn_rng_1d(rng);
}
