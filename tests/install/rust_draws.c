/* SPDX-License-Identifier: Apache-2.0
 * What examples/rust/bluenoise/examples/draws.rs prints, in C; with an argument, the golden bits of its tests. */
#include <bn/bn_path.h>
#include <stdio.h>
#include <string.h>

static uint32_t bits(float v) {
    uint32_t out;
    memcpy(&out, &v, sizeof out);
    return out;
}

static uint32_t hash;

static void add(const float *v, int count) {
    for (int i = 0; i < count; ++i) hash = (hash ^ bits(v[i])) * 0x01000193u;
}

static void hash_ray(const bn_sampler *sampler, const bn_path *path, uint32_t depth) {
    bn_ray ray = bn_path_ray(path, depth);
    float v[4];
    bn_ray_draw(sampler, &ray, v);
    add(v, 4);
    for (int i = 0; i < 5; ++i) {
        v[0] = bn_ray_1d(sampler, &ray);
        add(v, 1);
    }
    for (int i = 0; i < 3; ++i) {
        bn_ray_2d(sampler, &ray, v);
        add(v, 2);
    }
    bn_ray_4d(sampler, &ray, v);
    add(v, 4);
    bn_rng rng = bn_ray_rng(sampler, &ray);
    for (int i = 0; i < 6; ++i) {
        v[0] = bn_rng_1d(&rng);
        add(v, 1);
    }
    const bn_split split = bn_ray_split(&ray, 3), from = bn_ray_split_from(&ray, 9);
    for (uint32_t k = 0; k < 4; ++k) {
        const bn_path branch = bn_split_path(&split, k);
        const bn_ray first = bn_path_ray(&branch, 1);
        bn_ray_draw(sampler, &first, v);
        add(v + 2, 1);
    }
    for (uint32_t k = 0; k < 2; ++k) {
        const bn_path branch = bn_split_path(&from, k);
        const bn_ray first = bn_path_ray(&branch, 0);
        bn_ray_draw(sampler, &first, v);
        add(v, 1);
    }
    bn_ray keyed = bn_ray_keyed(&ray, 77);
    v[0] = bn_ray_1d(sampler, &keyed);
    add(v, 1);
}

static void golden(const bn_sampler *sampler) {
    const bn_path path = bn_path_start(3, 4, 5, 0);
    bn_ray ray = bn_path_ray(&path, 2);
    uint32_t root[4];
    float u[4];
    bn_sample_4d_u32(sampler, 3, 4, 5, BN_DOMAIN_ROOT, root);
    bn_ray_draw(sampler, &ray, u);
    printf("const GOLDEN_ROOT: [u32; 4] = [%#x, %#x, %#x, %#x];\n", (unsigned)root[0],
           (unsigned)root[1], (unsigned)root[2], (unsigned)root[3]);
    printf("const GOLDEN_RAY: [u32; 4] = [%#x, %#x, %#x, %#x];\n", (unsigned)bits(u[0]),
           (unsigned)bits(u[1]), (unsigned)bits(u[2]), (unsigned)bits(u[3]));
    for (int i = 0; i < 3; ++i) u[i] = bn_ray_1d(sampler, &ray);
    printf("const GOLDEN_NUMBERS: [u32; 3] = [%#x, %#x, %#x];\n", (unsigned)bits(u[0]),
           (unsigned)bits(u[1]), (unsigned)bits(u[2]));
}

int main(int count, char **arguments) {
    static const uint32_t indices[] = {0, 1, 5, 255, 256, 70000};
    const bn_sampler sampler = bn_sampler_make(BN_SAMPLER_BLUE, 1);
    (void)arguments;
    if (count > 1) golden(&sampler);
    for (int32_t pixel = 0; count == 1 && pixel < 16; ++pixel) {
        const int32_t x = 3 * pixel - 20, y = 100 - 37 * pixel;
        for (int i = 0; i < 6; ++i) {
            const bn_path path = bn_path_start(x, y, indices[i], 0);
            hash = 0;
            for (uint32_t depth = 0; depth < 8; ++depth) hash_ray(&sampler, &path, depth);
            printf("%d %d %u %08x\n", (int)x, (int)y, (unsigned)indices[i], (unsigned)hash);
        }
    }
    return 0;
}
