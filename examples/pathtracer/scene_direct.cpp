// SPDX-License-Identifier: Apache-2.0
// Scenes lit mostly by direct light. Few decisions make a pixel, so these show what good
// low-dimensional samples are worth. y is up.
#include "scene_builder.h"

// The box measured at Cornell (Goral et al., "Modeling the Interaction of Light Between Diffuse
// Surfaces", 1984; dimensions, camera and materials as published by the Program of Computer
// Graphics, spectra as the linear RGB in common use). Included because everybody knows it: soft
// shadows, colour bleeding, several bounces. Lengths in millimetres, as measured; the open side is
// at z = 0.
Scene scene_cornell() {
    Scene scene;
    const float sensor_height = 0.025f, focal_length = 0.035f;
    scene.camera = camera_look_at({278, 273, -800}, {278, 273, 0}, {0, 1, 0},
                                  0.5f * sensor_height / focal_length);

    const uint32_t white = add_diffuse(scene, {0.725f, 0.71f, 0.68f});
    const uint32_t red = add_diffuse(scene, {0.63f, 0.065f, 0.05f});
    const uint32_t green = add_diffuse(scene, {0.14f, 0.45f, 0.091f});
    const uint32_t lamp = add_diffuse(scene, {0.78f, 0.78f, 0.78f});

    const float top = 548.8f, back = 559.2f;
    const float lamp_x0 = 213, lamp_x1 = 343, lamp_z0 = 227, lamp_z1 = 332;

    add_light(scene, lamp, {17, 12, 4}, {lamp_x0, top, lamp_z0}, {lamp_x1, top, lamp_z0},
              {lamp_x1, top, lamp_z1});
    // The lamp fills a hole in the ceiling, so that no two surfaces coincide.
    const auto ceiling = [&](float x0, float x1, float z0, float z1) {
        add_quad(scene, white, {x0, top, z0}, {x1, top, z0}, {x1, top, z1}, {x0, top, z1});
    };
    ceiling(0, 556, 0, lamp_z0);
    ceiling(0, 556, lamp_z1, back);
    ceiling(0, lamp_x0, lamp_z0, lamp_z1);
    ceiling(lamp_x1, 556, lamp_z0, lamp_z1);

    add_quad(scene, white, {552.8f, 0, 0}, {0, 0, 0}, {0, 0, back}, {549.6f, 0, back});
    add_quad(scene, white, {549.6f, 0, back}, {0, 0, back}, {0, top, back}, {556, top, back});
    add_quad(scene, green, {0, 0, back}, {0, 0, 0}, {0, top, 0}, {0, top, back});
    add_quad(scene, red, {552.8f, 0, 0}, {549.6f, 0, back}, {556, top, back}, {556, top, 0});

    add_block(scene, white, 165, {{130, 65}, {82, 225}, {240, 272}, {290, 114}});
    add_block(scene, white, 330, {{423, 247}, {265, 296}, {314, 456}, {472, 406}});
    return scene;
}

