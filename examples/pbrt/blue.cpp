// SPDX-License-Identifier: Apache-2.0

#include <pbrt/blue.h>

#include <pbrt/options.h>
#include <pbrt/paramdict.h>
#include <pbrt/util/error.h>
#include <pbrt/util/print.h>

#include <bn/bn_draw.h>

#include <algorithm>

namespace pbrt {

// With 2 to MaxEquidistant samples per pixel, wavelengths are equidistant. Sample i takes place i * step modulo the count, so
// that the first few samples are far apart, too.
static constexpr int MaxEquidistant = 7;
static constexpr int EquidistantSteps[MaxEquidistant + 1] = {0, 1, 1, 2, 3, 3, 5, 4};

BlueSampler *BlueSampler::Create(const ParameterDictionary &parameters, const FileLoc *,
                                 Allocator alloc) {
    const int asked = parameters.GetOneInt("pixelsamples", 16);
    const int count = Options->quickRender    ? 1
                      : Options->pixelSamples ? *Options->pixelSamples
                                              : asked;
    const int seed = parameters.GetOneInt("seed", Options->seed);
    return alloc.new_object<BlueSampler>(count, uint32_t(seed));
}

void BlueSampler::OpenDomain(int newKey) {
    key = newKey;
    spent = 0;
    bn_sample_4d(&sampler, pixel.x, pixel.y, sampleIndex, bn_domain_child(BN_DOMAIN_ROOT, key), u);
}

// Three dimensions a domain: keys of a whole path and of one that is started anew agree.
void BlueSampler::OpenNextDomain() {
    OpenDomain(std::max(key + 1, (dimension + 1) / 3));
}

void BlueSampler::StartPixelSample(Point2i p, int index, int dim) {
    pixel = p;
    sampleIndex = index;
    dimension = dim;
    key = -1;
    spent = 4;
    // The wavefront integrator starts each surface here. Roulette at the surface before has spent a number.
    if (dim > 0) {
        OpenDomain(dim / 3);
        spent = dim > 6;
    }
}

// Where a sample's wavelengths fall within their spacing, in [0, 1). Usually u[3]. The u[3] of 2 to 7 samples are unevenly
// spaced, so evenly spaced numbers take their place, of which the first is sample 0's u[3]. For one sample a mask: nothing is
// bluer where a single smooth number decides.
Float BlueSampler::WavelengthOffset() const {
    if (samplesPerPixel > MaxEquidistant || sampleIndex >= samplesPerPixel) return u[3];
    const uint32_t domain = bn_domain_child(BN_DOMAIN_ROOT, 0);
    if (samplesPerPixel == 1) return bn_sample_1d(&mask, pixel.x, pixel.y, 0, domain);
    float first[2];
    bn_sample_2d(&sampler, pixel.x, pixel.y, 0, domain, 1, first);
    const int place = sampleIndex * EquidistantSteps[samplesPerPixel] % samplesPerPixel;
    const Float v = first[1] + Float(place) / samplesPerPixel;
    return v - int(v);
}

Float BlueSampler::Get1D() {
    if (dimension == 0) {
        // Of the wavelengths w, w + 1/4, w + 1/2, w + 3/4, only w modulo 1/4 decides which are taken.
        OpenDomain(0);
        spent = 4;
        dimension = 1;
        return std::min<Float>((int(4 * u[2]) + WavelengthOffset()) / 4, OneMinusEpsilon);
    }
    if (spent >= 2) OpenNextDomain();
    ++dimension;
    return u[2 + spent++];
}

Point2f BlueSampler::Get2D() {
    if (spent > 2) OpenNextDomain();
    dimension += 2;
    spent = 4;
    return Point2f(u[0], u[1]);
}

Point2f BlueSampler::GetPixel2D() {
    dimension += 2;
    if (key == 0) return Point2f(u[0], u[1]);
    float pair[4];
    bn_sample_4d(&sampler, pixel.x, pixel.y, sampleIndex, bn_domain_child(BN_DOMAIN_ROOT, 0), pair);
    return Point2f(pair[0], pair[1]);
}

Sampler BlueSampler::Clone(Allocator alloc) {
    return alloc.new_object<BlueSampler>(*this);
}

std::string BlueSampler::ToString() const {
    return StringPrintf("[ BlueSampler pixel: %s sampleIndex: %d dimension: %d "
                        "samplesPerPixel: %d ]",
                        pixel, sampleIndex, dimension, samplesPerPixel);
}

} // namespace pbrt
