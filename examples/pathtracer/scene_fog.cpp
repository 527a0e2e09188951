// SPDX-License-Identifier: Apache-2.0
// A scene in fog. y is up.
#include "scene_builder.h"
#include "scene_groups.h"

namespace {

constexpr Vec3 FOG_LOW = {-6, -0.1f, -7}, FOG_HIGH = {6, 5.9f, 7};

// Banks of fog over the ground: thinner with height, torn by waves that bend each other.
float fog_density(Vec3 p) {
    const Vec3 q = {p.x + 0.9f * std::sin(1.1f * p.z + 0.5f) + 0.4f * std::sin(2.3f * p.y),
                    1.6f * p.y + 0.5f * std::sin(1.3f * p.x + 0.7f * p.z),
                    p.z + 0.8f * std::sin(0.9f * p.x - 0.4f) + 0.4f * std::sin(1.9f * p.y + 1)};
    const float waves = std::sin(1.3f * q.x + 0.3f) * std::sin(1.5f * q.y) * std::sin(1.2f * q.z) +
                        0.5f * std::sin(2.9f * q.x + q.z) * std::sin(3.1f * q.z - q.y + 1) +
                        0.25f * std::sin(6.1f * q.y + q.x) * std::sin(5.7f * q.z + 2.1f * q.x);
    const float torn = std::max(0.35f + 0.8f * waves, 0.03f);
    return 0.26f * torn * std::exp(-std::max(p.y, 0.0f) / 1.9f) + 0.015f;
}

} // namespace

// A colonnade at night: a warm lamp behind the pillars and a cold one high on the right, in drifting
// fog. Included because how far a ray flies is one more decision at every vertex, and how much light
// a shadow ray brings another: loops that take as many numbers as it happens.
Scene scene_fog() {
    Scene scene;
    scene.camera = camera_look_at({0.4f, 1.7f, 8.2f}, {0, 1.25f, 0}, {0, 1, 0}, 0.296f);
    scene.medium = std::make_shared<Medium>(
        medium_create(FOG_LOW, FOG_HIGH, {96, 48, 112}, {0.92f, 0.94f, 0.96f}, 0.45f, fog_density));

    const uint32_t stone = add_diffuse(scene, {0.42f, 0.38f, 0.33f});
    const uint32_t ground = add_diffuse(scene, {0.26f, 0.25f, 0.24f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    add_quad(scene, ground, {-40, 0, 40}, {40, 0, 40}, {40, 0, -40}, {-40, 0, -40});

    add_light_towards(scene, black, {260, 150, 62}, {-0.9f, 1.5f, -4.4f}, {0.3f, 1.0f, 3}, 0.4f, 0.6f);
    add_light_towards(scene, black, {60, 92, 150}, {4.6f, 5.2f, -1.2f}, {-0.6f, 0, 1.2f}, 0.7f, 0.7f);

    // Two rows of pillars with a beam across each, and steps before them.
    const auto box = [&](Vec3 middle, Vec3 half, float turn) {
        const float c = std::cos(turn), s = std::sin(turn);
        add_box(scene, stone, middle, {half.x * c, 0, -half.x * s}, {0, half.y, 0},
                {half.z * s, 0, half.z * c});
    };
    for (int row = 0; row < 2; ++row) {
        const float z = -2.6f + 2.4f * static_cast<float>(row);
        for (int i = 0; i < 6; ++i) {
            const float x = -3.1f + 1.24f * static_cast<float>(i) + 0.3f * static_cast<float>(row);
            box({x, 1.3f, z}, {0.15f, 1.3f, 0.15f}, 0.1f * static_cast<float>(i));
            box({x, 2.66f, z}, {0.24f, 0.06f, 0.24f}, 0);
        }
        box({0.15f, 2.85f, z}, {3.8f, 0.13f, 0.2f}, 0);
    }
    for (int i = 0; i < 3; ++i) {
        const float step = static_cast<float>(i);
        box({0.2f, 0.05f + 0.1f * (2 - step), 0.7f + 0.35f * step}, {3.4f, 0.05f + 0.1f * (2 - step), 0.18f}, 0);
    }
    return scene;
}