// A large panel and a lamp of a hundredth of its area, each giving half of the light, behind bars
// and slats that can hide all of the lamp but only part of the panel. Included because neighbouring
// pixels differ mainly in visibility: smooth penumbrae and sharp edges cross.
Scene scene_penumbra() {
    Scene scene;
    scene.camera = camera_look_at({0.15f, 2.3f, 6.0f}, {0, 0.42f, 0.1f}, {0, 1, 0}, 0.235f);

    const uint32_t paper = add_diffuse(scene, {0.31f, 0.30f, 0.285f});
    const uint32_t blue = add_diffuse(scene, {0.08f, 0.14f, 0.28f});
    const uint32_t orange = add_diffuse(scene, {0.40f, 0.15f, 0.05f});
    const uint32_t dark = add_diffuse(scene, {0.12f, 0.12f, 0.13f});
    const uint32_t lamp = add_diffuse(scene, {0.1f, 0.1f, 0.1f});

    // A paper backdrop that curves up behind everything.
    add_backdrop(scene, paper, 9, {-3.4f, 9}, {-1.6f, 1.8f}, 1.8f, {9, 0});

    add_light_towards(scene, lamp, {16, 19, 23}, {-3.4f, 4.4f, -0.6f}, {0, 0.3f, 0}, 1.8f, 1.8f);
    add_light_towards(scene, lamp, {2000, 1450, 860}, {3.2f, 3.2f, -0.9f}, {0, 0.3f, 0}, 0.18f,
                      0.18f);

    // Bars in an arc, each taller and thinner than the last.
    for (int i = 0; i < 11; ++i) {
        const float t = static_cast<float>(i) / 10;
        const float angle = PI * (0.95f - 0.9f * t);
        const Vec3 foot = {1.25f * std::cos(angle), 0, -0.55f * std::sin(angle) - 0.1f};
        add_bar(scene, i % 2 ? dark : orange, foot, foot + Vec3{0, 0.5f + 0.9f * t, 0},
                0.035f - 0.026f * t);
    }
    // Slats floating above the floor in front.
    for (int i = 0; i < 9; ++i) {
        const float x = -1.25f + 0.12f * static_cast<float>(i);
        add_box(scene, blue, {x, 0.42f, 0.75f}, {0.022f, 0.014f, 0}, {-0.004f, 0.006f, 0},
                {0, 0, 0.38f});
    }
    add_sphere(scene, orange, {0.05f, 0.34f, 0.1f}, 0.34f);
    add_sphere(scene, blue, {0.9f, 0.16f, 0.8f}, 0.16f);
    return scene;
}

