// SPDX-License-Identifier: Apache-2.0
// bn.hpp as a C++17 renderer uses it: prints what consumer.c prints first, then the number of
// things that are not as bn.hpp says.
#include <bn/bn.hpp>

#include <cstdio>
#include <cstring>
#include <type_traits>

static_assert(std::is_nothrow_move_constructible_v<bn::Sampler> &&
              std::is_nothrow_move_assignable_v<bn::Sampler>);
static_assert(!std::is_copy_constructible_v<bn::Sampler> &&
              !std::is_copy_assignable_v<bn::Sampler>);
static_assert(!std::is_convertible_v<int, bn::Sampler> && !std::is_convertible_v<int, bn::Domain>);

namespace {

template <typename Function>
int fails_with(bn_result expected, Function function) {
    try {
        function();
    } catch (const bn::Error &error) {
        return error.result() == expected &&
               std::strstr(error.what(), bn_result_string(expected)) &&
               std::strstr(error.what(), "bn_sample");
    }
    return 0;
}

int wrong(const bn::Sampler &sampler, bn::Domain domain) {
    int count = 0;
    for (int32_t x = -40; x < 40; ++x) {
        float own[4];
        bn_sample_4d(sampler.get(), x, 3, 300, domain.value(), own);
        const auto four = sampler.sample(x, 3, 300, domain);
        const auto [a, b, c] = sampler.sample<3>(x, 3, 300, domain);
        const auto [d, e] = sampler.sample<2>(x, 3, 300, domain);
        const float f = sampler.sample<1>(x, 3, 300, domain)[0];
        count += std::memcmp(own, four.data(), sizeof own) != 0;
        count += a != own[0] || b != own[1] || c != own[2] || d != own[0] || e != own[1];
        count += f != own[0];
        const auto [g, h] = sampler.sample_pair(x, 3, 300, domain, 1);
        count += g != own[2] || h != own[3];
    }
    const std::vector<float> block = sampler.block(5, 6, 3, 2, 7, 4, domain);
    const auto last = sampler.sample(7, 7, 10, domain);
    count += block.size() != 96 || std::memcmp(&block[92], last.data(), sizeof last) != 0;
    const int32_t x[3] = {-40, 0, 39}, y[3] = {3, 3, 3};
    const uint32_t index[3] = {300, 300, 300};
    const uint32_t domains[3] = {domain.value(), domain.value(), domain.value()};
    float many[7] = {};
    many[6] = 2.0f;
    sampler.sample_many<2>(3, x, y, index, domains, many);
    for (int i = 0; i < 3; ++i) {
        const auto [a, b] = sampler.sample<2>(x[i], 3, 300, domain);
        count += many[2 * i] != a || many[2 * i + 1] != b;
    }
    sampler.sample_many_pair(3, x, y, index, domains, 1, many);
    for (int i = 0; i < 3; ++i) {
        const auto [a, b] = sampler.sample_pair(x[i], 3, 300, domain, 1);
        count += many[2 * i] != a || many[2 * i + 1] != b;
    }
    sampler.sample_many(0, nullptr, nullptr, nullptr, nullptr, nullptr);
    return count + (many[6] != 2.0f);
}

} // namespace

int main() {
    const bn::Domain light = bn::Domain().child(3);
    bn::Sampler sampler;
    for (uint32_t index = 0; index < 4; ++index) {
        const auto u = sampler.sample_u32(-7, 12, index, light);
        std::printf("%08lx %08lx %08lx %08lx\n", static_cast<unsigned long>(u[0]),
                    static_cast<unsigned long>(u[1]), static_cast<unsigned long>(u[2]),
                    static_cast<unsigned long>(u[3]));
    }
    int failures = wrong(sampler, light);
    failures += light.value() != bn_domain_child(BN_DOMAIN_ROOT, 3) || light == bn::Domain();
    failures += light != bn::Domain(light.value());

    bn::Sampler other(BN_SAMPLER_SOBOL, 5);
    const auto before = other.sample(1, 2, 3);
    failures += before == sampler.sample(1, 2, 3);
    bn::Sampler moved(std::move(other));
    failures += moved.sample(1, 2, 3) != before || other.get() != nullptr;
    sampler = std::move(moved);
    failures += sampler.sample(1, 2, 3) != before;

    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT, [] { const bn::Sampler bad(99); });
    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT, [&] { sampler.block(0, 0, 0, 1, 0, 1); });
    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT, [&] {
        sampler.sample_many(1, nullptr, nullptr, nullptr, nullptr, nullptr);
    });
    failures += !fails_with(BN_ERROR_OUT_OF_MEMORY,
                            [&] { sampler.block(0, 0, 1u << 31, 1u << 31, 0, 1u << 31); });
    const uint32_t ranks[2] = {0, 0};
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = BN_SAMPLER_MASK;
    options.mask_ranks = ranks;
    options.mask_width = 2;
    options.mask_height = 1;
    failures += !fails_with(BN_ERROR_BAD_DATA, [&] { const bn::Sampler bad(options); });
    std::printf("%d\n", failures);
}
