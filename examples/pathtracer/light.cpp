// SPDX-License-Identifier: Apache-2.0
// The environment is sampled by brightness: first a row, then a column, then uniformly over the texel's
// solid angle, over which radiance is constant, so that the pdf matches exactly. The mean is subtracted
// from each texel's luminance, because scattered rays find the darker parts of the sky (Karlik et al.,
// "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", 2019).
#include "light.h"

#include "files.h"
#include "film.h"

namespace {

// Samples the environment only if at least this share of its light exceeds the mean.
constexpr double LEAST_CONTRAST = 0.02;

glm::ivec2 texel_at(const Environment &e, Vec3 d) {
    const float longitude = std::atan2(d.x, d.z);
    const float from_top = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
    const float x = (0.5f - longitude / (2 * PI)) * float(e.width);
    const float y = from_top / PI * float(e.height);
    return clamp(glm::ivec2(x, y), glm::ivec2(0), glm::ivec2(e.width, e.height) - 1);
}

Vec3 direction_at(float column, float cosine, int width) {
    const float longitude = (0.5f - column / float(width)) * 2 * PI;
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
}

float texel_pdf(const Environment &e, size_t row, float probability) {
    const float solid_angle =
        (e.row_cosines[row] - e.row_cosines[row + 1]) * 2 * PI / float(e.width);
    return probability / solid_angle;
}

// ---- Choosing lights

constexpr size_t WIDTH = 8; // children of a node, at most
// Spread evenly over all children that can shine at the point, because the bounds ignore occlusion.
constexpr float EVEN_SHARE = 0.02f;

// The cosine of the difference of two angles, or 1 if the difference is negative.
float cosine_less(float cosine, float by_cosine) {
    if (cosine >= by_cosine) return 1;
    return cosine * by_cosine +
           std::sqrt(std::max(0.0f, (1 - cosine * cosine) * (1 - by_cosine * by_cosine)));
}

float importance(const LightNode &n, const Receiver &r) {
    if (n.distant) {
        const bool facing = r.one_side && n.cosine > -1;
        return n.power * (facing ? std::max(0.0f, -dot(n.axis, r.normal)) : 1);
    }
    const Vec3 half = 0.5f * (n.high - n.low), to_light = n.low + half - r.point;
    const float radius = dot(half, half), squared = dot(to_light, to_light); // both squared
    if (!(squared > radius)) return radius > 0 ? std::min(n.power / radius, 1e30f) : 0;
    const Vec3 direction = to_light / std::sqrt(squared);
    const float spread = std::sqrt(1 - radius / squared); // cosine of the angle the bounds span
    float result = n.power / squared;
    if (r.one_side) result *= std::max(0.0f, cosine_less(dot(direction, r.normal), spread));
    if (n.cosine > -1)
        result *=
            std::max(0.0f, cosine_less(cosine_less(-dot(direction, n.axis), n.cosine), spread));
    return std::min(result, 1e30f); // sums stay finite
}

// The weights of a node's children. Returns their sum.
float weigh(const LightTree &tree, const LightNode &node, const Receiver &r,
            float (&weights)[WIDTH]) {
    float total = 0, shining = 0;
    for (uint32_t i = 0; i < node.count; ++i) {
        weights[i] = importance(tree.nodes[node.first + i], r);
        total += weights[i];
        shining += weights[i] > 0 ? 1.0f : 0.0f;
    }
    const float even = EVEN_SHARE * total / std::max(shining, 1.0f);
    for (uint32_t i = 0; i < node.count; ++i)
        if (weights[i] > 0) weights[i] += even;
    return total + even * shining;
}

LightNode node_around(const std::vector<Light> &lights, const uint32_t *first, size_t count) {
    LightNode node;
    node.low = Vec3(INFINITY);
    node.high = -node.low;
    bool to_all_sides = false;
    for (size_t i = 0; i < count; ++i) {
        const Light &light = lights[first[i]];
        node.power += light_power(light);
        node.distant = node.distant || light.is_distant();
        to_all_sides = to_all_sides || light.both_sides || light.kind == Light::POINT ||
                       light.kind == Light::ENVIRONMENT;
        node.axis += light.normal;
        const Vec3 a = light.corner, u = light.edge_u, v = light.edge_v;
        const Vec3 opposite = light.kind == Light::TRIANGLE ? a + u : a + u + v;
        for (const Vec3 p : {a, a + u, a + v, opposite}) {
            node.low = min(node.low, p);
            node.high = max(node.high, p);
        }
    }
    node.axis = normalize_or(node.axis, {0, 0, 1});
    if (to_all_sides || (node.distant && count > 1)) return node;
    node.cosine = 1;
    for (size_t i = 0; i < count; ++i) {
        const Light &light = lights[first[i]];
        const float own = light.kind == Light::SPOT ? light.cosine_outer : 1,
                    between = dot(node.axis, light.normal);
        // The cosine of the sum of two angles; all sides if the sum exceeds pi.
        const float sum =
            own * between - std::sqrt(std::max(0.0f, (1 - own * own) * (1 - between * between)));
        node.cosine = std::min(node.cosine, own < -between ? -1 : sum);
    }
    return node;
}

// Splits lights into two groups: separates lights without a position from the others, or splits by position.
size_t split(const std::vector<Light> &lights, uint32_t *first, size_t count) {
    uint32_t *const end = first + count;
    const auto distant = [&](uint32_t i) { return lights[i].is_distant(); };
    const auto apart = size_t(std::stable_partition(first, end, distant) - first);
    if (apart > 0 && apart < count) return apart;
    const LightNode all = node_around(lights, first, count);
    const Vec3 extent = all.high - all.low;
    const int axis = extent.x > extent.y && extent.x > extent.z ? 0 : extent.y > extent.z ? 1 : 2;
    std::nth_element(first, first + count / 2, end, [&](uint32_t a, uint32_t b) {
        const float pa = lights[a].corner[axis], pb = lights[b].corner[axis];
        return pa < pb || (pa == pb && a < b);
    });
    return count / 2;
}

// Splits the largest group of lights until there are enough groups, and makes each a child.
void add_children(const std::vector<Light> &lights, LightTree &tree, uint32_t parent,
                  uint32_t *first, size_t count) {
    std::vector<std::pair<uint32_t *, size_t>> groups = {{first, count}};
    while (groups.size() < std::min(WIDTH, count)) {
        const auto largest =
            std::max_element(groups.begin(), groups.end(),
                             [](const auto &a, const auto &b) { return a.second < b.second; });
        const auto [begin, size] = *largest;
        // A small group is split into single lights, in order.
        const size_t part = count <= WIDTH ? 1 : split(lights, begin, size);
        *largest = {begin, part};
        groups.insert(largest + 1, {begin + part, size - part});
    }
    const auto children = uint32_t(tree.nodes.size());
    tree.nodes[parent].first = children;
    tree.nodes[parent].count = uint32_t(groups.size());
    for (const auto &[begin, size] : groups) {
        tree.nodes.push_back(node_around(lights, begin, size));
        tree.nodes.back().parent = parent;
        if (size > 1) continue;
        tree.nodes.back().light = int32_t(*begin);
        tree.node_of[*begin] = uint32_t(tree.nodes.size() - 1);
    }
    for (uint32_t i = 0; i < groups.size(); ++i)
        if (groups[i].second > 1)
            add_children(lights, tree, children + i, groups[i].first, groups[i].second);
}

} // namespace

