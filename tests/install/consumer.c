/* SPDX-License-Identifier: Apache-2.0
 * A renderer's first steps. Every consumer project builds this program, which must always print the same. */
#include <bn/bn_path.h>
#include <stdio.h>

int main(void) {
    const bn_sampler sampler = bn_sampler_make(0);
    const uint32_t light = bn_domain_child(BN_DOMAIN_ROOT, 3);
    for (uint32_t index = 0; index < 4; ++index) {
        uint32_t u[4];
        bn_sample_4d_u32(&sampler, -7, 12, index, light, u);
        printf("%08lx %08lx %08lx %08lx\n", (unsigned long)u[0], (unsigned long)u[1],
               (unsigned long)u[2], (unsigned long)u[3]);
    }
    float number[4];
    const bn_path path = bn_path_start(-7, 12, 1, 2);
    bn_ray ray = bn_path_ray(&path, 3);
    const bn_split split = bn_ray_next_split(&ray, 4);
    const bn_path branch = bn_split_path(&split, 5);
    bn_ray_next_4d(&sampler, &ray, number);
    printf("%.7f %.7f %08lx %lu\n", (double)number[0], (double)number[3],
           (unsigned long)branch.domain, (unsigned long)branch.index);

    uint32_t ranks[16 * 16];
    const bn_mask mask = bn_mask_u32(ranks, 16, 16);
    double error;
    if (bn_void_and_cluster(NULL, &mask, NULL, NULL) != BN_SUCCESS ||
        bn_mask_error(&mask, 1.0, &error, NULL, NULL) != BN_SUCCESS)
        return 1;
    printf("%s %lu %.6f\n", bn_version_string(), (unsigned long)ranks[0], error);
    return 0;
}
