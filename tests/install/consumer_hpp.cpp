// SPDX-License-Identifier: Apache-2.0
// Uses bn.hpp as a C++ renderer would. Prints the same lines as consumer.c, followed by the number of
// bn.hpp's violated guarantees.
#include <bn/bn.hpp>

#include <cstdio>
#include <cstring>
#include <memory>
#include <type_traits>

static_assert(std::is_trivially_copyable_v<bn::Sampler> && sizeof(bn::Sampler) <= 48);
constexpr bn::Sampler at_compile_time(bn::Type::sobol, 5);
struct Renderer {
    bn::Sampler sampler = {}; // no warning
};
static_assert(!std::is_convertible_v<int, bn::Sampler> && !std::is_convertible_v<int, bn::Domain>);
// An integer is accepted as a seed, but a C constant is not.
static_assert(std::is_constructible_v<bn::Sampler, int> &&
              !std::is_constructible_v<bn::Sampler, decltype(BN_SAMPLER_SOBOL)> &&
              !std::is_constructible_v<bn::Sampler, decltype(BN_SAMPLER_SOBOL), int> &&
              !std::is_constructible_v<bn::Sampler, int, int>);
// A copy would return the same numbers as its original.
static_assert(!std::is_copy_constructible_v<bn::RaySampler> &&
              !std::is_copy_assignable_v<bn::RaySampler> &&
              std::is_nothrow_move_constructible_v<bn::RaySampler>);

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
        const auto four = sampler.sample_4d(x, 3, 300, domain);
        const auto [a, b] = sampler.sample_2d(x, 3, 300, domain);
        const auto [c, d] = sampler.sample_2d(x, 3, 300, domain, 1);
        count += std::memcmp(own, four.data(), sizeof own) != 0;
        count += a != own[0] || b != own[1] || c != own[2] || d != own[3];
        count += sampler.sample_1d(x, 3, 300, domain) != own[0];
    }
    const std::vector<float> block = sampler.block(5, 6, 3, 2, 7, 4, domain);
    const auto last = sampler.sample_4d(7, 7, 10, domain);
    count += block.size() != 96 || std::memcmp(&block[92], last.data(), sizeof last) != 0;
    const int32_t x[3] = {-40, 0, 39}, y[3] = {3, 3, 3};
    float second[6];
    bn_wavefront lanes = bn_wavefront_default();
    lanes.count = 3;
    lanes.x = x;
    lanes.y = y;
    lanes.shared_index = 300;
    lanes.shared_domain = domain.value();
    lanes.out[2] = second;
    lanes.out[3] = second + 1;
    lanes.stride = 2;
    sampler.sample_wavefront(lanes);
    for (int i = 0; i < 3; ++i) {
        const auto [a, b] = sampler.sample_2d(x[i], 3, 300, domain, 1);
        count += second[2 * i] != a || second[2 * i + 1] != b;
    }
    return count;
}

// The hash of the paths in tests/c/test_draw_hashes.c, which must not change.
constexpr uint64_t hash_of_paths = 0x3d750840263d82dbu;

bool wrong_paths() {
    const bn::Sampler sampler(1);
    uint64_t hash = 0xcbf29ce484222325u;
    for (int32_t pixel = 0; pixel < 16; ++pixel) {
        for (const uint32_t index : {0u, 1u, 5u, 255u, 256u, 70000u}) {
            const bn::PathSampler path(sampler, 3 * pixel - 20, 100 - 37 * pixel, index);
            uint32_t own = 0;
            const auto add = [&](float v) {
                uint32_t bits;
                std::memcpy(&bits, &v, sizeof bits);
                own = (own ^ bits) * 0x01000193u;
            };
            for (uint32_t depth = 0; depth < 8; ++depth) {
                bn::RaySampler ray = path.ray(depth);
                for (const float v : ray.draw()) add(v);
                for (int i = 0; i < 5; ++i) add(ray.next_1d());
                for (int i = 0; i < 3; ++i)
                    for (const float v : ray.next_2d()) add(v);
                for (const float v : ray.next_4d()) add(v);
                bn::LoopSampler rng = ray.next_loop();
                for (int i = 0; i < 6; ++i) add(rng.next_1d());
                const bn::Split split = ray.next_split(3), from = ray.next_split_from(9);
                for (uint32_t k = 0; k < 4; ++k) add(split[k].ray(1).draw_end_light()[0]);
                for (uint32_t k = 0; k < 2; ++k) add(from[k].ray(0).draw_direction()[0]);
                add(ray.child(77).next_1d());
            }
            for (int i = 0; i < 4; ++i) hash = (hash ^ (own >> 8 * i & 255u)) * 0x100000001b3u;
        }
    }
    return hash != hash_of_paths;
}

