/* SPDX-License-Identifier: Apache-2.0
 * Samplers and domains. */
#include "core.hpp"

#include <bn/bn_path.h>

#include <algorithm>
#include <vector>

namespace bluenoise {

namespace {

using Int32s = py::array_t<int32_t>;
using UInt32s = py::array_t<uint32_t>;

/* Samples between two polls for interrupts: some milliseconds. */
constexpr py::ssize_t poll_interval = py::ssize_t{1} << 18;

/* Copies elements that are `stride` bytes apart. */
template <typename T>
void gather(const char *from, py::ssize_t stride, py::ssize_t count, T *to) {
    if (stride == py::ssize_t{sizeof(T)}) {
        std::copy_n(reinterpret_cast<const T *>(from), count, to);
    } else {
        for (py::ssize_t i = 0; i < count; ++i, from += stride) {
            to[i] = *reinterpret_cast<const T *>(from);
        }
    }
}

/* Collects the lanes of arrays and draws them in parts. Runs without the GIL. */
class Lanes {
  public:
    /* Draws the first `dims` dimensions, or of those the pair `pair` if it is not negative. */
    Lanes(const bn_sampler *sampler, uint32_t dims, int32_t pair, float *out)
        : sampler_(sampler), dims_(dims), pair_(pair), out_(out) {}

    /* A row of x, y, index and domain. */
    void add(const char *const from[4], const py::ssize_t strides[4], py::ssize_t count) {
        for (py::ssize_t at = 0, now; at < count; at += now) {
            now = std::min(count - at, capacity - count_);
            gather(from[0] + at * strides[0], strides[0], now, x_ + count_);
            gather(from[1] + at * strides[1], strides[1], now, y_ + count_);
            gather(from[2] + at * strides[2], strides[2], now, index_ + count_);
            gather(from[3] + at * strides[3], strides[3], now, domain_ + count_);
            count_ += now;
            if (count_ == capacity) draw();
        }
    }

    void draw() {
        const auto count = static_cast<size_t>(count_);
        /* Cannot fail: the arguments are right. */
        if (pair_ < 0) {
            bn_sample_many(sampler_, count, x_, y_, index_, domain_, dims_, out_, count * dims_);
        } else {
            bn_sample_many_pair(sampler_, count, x_, y_, index_, domain_,
                                static_cast<uint32_t>(pair_), out_, count * dims_);
        }
        out_ += count * dims_;
        since_poll_ += count_;
        count_ = 0;
        if (since_poll_ >= poll_interval) {
            interrupts_.poll();
            since_poll_ = 0;
        }
    }

  private:
    static constexpr py::ssize_t capacity = 1024;

    const bn_sampler *sampler_;
    uint32_t dims_;
    int32_t pair_;
    float *out_;
    Interrupts interrupts_;
    py::ssize_t count_ = 0, since_poll_ = 0;
    int32_t x_[capacity], y_[capacity];
    uint32_t index_[capacity], domain_[capacity];
};

class Sampler {
  public:
    Sampler(int32_t kind, uint64_t seed, uint32_t samples_per_pixel, const py::object &mask)
        : mask_(mask) {
        bn_sampler_options options = bn_sampler_options_default();
        options.kind = kind;
        options.seed = seed;
        options.samples_per_pixel = samples_per_pixel;
        std::string arguments = "kind " + std::to_string(kind);
        const Ranks ranks = set_mask(options, mask, arguments);
        check(unlocked([&] { return bn_sampler_init(&sampler_, &options); }), arguments);
    }

    /* The arrays have equal shapes, with strides of 0 along broadcast axes; `out` has one more axis,
     * for 1 to 4 dimensions. `pair` is 0 to 3, as in bn_sample_pair(), and else -1. */
    void sample(const Int32s &x, const Int32s &y, const UInt32s &index, const UInt32s &domain,
                Floats &out, int32_t pair) const {
        std::vector<py::ssize_t> shape(out.shape(), out.shape() + out.ndim());
        if (pair < -1 || pair > 3 || (pair >= 0 && shape.back() != 2)) {
            throw py::value_error("pair must be 0 to 3, with two dimensions, or -1");
        }
        const py::array *arrays[4] = {&x, &y, &index, &domain};
        const char *at[4];
        py::ssize_t inner_stride[4];
        for (int i = 0; i < 4; ++i) {
            if (arrays[i]->ndim() != out.ndim() - 1 ||
                !std::equal(shape.begin(), shape.end() - 1, arrays[i]->shape())) {
                throw py::value_error("x, y, index, domain and out must have equal shapes");
            }
            at[i] = static_cast<const char *>(arrays[i]->data());
            inner_stride[i] = x.ndim() > 0 ? arrays[i]->strides(x.ndim() - 1) : 0;
        }
        const py::ssize_t outer_ndim = std::max<py::ssize_t>(x.ndim() - 1, 0);
        const py::ssize_t inner_count = x.ndim() > 0 ? x.shape(x.ndim() - 1) : 1;
        const py::ssize_t outer_count = inner_count > 0 ? x.size() / inner_count : 0;
        std::vector<py::ssize_t> position(static_cast<size_t>(outer_ndim), 0);
        std::vector<py::ssize_t> strides;
        for (py::ssize_t axis = 0; axis < outer_ndim; ++axis) {
            for (const py::array *array : arrays) strides.push_back(array->strides(axis));
        }
        Lanes lanes(&sampler_, static_cast<uint32_t>(shape.back()), pair, out.mutable_data());

        py::gil_scoped_release release;
        for (py::ssize_t row = 0; row < outer_count; ++row) {
            lanes.add(at, inner_stride, inner_count);
            for (py::ssize_t axis = outer_ndim - 1; axis >= 0; --axis) {
                const bool wraps = ++position[static_cast<size_t>(axis)] == shape[axis];
                const py::ssize_t step = wraps ? 1 - shape[axis] : 1;
                for (int k = 0; k < 4; ++k)
                    at[k] += step * strides[static_cast<size_t>(axis * 4 + k)];
                if (!wraps) break;
                position[static_cast<size_t>(axis)] = 0;
            }
        }
        lanes.draw();
    }

