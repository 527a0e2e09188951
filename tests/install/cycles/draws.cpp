// SPDX-License-Identifier: Apache-2.0
// Draws numbers as Cycles' kernels do. Prints the numbers of a path or the result of a comparison:
//     draws path KIND BOUNCES     one line per number, with its values in eight samples
//     draws domains               how many values do not match the draws of their domain
#include "stand_in.h"

#include "kernel/sample/blue.h"

#include <cstdio>
#include <cstdlib>
#include <string>

using namespace ccl;
using Numbers = std::vector<float>;

namespace {

// Fills the lookup table as Integrator::device_update() does.
Globals make(uint seed) {
    Globals globals;
    globals.data.integrator.seed = seed * 0x9e3779b9u + 77u;
    const bn_sampler sampler = bn_sampler_make(seed);
    size_t count;
    const uint32_t *words = bn_tables(&count, nullptr);
    globals.sample_pattern_lut.resize(count + 2);
    uint32_t *lut = reinterpret_cast<uint32_t *>(globals.sample_pattern_lut.data());
    std::memcpy(lut, words, count * sizeof *words);
    bn_sampler_seed(&sampler, lut + count);
    return globals;
}

struct Sample {
    KernelGlobals kg;
    uint pixel, index;
    Numbers numbers;

    void one(int dimension) { numbers.push_back(blue_sample_1D(kg, pixel, index, dimension)); }
    void two(int dimension) {
        const float2 u = blue_sample_2D(kg, pixel, index, dimension);
        numbers.insert(numbers.end(), {u.x, u.y});
    }
    void three(int dimension) {
        const float3 u = blue_sample_3D(kg, pixel, index, dimension);
        numbers.insert(numbers.end(), {u.x, u.y, u.z});
    }
};

// "surface": everything a surface may draw; "volume": the same in a medium; "subsurface": random walks from hashed offsets.
Numbers path(const Globals &globals, int x, int y, uint index, const std::string &kind,
             int bounces) {
    Sample sample{&globals, blue_pixel(&globals, x, y), index, {}};
    sample.two(PRNG_FILTER);
    sample.three(PRNG_LENS_TIME);
    for (int bounce = 1; bounce <= bounces; ++bounce) {
        const int at = PRNG_BOUNCE_NUM * bounce;
        if (kind == "subsurface" && bounce > 1) {
            const int hashed = int(uint(bounce) * 0x9e3779b9u & ~3u);
            sample.two(hashed);
            for (int k = 1; k < 5; ++k) sample.one(hashed + k);
            continue;
        }
        sample.one(at + PRNG_TERMINATE);
        sample.three(at + PRNG_LIGHT);
        sample.one(at + PRNG_LIGHT_TERMINATE);
        if (kind == "volume" && bounce % 2) {
            sample.two(at + PRNG_VOLUME_PHASE);
            for (int k = PRNG_VOLUME_PHASE_CHANNEL; k <= PRNG_VOLUME_PHASE_GUIDING_EQUIANGULAR; ++k)
                sample.one(at + k);
            continue;
        }
        sample.three(at + PRNG_SURFACE_BSDF);
        sample.two(at + PRNG_SURFACE_AO);
        sample.two(at + PRNG_SURFACE_BEVEL);
        sample.one(at + PRNG_SURFACE_BSDF_GUIDING);
        sample.three(at + PRNG_SURFACE_RIS_GUIDING_0);
        sample.one(at + PRNG_SURFACE_RIS_GUIDING_1);
    }
    return sample.numbers;
}

int print_path(const std::string &kind, int bounces) {
    const Globals globals = make(3);
    std::vector<Numbers> samples;
    for (int k = 0; k < 8; ++k)
        samples.push_back(path(globals, 11 * k, 5 + 3 * k, uint(k), kind, bounces));
    for (size_t i = 0; i < samples[0].size(); ++i) {
        for (const Numbers &numbers : samples) std::printf("%.9g ", double(numbers[i]));
        std::printf("\n");
    }
    return 0;
}

// A Cycles dimension, the library domain it draws from, and the order in which it uses the domain's numbers.
struct Wanted {
    int dimension;
    uint32_t domain;
    int order[3];
};

int domains() {
    int wrong = 0;
    const bn_sampler library = bn_sampler_make(0);
    const Globals globals = make(0);
    const auto ray = [](uint32_t key) { return bn_domain_child(BN_DOMAIN_ROOT, key); };
    // Rays 3 and later use the next key, because the camera's domain has key 3.
    const Wanted all[] = {
        {PRNG_FILTER, ray(0), {0, 1, -1}},
        {16 + PRNG_LIGHT, ray(3), {0, 1, 3}},
        {16 + PRNG_SURFACE_BSDF, ray(1), {0, 1, 2}},
        {32 + PRNG_LIGHT, bn_domain_child(ray(2), 4 * PRNG_LIGHT + 2), {0, 1, 2}},
        {48 + PRNG_SURFACE_BSDF, ray(4), {0, 1, 2}},
        {48 + PRNG_SURFACE_AO, bn_domain_child(ray(4), 4 * PRNG_SURFACE_AO + 2), {0, 1, -1}},
        {48 + PRNG_TERMINATE, bn_domain_child(ray(4), 0), {0, -1, -1}},
        {48 + PRNG_LIGHT_TERMINATE, bn_domain_child(ray(4), 8), {0, -1, -1}},
    };
    for (uint index = 0; index < 300; index += 7)
        for (const Wanted &wanted : all) {
            const int x = int(index) * 200, y = 65535 - int(index) * 150;
            float u[4];
            bn_sample_4d(&library, x, y, index, wanted.domain, u);
            Sample sample{&globals, blue_pixel(&globals, x, y), index, {}};
            if (wanted.order[1] < 0)
                sample.one(wanted.dimension);
            else if (wanted.order[2] < 0)
                sample.two(wanted.dimension);
            else
                sample.three(wanted.dimension);
            for (size_t k = 0; k < sample.numbers.size(); ++k)
                wrong += sample.numbers[k] != u[wanted.order[k]];
        }
    // Time and lens.
    for (uint index = 0; index < 40; ++index) {
        float first[4], camera[4];
        bn_sample_4d(&library, 5, 6, index, ray(0), first);
        bn_sample_4d(&library, 5, 6, index, ray(3), camera);
        const float3 u =
            blue_sample_3D(&globals, blue_pixel(&globals, 5, 6), index, PRNG_LENS_TIME);
        wrong += u.x != camera[2] || u.y != first[2] || u.z != first[3];
    }
    return wrong;
}

} // namespace

int main(int count, char **arguments) {
    const std::string what = count > 1 ? arguments[1] : "";
    if (what == "path" && count == 4) return print_path(arguments[2], std::atoi(arguments[3]));
    int wrong = -1;
    if (what == "domains") wrong = domains();
    std::printf("%d\n", wrong);
    return 0;
}