// Explicit counters give the same numbers as a ray's own counters. A path's first numbers match those in C.
int wrong_counters(const bn::Sampler &sampler) {
    const bn::PathSampler path(sampler, -3, 9, 5, 2);
    const bn_path own = bn_path_start(-3, 9, 5, 2);
    bn::RaySampler ray = path.ray(2);
    const bn::RaySampler by_counter = path.ray(2);
    int count = 0;
    for (uint32_t i = 0; i < 3; ++i) {
        count += ray.next_1d() != by_counter.draw_1d(i);
        count += ray.next_2d() != by_counter.draw_2d(i);
        count += ray.next_4d() != by_counter.draw_4d(i);
        count +=
            ray.next_split(3)[4].state().domain != by_counter.draw_split(i, 3)[4].state().domain;
        count += ray.next_loop().next_1d() != by_counter.draw_loop(i).next_1d();
    }
    float u[4];
    bn_path_first_light(sampler.get(), &own, 4, 3, u);
    count += path.first_light(4, 3) != std::array<float, 2>{u[0], u[1]};
    bn_path_time_wavelength(sampler.get(), &own, u);
    return count + (path.time_wavelength() != std::array<float, 2>{u[0], u[1]});
}

// Pans and the frames of a film are those of C.
int wrong_frames() {
    bn::Pan pan;
    for (int frame = 0; frame < 4; ++frame) pan.follow(2.5f, -0.25f);
    return (pan.x() != 10) + (pan.y() != -1) + (pan.state().x != 10u) +
           (bn::frame_index(3, 100) != 384) + (bn::frame_stream(1u << 22, 1000) != 1);
}

// The numbers drawn for a pattern of one-dimensional ('1') and two-dimensional ('2') requests.
std::vector<float> counted(bn::SequentialSampler &numbers, const char *pattern) {
    std::vector<float> all;
    for (; *pattern; ++pattern) {
        if (*pattern == '1') {
            all.push_back(numbers.next_1d());
        } else {
            const auto [a, b] = numbers.next_2d();
            all.insert(all.end(), {a, b});
        }
    }
    return all;
}

int wrong_counts(const bn::Sampler &sampler) {
    int count = 0;
    bn::SequentialSampler numbers(sampler);
    numbers.start(5, 6, 7);
    const auto first = bn::PathSampler(sampler, 5, 6, 7).ray(0).draw();
    // Two pairs, or a number and a pair, share a domain.
    const auto pairs = counted(numbers, "22");
    count += std::memcmp(pairs.data(), first.data(), sizeof first) != 0;
    numbers.start(5, 6, 7);
    for (uint32_t ray = 0; ray < 8; ++ray) {
        numbers.start_ray(ray);
        const auto own = bn::PathSampler(sampler, 5, 6, 7).ray(ray).draw();
        count += counted(numbers, "12") != std::vector<float>{own[2], own[0], own[1]};
    }
    // The next ray begins with the same numbers whatever this ray draws, and no number occurs twice.
    std::vector<float> next;
    for (const char *pattern : {"", "1", "2", "112112", "2222222222", "1111111111111111111111"}) {
        numbers.start(5, 6, 7);
        auto all = counted(numbers, pattern);
        numbers.start_ray(1);
        const auto own = counted(numbers, "1212121");
        count += !next.empty() && own != next;
        next = own;
        all.insert(all.end(), own.begin(), own.end());
        for (std::size_t i = 0; i < all.size(); ++i)
            for (std::size_t k = 0; k < i; ++k) count += all[i] == all[k];
    }
    // A sequential sampler created from a path draws the same numbers. Starting the current ray again continues it.
    const bn::PathSampler path(sampler, 5, 6, 7);
    bn::SequentialSampler own(path);
    numbers.start(5, 6, 7);
    auto whole = counted(own, "122");
    count += whole != counted(numbers, "122");
    own.start_ray(0);
    count += counted(own, "12") != counted(numbers, "12");
    own.start_ray(1);
    count += counted(own, "1212121") != next;
    // A sequential sampler created from a child of a ray draws numbers that the ray itself does not draw.
    bn::RaySampler ray = path.ray(0);
    bn::SequentialSampler part(ray.child(3));
    const auto parts = counted(part, "2212");
    for (const float u : ray.draw()) whole.push_back(u);
    for (const float u : ray.next_4d()) whole.push_back(u);
    for (const float a : parts)
        for (const float b : whole) count += a == b;
    return count + (parts[0] != path.ray(0).child(3).draw()[0]);
}

