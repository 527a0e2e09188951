// SPDX-License-Identifier: Apache-2.0
// libbn for C++14 and later: samplers, paths, domains and draws as values. This header is a thin inline layer over bn.h
// and bn_path.h, which document the functions. Draws are bit-identical to those in C.
//
//     const bn::Sampler sampler(seed);
//     const bn::PathSampler path(sampler, x, y, index);
//     bn::RaySampler ray = path.ray(depth);
//     const std::array<float, 4> u = ray.draw();   // u[0], u[1]: the direction; u[2], u[3]: a light at its end
//     const float lobe = ray.next_1d();
//
// For renderers that ask for the next number or pair:
//
//     bn::SequentialSampler numbers(sampler);
//     numbers.start(x, y, index);
//     const std::array<float, 2> film = numbers.next_2d();
//
// To use your own domains:
//
//     const bn::Domain light = bn::Domain().child(KEY_LIGHT);
//     const std::array<float, 2> point = sampler.sample_2d(x, y, index, light);
//
// A Sampler is immutable, so threads can share it. Functions that are not noexcept throw bn::Error if the library
// returns an error, or std::bad_alloc. Call the rest of the library as in C, passing sampler.get().
//
// Without exceptions (-fno-exceptions), these functions call std::terminate() instead. To handle an error there, call
// the function in bn.h and construct the Sampler from its result:
//
//     bn_sampler made;
//     if (bn_sampler_init(&made, BN_SAMPLER_SOBOL, seed) != BN_SUCCESS) return;
//     const bn::Sampler sobol(made);
//
// Use bn/bn.hpp in C++14 and later, and bn/bn_path.h in C and C++11. A C++11 project can also compile one file as
// C++14:
//
//     // numbers.h, C++11
//     class Numbers {
//       public:
//         explicit Numbers(uint64_t seed);
//         ~Numbers();
//         void start(int x, int y, unsigned index);
//         void start_ray(unsigned ray);
//         float get_1d();
//         void get_2d(float out[2]);
//       private:
//         struct State;
//         std::unique_ptr<State> state_;
//     };
//
//     // numbers.cpp, C++14
//     struct Numbers::State {
//         bn::SequentialSampler numbers;
//     };
//     Numbers::Numbers(uint64_t seed) : state_(new State{bn::SequentialSampler(bn::Sampler(seed))}) {}
//     Numbers::~Numbers() = default;
//     void Numbers::start(int x, int y, unsigned index) { state_->numbers.start(x, y, index); }
//     void Numbers::start_ray(unsigned ray) { state_->numbers.start_ray(ray); }
//     float Numbers::get_1d() { return state_->numbers.next_1d(); }
//     void Numbers::get_2d(float out[2]) {
//         const std::array<float, 2> u = state_->numbers.next_2d();
//         out[0] = u[0], out[1] = u[1];
//     }
#ifndef BN_BN_HPP
#define BN_BN_HPP

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

#if __cplusplus < 201402L && !(defined(_MSVC_LANG) && _MSVC_LANG >= 201402L)
#error                                                                                             \
    "bn.hpp needs C++14 (-std=c++14); a C++11 program uses bn_path.h, or hides bn.hpp behind one file"
#else

#include <bn/bn_path.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace bn {

// Thrown for any result other than BN_SUCCESS. what() names the function and describes the result.
class Error : public std::runtime_error {
  public:
    Error(const char *function, bn_result result)
        : std::runtime_error(std::string(function) + ": " + bn_result_string(result)),
          result_(result) {}

    bn_result result() const noexcept { return result_; }

  private:
    bn_result result_;
};

namespace detail {

[[noreturn]] inline void fail(const char *function, bn_result result) {
#if defined(__cpp_exceptions) || defined(__EXCEPTIONS) || defined(_CPPUNWIND)
    throw Error(function, result);
#else
    (void)function, (void)result;
    std::terminate();
#endif
}

inline void require(const char *function, bn_result result) {
    if (result != BN_SUCCESS) fail(function, result);
}

} // namespace detail

// Throws bn::Error unless the result is BN_SUCCESS. You can also use it with other functions in bn.h:
// bn::check("bn_dither", bn_dither(...)). In parentheses, because other libraries define a macro with this name.
inline void(check)(const char *function, bn_result result) {
    detail::require(function, result);
}

// Identifies one decision along a path. The default Domain is the root.
class Domain {
  public:
    constexpr Domain() noexcept = default;
    constexpr explicit Domain(uint32_t value) noexcept : value_(value) {}