    /* `out` has shape (height, width, index_count, 4). */
    void block(int32_t x0, int32_t y0, uint32_t first_index, uint32_t domain, Floats &out) const {
        const auto height = static_cast<uint32_t>(out.shape(0));
        const auto width = static_cast<uint32_t>(out.shape(1));
        const auto index_count = static_cast<uint32_t>(out.shape(2));
        const size_t row_count = size_t{width} * index_count * 4;
        const auto rows = static_cast<uint32_t>(
            std::max(size_t{1}, static_cast<size_t>(poll_interval) * 4 / row_count));
        float *to = out.mutable_data();
        bn_result result = out.shape(3) == 4 ? BN_SUCCESS : BN_ERROR_SIZE_MISMATCH;
        {
            py::gil_scoped_release release;
            Interrupts interrupts;
            uint32_t now = 0;
            for (uint32_t y = 0; y < height && result == BN_SUCCESS; y += now) {
                now = std::min(rows, height - y);
                result = bn_sample_block(&sampler_, x0, static_cast<int32_t>(y0 + int64_t{y}),
                                         width, now, first_index, index_count, domain,
                                         to + y * row_count, now * row_count);
                interrupts.poll();
            }
        }
        check(result, "width " + std::to_string(width) + ", height " + std::to_string(height) +
                          ", index_count " + std::to_string(index_count));
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

} // namespace

void bind_sampler(py::module_ &module) {
    py::dict kinds;
    kinds["blue"] = static_cast<int32_t>(BN_SAMPLER_BLUE);
    kinds["sobol"] = static_cast<int32_t>(BN_SAMPLER_SOBOL);
    kinds["white"] = static_cast<int32_t>(BN_SAMPLER_WHITE);
    kinds["zorder"] = static_cast<int32_t>(BN_SAMPLER_ZORDER);
    kinds["mask"] = static_cast<int32_t>(BN_SAMPLER_MASK);
    module.attr("sampler_kinds") = kinds;

    py::class_<Sampler>(module, "Sampler")
        .def(py::init<int32_t, uint64_t, uint32_t, const py::object &>(), py::arg("kind"),
             py::arg("seed"), py::arg("samples_per_pixel"), py::arg("mask"))
        .def("sample", &Sampler::sample, py::arg("x").noconvert(), py::arg("y").noconvert(),
             py::arg("index").noconvert(), py::arg("domain").noconvert(),
             py::arg("out").noconvert(), py::arg("pair") = -1)
        .def("block", &Sampler::block, py::arg("x0"), py::arg("y0"), py::arg("first_index"),
             py::arg("domain"), py::arg("out").noconvert())
        .def("seed_words", &Sampler::seed_words);
    module.def("tables", &tables);
    /* These take numbers or arrays, which broadcast. */
    module.def("domain_child", py::vectorize(&bn_domain_child), py::arg("domain"), py::arg("key"));
    module.def("frame_domain", py::vectorize(&bn_path_frame_domain));
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
    module.def("ray_keyed_domain", py::vectorize(&bn_ray_keyed_domain));
    module.def("branch_domain", py::vectorize([](uint32_t split, uint32_t count, uint32_t k) {
                   return bn_path_branch({0, 0, 0, 0}, split, count, k).domain;
               }));
    module.def("rng_float", py::vectorize([](uint32_t seed0, uint32_t seed1, int32_t x, int32_t y,
                                             uint32_t index, uint32_t domain, uint32_t k) {
                   const bn_path path = {static_cast<uint32_t>(x), static_cast<uint32_t>(y), index,
                                         domain};
                   return bn_draw_float(bn_path_rng_bits({seed0, seed1}, path, domain, k));
               }));
}

} // namespace bluenoise
