// SPDX-License-Identifier: Apache-2.0
// The same header from C++11, the oldest standard it promises.
#include <bn/bn.h>

#include <cstdio>
#include <memory>

int main() {
    bn_sampler *sampler = nullptr;
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = BN_SAMPLER_SOBOL;
    options.seed = 5;
    if (bn_sampler_create(&options, &sampler) != BN_SUCCESS) return 1;
    const std::unique_ptr<bn_sampler, decltype(&bn_sampler_destroy)> owner(sampler,
                                                                           bn_sampler_destroy);
    float u[2];
    bn_sample_2d(owner.get(), 3, 4, 5, BN_DOMAIN_ROOT, u);
    std::printf("%s %.8f %.8f\n", bn_version_string(), u[0], u[1]);
}
