/* SPDX-License-Identifier: Apache-2.0
 * Samplers, which keep their mask's array alive; draws on arrays and blocks; domains, paths and choices. */
#include "core.hpp"

#include <bn/bn_choose.h>
#include <bn/bn_path.h>

#include <cstring>

namespace bluenoise {

namespace {

using Int32s = py::array_t<int32_t, py::array::c_style>;
using UInt32s = py::array_t<uint32_t, py::array::c_style>;

class Sampler {
  public:
    Sampler(int32_t type, uint64_t seed, uint32_t samples_per_pixel, const py::object &mask)
        : mask_(mask) {
        bn_result result = BN_SUCCESS;
        if (!mask.is_none()) {
            const auto ranks = mask.cast<Ranks>();
            const bn_mask value = mask_of(ranks);
            result = unlocked([&] { return bn_sampler_init_mask(&sampler_, &value, seed); });
        } else if (type == BN_SAMPLER_ZORDER) {
            result = bn_sampler_init_zorder(&sampler_, samples_per_pixel, seed);
        } else {
            result = bn_sampler_init(&sampler_, type, seed);
        }
        check(result);
    }

    /* Draws n lanes: `out` has shape (n, dimensions). `pair` is 0 or 1, or -1 for the first 1 to 4
     * dimensions. */
    void sample(const Int32s &x, const Int32s &y, const UInt32s &index, const UInt32s &domain,
                Floats &out, int32_t pair) const {
        const auto dims = static_cast<uint32_t>(out.shape(1));
        const uint32_t first = pair == 1 ? 2 : 0;
        bn_wavefront lanes = bn_wavefront_default();
        lanes.count = static_cast<size_t>(out.shape(0));
        lanes.x = x.data();
        lanes.y = y.data();
        lanes.index = index.data();
        lanes.domain = domain.data();
        for (uint32_t d = 0; d < dims; ++d) lanes.out[first + d] = out.mutable_data() + d;
        lanes.stride = dims;
        check(unlocked([&] { return bn_sample_wavefront(&sampler_, &lanes); }));
    }

    /* `out` has shape (height, width, index_count, 4). */
    void block(int32_t x0, int32_t y0, uint32_t first_index, uint32_t domain, Floats &out) const {
        const auto height = static_cast<uint32_t>(out.shape(0));
        const auto width = static_cast<uint32_t>(out.shape(1));
        const auto index_count = static_cast<uint32_t>(out.shape(2));
        const auto size = static_cast<size_t>(out.size());
        float *to = out.mutable_data();
        check(unlocked([&] {
            return bn_sample_block(&sampler_, x0, y0, width, height, first_index, index_count,
                                   domain, to, size);
        }));
    }

    /* Draws samples first_index, first_index + 1 ... of one pixel with all 32 bits. Each is at the
     * centre of its interval, so integrals are unbiased. `out` has shape (index_count, 4). */
    void points(int32_t x, int32_t y, uint32_t first_index, uint32_t domain, Doubles &out) const {
        double *to = out.mutable_data();
        for (py::ssize_t i = 0; i < out.shape(0); ++i, to += 4) {
            uint32_t bits[4];
            bn_sample_4d_u32(&sampler_, x, y, first_index + static_cast<uint32_t>(i), domain, bits);
            for (int d = 0; d < 4; ++d) to[d] = (bits[d] + 0.5) * (1.0 / 4294967296.0);
        }
    }

    UInt32s seed_words() const {
        UInt32s words(2);
        bn_sampler_seed(&sampler_, words.mutable_data());
        return words;
    }

