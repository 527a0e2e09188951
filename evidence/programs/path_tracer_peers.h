// SPDX-License-Identifier: Apache-2.0
// Other samplers behind the interface of bn::PathSampler and bn::RaySampler. The path tracer's sampler.h
// includes this file if BN_WITH_PEERS is defined.
#pragma once

#include <bn/bn.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

// Draws with one key per decision. Either half of a 4-D draw may also be a separate decision; the second
// half then has key + 1.
class PeerSampler {
  public:
    explicit PeerSampler(uint64_t own_seed)
        : seed(own_seed), generator(bn::Type::white, own_seed) {}
    virtual ~PeerSampler() = default;
    // The first `dimensions` numbers: 2 or 4.
    virtual void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
                      float *u) const = 0;
    // The first two numbers of part k of a sample that is split into `count` parts. The parts of all
    // samples form one sequence, as in libbn, unless the sampler has its own method.
    virtual void draw_split(int32_t x, int32_t y, uint32_t index, uint32_t key, uint32_t count,
                            uint32_t k, float *u) const {
        draw(x, y, index * count + k, key, 2, u);
    }

    const uint64_t seed;
    const bn::Sampler generator; // for loops, after their first four numbers
};

template <typename Peer>
std::shared_ptr<const PeerSampler> create_peer(uint64_t seed) {
    return std::make_shared<Peer>(seed);
}

class PeerRay;

// One sample of one pixel, like bn::PathSampler: ray 0 leaves the camera, ray d the d-th surface.
struct PeerPath {
    // In place of ray 3, which moves up, as in bn_path.h.
    static constexpr uint32_t CAMERA_KEY = 12;
    static uint32_t ray_key(uint32_t ray) { return 4 * (ray < 3 ? ray : ray + 1); }

    const PeerSampler &sampler;
    int32_t x, y;
    uint32_t index;

    template <int N>
    std::array<float, N> draw(uint32_t key) const {
        std::array<float, N> u;
        sampler.draw(x, y, index, key, N, u.data());
        return u;
    }
    PeerRay ray(uint32_t number) const;
    std::array<float, 2> first_light(uint32_t count, uint32_t k) const {
        if (count == 1) return draw<2>(CAMERA_KEY);
        std::array<float, 2> u;
        sampler.draw_split(x, y, index, CAMERA_KEY, count, k, u.data());
        return u;
    }
    std::array<float, 2> time_wavelength() const {
        const std::array<float, 4> u = draw<4>(CAMERA_KEY);
        return {u[2], u[3]};
    }
};

// One ray of a path, which must outlive the ray: the part of bn::RaySampler that the integrator uses.
class PeerRay {
  public:
    // Ray keys are multiples of four below 2^14.
    PeerRay(const PeerPath &path, uint32_t key) : path_(&path), key_(key) {}

    std::array<float, 4> draw() const { return path_->draw<4>(key_); }
    std::array<float, 2> draw_direction() const { return path_->draw<2>(key_); }
    float next_1d() {
        const uint32_t k = drawn_1d_++;
        if (k % 2 == 1) return next_1d_;
        const auto [number, next] = path_->draw<2>(key_ + 2 + (k / 2 << 24));
        next_1d_ = next;
        return number;
    }
    bn::LoopSampler draw_loop(uint32_t k) const {
        const uint32_t key = key_ + ((k + 1) << 14);
        const std::array<float, 4> u = path_->draw<4>(key);
        const bn_uint4 counter =
            bn_draw_white_counter(bn_draw_seed(path_->sampler.generator.get()), uint32_t(path_->x),
                                  uint32_t(path_->y), path_->index, key);
        return bn::LoopSampler({{u[0], u[1], u[2], u[3]}, counter, 0});
    }

  private:
    const PeerPath *path_;
    uint32_t key_, drawn_1d_ = 0;
    float next_1d_ = 0; // drawn with the one before it
};

inline PeerRay PeerPath::ray(uint32_t number) const {
    return PeerRay(*this, ray_key(number));
}
