// SPDX-License-Identifier: Apache-2.0
// libbn's "blue" sampler for pbrt-v4's CPU integrators. README.md explains how to add it.

#ifndef PBRT_BLUE_H
#define PBRT_BLUE_H

#include <pbrt/pbrt.h>

#include <pbrt/base/sampler.h>
#include <pbrt/util/vecmath.h>

#include <bn/bn_path.h>

#include <string>

namespace pbrt {

// Draws a number and the pair after it from one libbn domain: first u[2], then (u[0], u[1]). The wavelengths and
// the pixel position share domain 0. This class cannot be a bn::SequentialSampler, which counts rays: pbrt
// counts the dimensions of a whole path, and may start at any dimension.
class BlueSampler {
  public:
    BlueSampler(int samplesPerPixel, uint64_t seed, int frame = 0)
        : samplesPerPixel(samplesPerPixel),
          firstIndex(bn_frame_index(uint32_t(frame), uint32_t(samplesPerPixel))),
          sampler(bn_sampler_make(seed)) {
        bn_sampler_init(&mask, BN_SAMPLER_MASK, seed);
    }

    static constexpr const char *Name() { return "BlueSampler"; }
    static BlueSampler *Create(const ParameterDictionary &parameters, const FileLoc *loc,
                               Allocator alloc);

    int SamplesPerPixel() const { return samplesPerPixel; }

    void StartPixelSample(Point2i p, int sampleIndex, int dimension);
    Float Get1D();
    Point2f Get2D();
    Point2f GetPixel2D();

    Sampler Clone(Allocator alloc);
    std::string ToString() const;

  private:
    void OpenDomain(int newKey);
    void OpenNextDomain();
    Float WavelengthOffset() const;

    int samplesPerPixel;
    uint32_t firstIndex; // of this frame of a film
    bn_sampler sampler;
    bn_sampler mask; // for images with one sample per pixel
    Point2i pixel;
    int sampleIndex = 0, dimension = 0;
    // The current domain: its key, its numbers, and how many of them have been used, counting from u[2].
    int key = 0, spent = 4;
    float u[4];
};

} // namespace pbrt

#endif // PBRT_BLUE_H
