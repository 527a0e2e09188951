// SPDX-License-Identifier: Apache-2.0
// A scene in fog. y is up.
#include "scene_builder.h"
#include "scene_groups.h"

namespace {

constexpr Vec3 FOG_LOW = {-6, -0.1f, -6}, FOG_HIGH = {6, 4.4f, 6};

// Banks of fog over the ground: thinner with height, torn by waves that bend each other.
float fog_density(Vec3 p) {
    const Vec3 q = {p.x + 0.9f * std::sin(1.1f * p.z + 0.5f) + 0.4f * std::sin(2.3f * p.y),
                    1.6f * p.y + 0.5f * std::sin(1.3f * p.x + 0.7f * p.z),
                    p.z + 0.8f * std::sin(0.9f * p.x - 0.4f) + 0.4f * std::sin(1.9f * p.y + 1)};
    const float waves = std::sin(1.3f * q.x + 0.3f) * std::sin(1.5f * q.y) * std::sin(1.2f * q.z) +
                        0.5f * std::sin(2.9f * q.x + q.z) * std::sin(3.1f * q.z - q.y + 1) +
                        0.25f * std::sin(6.1f * q.y + q.x) * std::sin(5.7f * q.z + 2.1f * q.x);
    const float torn = std::max(0.45f + 0.7f * waves, 0.04f);
    return 0.16f * torn * std::exp(-std::max(p.y, 0.0f) / 1.8f) + 0.012f;
}

} // namespace

// A pergola at night: a warm lamp behind it and a cold one on the right, both high above drifting
// fog. Included because how far a ray flies is one more decision at every vertex, and how much light
// a shadow ray brings another: loops that take as many numbers as it happens.
Scene scene_fog() {
    Scene scene;
    scene.camera = camera_look_at({-0.6f, 2.0f, 8.8f}, {0, 1.2f, 0}, {0, 1, 0}, 0.265f);
    scene.medium = std::make_shared<Medium>(
        medium_create(FOG_LOW, FOG_HIGH, {96, 40, 96}, {0.92f, 0.94f, 0.96f}, 0.5f, fog_density));

    const uint32_t stone = add_diffuse(scene, {0.42f, 0.38f, 0.33f});
    const uint32_t ground = add_diffuse(scene, {0.28f, 0.26f, 0.24f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    add_quad(scene, ground, {-40, 0, 40}, {40, 0, 40}, {40, 0, -40}, {-40, 0, -40});

    add_light_towards(scene, black, {1700, 950, 400}, {-4.2f, 7.6f, -6.5f}, {0.2f, 0.8f, 0}, 0.7f,
                      0.7f);
    add_light_towards(scene, black, {80, 150, 270}, {6.8f, 5.6f, 0.8f}, {0, 0.8f, 0.4f}, 0.8f,
                      0.8f);

    const auto box = [&](Vec3 middle, Vec3 half) {
        add_box(scene, stone, middle, {half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z});
    };
    for (int row = 0; row < 2; ++row) {
        const float z = row == 0 ? -1.6f : 1.2f;
        for (int i = 0; i < 4; ++i) {
            const float x = -2.55f + 1.7f * static_cast<float>(i);
            box({x, 1.2f, z}, {0.11f, 1.2f, 0.11f});
            box({x, 0.07f, z}, {0.19f, 0.07f, 0.19f});
        }
        box({0, 2.5f, z}, {2.9f, 0.1f, 0.12f});
    }
    for (int i = 0; i < 9; ++i)
        box({-2.72f + 0.68f * static_cast<float>(i), 2.66f, -0.2f}, {0.16f, 0.06f, 1.9f});
    return scene;
}