Environment environment_create(int width, int height, std::vector<Vec3> texels, bool clamp) {
    Environment e{width, height, std::move(texels), {}, {}, {}, 0};
    for (size_t i = 0; i < e.texels.size(); ++i) {
        Vec3 &v = e.texels[i];
        if (!clamp && !is_finite(v))
            throw Error("its texel ", i % size_t(width), ",", i / size_t(width),
                        " is not finite; use --clamp to bound it");
        for (int c = 0; c < 3; ++c)
            v[c] = clamp ? std::min(std::max(0.0f, v[c]), 65504.0f) : std::max(0.0f, v[c]);
    }
    const auto w = size_t(width), h = size_t(height);
    e.row_limits.resize(h + 1);
    e.column_limits.resize(h * (w + 1));
    for (size_t y = 0; y <= h; ++y)
        e.row_cosines.push_back(float(std::cos(3.14159265358979 * double(y) / double(h))));

    std::vector<double> weights, row_weights(h);
    const auto solid_angle = [&](size_t y) {
        return double((e.row_cosines[y] - e.row_cosines[y + 1]) * 2 * PI) / width;
    };
    double total = 0, sampled = 0;
    for (const Vec3 texel : e.texels) {
        total += double(luminance(texel)) * solid_angle(weights.size() / w);
        weights.push_back(double(luminance(texel)));
    }
    const double mean = total / (4 * double(PI));
    for (size_t y = 0; y < h; ++y) {
        for (size_t i = y * w; i < (y + 1) * w; ++i) {
            weights[i] = std::max(0.0, weights[i] - mean);
            row_weights[y] += weights[i] * solid_angle(y);
        }
        distribution_build(&weights[y * w], w, &e.column_limits[y * (w + 1)]);
        sampled += row_weights[y];
    }
    distribution_build(row_weights.data(), h, e.row_limits.data());
    e.irradiance = sampled > LEAST_CONTRAST * total ? float(sampled) : 0;
    return e;
}

Vec3 environment_radiance(const Environment &e, Vec3 direction) {
    const glm::ivec2 at = texel_at(e, direction);
    return e.texels[at.y * e.width + at.x];
}

float environment_pdf(const Environment &e, Vec3 direction) {
    const glm::ivec2 at = texel_at(e, direction);
    const float *row = &e.row_limits[at.y], *column = &e.column_limits[at.y * (e.width + 1) + at.x];
    return texel_pdf(e, at.y, (row[1] - row[0]) * (column[1] - column[0]));
}

