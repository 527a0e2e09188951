// SPDX-License-Identifier: Apache-2.0
// pbrt draws one dimension after another; each group of three becomes a domain. With few samples, wavelengths are evenly spaced.

#include <pbrt/blue.h>

#include <pbrt/options.h>
#include <pbrt/paramdict.h>
#include <pbrt/util/error.h>
#include <pbrt/util/print.h>

#include <algorithm>

namespace pbrt {

// With 2 to MaxEquidistant samples per pixel, wavelengths are evenly spaced. Sample i takes position i * step modulo the
// sample count, so the first few samples are also far apart.
static constexpr int MaxEquidistant = 7;
static constexpr int EquidistantSteps[MaxEquidistant + 1] = {0, 1, 1, 2, 3, 3, 5, 4};

BlueSampler *BlueSampler::Create(const ParameterDictionary &parameters, const FileLoc *,
                                 Allocator alloc) {
    const int asked = parameters.GetOneInt("pixelsamples", 16);
    const int count = Options->quickRender    ? 1
                      : Options->pixelSamples ? *Options->pixelSamples
                                              : asked;
    const int seed = parameters.GetOneInt("seed", Options->seed);
    return alloc.new_object<BlueSampler>(count, uint32_t(seed), parameters.GetOneInt("frame", 0));
}

void BlueSampler::OpenDomain(int newKey) {
    key = newKey;
    spent = 0;
    bn_sample_4d(&sampler, pixel.x, pixel.y, firstIndex + sampleIndex,
                 bn_domain_child(BN_DOMAIN_ROOT, key), u);
}

// Each domain covers three dimensions so that a path restarted at a later dimension gets the same keys.
void BlueSampler::OpenNextDomain() {
    OpenDomain(std::max(key + 1, (dimension + 1) / 3));
}

void BlueSampler::StartPixelSample(Point2i p, int index, int dim) {
    pixel = p;
    sampleIndex = index;
    dimension = dim;
    key = -1;
    spent = 4;
    // The wavefront integrator restarts here at each surface. Russian roulette at the previous surface has used one number.
    if (dim > 0) {
        OpenDomain(dim / 3);
        spent = dim > 6;
    }
}

// The offset of a sample's wavelengths within their spacing, in [0, 1). Usually, this is u[3]. With 2 to 7 samples, the
// values of u[3] are unevenly spaced, so evenly spaced values starting at sample 0's u[3] replace them. With one sample,
// the offset comes from a mask, which gives the bluest error for a smooth function of one number.
Float BlueSampler::WavelengthOffset() const {
    if (samplesPerPixel > MaxEquidistant || sampleIndex >= samplesPerPixel) return u[3];
    const uint32_t domain = bn_domain_child(BN_DOMAIN_ROOT, 0);
    if (samplesPerPixel == 1) return bn_sample_1d(&mask, pixel.x, pixel.y, firstIndex, domain);
    float first[2];
    bn_sample_2d(&sampler, pixel.x, pixel.y, firstIndex, domain, 1, first);
    const int place = sampleIndex * EquidistantSteps[samplesPerPixel] % samplesPerPixel;
    const Float v = first[1] + Float(place) / samplesPerPixel;
    return v - int(v);
}

Float BlueSampler::Get1D() {
    if (dimension == 0) {
        // pbrt samples the wavelengths w, w + 1/4, w + 1/2 and w + 3/4, so only w modulo 1/4 matters.
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
    bn_sample_4d(&sampler, pixel.x, pixel.y, firstIndex + sampleIndex,
                 bn_domain_child(BN_DOMAIN_ROOT, 0), pair);
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
