// SPDX-License-Identifier: Apache-2.0
// Loads samplers from shared libraries (sampler_plugin.h) and draws from them.
#pragma once

#include <bn/bn.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sampler_plugin.h"

struct Plugin {
    std::string name;
    uint64_t seed;
    decltype(&sampler_plugin_draw) draw;
    decltype(&sampler_plugin_split) split; // or null
    std::shared_ptr<void> state;
    bn::Sampler white; // the numbers of loops after their first four
};

constexpr uint64_t PLUGIN_INDEX_LIMIT = uint64_t{1} << 31;

// The library's path in "FILE" or "FILE:ARGUMENT", and the argument if it names a file. Empty if the name has no dot
// or slash: it is then a built-in sampler.
std::vector<std::string> plugin_files(const std::string &name);
// `samples`: 0 means unknown. Throws std::runtime_error.
Plugin plugin_load(const std::string &name, uint64_t seed, uint32_t samples);

// The numbers of a path, or of one of its rays: what the path tracer uses of bn::PathSampler and bn::RaySampler.
// Throws std::runtime_error if a number is not in [0, 1).
class PluginPath {
  public:
    static constexpr uint32_t CAMERA = 12; // in place of ray 3, which moves up, as in bn_path.h
    static uint32_t ray_decision(uint32_t ray) { return 4 * (ray < 3 ? ray : ray + 1); }

    PluginPath(const Plugin &plugin, int32_t x, int32_t y, uint32_t index, uint32_t decision = 0)
        : plugin_(&plugin), x_(x), y_(y), index_(index), decision_(decision) {}
    PluginPath ray(uint32_t n) const { return {*plugin_, x_, y_, index_, ray_decision(n)}; }

    std::array<float, 4> draw() const { return numbers<4>(decision_); }
    std::array<float, 2> draw_direction() const { return numbers<2>(decision_); }
    std::array<float, 2> first_light(uint32_t count, uint32_t k) const {
        std::array<float, 2> u;
        if (!plugin_->split || count == 1)
            return PluginPath(*plugin_, x_, y_, index_ * count + k).numbers<2>(CAMERA);
        plugin_->split(plugin_->state.get(), plugin_->seed, x_, y_, index_, CAMERA, count, k,
                       u.data());
        return checked(u, CAMERA);
    }
    std::array<float, 2> time_wavelength() const {
        const std::array<float, 4> u = numbers<4>(CAMERA);
        return {u[2], u[3]};
    }
    float next_1d() {
        const uint32_t k = drawn_1d_++;
        if (k % 2 == 0) pair_ = numbers<2>(decision_ + 2 + (k / 2 << 24));
        return pair_[k % 2];
    }
    bn::LoopSampler draw_loop(uint32_t k) const {
        const uint32_t decision = decision_ + ((k + 1) << 14);
        const std::array<float, 4> u = numbers<4>(decision);
        return bn::LoopSampler({{u[0], u[1], u[2], u[3]},
                                bn_draw_white_counter(bn_draw_seed(plugin_->white.get()),
                                                      uint32_t(x_), uint32_t(y_), index_, decision),
                                0});
    }

  private:
    template <size_t N>
    std::array<float, N> numbers(uint32_t decision) const {
        std::array<float, N> u;
        plugin_->draw(plugin_->state.get(), plugin_->seed, x_, y_, index_, decision, N, u.data());
        return checked(u, decision);
    }
    template <size_t N>
    std::array<float, N> checked(const std::array<float, N> &u, uint32_t decision) const {
        for (const float number : u)
            if (!(number >= 0 && number < 1)) refuse(number, decision);
        return u;
    }
    // Throws std::runtime_error with a number that is not in [0, 1).
    [[noreturn]] void refuse(float number, uint32_t decision) const;

    const Plugin *plugin_;
    int32_t x_, y_;
    uint32_t index_, decision_, drawn_1d_ = 0;
    std::array<float, 2> pair_ = {}; // of next_1d()
};
