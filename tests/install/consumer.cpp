// SPDX-License-Identifier: Apache-2.0
// The same header from C++11, the oldest standard it promises.
#include <bn/bn.h>

#include <cstdio>

int main() {
    bn_sampler sampler;
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = BN_SAMPLER_SOBOL;
    options.seed = 5;
    if (bn_sampler_init(&sampler, &options) != BN_SUCCESS) return 1;
    float u[2];
    bn_sample_2d(&sampler, 3, 4, 5, BN_DOMAIN_ROOT, u);
    std::printf("%s %.8f %.8f\n", bn_version_string(), u[0], u[1]);
}