    // Calls bn_domain_child(). Keys 4*k to 4*k + 3 form a family.
    Domain child(uint32_t key) const noexcept { return Domain(bn_domain_child(value_, key)); }

    // The value to pass to bn.h, bn_draw.h and shaders.
    constexpr uint32_t value() const noexcept { return value_; }

    friend constexpr bool operator==(Domain a, Domain b) noexcept { return a.value_ == b.value_; }
    friend constexpr bool operator!=(Domain a, Domain b) noexcept { return a.value_ != b.value_; }

  private:
    uint32_t value_ = BN_DOMAIN_ROOT;
};

// The sampler types; see BN_SAMPLER_... in bn.h.
enum class Type : int32_t {
    blue = BN_SAMPLER_BLUE,
    sobol = BN_SAMPLER_SOBOL,
    white = BN_SAMPLER_WHITE,
    zorder = BN_SAMPLER_ZORDER,
    mask = BN_SAMPLER_MASK
};

class Sampler {
  public:
    // A BLUE sampler.
    constexpr Sampler() noexcept : Sampler(uint64_t{0}) {}
    constexpr explicit Sampler(uint64_t seed) noexcept : sampler_(bn_sampler_make(seed)) {}
    // Throws INVALID_ARGUMENT for an unknown type. ZORDER is tuned for 256 samples.
    constexpr explicit Sampler(Type type, uint64_t seed = 0) : Sampler(seed) {
        if (type < Type::blue || type > Type::mask)
            detail::fail("bn_sampler_init", BN_ERROR_INVALID_ARGUMENT);
        sampler_.type = static_cast<int32_t>(type);
    }
    // Rejects BN_SAMPLER_..., which would otherwise be taken for a seed. Pass a Type.
    template <typename Other, typename = std::enable_if_t<std::is_enum<Other>::value &&
                                                          !std::is_same<Other, Type>::value>>
    explicit Sampler(Other type, uint64_t seed = 0) = delete;
    // Calls bn_sampler_init_zorder(): the sampler is tuned for samples_per_pixel samples.
    static Sampler zorder(uint32_t samples_per_pixel, uint64_t seed = 0) {
        Sampler made(seed);
        detail::require("bn_sampler_init_zorder",
                        bn_sampler_init_zorder(&made.sampler_, samples_per_pixel, seed));
        return made;
    }
    // Calls bn_sampler_init_mask(). Throws INVALID_ARGUMENT, BAD_DATA or OUT_OF_MEMORY. Keep the ranks alive while the
    // Sampler or a copy of it is in use.
    static Sampler from_mask(const bn_mask &mask, uint64_t seed = 0) {
        Sampler made(seed);
        detail::require("bn_sampler_init_mask", bn_sampler_init_mask(&made.sampler_, &mask, seed));
        return made;
    }
    constexpr explicit Sampler(const bn_sampler &sampler) noexcept : sampler_(sampler) {}

    // Sample `index` of pixel (x, y) in a domain. sample_1d() returns dimension 0; sample_2d() returns one pair, (0, 1)
    // for pair 0 or (2, 3) for pair 1; sample_4d() returns all four dimensions.
    float sample_1d(int32_t x, int32_t y, uint32_t index, Domain domain = Domain()) const noexcept {
        return bn_draw_1d(&sampler_, x, y, index, domain.value());
    }
    std::array<float, 2> sample_2d(int32_t x, int32_t y, uint32_t index, Domain domain = Domain(),
                                   uint32_t pair = 0) const noexcept {
        std::array<float, 2> out{};
        bn_draw_2d(&sampler_, x, y, index, domain.value(), pair, out.data());
        return out;
    }
    std::array<float, 4> sample_4d(int32_t x, int32_t y, uint32_t index,
                                   Domain domain = Domain()) const noexcept {
        std::array<float, 4> out{};
        bn_draw_4d(&sampler_, x, y, index, domain.value(), out.data());
        return out;
    }
    // All four dimensions, each as 32 random bits.
    std::array<uint32_t, 4> sample_4d_u32(int32_t x, int32_t y, uint32_t index,
                                          Domain domain = Domain()) const noexcept {
        std::array<uint32_t, 4> out{};
        bn_draw_4d_u32(&sampler_, x, y, index, domain.value(), out.data());
        return out;
    }