EnvironmentSample environment_sample(const Environment &e, Vec2 u) {
    const auto w = size_t(e.width), h = size_t(e.height);
    const Choice row = distribution_choose(e.row_limits.data(), h, u.y);
    const Choice column = distribution_choose(&e.column_limits[row.index * (w + 1)], w, u.x);
    const float cosine =
        (1 - row.rest) * e.row_cosines[row.index] + row.rest * e.row_cosines[row.index + 1];
    return {direction_at(float(column.index) + column.rest, cosine, e.width),
            texel_pdf(e, row.index, row.probability * column.probability)};
}

Environment environment_sky(Vec3 to_sun) {
    const int width = 1024, height = 512;
    const Vec3 zenith = {0.08f, 0.18f, 0.48f}, horizon = {0.55f, 0.62f, 0.70f};
    const Vec3 glow = {1.0f, 0.72f, 0.42f}, ground = {0.20f, 0.18f, 0.16f};
    const float sun_radius = 0.03f; // radians: ten texels across, enough to look round
    const Vec3 sun_radiance = {700, 590, 430};

    std::vector<Vec3> texels;
    texels.reserve(size_t(width) * size_t(height));
    for (int y = 0; y < height; ++y) {
        const float cosine = std::cos(PI * (float(y) + 0.5f) / height);
        for (int x = 0; x < width; ++x) {
            const Vec3 d = direction_at(float(x) + 0.5f, cosine, width);
            const float toward = std::max(dot(d, to_sun), 0.0f);
            const float haze = std::pow(1 - std::abs(d.y), 5.0f);
            Vec3 radiance = haze * horizon + (1 - haze) * (d.y > 0 ? zenith : ground);
            if (d.y > 0) {
                const float angle = std::acos(std::min(toward, 1.0f));
                const float edge = 2 * PI / float(width); // one texel, in radians
                const float disc = std::clamp((sun_radius - angle) / edge + 0.5f, 0.0f, 1.0f);
                radiance += (0.5f * std::pow(toward, 6.0f) + 3 * std::pow(toward, 300.0f)) * glow;
                radiance += disc * sun_radiance;
            }
            texels.push_back(radiance);
        }
    }
    return environment_create(width, height, std::move(texels));
}

Environment environment_read(const std::string &path, bool clamp) {
    if (path == "sky") return environment_sky(normalize(Vec3{-0.40f, 0.62f, 0.68f}));
    if (path == "none") return environment_create(2, 1, {{0, 0, 0}, {0, 0, 0}});
    const Image image = exr_read(path);
    return named("the environment " + path, [&] {
        // The sphere is the display window: a cropped file is black elsewhere, and overscan is cut off.
        const int w = image.full_width, h = image.full_height;
        const Crop &c = image.crop;
        if (size_t(w) * size_t(h) > 4 * MAX_PIXELS) throw Error("its display window is too large");
        std::vector<Vec3> texels(size_t(w) * size_t(h), Vec3(0));
        for (int y = std::max(c.y0, 0); y < std::min(c.y1, h); ++y)
            for (int x = std::max(c.x0, 0); x < std::min(c.x1, w); ++x)
                texels[size_t(y) * w + x] = image.rgb[size_t(y - c.y0) * width(c) + (x - c.x0)];
        return environment_create(w, h, std::move(texels), clamp);
    });
}

float light_power(const Light &light) {
    if (light.kind == Light::ENVIRONMENT) return light.environment->irradiance;
    return luminance(light.radiance) * (light.has_extent() ? light.area : 1);
}

LightTree light_tree(const std::vector<Light> &lights) {
    LightTree tree;
    std::vector<uint32_t> order(lights.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = uint32_t(i);
    tree.nodes.resize(1);
    tree.node_of.resize(lights.size());
    if (lights.size() == 1)
        tree.nodes[0].light = 0;
    else if (!lights.empty())
        add_children(lights, tree, 0, order.data(), order.size());
    return tree;
}

LightChoice light_choose(const LightTree &tree, const Receiver &receiver, float &u) {
    const LightNode *node = &tree.nodes[0];
    float probability = 1;
    while (node->count > 0) {
        float weights[WIDTH];
        const float total = weigh(tree, *node, receiver, weights);
        if (!(total > 0)) return {-1, 0};
        float left = u * total;
        uint32_t chosen = node->count;
        for (uint32_t i = 0; i < node->count; ++i) {
            if (!(weights[i] > 0)) continue;
            if (chosen < node->count) left -= weights[chosen];
            chosen = i;
            if (left < weights[i]) break;
        }
        u = std::clamp(left / weights[chosen], 0.0f, 1 - DRAW_STEP);
        probability *= weights[chosen] / total;
        node = &tree.nodes[node->first + chosen];
    }
    return {node->light, probability};
}

float light_probability(const LightTree &tree, const Receiver &receiver, uint32_t light) {
    float probability = 1;
    for (uint32_t at = tree.node_of[light]; at != 0; at = tree.nodes[at].parent) {
        const LightNode &parent = tree.nodes[tree.nodes[at].parent];
        float weights[WIDTH];
        const float total = weigh(tree, parent, receiver, weights);
        if (!(total > 0)) return 0;
        probability *= weights[at - parent.first] / total;
    }
    return probability;
}
