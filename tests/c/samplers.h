/* SPDX-License-Identifier: Apache-2.0
 * Creates samplers for tests; a failure ends the program. */
#ifndef BN_TESTS_SAMPLERS_H
#define BN_TESTS_SAMPLERS_H

#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>

static inline bn_sampler *make_sampler(int32_t kind, uint32_t samples_per_pixel, uint64_t seed) {
    bn_sampler_options options = bn_sampler_options_default();
    bn_sampler *sampler = NULL;
    options.kind = kind;
    options.samples_per_pixel = samples_per_pixel;
    options.seed = seed;
    bn_result result = bn_sampler_create(&options, &sampler);
    if (result != BN_SUCCESS) {
        printf("cannot create a sampler: %s\n", bn_result_string(result));
        exit(1);
    }
    return sampler;
}

#endif