// Four lamps of equal power, from small to large, reflected by plates from smooth to rough (after
// Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995).
// Included because neither light sampling nor material sampling is good everywhere.
Scene scene_glossy() {
    Scene scene;
    const Vec3 eye = {0, 2.4f, 8}, lamps = {0, 4.3f, -1.6f};
    scene.camera = camera_look_at(eye, {0, 0.95f, 0.9f}, {0, 1, 0}, 0.245f);

    scene.light_samples = 4; // there are five lights, and most points reflect one

    const uint32_t wall = add_diffuse(scene, {0.30f, 0.31f, 0.34f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    add_backdrop(scene, wall, 12, {-2.6f, 9}, {-1.4f, 1.0f}, 1.2f, {10, -0.2f});

    const float sides[4] = {0.16f, 0.3f, 0.55f, 1.0f};
    const float places[4] = {-2.45f, -1.05f, 0.35f, 2.05f};
    const Vec3 colours[4] = {
        {1.0f, 0.45f, 0.25f}, {0.95f, 0.85f, 0.45f}, {0.4f, 0.85f, 0.6f}, {0.4f, 0.6f, 1.0f}};
    for (int i = 0; i < 4; ++i)
        add_light_towards(scene, black, (1.3f / (sides[i] * sides[i])) * colours[i],
                          lamps + Vec3{places[i], 0, 0}, {0.7f * places[i], 1, 2}, sides[i],
                          sides[i]);

    // A dim panel above the eye fills in what the lamps do not reach.
    add_light_towards(scene, black, {0.6f, 0.6f, 0.6f}, {0, 6, 7}, {0, 0.8f, 0}, 4, 3);

    // Each plate is tilted to reflect the lamps to the eye.
    const float roughnesses[4] = {0.14f, 0.22f, 0.33f, 0.5f};
    const Vec3 middles[4] = {
        {0, 1.85f, -0.7f}, {0, 1.22f, 0.35f}, {0, 0.66f, 1.4f}, {0, 0.22f, 2.4f}};
    for (int i = 0; i < 4; ++i) {
        const uint32_t metal = add_conductor(scene, {0.78f, 0.77f, 0.75f}, roughnesses[i]);
        const Vec3 up = normalize(normalize(lamps - middles[i]) + normalize(eye - middles[i]));
        const Vec3 x = {1, 0, 0};
        add_box(scene, metal, middles[i], 2.3f * x, 0.02f * up, 0.46f * cross(x, up));
    }
    return scene;
}

// Balls and posts on a plain under a sky with a sun, through a wide-aperture lens. Included because
// pixel, lens and light positions make six dimensions at once, and because the environment is
// sampled by brightness: the sun is a ten-thousandth of it and gives most of the light.
Scene scene_lens() {
    Scene scene;
    scene.camera = camera_look_at({0, 0.8f, 4.2f}, {0, 0.33f, 0}, {0, 1, 0}, 0.23f);
    camera_set_lens(scene.camera, 0.075f, {0, 0.3f, 0.35f});
    scene.environment =
        std::make_shared<Environment>(environment_sky(normalize(Vec3{-0.62f, 0.52f, 0.40f})));

    const uint32_t plain = add_diffuse(scene, {0.42f, 0.38f, 0.33f});
    add_quad(scene, plain, {-60, 0, 60}, {60, 0, 60}, {60, 0, -60}, {-60, 0, -60});

    const Vec3 colours[5] = {{0.60f, 0.13f, 0.08f},
                             {0.68f, 0.42f, 0.10f},
                             {0.55f, 0.56f, 0.54f},
                             {0.12f, 0.38f, 0.34f},
                             {0.10f, 0.18f, 0.45f}};
    for (int i = 0; i < 5; ++i) {
        const uint32_t ball = add_diffuse(scene, colours[i]);
        const float t = static_cast<float>(i);
        add_sphere(scene, ball, {-0.52f + 0.36f * t, 0.25f, 1.75f - 0.9f * t}, 0.25f);
    }
    const uint32_t chalk = add_diffuse(scene, {0.78f, 0.76f, 0.70f});
    add_sphere(scene, chalk, {0.42f, 0.16f, 1.55f}, 0.16f);
    const uint32_t post = add_diffuse(scene, {0.5f, 0.5f, 0.5f});
    for (int i = 0; i < 7; ++i) {
        const float x = -2.4f + 0.7f * static_cast<float>(i);
        add_bar(scene, post, {x, 0, -4}, {x, 1.5f, -4}, 0.04f);
    }
    return scene;
}

namespace {

// A point turned about an axis through `middle`, which is a unit vector.
Vec3 turned(Vec3 point, Vec3 middle, Vec3 axis, float angle) {
    const Vec3 p = point - middle;
    const Vec3 along = dot(p, axis) * axis;
    return middle + along + std::cos(angle) * (p - along) + std::sin(angle) * cross(axis, p);
}

} // namespace

// Balls in flight, a pinwheel, a tumbling die and a shuttle of thin rods under soft light, with the
// shutter open. Included because time multiplies with the position in the pixel: what an edge
// uncovers depends on both, and each moves at its own speed in its own direction.
Scene scene_motion() {
    Scene scene;
    scene.camera = camera_look_at({0.1f, 1.5f, 6.0f}, {0, 0.93f, 0}, {0, 1, 0}, 0.225f);

    const uint32_t paper = add_diffuse(scene, {0.50f, 0.50f, 0.49f});
    const uint32_t red = add_diffuse(scene, {0.62f, 0.10f, 0.07f});
    const uint32_t yellow = add_diffuse(scene, {0.75f, 0.48f, 0.08f});
    const uint32_t teal = add_diffuse(scene, {0.06f, 0.34f, 0.36f});
    const uint32_t white = add_diffuse(scene, {0.74f, 0.73f, 0.70f});
    const uint32_t dark = add_diffuse(scene, {0.07f, 0.07f, 0.08f});
    const uint32_t lamp = add_diffuse(scene, {0.1f, 0.1f, 0.1f});

    add_backdrop(scene, paper, 9, {-3.4f, 9}, {-1.6f, 1.8f}, 1.8f, {9, 0});
    add_light_towards(scene, lamp, {46, 41, 34}, {-3.2f, 4.6f, 2.2f}, {0, 0.7f, 0}, 1.5f, 1.5f);
    add_light_towards(scene, lamp, {3.6f, 4.8f, 6.6f}, {4.6f, 3.0f, 1.5f}, {0, 0.8f, 0}, 2.0f,
                      2.6f);

    size_t first = scene.vertices.size();
    const auto flies = [&](Vec3 by) {
        add_motion(scene, first, [by](Vec3 p) { return p + by; });
        first = scene.vertices.size();
    };
    const auto turns = [&](Vec3 middle, Vec3 axis, float angle, Vec3 by) {
        add_motion(scene, first,
                   [=](Vec3 p) { return turned(p, middle, normalize(axis), angle) + by; });
        first = scene.vertices.size();
    };

    // Balls thrown from the left, each farther along and slower to rise than the one before.
    for (int i = 0; i < 5; ++i) {
        const float t = static_cast<float>(i) / 4;
        add_sphere(scene, i % 2 ? yellow : red,
                   {-0.72f + 1.6f * t, 0.62f + 2.6f * t * (1 - t) + 0.15f * t, 0.7f - 0.2f * t},
                   0.15f);
        flies({0.22f, 0.36f * (1 - 2 * t), -0.03f});
    }

    // A pinwheel: its post stands still.
    const Vec3 hub = {-1.22f, 1.35f, -0.35f};
    add_bar(scene, dark, {hub.x, 0, hub.z - 0.08f}, hub - Vec3{0, 0, 0.08f}, 0.03f);
    first = scene.vertices.size();
    for (int i = 0; i < 6; ++i) {
        const float angle = PI * static_cast<float>(i) / 3;
        const Vec3 out = {std::cos(angle), std::sin(angle), 0};
        const Vec3 side = {-out.y, out.x, 0.25f};
        const Vec3 tip = hub + 0.66f * out, foot = hub + 0.06f * out;
        add_quad(scene, i % 2 ? white : teal, foot, tip - 0.02f * side, tip + 0.2f * side,
                 foot + 0.05f * side);
    }
    turns(hub, {0, 0, 1}, 0.32f, {0, 0, 0});

    // A die that tumbles down on the right.
    const Vec3 die = {1.28f, 1.25f, 0.1f};
    add_box(scene, white, die, {0.21f, 0.08f, 0.06f}, {-0.08f, 0.2f, 0.08f},
            {-0.02f, -0.09f, 0.2f});
    turns(die, {0.3f, 0.2f, 1}, 0.35f, {0.05f, -0.28f, 0.1f});

    // A shuttle of rods that slides to the left, between rods that do not move.
    for (int i = 0; i < 9; ++i) {
        const float x = 0.35f + 0.16f * static_cast<float>(i);
        add_bar(scene, i % 2 ? teal : yellow, {x, 0, -0.7f}, {x, 0.8f, -0.7f}, 0.025f);
        if (i % 2) flies({-0.2f, 0, 0});
        first = scene.vertices.size();
    }

    // A pendulum that swings to the right; it hangs from above the picture.
    const Vec3 pivot = {0.62f, 3.2f, -0.6f}, bob = {0.40f, 1.76f, -0.6f};
    add_bar(scene, dark, pivot, bob, 0.012f);
    add_sphere(scene, teal, bob, 0.13f);
    turns(pivot, {0, 0, 1}, 0.15f, {0, 0, 0});

    // Low over the floor: one ball rolls towards the camera, one away, one stands.
    add_sphere(scene, teal, {-0.35f, 0.2f, 1.05f}, 0.2f);
    flies({-0.30f, 0, 0.22f});
    add_sphere(scene, yellow, {0.75f, 0.14f, 1.0f}, 0.14f);
    flies({0.32f, 0, -0.25f});
    add_sphere(scene, red, {0.2f, 0.12f, 1.35f}, 0.12f);
    return scene;
}