    // Calls bn_sample_wavefront(). Throws INVALID_ARGUMENT or UNSUPPORTED.
    void sample_wavefront(const bn_wavefront &wavefront) const {
        detail::require("bn_sample_wavefront", bn_sample_wavefront(&sampler_, &wavefront));
    }

    // Calls bn_sample_block(). The result is [height][width][index_count][4]. Throws INVALID_ARGUMENT for a zero extent
    // or a block that runs past the last coordinate or index, and OUT_OF_MEMORY if the size of the result overflows.
    std::vector<float> block(int32_t x0, int32_t y0, uint32_t width, uint32_t height,
                             uint32_t first_index, uint32_t index_count,
                             Domain domain = Domain()) const {
        std::size_t count = 4;
        for (const uint32_t extent : {width, height, index_count}) {
            if (extent != 0 && count > out_max / extent)
                detail::fail("bn_sample_block", BN_ERROR_OUT_OF_MEMORY);
            count *= extent;
        }
        std::vector<float> out(count);
        float none = 0; // an empty vector's data() may be NULL, which would be a different error
        detail::require("bn_sample_block",
                        bn_sample_block(&sampler_, x0, y0, width, height, first_index, index_count,
                                        domain.value(), out.empty() ? &none : out.data(),
                                        out.size()));
        return out;
    }

    // The sampler to pass to functions in bn.h and bn_path.h.
    constexpr const bn_sampler *get() const noexcept { return &sampler_; }
    // The result of bn_sampler_seed(), for shaders.
    constexpr std::array<uint32_t, 2> seed() const noexcept {
        return {sampler_.seed[0], sampler_.seed[1]};
    }

  private:
    static constexpr std::size_t out_max = static_cast<std::size_t>(-1) / 2 / sizeof(float);

    bn_sampler sampler_{};
};

// ---- A path's decisions (bn_path.h describes the layout)

class PathSampler;
class SequentialSampler;

// Random numbers for a loop of unknown length. The first four are stratified; the rest are pseudo-random.
class LoopSampler {
  public:
    explicit LoopSampler(const bn_loop &loop) noexcept : loop_(loop) {}

    // The next number, in [0, 1).
    float next_1d() noexcept { return bn_loop_next_1d(&loop_); }

  private:
    bn_loop loop_;
};

// A path that continues in multiple branches.
class Split {
  public:
    Split(const bn_sampler *sampler, const bn_split &split) noexcept
        : sampler_(sampler), split_(split) {}

    // Branch k. Its rays are numbered from 0. A path may use fewer or more branches than the count passed to
    // next_split().
    PathSampler operator[](uint32_t k) const noexcept;

  private:
    const bn_sampler *sampler_;
    bn_split split_;
};

// One ray of a path. It is stateful, so it can be moved but not copied: pass it by reference. A second RaySampler for
// the same ray returns the same numbers.
class RaySampler {
  public:
    // Empty: assign a path's ray before you draw.
    RaySampler() noexcept = default;
    RaySampler(const bn_sampler *sampler, const bn_ray &ray) noexcept
        : sampler_(sampler), ray_(ray) {}
    RaySampler(RaySampler &&) noexcept = default;
    RaySampler &operator=(RaySampler &&) noexcept = default;
    RaySampler(const RaySampler &) = delete;
    RaySampler &operator=(const RaySampler &) = delete;

    // The ray's direction, and the light sample at its end. Every call returns the same four numbers.
    std::array<float, 4> draw() const noexcept {
        std::array<float, 4> out{};
        bn_ray_draw(sampler_, &ray_, out.data());
        return out;
    }
    // One of draw()'s two pairs.
    std::array<float, 2> draw_direction() const noexcept {
        std::array<float, 2> out{};
        bn_ray_draw_direction(sampler_, &ray_, out.data());
        return out;
    }
    std::array<float, 2> draw_end_light() const noexcept {
        std::array<float, 2> out{};
        bn_ray_draw_end_light(sampler_, &ray_, out.data());
        return out;
    }

