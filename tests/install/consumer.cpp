// SPDX-License-Identifier: Apache-2.0
// Uses bn.h in C++11, the oldest supported standard.
#include <bn/bn.h>

#include <cstdio>

int main() {
    bn_sampler sampler;
    if (bn_sampler_init(&sampler, BN_SAMPLER_SOBOL, 5) != BN_SUCCESS) return 1;
    float u[2];
    bn_sample_2d(&sampler, 3, 4, 5, BN_DOMAIN_ROOT, 0, u);
    std::printf("%s %.8f %.8f\n", bn_version_string(), u[0], u[1]);
}