  private:
    bn_sampler sampler_;
    py::object mask_; /* whose ranks sampler_ borrows */
};

UInt32s tables() {
    size_t count = 0;
    const uint32_t *words = bn_tables(&count, nullptr);
    return UInt32s(static_cast<py::ssize_t>(count), words);
}

/* The upper half holds the choice; the lower half holds the remainder's bits. */
uint64_t packed(uint32_t chosen, float rest) {
    uint32_t bits;
    std::memcpy(&bits, &rest, sizeof bits);
    return uint64_t{chosen} << 32 | bits;
}

py::object choose_cdf(const Floats &cdf, const Floats &u) {
    const float *table = cdf.data();
    const auto count = static_cast<uint32_t>(cdf.size());
    return py::vectorize([table, count](float number) {
        const uint32_t index = bn_choose_cdf(table, count, &number);
        return packed(index, number);
    })(u);
}

} // namespace

void bind_sampler(py::module_ &module) {
    py::dict types;
    types["blue"] = static_cast<int32_t>(BN_SAMPLER_BLUE);
    types["sobol"] = static_cast<int32_t>(BN_SAMPLER_SOBOL);
    types["white"] = static_cast<int32_t>(BN_SAMPLER_WHITE);
    types["zorder"] = static_cast<int32_t>(BN_SAMPLER_ZORDER);
    types["mask"] = static_cast<int32_t>(BN_SAMPLER_MASK);
    module.attr("sampler_types") = types;

    py::class_<Sampler>(module, "Sampler")
        .def(py::init<int32_t, uint64_t, uint32_t, const py::object &>(), py::arg("type"),
             py::arg("seed"), py::arg("samples_per_pixel"), py::arg("mask"))
        .def("sample", &Sampler::sample, py::arg("x"), py::arg("y"), py::arg("index"),
             py::arg("domain"), py::arg("out").noconvert(), py::arg("pair") = -1)
        .def("block", &Sampler::block, py::arg("x0"), py::arg("y0"), py::arg("first_index"),
             py::arg("domain"), py::arg("out").noconvert())
        .def("points", &Sampler::points, py::arg("x"), py::arg("y"), py::arg("first_index"),
             py::arg("domain"), py::arg("out").noconvert())
        .def("seed_words", &Sampler::seed_words);
    module.def("tables", &tables);
    /* These functions take numbers or arrays, which broadcast. */
    module.def("choose", py::vectorize([](float probability, float u) {
                   const auto chosen = static_cast<uint32_t>(bn_choose(probability, &u));
                   return packed(chosen, u);
               }));
    module.def("choose_u32", py::vectorize([](uint32_t count, float u) {
                   const uint32_t index = bn_choose_u32(count, &u);
                   return packed(index, u);
               }));
    module.def("choose_cdf", &choose_cdf);
    module.def("domain_child", py::vectorize(&bn_domain_child), py::arg("domain"), py::arg("key"));
    module.def(
        "pan_add", py::vectorize([](uint64_t sum, float motion) {
            const bn_uint2 at = {static_cast<uint32_t>(sum >> 32), static_cast<uint32_t>(sum)};
            const bn_uint2 moved = bn_pan_add(at, motion);
            return uint64_t{moved.x} << 32 | moved.y;
        }));
    module.def("frame_index", py::vectorize(&bn_frame_index));
    module.def("frame_stream", py::vectorize(&bn_frame_stream));
    module.def("stream_domain", py::vectorize(&bn_path_stream_domain));
    module.def("path_ray_domain", py::vectorize([](uint32_t domain, uint32_t ray) {
                   return bn_path_ray_domain({0, 0, 0, domain}, ray);
               }));
    module.def("path_camera_domain", py::vectorize([](uint32_t domain) {
                   return bn_path_camera_domain({0, 0, 0, domain});
               }));
    module.def("ray_1d_domain", py::vectorize(&bn_ray_1d_domain));
    module.def("ray_2d_domain", py::vectorize(&bn_ray_2d_domain));
    module.def("ray_4d_domain", py::vectorize(&bn_ray_4d_domain));
    module.def("ray_split_domain", py::vectorize(&bn_ray_split_domain));
    module.def("ray_loop_domain", py::vectorize(&bn_ray_loop_domain));
    module.def("ray_child_domain", py::vectorize(&bn_ray_child_domain));
    module.def("branch_domain", py::vectorize([](uint32_t split, uint32_t count, uint32_t k) {
                   return bn_path_branch({0, 0, 0, 0}, split, count, k).domain;
               }));
    module.def("loop_float", py::vectorize([](uint32_t seed0, uint32_t seed1, int32_t x, int32_t y,
                                              uint32_t index, uint32_t domain, uint32_t k) {
                   const bn_path path = {static_cast<uint32_t>(x), static_cast<uint32_t>(y), index,
                                         domain};
                   return bn_draw_float(bn_loop_later_bits({seed0, seed1}, path, domain, k));
               }));
}

} // namespace bluenoise