    // Returns the same result as call k + 1 of the matching next_...() below.
    float draw_1d(uint32_t k) const noexcept { return bn_ray_draw_1d(sampler_, &ray_, k); }
    std::array<float, 2> draw_2d(uint32_t k) const noexcept {
        std::array<float, 2> out{};
        bn_ray_draw_2d(sampler_, &ray_, k, out.data());
        return out;
    }
    std::array<float, 4> draw_4d(uint32_t k) const noexcept {
        std::array<float, 4> out{};
        bn_ray_draw_4d(sampler_, &ray_, k, out.data());
        return out;
    }
    Split draw_split(uint32_t k, uint32_t count) const noexcept {
        return Split(sampler_, bn_ray_draw_split(&ray_, k, count));
    }
    LoopSampler draw_loop(uint32_t k) const noexcept {
        return LoopSampler(bn_ray_draw_loop(sampler_, &ray_, k));
    }

    // Numbers for other decisions. Every call returns new ones.
    float next_1d() noexcept { return bn_ray_next_1d(sampler_, &ray_); }
    std::array<float, 2> next_2d() noexcept {
        std::array<float, 2> out{};
        bn_ray_next_2d(sampler_, &ray_, out.data());
        return out;
    }
    std::array<float, 4> next_4d() noexcept {
        std::array<float, 4> out{};
        bn_ray_next_4d(sampler_, &ray_, out.data());
        return out;
    }
    Split next_split(uint32_t count) noexcept {
        return Split(sampler_, bn_ray_next_split(&ray_, count));
    }
    // For branch counts that vary: `first` is the number of branches the pixel's earlier samples took here.
    Split next_split_from(uint32_t first) noexcept {
        return Split(sampler_, bn_ray_next_split_from(&ray_, first));
    }
    LoopSampler next_loop() noexcept { return LoopSampler(bn_ray_next_loop(sampler_, &ray_)); }

    // A sub-sampler of the ray, selected by a key such as a primitive's index. Draw from it as you would from
    // a ray. A second child with the same key returns the same numbers.
    RaySampler child(uint32_t key) const noexcept {
        return RaySampler(sampler_, bn_ray_child(&ray_, key));
    }

  private:
    friend class SequentialSampler;
    const bn_sampler *sampler_ = nullptr;
    bn_ray ray_{};
};

// One sample of one pixel. The Sampler must outlive it.
class PathSampler {
  public:
    // Empty: assign a path before you draw.
    PathSampler() noexcept = default;
    PathSampler(const Sampler &sampler, int32_t x, int32_t y, uint32_t index,
                uint32_t stream = 0) noexcept
        : PathSampler(sampler.get(), bn_path_start(x, y, index, stream)) {}
    PathSampler(const Sampler &&, int32_t, int32_t, uint32_t, uint32_t = 0) = delete;
    PathSampler(const bn_sampler *sampler, const bn_path &state) noexcept
        : sampler_(sampler), state_(state) {}

    // Ray 0 leaves the camera; ray d leaves the d-th surface.
    RaySampler ray(uint32_t number) const noexcept {
        return RaySampler(sampler_, bn_path_ray(&state_, number));
    }
    // Light sample k of `count` at the end of ray 0. Call this if a lens uses that ray's second pair, or if you take
    // multiple light samples.
    std::array<float, 2> first_light(uint32_t count = 1, uint32_t k = 0) const noexcept {
        std::array<float, 2> out{};
        bn_path_first_light(sampler_, &state_, count, k, out.data());
        return out;
    }
    // [0]: time as a fraction of the shutter interval. [1]: position in the spectrum.
    std::array<float, 2> time_wavelength() const noexcept {
        std::array<float, 2> out{};
        bn_path_time_wavelength(sampler_, &state_, out.data());
        return out;
    }

    // The path's 16-byte state. A wavefront keeps one per lane.
    const bn_path &state() const noexcept { return state_; }

  private:
    friend class SequentialSampler;
    const bn_sampler *sampler_ = nullptr;
    bn_path state_{};
};

inline PathSampler Split::operator[](uint32_t k) const noexcept {
    return PathSampler(sampler_, bn_split_path(&split_, k));
}

// ---- Frames

// How far an image has moved, in whole pixels. Call follow() once per frame, and draw at (x - pan.x(), y - pan.y()).
class Pan {
  public:
    // Calls bn_follow(): the image moved by (x, y) pixels, in the directions in which coordinates grow.
    void follow(float x, float y) noexcept { state_ = bn_follow(state_, x, y); }

    int32_t x() const noexcept { return static_cast<int32_t>(state_.x); }
    int32_t y() const noexcept { return static_cast<int32_t>(state_.y); }

    // The 16-byte state, for shaders.
    const bn_pan &state() const noexcept { return state_; }

  private:
    bn_pan state_{};
};

