// SPDX-License-Identifier: Apache-2.0
// Draws numbers as pbrt's integrators do. Prints the numbers of a path or the result of a comparison:
//     draws path ORDER DEPTHS          one line per number, with its values in eight samples
//     draws wavefront DEPTHS           how many values differ from those of an uninterrupted path
//     draws domains                    how many values do not match the draws of their domain
//     draws frames                     how many values of a film's frame do not continue those of the frames before it
//     draws wavelengths                how many pixels have unevenly spaced wavelengths at 1 to 7 samples
#include <pbrt/blue.h>

#include <bn/bn.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using pbrt::Point2f, pbrt::Point2i;
using Numbers = std::vector<float>;

namespace {

pbrt::BlueSampler make(int frame = 0) {
    pbrt::ParameterDictionary parameters;
    parameters.frame = frame;
    return *pbrt::BlueSampler::Create(parameters, nullptr, {});
}

void add(Numbers &numbers, const Point2f &p) {
    numbers.push_back(p.x);
    numbers.push_back(p.y);
}

void one_then_two(pbrt::BlueSampler &sampler, Numbers &numbers) {
    numbers.push_back(sampler.Get1D());
    add(numbers, sampler.Get2D());
}

void camera(pbrt::BlueSampler &sampler, Numbers &numbers) {
    numbers.push_back(sampler.Get1D());
    add(numbers, sampler.GetPixel2D());
    one_then_two(sampler, numbers);
}

// Draws light, direction, Russian roulette and, with ten dimensions, the subsurface probe, as the wavefront integrator does.
void surface(pbrt::BlueSampler &sampler, Numbers &numbers, int dimensions) {
    one_then_two(sampler, numbers);
    one_then_two(sampler, numbers);
    numbers.push_back(sampler.Get1D());
    if (dimensions == 10) one_then_two(sampler, numbers);
}

// "7" and "10": as the wavefront integrator, with 7 or 10 dimensions per depth. "cpu": with media, two pairs in a row and
// occasional Russian roulette. "late": the same, but the pixel position is drawn after another number.
Numbers path(pbrt::BlueSampler &sampler, const Point2i &pixel, int index, const std::string &order,
             int depths) {
    Numbers numbers;
    sampler.StartPixelSample(pixel, index, 0);
    if (order == "late") {
        for (int k = 0; k < 2; ++k) numbers.push_back(sampler.Get1D());
        add(numbers, sampler.GetPixel2D());
    } else {
        camera(sampler, numbers);
    }
    for (int depth = 0; depth < depths; ++depth) {
        if (order == "7" || order == "10") {
            const int dimensions = std::atoi(order.c_str());
            sampler.StartPixelSample(pixel, index, 6 + dimensions * depth);
            surface(sampler, numbers, dimensions);
            continue;
        }
        for (int k = 0; k < 3 * (depth % 3 == 1); ++k) numbers.push_back(sampler.Get1D());
        one_then_two(sampler, numbers);
        if (depth % 3 == 1) add(numbers, sampler.Get2D());
        one_then_two(sampler, numbers);
        if (depth % 4 == 2) one_then_two(sampler, numbers);
        if (depth > 1) numbers.push_back(sampler.Get1D());
    }
    return numbers;
}

int print_path(const std::string &order, int depths) {
    std::vector<Numbers> samples;
    pbrt::BlueSampler sampler = make();
    for (int k = 0; k < 8; ++k)
        samples.push_back(path(sampler, {11 * k, 5 + 3 * k}, k, order, depths));
    for (size_t i = 0; i < samples[0].size(); ++i) {
        for (const Numbers &numbers : samples) std::printf("%.9g ", double(numbers[i]));
        std::printf("\n");
    }
    return 0;
}

int wavefront(int depths) {
    int wrong = 0;
    pbrt::BlueSampler sampler = make(), other = make();
    for (int index = 0; index < 20; ++index) {
        const Point2i pixel{7 * index, 3};
        const Numbers broken = path(sampler, pixel, index, "7", depths);
        Numbers whole;
        other.StartPixelSample(pixel, index, 0);
        camera(other, whole);
        for (int depth = 0; depth < depths; ++depth) surface(other, whole, 7);
        for (size_t i = 0; i < whole.size(); ++i) wrong += whole[i] != broken[i];
    }
    return wrong;
}

int frames() {
    int wrong = 0;
    pbrt::BlueSampler film = make(), frame = make(3);
    for (int index = 0; index < 16; ++index) {
        const Numbers wanted = path(film, {index, 9}, 3 * 16 + index, "7", 4);
        const Numbers numbers = path(frame, {index, 9}, index, "7", 4);
        for (size_t i = 0; i < wanted.size(); ++i) wrong += numbers[i] != wanted[i];
    }
    return wrong;
}

int domains() {
    int wrong = 0;
    const bn_sampler library = bn_sampler_make(0);
    pbrt::BlueSampler sampler = make();
    for (int index = 0; index < 300; index += 7) {
        float u[4][4];
        const Point2i pixel{index, 900 - index};
        for (uint32_t key = 0; key < 4; ++key)
            bn_sample_4d(&library, pixel.x, pixel.y, uint32_t(index),
                         bn_domain_child(BN_DOMAIN_ROOT, key), u[key]);
        const float wavelength = (float(int(4 * u[0][2])) + u[0][3]) / 4;
        const Numbers wanted = {wavelength, u[0][0], u[0][1], u[1][2], u[1][0], u[1][1],
                                u[2][2],    u[2][0], u[2][1], u[3][2], u[3][0], u[3][1]};
        const Numbers numbers = path(sampler, pixel, index, "7", 1);
        for (size_t i = 0; i < wanted.size(); ++i) wrong += numbers[i] != wanted[i];
    }
    return wrong;
}

// With one to seven samples in a pixel, their wavelengths modulo 1/4, times 4, are 1 / count apart. Over all pixels,
// each sample's wavelengths are uniform. With one sample, they match the mask.
int wavelengths() {
    int wrong = 0;
    bn_sampler mask;
    bn_sampler_init(&mask, BN_SAMPLER_MASK, 0);
    for (int count = 1; count <= 7; ++count) {
        pbrt::given.pixelSamples = count;
        pbrt::BlueSampler sampler = make();
        std::vector<int> bins(size_t(8 * count));
        for (int x = 0; x < 4096; ++x) {
            std::vector<double> places;
            for (int index = 0; index < count; ++index) {
                const float w = path(sampler, {x % 64, x / 64}, index, "7", 1)[0];
                if (!(w >= 0 && w < 1)) ++wrong;
                places.push_back(4 * w - std::floor(4 * w));
                ++bins[size_t(8 * index) + size_t(8 * places.back())];
            }
            std::sort(places.begin(), places.end());
            for (int k = 0; k < count; ++k)
                if (std::abs(places[size_t(k)] - places[0] - double(k) / count) > 1e-5) {
                    ++wrong;
                    break;
                }
            const float wanted =
                bn_sample_1d(&mask, x % 64, x / 64, 0, bn_domain_child(BN_DOMAIN_ROOT, 0));
            wrong += count == 1 && std::abs(places[0] - double(wanted)) > 1e-6;
        }
        for (int bin : bins) wrong += std::abs(bin - 512) > 100;
    }
    return wrong;
}

} // namespace

int main(int, char **arguments) {
    const std::string what = arguments[1];
    if (what == "path") return print_path(arguments[2], std::atoi(arguments[3]));
    std::printf("%d\n", what == "wavefront" ? wavefront(std::atoi(arguments[2]))
                        : what == "domains" ? domains()
                        : what == "frames"  ? frames()
                                            : wavelengths());
    return 0;
}
