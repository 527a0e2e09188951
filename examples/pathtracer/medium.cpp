// SPDX-License-Identifier: Apache-2.0
// Tracking through a medium, from block to block, with exponential steps within each block.
#include "medium.h"

namespace {

size_t index_of(glm::ivec3 size, int x, int y, int z) {
    return (size_t(z) * size.y + y) * size.x + x;
}

// Calls visit(x, y, z) for all cells from `first` to `last`; x changes fastest.
template <typename Visit>
void each_cell(glm::ivec3 first, glm::ivec3 last, Visit visit) {
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) visit(x, y, z);
}

// The range of the density, whose interpolation reads one cell beyond the block.
Medium::Range range_of(const Medium &m, glm::ivec3 block) {
    const glm::ivec3 first = max(block * Medium::BLOCK - 1, glm::ivec3(0));
    const glm::ivec3 last = min((block + 1) * Medium::BLOCK, m.size - 1);
    Medium::Range range = {INFINITY, 0};
    each_cell(first, last, [&](int x, int y, int z) {
        const float density = m.density[index_of(m.size, x, y, z)];
        range = {std::min(range.least, density), std::max(range.most, density)};
    });
    return range;
}

// Visits the blocks that the ray crosses before `end`, in order (Amanatides and Woo, "A Fast Voxel Traversal
// Algorithm for Ray Tracing", 1987). The rate of collisions in a block is rate(range, length). Calls
// meet(distance, range) at each collision, until it returns false. The optical depth (rate times length) between
// collisions is exponentially distributed and carries over from block to block.
template <typename Rate, typename Meet>
void walk(const Medium &m, const Ray &ray, float end, bn::LoopSampler &numbers, Rate rate_in,
          Meet meet) {
    const Vec3 origin = ray.origin, direction = ray.direction, low = m.low, high = m.high;
    float from = 0;
    for (int i = 0; i < 3; ++i) { // along a zero direction, both are infinite
        const float a = (low[i] - origin[i]) / direction[i];
        const float b = (high[i] - origin[i]) / direction[i];
        from = std::max(from, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    if (!(from < end)) return;

    const Vec3 side = (high - low) * float{Medium::BLOCK} / Vec3(m.size);
    glm::ivec3 block = (origin + from * direction - low) / side, step;
    block = clamp(block, glm::ivec3(0), m.blocks - 1);
    Vec3 next, length; // per axis: distance to the block's end; distance across a block
    for (int i = 0; i < 3; ++i) {
        step[i] = direction[i] < 0 ? -1 : 1;
        const float face = low[i] + side[i] * float(block[i] + (step[i] > 0 ? 1 : 0));
        const bool crosses = direction[i] != 0;
        next[i] = crosses ? (face - origin[i]) / direction[i] : INFINITY;
        length[i] = crosses ? side[i] / std::abs(direction[i]) : INFINITY;
    }
    const auto draw_depth = [&] { return -std::log(1 - numbers.next_1d()); };
    float left = -1; // optical depth until the next collision; below 0: not drawn yet
    while (from < end) {
        const int axis =
            next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const float to = std::min(next[axis], end);
        if (to > from) {
            const Medium::Range &range = m.ranges[index_of(m.blocks, block[0], block[1], block[2])];
            const float rate = rate_in(range, to - from);
            if (rate > 0) {
                if (left < 0) left = draw_depth();
                for (; left < rate * (to - from); left = draw_depth()) {
                    from += left / rate;
                    if (!meet(from, range)) return;
                }
                left -= rate * (to - from);
            }
            from = to;
        }
        block[axis] += step[axis];
        if (block[axis] < 0 || block[axis] >= m.blocks[axis]) return;
        next[axis] += length[axis];
    }
}

} // namespace

Medium medium_create(Vec3 low, Vec3 high, glm::ivec3 size, Vec3 albedo, float anisotropy,
                     const std::function<float(Vec3)> &density) {
    const glm::ivec3 blocks = (size + Medium::BLOCK - 1) / Medium::BLOCK;
    Medium m{low, high, size, {}, blocks, {}, {Material::PHASE, albedo}};
    m.material.anisotropy = anisotropy;
    each_cell(glm::ivec3(0), size - 1, [&](int x, int y, int z) {
        m.density.push_back(density(low + (high - low) * (Vec3(x, y, z) + 0.5f) / Vec3(size)));
    });
    each_cell(glm::ivec3(0), blocks - 1, [&](int x, int y, int z) {
        m.ranges.push_back(range_of(m, {x, y, z}));
    });
    return m;
}

float medium_density(const Medium &m, Vec3 point) {
    const Vec3 count = m.size;
    const Vec3 place = (point - m.low) / (m.high - m.low) * count - 0.5f;
    const Vec3 inside = clamp(place, Vec3(0), count - 1.0f);
    const glm::ivec3 before = inside, after = min(before + 1, m.size - 1);
    const Vec3 rest = inside - Vec3(before);
    const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
    const auto row = [&](int y, int z) {
        return mix(m.density[index_of(m.size, before[0], y, z)],
                   m.density[index_of(m.size, after[0], y, z)], rest[0]);
    };
    return mix(mix(row(before[1], before[2]), row(after[1], before[2]), rest[1]),
               mix(row(before[1], after[2]), row(after[1], after[2]), rest[1]), rest[2]);
}

float medium_free_flight(const Medium &medium, const Ray &ray, float end,
                         bn::LoopSampler &numbers) {
    float found = INFINITY;
    const auto rate = [](Medium::Range range, float) { return range.most; };
    walk(medium, ray, end, numbers, rate, [&](float distance, Medium::Range range) {
        const float density = medium_density(medium, ray.origin + distance * ray.direction);
        if (numbers.next_1d() * range.most >= density) return true;
        found = distance;
        return false;
    });
    return found;
}

float medium_transmittance(const Medium &medium, const Ray &ray, float end,
                           bn::LoopSampler &numbers) {
    float passed = 1, even = 0;
    const auto rate = [&](Medium::Range range, float length) {
        even += range.least * length;
        return range.most - range.least;
    };
    walk(medium, ray, end, numbers, rate, [&](float distance, Medium::Range range) {
        const float density = medium_density(medium, ray.origin + distance * ray.direction);
        passed *= std::clamp((range.most - density) / (range.most - range.least), 0.0f, 1.0f);
        return passed > 0;
    });
    return passed * std::exp(-even);
}

float phase_pdf(float g, Vec3 wi) {
    const float squared = std::max(1 + g * g + 2 * g * wi.z, 1e-12f);
    return (1 - g * g) / (4 * PI * squared * std::sqrt(squared));
}

Vec3 phase_sample(float g, Vec2 u) {
    // The squared radius of the disc is uniform, and its angle is continuous.
    const Vec2 d = square_to_disc(u);
    const float squared = std::min(d.x * d.x + d.y * d.y, 1.0f);
    float cosine = 2 * squared - 1;
    if (std::abs(g) > 1e-3f) {
        const float root = (1 - g * g) / (1 + g - 2 * g * squared);
        cosine = std::clamp((root * root - 1 - g * g) / (2 * g), -1.0f, 1.0f);
    }
    const float sine = std::sqrt(1 - cosine * cosine);
    const float scale = squared > 0 ? sine / std::sqrt(squared) : 0;
    return {scale * d.x, scale * d.y, cosine};
}