// Call bn_frame_index() and bn_frame_stream(): the first index of a film's frame, and its stream. `most` is the largest
// number of samples that a pixel takes in any frame.
inline uint32_t frame_index(uint32_t frame, uint32_t most) noexcept {
    return bn_frame_index(frame, most);
}
inline uint32_t frame_stream(uint32_t frame, uint32_t most) noexcept {
    return bn_frame_stream(frame, most);
}

// For renderers that ask a stateful sampler for the next number or pair, as pbrt does. A number and the pair after it,
// or two consecutive pairs, share a domain. Each ray has its own infinite sequence. For a 2-D decision, draw one pair
// instead of two numbers. Do not write f(next_1d(), next_2d()): C++ does not specify the evaluation order, so store the
// numbers in variables first.
class SequentialSampler {
  public:
    // Holds a copy of the Sampler. Call start() before you draw.
    SequentialSampler() noexcept : SequentialSampler(Sampler()) {}
    explicit SequentialSampler(const Sampler &sampler) noexcept : sampler_(*sampler.get()) {}
    // Starts at ray 0 of a path or branch. You can also pass a ray that you do not draw from elsewhere, such as
    // ray.child(MATERIAL) alongside ray.draw().
    explicit SequentialSampler(const PathSampler &path) noexcept
        : sampler_(*path.sampler_), path_(path.state_) {
        begin(0);
    }
    explicit SequentialSampler(RaySampler &&ray) noexcept
        : sampler_(*ray.sampler_), path_(ray.ray_.path), state_(ray.ray_) {
        open();
    }

    // Starts sample `index` of a pixel at ray 0.
    void start(int32_t x, int32_t y, uint32_t index, uint32_t stream = 0) noexcept {
        path_ = bn_path_start(x, y, index, stream);
        begin(0);
    }
    // Call this before each later ray so that neighbouring paths get back in step. To continue the current ray, as in
    // loops that step over transparent surfaces, pass its number again. Passing an earlier number also continues the
    // current ray, because the earlier rays' numbers have been used up; in debug builds, this fails an assertion.
    void start_ray(uint32_t ray) noexcept {
        assert(ray >= ray_);
        if (ray > ray_) begin(ray);
    }
    // Declares the order of calls: '1' stands for a number and '2' for a pair. Debug builds assert that later calls
    // follow this order. For example, expect("22", "1212") declares the pixel position and the lens for ray 0, and a
    // light, the point on it, a lobe and its direction for each later ray. Call expect() before start(). The strings
    // must outlive the object. Calls past the end of a string are not checked.
    void expect(const char *ray_0, const char *later_rays) noexcept {
        expected_[0] = ray_0;
        expected_[1] = later_rays;
    }

    float next_1d() noexcept {
        ask('1');
        if (pair_spent_ || numbers_spent_ == 2) next_domain();
        return u_[2 + numbers_spent_++];
    }
    std::array<float, 2> next_2d() noexcept {
        ask('2');
        if (pair_spent_ && numbers_spent_ > 0) next_domain();
        if (pair_spent_) {
            numbers_spent_ = 2;
            return {u_[2], u_[3]};
        }
        pair_spent_ = true;
        return {u_[0], u_[1]};
    }

  private:
    void begin(uint32_t ray) noexcept {
        ray_ = ray;
        next_expected_ = expected_[ray == 0 ? 0 : 1];
        state_ = bn_path_ray(&path_, ray);
        open();
    }
    void open() noexcept {
        bn_ray_draw(&sampler_, &state_, u_);
        pair_spent_ = false;
        numbers_spent_ = 0;
    }
    void ask(char dimensions) noexcept {
        if (*next_expected_ == '\0') return;
        assert(*next_expected_ == dimensions && "calls differ from the order in expect()");
        (void)dimensions;
        ++next_expected_;
    }
    void next_domain() noexcept {
        bn_ray_next_4d(&sampler_, &state_, u_);
        pair_spent_ = false;
        numbers_spent_ = 0;
    }

    bn_sampler sampler_;
    bn_path path_{};
    bn_ray state_{};
    uint32_t ray_ = 0;
    // The current domain's numbers. The first pair serves a 2-D decision; the second serves another 2-D decision or
    // single numbers.
    float u_[4] = {};
    bool pair_spent_ = true;
    std::size_t numbers_spent_ = 2;
    const char *expected_[2] = {"", ""};
    const char *next_expected_ = "";
};

} // namespace bn

#endif // C++14
#endif
