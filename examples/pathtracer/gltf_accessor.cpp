// SPDX-License-Identifier: Apache-2.0
// Reads arrays from glTF buffers. Whatever offsets, strides and counts a file claims, nothing
// outside the buffers is read.
#include <cmath>
#include <cstring>

#include "gltf_parts.h"

namespace {

template <typename Number>
Number number_at(const unsigned char *data) {
    Number value;
    std::memcpy(&value, data, sizeof(Number));
    return value;
}

size_t component_size(int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

float component_at(const unsigned char *data, int type, bool normalized) {
    const auto scaled = [&](float value, float largest) {
        return normalized ? std::max(value / largest, -1.0f) : value;
    };
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return scaled(number_at<int8_t>(data), 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return scaled(number_at<uint8_t>(data), 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return scaled(number_at<int16_t>(data), 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return scaled(number_at<uint16_t>(data), 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return scaled(static_cast<float>(number_at<uint32_t>(data)), 4294967295.0f);
    default:
        return number_at<float>(data);
    }
}

uint32_t index_at(const unsigned char *data, int type) {
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return number_at<uint8_t>(data);
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return number_at<uint16_t>(data);
    return number_at<uint32_t>(data);
}

bool is_index_type(int type) {
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// Locates `count` elements of `size` bytes each in a buffer view: their start and stride.
GltfBytes elements(const tinygltf::Model &model, int view, size_t offset, size_t count, size_t size,
                   const char *what) {
    GltfBytes bytes = gltf_buffer_view(model, view, what);
    if (bytes.stride == 0) bytes.stride = size;
    if (bytes.stride < size) throw Error(std::string(what) + " overlap each other in their buffer");
    const bool fits = count == 0 || (offset <= bytes.size && size <= bytes.size - offset &&
                                     (count - 1) <= (bytes.size - offset - size) / bytes.stride);
    if (!fits) throw Error(std::string(what) + " run past the end of their buffer view");
    return {bytes.data + offset, bytes.size - offset, bytes.stride};
}

const tinygltf::Accessor &checked(const tinygltf::Model &model, int index, const char *what) {
    const tinygltf::Accessor &accessor = gltf_at(model.accessors, index, "accessor");
    if (accessor.count > MAX_SCENE_ELEMENTS)
        throw Error("has " + std::to_string(accessor.count) + " " + what +
                    "; at most 2^26 are read");
    if (component_size(accessor.componentType) == 0)
        throw Error(std::string(what) + " have a number type that glTF does not have");
    return accessor;
}

} // namespace

GltfBytes gltf_buffer_view(const tinygltf::Model &model, int index, const char *what) {
    const tinygltf::BufferView &view = gltf_at(model.bufferViews, index, "buffer view");
    const tinygltf::Buffer &buffer = gltf_at(model.buffers, view.buffer, "buffer");
    if (view.byteOffset > buffer.data.size() ||
        view.byteLength > buffer.data.size() - view.byteOffset)
        throw Error("is cut short: the buffer view of " + std::string(what) +
                    " runs past the end of its buffer");
    return {buffer.data.data() + view.byteOffset, view.byteLength, view.byteStride};
}

int gltf_components(const tinygltf::Model &model, int accessor) {
    if (accessor < 0 || static_cast<size_t>(accessor) >= model.accessors.size()) return 0;
    return tinygltf::GetNumComponentsInType(
        static_cast<uint32_t>(model.accessors[static_cast<size_t>(accessor)].type));
}

std::vector<float> gltf_floats(const tinygltf::Model &model, int index, int components,
                               const char *what) {
    const tinygltf::Accessor &accessor = checked(model, index, what);
    if (gltf_components(model, index) != components)
        throw Error(std::string(what) + " have the wrong number of components");
    const auto width = static_cast<size_t>(components);
    const size_t size = component_size(accessor.componentType);
    std::vector<float> values;
    const auto read = [&](const unsigned char *from, float *to) {
        for (size_t c = 0; c < width; ++c)
            to[c] = component_at(from + c * size, accessor.componentType, accessor.normalized);
    };
    // Without a buffer view, all elements are zero.
    if (accessor.bufferView >= 0) {
        const GltfBytes bytes = elements(model, accessor.bufferView, accessor.byteOffset,
                                         accessor.count, width * size, what);
        values.resize(accessor.count * width);
        for (size_t i = 0; i < accessor.count; ++i)
            read(bytes.data + i * bytes.stride, &values[i * width]);
    }
    values.resize(accessor.count * width);
    if (accessor.sparse.isSparse) {
        const auto &sparse = accessor.sparse;
        if (sparse.count < 0 || static_cast<size_t>(sparse.count) > accessor.count ||
            static_cast<int64_t>(sparse.indices.byteOffset) < 0 ||
            static_cast<int64_t>(sparse.values.byteOffset) < 0 ||
            !is_index_type(sparse.indices.componentType))
            throw Error(std::string(what) + " have invalid sparse parts");
        const auto count = static_cast<size_t>(sparse.count);
        const GltfBytes indices = elements(model, sparse.indices.bufferView,
                                           static_cast<size_t>(sparse.indices.byteOffset), count,
                                           component_size(sparse.indices.componentType), what);
        const GltfBytes changed =
            elements(model, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
                     count, width * size, what);
        for (size_t i = 0; i < count; ++i) {
            const size_t at =
                index_at(indices.data + i * indices.stride, sparse.indices.componentType);
            if (at >= accessor.count)
                throw Error(std::string(what) + " have a sparse index out of range");
            read(changed.data + i * changed.stride, &values[at * width]);
        }
    }
    return values;
}

std::vector<uint32_t> gltf_indices(const tinygltf::Model &model, int index, size_t limit) {
    const char *const what = "indices";
    const tinygltf::Accessor &accessor = checked(model, index, what);
    if (gltf_components(model, index) != 1 || !is_index_type(accessor.componentType))
        throw Error("has indices that are not unsigned integers");
    if (accessor.sparse.isSparse) throw Error("has sparse indices, which cannot be read");
    const GltfBytes bytes = elements(model, accessor.bufferView, accessor.byteOffset,
                                     accessor.count, component_size(accessor.componentType), what);
    std::vector<uint32_t> values(accessor.count);
    for (size_t i = 0; i < accessor.count; ++i) {
        values[i] = index_at(bytes.data + i * bytes.stride, accessor.componentType);
        if (values[i] >= limit)
            throw Error("has an index out of range: vertex " + std::to_string(values[i]) + " of " +
                        std::to_string(limit));
    }
    return values;
}