// The state that a renderer keeps for each thread.
struct Worker {
    bn::Sampler sampler;
    bn::SequentialSampler numbers{sampler};
    bn::PathSampler path;
    bn::RaySampler ray;
};

// After a move, a worker does not refer to its old location.
int wrong_moves() {
    auto first = std::make_unique<Worker>(Worker{bn::Sampler(5), {}, {}, {}});
    first->numbers = bn::SequentialSampler(first->sampler);
    Worker second(std::move(*first));
    first->sampler = bn::Sampler(6);
    first.reset();
    second.numbers.start(1, 2, 3);
    const bn::Sampler same(5);
    return second.numbers.next_2d() != bn::PathSampler(same, 1, 2, 3).ray(0).draw_direction();
}

} // namespace

int main() {
    const bn::Domain light = bn::Domain().child(3);
    bn::Sampler sampler;
    for (uint32_t index = 0; index < 4; ++index) {
        const auto u = sampler.sample_4d_u32(-7, 12, index, light);
        std::printf("%08lx %08lx %08lx %08lx\n", static_cast<unsigned long>(u[0]),
                    static_cast<unsigned long>(u[1]), static_cast<unsigned long>(u[2]),
                    static_cast<unsigned long>(u[3]));
    }
    bn::RaySampler ray = bn::PathSampler(sampler, -7, 12, 1, 2).ray(3);
    const bn::PathSampler branch = ray.next_split(4)[5];
    const auto number = ray.next_4d();
    std::printf("%.7f %.7f %08lx %lu\n", static_cast<double>(number[0]),
                static_cast<double>(number[3]), static_cast<unsigned long>(branch.state().domain),
                static_cast<unsigned long>(branch.state().index));
    int failures = wrong(sampler, light) + wrong_paths() + wrong_counters(sampler) +
                   wrong_frames() + wrong_counts(sampler) + wrong_moves();
    failures +=
        bn::Sampler(7).sample_4d(1, 2, 3) != bn::Sampler(bn::Type::blue, 7).sample_4d(1, 2, 3);
    failures += light.value() != bn_domain_child(BN_DOMAIN_ROOT, 3) || light == bn::Domain();
    failures += light != bn::Domain(light.value());

    bn::Sampler other(bn::Type::sobol, 5);
    const auto before = other.sample_4d(1, 2, 3);
    failures += before == sampler.sample_4d(1, 2, 3);
    failures +=
        at_compile_time.sample_4d(1, 2, 3) != before || Renderer().sampler.seed() != sampler.seed();
    sampler = other;
    failures += sampler.sample_4d(1, 2, 3) != before || other.sample_4d(1, 2, 3) != before;

    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT, [&] { sampler.block(0, 0, 0, 1, 0, 1); });
    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT,
                            [&] { sampler.sample_wavefront(bn_wavefront_default()); });
    failures += !fails_with(BN_ERROR_OUT_OF_MEMORY,
                            [&] { sampler.block(0, 0, 1u << 31, 1u << 31, 0, 1u << 31); });
    const uint32_t ranks[2] = {0, 0};
    const bn_mask mask = bn_mask_u32(ranks, 2, 1);
    failures += !fails_with(BN_ERROR_INVALID_ARGUMENT,
                            [] { const bn::Sampler bad(static_cast<bn::Type>(99)); });
    failures += !fails_with(BN_ERROR_BAD_DATA, [&] { bn::Sampler::from_mask(mask); });
    std::printf("%d\n", failures);
}
