// SPDX-License-Identifier: Apache-2.0
// Reads arrays from glTF buffers. Whatever offsets, strides and counts a file claims, nothing
// outside the buffers is read.
#include <cstring>
#include <limits>
#include <type_traits>

#include "gltf_parts.h"

namespace {

// What visit(0 of that type) returns for a type of glTF's numbers; floats for all others.
template <typename Visit>
auto with_number_type(int type, const Visit &visit) {
    if (type == TINYGLTF_COMPONENT_TYPE_BYTE) return visit(int8_t{0});
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return visit(uint8_t{0});
    if (type == TINYGLTF_COMPONENT_TYPE_SHORT) return visit(int16_t{0});
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return visit(uint16_t{0});
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) return visit(uint32_t{0});
    return visit(0.0f);
}

float component_at(const unsigned char *data, int type, bool normalized) {
    return with_number_type(type, [&](auto number) {
        using Number = decltype(number);
        std::memcpy(&number, data, sizeof number);
        const auto value = static_cast<float>(number);
        if (!normalized || std::is_same_v<Number, float>) return value;
        return std::max(value / static_cast<float>(std::numeric_limits<Number>::max()), -1.0f);
    });
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
    if (bytes.stride < size) throw Error(what, " overlap each other in their buffer");
    const bool fits = count == 0 || (offset <= bytes.size && size <= bytes.size - offset &&
                                     (count - 1) <= (bytes.size - offset - size) / bytes.stride);
    if (!fits) throw Error(what, " run past the end of their buffer view");
    return {bytes.data + offset, bytes.size - offset, bytes.stride};
}

const tinygltf::Accessor &checked(const tinygltf::Model &model, int index, const char *what) {
    const tinygltf::Accessor &accessor = gltf_at(model.accessors, index, "accessor");
    if (accessor.count > MAX_SCENE_ELEMENTS)
        throw Error("has ", accessor.count, " ", what, "; at most 2^26 are read");
    const int type = accessor.componentType;
    if (!is_index_type(type) && type != TINYGLTF_COMPONENT_TYPE_BYTE &&
        type != TINYGLTF_COMPONENT_TYPE_SHORT && type != TINYGLTF_COMPONENT_TYPE_FLOAT)
        throw Error(what, " have a number type that glTF does not have");
    return accessor;
}

std::vector<uint32_t> indices_at(const tinygltf::Model &model, int view, size_t offset,
                                 size_t count, int type, size_t limit, const char *what) {
    const GltfBytes bytes =
        elements(model, view, offset, count,
                 tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type)), what);
    std::vector<uint32_t> values(count);
    for (size_t i = 0; i < count; ++i) {
        values[i] = with_number_type(type, [&](auto number) {
            std::memcpy(&number, bytes.data + i * bytes.stride, sizeof number);
            return static_cast<uint32_t>(number);
        });
        if (values[i] >= limit)
            throw Error("has an index out of range: vertex ", values[i], " of ", limit);
    }
    return values;
}

} // namespace

GltfBytes gltf_buffer_view(const tinygltf::Model &model, int index, const char *what) {
    const tinygltf::BufferView &view = gltf_at(model.bufferViews, index, "buffer view");
    const tinygltf::Buffer &buffer = gltf_at(model.buffers, view.buffer, "buffer");
    if (view.byteOffset > buffer.data.size() ||
        view.byteLength > buffer.data.size() - view.byteOffset)
        throw Error("is cut short: the buffer view of ", what, " runs past the end of its buffer");
    return {buffer.data.data() + view.byteOffset, view.byteLength, view.byteStride};
}

int gltf_components(const tinygltf::Model &model, int accessor) {
    if (accessor < 0 || static_cast<size_t>(accessor) >= model.accessors.size()) return 0;
    return tinygltf::GetNumComponentsInType(static_cast<uint32_t>(model.accessors[accessor].type));
}

std::vector<float> gltf_floats(const tinygltf::Model &model, int index, int components,
                               const char *what) {
    const tinygltf::Accessor &accessor = checked(model, index, what);
    if (gltf_components(model, index) != components)
        throw Error(what, " have the wrong number of components");
    const auto width = static_cast<size_t>(components);
    const auto type = static_cast<uint32_t>(accessor.componentType);
    const size_t size = tinygltf::GetComponentSizeInBytes(type);
    std::vector<float> values;
    const auto read = [&](int view, size_t offset, size_t count, const auto &place) {
        const GltfBytes from = elements(model, view, offset, count, width * size, what);
        values.resize(accessor.count * width);
        for (size_t i = 0; i < count; ++i)
            for (size_t c = 0; c < width; ++c)
                values[place(i) * width + c] =
                    component_at(from.data + i * from.stride + c * size, accessor.componentType,
                                 accessor.normalized);
    };
    // Without a buffer view, all elements are zero.
    if (accessor.bufferView >= 0)
        read(accessor.bufferView, accessor.byteOffset, accessor.count, [](size_t i) { return i; });
    values.resize(accessor.count * width);
    const auto &sparse = accessor.sparse;
    if (sparse.isSparse) {
        if (sparse.count < 0 || static_cast<size_t>(sparse.count) > accessor.count ||
            static_cast<int64_t>(sparse.indices.byteOffset) < 0 ||
            static_cast<int64_t>(sparse.values.byteOffset) < 0 ||
            !is_index_type(sparse.indices.componentType))
            throw Error(what, " have invalid sparse parts");
        const auto count = static_cast<size_t>(sparse.count);
        const std::vector<uint32_t> changed = indices_at(
            model, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), count,
            sparse.indices.componentType, accessor.count, what);
        read(sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset), count,
             [&](size_t i) { return changed[i]; });
    }
    return values;
}

std::vector<uint32_t> gltf_indices(const tinygltf::Model &model, int index, size_t limit) {
    const char *const what = "indices";
    const tinygltf::Accessor &accessor = checked(model, index, what);
    if (gltf_components(model, index) != 1 || !is_index_type(accessor.componentType))
        throw Error("has indices that are not unsigned integers");
    if (accessor.sparse.isSparse) throw Error("has sparse indices, which cannot be read");
    return indices_at(model, accessor.bufferView, accessor.byteOffset, accessor.count,
                      accessor.componentType, limit, what);
}
