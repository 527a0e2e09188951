// SPDX-License-Identifier: Apache-2.0
// Scenes where light takes many bounces, or ones that only chance finds. Many decisions make a
// pixel, so these show how much of its advantage a sampler keeps. y is up.
#include "scene_builder.h"

// Smooth, rough and tinted glass in a studio. Included because only scattered rays find light
// behind a smooth surface, and because each surface offers a path two ways on.
Scene scene_glass() {
    Scene scene;
    scene.camera = camera_look_at({0, 1.45f, 5.0f}, {0.02f, 0.42f, 0}, {0, 1, 0}, 0.265f);

    const uint32_t paper = add_diffuse(scene, {0.66f, 0.65f, 0.63f});
    const uint32_t red = add_diffuse(scene, {0.60f, 0.10f, 0.07f});
    const uint32_t teal = add_diffuse(scene, {0.07f, 0.36f, 0.38f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    const uint32_t clear = add_dielectric(scene, 1.5f, 0);
    const uint32_t satin = add_dielectric(scene, 1.5f, 0.22f);
    const uint32_t frosted = add_dielectric(scene, 1.45f, 0.5f, {0.80f, 0.95f, 0.90f});
    const uint32_t amber = add_dielectric(scene, 1.6f, 0.05f, {0.95f, 0.70f, 0.30f});

    add_backdrop(scene, paper, 9, {-2.6f, 8}, {-1.4f, 1.2f}, 1.2f, {9, 0});

    add_light_towards(scene, black, {5.5f, 5.3f, 5.0f}, {-2.6f, 3.2f, 1.0f}, {0, 0.3f, 0}, 2.4f,
                      2.4f);
    add_light_towards(scene, black, {2.2f, 2.6f, 3.2f}, {3.2f, 2.0f, 1.6f}, {0, 0.4f, 0}, 1.0f,
                      2.6f);

    for (int i = 0; i < 9; ++i) {
        const float x = -1.5f + 0.375f * static_cast<float>(i);
        add_bar(scene, i % 2 ? red : teal, {x, 0, -1.1f}, {x, 1.3f, -1.1f}, 0.05f);
    }
    add_sphere(scene, clear, {-0.78f, 0.401f, 0.25f}, 0.4f);
    add_sphere(scene, satin, {0.08f, 0.401f, -0.1f}, 0.4f);
    add_sphere(scene, frosted, {0.9f, 0.351f, 0.25f}, 0.35f);
    add_box(scene, amber, {0.2f, 0.121f, 0.85f}, {0.22f, 0, 0.1f}, {0, 0.12f, 0},
            {-0.06f, 0, 0.132f});
    return scene;
}

// A room lit through a small window by a bright panel outside. Included because most of the light
// comes from the third bounce and later, where samples of many domains multiply.
Scene scene_interior() {
    Scene scene;
    scene.camera = camera_look_at({1.9f, 1.5f, 2.6f}, {-0.5f, 1.1f, -1.6f}, {0, 1, 0}, 0.46f);

    const uint32_t plaster = add_diffuse(scene, {0.76f, 0.74f, 0.70f});
    const uint32_t wood = add_diffuse(scene, {0.46f, 0.30f, 0.17f});
    const uint32_t rug = add_diffuse(scene, {0.45f, 0.14f, 0.12f});
    const uint32_t cloth = add_diffuse(scene, {0.20f, 0.34f, 0.42f});
    const uint32_t outside = add_diffuse(scene, {0.3f, 0.3f, 0.3f});
    const uint32_t steel = add_conductor(scene, {0.72f, 0.70f, 0.66f}, 0.3f);

    // The room, with a window in the left wall from (low_z, low_y) to (high_z, high_y).
    const float left = -2.4f, right = 2.4f, back = -3.2f, front = 3.0f, top = 2.7f;
    const float low_z = -1.9f, high_z = -0.7f, low_y = 0.95f, high_y = 2.15f, sill = -2.65f;
    add_quad(scene, wood, {left, 0, front}, {right, 0, front}, {right, 0, back}, {left, 0, back});
    add_quad(scene, plaster, {left, top, back}, {right, top, back}, {right, top, front},
             {left, top, front});
    add_quad(scene, plaster, {left, 0, back}, {right, 0, back}, {right, top, back},
             {left, top, back});
    add_quad(scene, plaster, {right, 0, front}, {left, 0, front}, {left, top, front},
             {right, top, front});
    add_quad(scene, cloth, {right, 0, back}, {right, 0, front}, {right, top, front},
             {right, top, back});
    const auto left_wall = [&](float z0, float z1, float y0, float y1) {
        add_quad(scene, plaster, {left, y0, z1}, {left, y0, z0}, {left, y1, z0}, {left, y1, z1});
    };
    left_wall(back, low_z, 0, top);
    left_wall(high_z, front, 0, top);
    left_wall(low_z, high_z, 0, low_y);
    left_wall(low_z, high_z, high_y, top);
    // The window's reveal.
    add_quad(scene, plaster, {sill, low_y, low_z}, {sill, low_y, high_z}, {left, low_y, high_z},
             {left, low_y, low_z});
    add_quad(scene, plaster, {sill, high_y, high_z}, {sill, high_y, low_z}, {left, high_y, low_z},
             {left, high_y, high_z});
    add_quad(scene, plaster, {sill, low_y, low_z}, {left, low_y, low_z}, {left, high_y, low_z},
             {sill, high_y, low_z});
    add_quad(scene, plaster, {left, low_y, high_z}, {sill, low_y, high_z}, {sill, high_y, high_z},
             {left, high_y, high_z});

    add_light_towards(scene, outside, {15, 17, 20}, {-4.4f, 2.2f, -2.2f}, {0, 1.2f, -1.6f}, 6.5f,
                      3.6f);

    // A table with a bowl, a chest, a rug.
    const auto box = [&](uint32_t material, Vec3 low, Vec3 high) {
        const Vec3 half = 0.5f * (high - low);
        add_box(scene, material, low + half, half);
    };
    box(wood, {-1.2f, 0.70f, -2.0f}, {0.5f, 0.76f, -1.0f});
    for (const float x : {-1.15f, 0.39f})
        for (const float z : {-1.95f, -1.11f}) box(wood, {x, 0, z}, {x + 0.06f, 0.70f, z + 0.06f});
    add_sphere(scene, steel, {-0.75f, 0.93f, -1.5f}, 0.17f);
    add_sphere(scene, cloth, {-0.05f, 0.88f, -1.35f}, 0.12f);
    box(cloth, {1.35f, 0, -3.0f}, {2.25f, 0.85f, -2.3f});
    box(rug, {-1.7f, 0.001f, -0.7f}, {0.6f, 0.015f, 0.9f});
    return scene;
}

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

    for (int row = 0; row < 2; ++row) {
        const float z = row == 0 ? -1.6f : 1.2f;
        for (int i = 0; i < 4; ++i) {
            const float x = -2.55f + 1.7f * static_cast<float>(i);
            add_box(scene, stone, {x, 1.2f, z}, {0.11f, 1.2f, 0.11f});
            add_box(scene, stone, {x, 0.07f, z}, {0.19f, 0.07f, 0.19f});
        }
        add_box(scene, stone, {0, 2.5f, z}, {2.9f, 0.1f, 0.12f});
    }
    for (int i = 0; i < 9; ++i)
        add_box(scene, stone, {-2.72f + 0.68f * static_cast<float>(i), 2.66f, -0.2f},
                {0.16f, 0.06f, 1.9f});
    return scene;
}

// A closed cube whose walls emit half and reflect half, so every picture of it is known without
// rendering: radiance 1 - 2^-(bounces + 1) in every pixel. A check, not a showpiece.
Scene scene_furnace() {
    Scene scene;
    scene.camera = camera_look_at({0.1f, 0.2f, -0.3f}, {1, 0.5f, 1}, {0, 1, 0}, 0.8f);
    const uint32_t wall = add_diffuse(scene, {0.5f, 0.5f, 0.5f});
    const Vec3 glow = {0.5f, 0.5f, 0.5f};
    add_light(scene, wall, glow, {-1, -1, -1}, {-1, -1, 1}, {1, -1, 1});
    add_light(scene, wall, glow, {-1, 1, -1}, {1, 1, -1}, {1, 1, 1});
    add_light(scene, wall, glow, {-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1});
    add_light(scene, wall, glow, {1, -1, -1}, {1, -1, 1}, {1, 1, 1});
    add_light(scene, wall, glow, {-1, -1, -1}, {1, -1, -1}, {1, 1, -1});
    add_light(scene, wall, glow, {-1, -1, 1}, {-1, 1, 1}, {1, 1, 1});
    return scene;
}
