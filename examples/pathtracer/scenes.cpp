// SPDX-License-Identifier: Apache-2.0
// Building blocks for scenes in code, and the scenes made of them. y is up.
#include "scene.h"

namespace {

uint32_t add_material(Scene &scene, Material::Kind kind, Vec3 albedo, float roughness = 0,
                      float ior = 1.5f) {
    scene.materials.push_back({kind, albedo, Vec3(1), roughness, 1, ior});
    return uint32_t(scene.materials.size() - 1);
}

void add_vertex(Scene &scene, Vec3 position, Vec3 normal) {
    // Zero marks earlier vertices as having no normal.
    scene.normals.resize(scene.vertices.size(), {0, 0, 0});
    scene.vertices.push_back(position);
    scene.normals.push_back(normal);
}

void add_triangle(Scene &scene, uint32_t material, uint32_t a, uint32_t b, uint32_t c,
                  int32_t light = -1) {
    scene.triangles.push_back({{a, b, c}, material, light});
}

// Joins each of the last vertex pairs to the next one and, if the strip is closed, the last to the first.
void add_strip(Scene &scene, uint32_t material, uint32_t pairs, bool closed) {
    const uint32_t first = uint32_t(scene.vertices.size()) - 2 * pairs;
    for (uint32_t i = 0; i + (closed ? 0 : 1) < pairs; ++i) {
        const uint32_t p = first + 2 * i, q = first + 2 * ((i + 1) % pairs);
        add_triangle(scene, material, p, q, q + 1);
        add_triangle(scene, material, p, q + 1, p + 1);
    }
}

} // namespace

uint32_t add_diffuse(Scene &scene, Vec3 albedo) {
    return add_material(scene, Material::DIFFUSE, albedo);
}

uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness) {
    return add_material(scene, Material::METALLIC_ROUGHNESS, albedo, roughness);
}

uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed) {
    return add_material(scene, Material::DIELECTRIC, passed, roughness, ior);
}

void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d, int32_t light) {
    const auto first = uint32_t(scene.vertices.size());
    scene.vertices.insert(scene.vertices.end(), {a, b, c, d});
    add_triangle(scene, material, first, first + 1, first + 2, light);
    add_triangle(scene, material, first, first + 2, first + 3, light);
}

void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c) {
    scene.lights.push_back(area_light(Light::PARALLELOGRAM, a, b - a, c - b, radiance));
    add_quad(scene, material, a, b, c, a + (c - b), int32_t(scene.lights.size() - 1));
}

void add_panel(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
               float width, float height) {
    const Vec3 normal = normalize(target - middle);
    const Vec3 x = normalize_or(cross({0, 1, 0}, normal), {1, 0, 0});
    const Vec3 half_x = (0.5f * width) * x, half_y = (0.5f * height) * cross(normal, x);
    add_light(scene, material, radiance, middle - half_x - half_y, middle + half_x - half_y,
              middle + half_x + half_y);
}

void add_box(Scene &scene, uint32_t material, Vec3 m, Vec3 x, Vec3 y, Vec3 z) {
    const auto face = [&](Vec3 out, Vec3 a, Vec3 b) { // a, b, out right-handed
        add_quad(scene, material, m + out - a - b, m + out + a - b, m + out + a + b,
                 m + out - a + b);
    };
    face(x, y, z), face(-x, z, y);
    face(y, z, x), face(-y, x, z);
    face(z, x, y), face(-z, y, x);
}

void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around) {
    const int rings = around / 2;
    const auto top = uint32_t(scene.vertices.size());
    for (int ring = 0; ring <= rings; ++ring)
        for (int column = 0; column < around; ++column) {
            const float theta = PI * float(ring) / float(rings);
            const float phi = 2 * PI * float(column) / float(around);
            const Vec3 n = {std::sin(theta) * std::cos(phi), std::cos(theta),
                            std::sin(theta) * std::sin(phi)};
            add_vertex(scene, middle + radius * n, n);
            const auto a = uint32_t(top + ring * around + column);
            const auto b = uint32_t(top + ring * around + (column + 1) % around);
            const auto below = uint32_t(around);
            if (ring > 0 && ring < rings) add_triangle(scene, material, a, b, a + below);
            if (ring + 1 < rings) add_triangle(scene, material, b, b + below, a + below);
        }
}

void add_motion(Scene &scene, size_t first, const std::function<Vec3(Vec3)> &end) {
    scene.motions.resize(scene.vertices.size(), {0, 0, 0});
    for (size_t i = first; i < scene.vertices.size(); ++i)
        scene.motions[i] = end(scene.vertices[i]) - scene.vertices[i];
}

namespace {

// A scene with a camera whose up direction is +y.
Scene scene_from(Vec3 eye, Vec3 target, float tan_half_height) {
    Scene scene;
    scene.camera = camera_look_at(eye, target, {0, 1, 0}, tan_half_height);
    return scene;
}

void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 half) {
    add_box(scene, material, middle, {half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z});
}

// A smooth-shaded cylinder between two points, without end caps.
void add_bar(Scene &scene, uint32_t material, Vec3 a, Vec3 b, float radius) {
    constexpr int AROUND = 16;
    const glm::mat3 frame = frame_around(normalize(b - a));
    for (int i = 0; i < AROUND; ++i) {
        const float phi = 2 * PI * float(i) / AROUND;
        const Vec3 n = std::cos(phi) * frame[0] + std::sin(phi) * frame[1];
        add_vertex(scene, a + radius * n, n);
        add_vertex(scene, b + radius * n, n);
    }
    add_strip(scene, material, AROUND, true);
}

// A smooth-shaded sheet that curves up behind everything. In (z, y), it runs from `top` along a
// quarter circle to `front`.
void add_backdrop(Scene &scene, uint32_t material, float half_width, Vec2 top, Vec2 centre,
                  float radius, Vec2 front) {
    constexpr int PARTS = 24;
    std::vector<Vec2> sheet = {top};
    for (int i = 0; i <= PARTS; ++i) {
        const float angle = 0.5f * PI * float(i) / PARTS;
        sheet.push_back({centre.x - radius * std::cos(angle), centre.y - radius * std::sin(angle)});
    }
    sheet.push_back(front);
    for (size_t i = 0; i < sheet.size(); ++i) {
        const Vec2 along = sheet[std::min(i + 1, sheet.size() - 1)] - sheet[i > 0 ? i - 1 : 0];
        const Vec3 n = normalize(Vec3{0, along.x, -along.y});
        add_vertex(scene, {-half_width, sheet[i].y, sheet[i].x}, n);
        add_vertex(scene, {half_width, sheet[i].y, sheet[i].x}, n);
    }
    add_strip(scene, material, uint32_t(sheet.size()), false);
}

// The box measured at Cornell (Goral et al., "Modeling the Interaction of Light Between Diffuse
// Surfaces", 1984; dimensions, camera and materials as published by the Program of Computer Graphics,
// in millimetres).
Scene scene_cornell() {
    const float sensor_height = 0.025f, focal_length = 0.035f;
    Scene scene = scene_from({278, 273, -800}, {278, 273, 0}, 0.5f * sensor_height / focal_length);

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

    // A block on the floor, without a bottom, from the corners of its top.
    const auto block = [&](float height, const std::array<Vec2, 4> &corners) {
        const auto at = [&](int i, float y) { return Vec3{corners[i % 4].x, y, corners[i % 4].y}; };
        add_quad(scene, white, at(0, height), at(1, height), at(2, height), at(3, height));
        for (int i = 0; i < 4; ++i)
            add_quad(scene, white, at(i, 0), at(i + 1, 0), at(i + 1, height), at(i, height));
    };
    block(165, {{{130, 65}, {82, 225}, {240, 272}, {290, 114}}});
    block(330, {{{423, 247}, {265, 296}, {314, 456}, {472, 406}}});
    return scene;
}

// A large panel and a lamp with a hundredth of its area, each giving half of the light, behind bars and slats.
Scene scene_penumbra() {
    Scene scene = scene_from({0.15f, 2.3f, 6.0f}, {0, 0.42f, 0.1f}, 0.235f);

    const uint32_t paper = add_diffuse(scene, {0.31f, 0.30f, 0.285f});
    const uint32_t blue = add_diffuse(scene, {0.08f, 0.14f, 0.28f});
    const uint32_t orange = add_diffuse(scene, {0.40f, 0.15f, 0.05f});
    const uint32_t dark = add_diffuse(scene, {0.12f, 0.12f, 0.13f});
    const uint32_t lamp = add_diffuse(scene, {0.1f, 0.1f, 0.1f});

    add_backdrop(scene, paper, 9, {-3.4f, 9}, {-1.6f, 1.8f}, 1.8f, {9, 0});

    add_panel(scene, lamp, {16, 19, 23}, {-3.4f, 4.4f, -0.6f}, {0, 0.3f, 0}, 1.8f, 1.8f);
    add_panel(scene, lamp, {2000, 1450, 860}, {3.2f, 3.2f, -0.9f}, {0, 0.3f, 0}, 0.18f, 0.18f);

    // Bars in an arc, each taller and thinner than the last.
    for (int i = 0; i < 11; ++i) {
        const float t = float(i) / 10;
        const float angle = PI * (0.95f - 0.9f * t);
        const Vec3 foot = {1.25f * std::cos(angle), 0, -0.55f * std::sin(angle) - 0.1f};
        add_bar(scene, i % 2 ? dark : orange, foot, foot + Vec3{0, 0.5f + 0.9f * t, 0},
                0.035f - 0.026f * t);
    }
    // Slats floating above the floor in front.
    for (int i = 0; i < 9; ++i) {
        const float x = -1.25f + 0.12f * float(i);
        add_box(scene, blue, {x, 0.42f, 0.75f}, {0.022f, 0.014f, 0}, {-0.004f, 0.006f, 0},
                {0, 0, 0.38f});
    }
    add_sphere(scene, orange, {0.05f, 0.34f, 0.1f}, 0.34f);
    add_sphere(scene, blue, {0.9f, 0.16f, 0.8f}, 0.16f);
    return scene;
}

// Four lamps of equal power, from small to large, reflected by plates from smooth to rough (after Veach
// and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995).
Scene scene_glossy() {
    const Vec3 eye = {0, 2.4f, 8}, lamps = {0, 4.3f, -1.6f};
    Scene scene = scene_from(eye, {0, 0.95f, 0.9f}, 0.245f);
    scene.light_samples = 4; // there are five lights, and most points reflect one

    const uint32_t wall = add_diffuse(scene, {0.30f, 0.31f, 0.34f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    add_backdrop(scene, wall, 12, {-2.6f, 9}, {-1.4f, 1.0f}, 1.2f, {10, -0.2f});

    const float sides[4] = {0.16f, 0.3f, 0.55f, 1.0f};
    const float places[4] = {-2.45f, -1.05f, 0.35f, 2.05f};
    const Vec3 colours[4] = {
        {1.0f, 0.45f, 0.25f}, {0.95f, 0.85f, 0.45f}, {0.4f, 0.85f, 0.6f}, {0.4f, 0.6f, 1.0f}};
    for (int i = 0; i < 4; ++i)
        add_panel(scene, black, (1.3f / (sides[i] * sides[i])) * colours[i],
                  lamps + Vec3{places[i], 0, 0}, {0.7f * places[i], 1, 2}, sides[i], sides[i]);

    // A dim panel above the eye lights what the lamps do not reach.
    add_panel(scene, black, {0.6f, 0.6f, 0.6f}, {0, 6, 7}, {0, 0.8f, 0}, 4, 3);

    // Each plate is tilted to reflect the lamps towards the eye.
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

// Balls and posts under a sky with a sun, seen through a wide-aperture lens.
Scene scene_lens() {
    Scene scene = scene_from({0, 0.8f, 4.2f}, {0, 0.33f, 0}, 0.23f);
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
        const float t = float(i);
        add_sphere(scene, ball, {-0.52f + 0.36f * t, 0.25f, 1.75f - 0.9f * t}, 0.25f);
    }
    add_sphere(scene, add_diffuse(scene, {0.78f, 0.76f, 0.70f}), {0.42f, 0.16f, 1.55f}, 0.16f);
    const uint32_t post = add_diffuse(scene, {0.5f, 0.5f, 0.5f});
    for (int i = 0; i < 7; ++i) {
        const float x = -2.4f + 0.7f * float(i);
        add_bar(scene, post, {x, 0, -4}, {x, 1.5f, -4}, 0.04f);
    }
    return scene;
}

Vec3 turned(Vec3 point, Vec3 middle, Vec3 axis, float angle) {
    const Vec3 p = point - middle;
    const Vec3 along = dot(p, axis) * axis;
    return middle + along + std::cos(angle) * (p - along) + std::sin(angle) * cross(axis, p);
}

// Moving objects under soft light, with the shutter open.
Scene scene_motion() {
    Scene scene = scene_from({0.1f, 1.5f, 6.0f}, {0, 0.93f, 0}, 0.225f);

    const uint32_t paper = add_diffuse(scene, {0.50f, 0.50f, 0.49f});
    const uint32_t red = add_diffuse(scene, {0.62f, 0.10f, 0.07f});
    const uint32_t yellow = add_diffuse(scene, {0.75f, 0.48f, 0.08f});
    const uint32_t teal = add_diffuse(scene, {0.06f, 0.34f, 0.36f});
    const uint32_t white = add_diffuse(scene, {0.74f, 0.73f, 0.70f});
    const uint32_t dark = add_diffuse(scene, {0.07f, 0.07f, 0.08f});
    const uint32_t lamp = add_diffuse(scene, {0.1f, 0.1f, 0.1f});

    add_backdrop(scene, paper, 9, {-3.4f, 9}, {-1.6f, 1.8f}, 1.8f, {9, 0});
    add_panel(scene, lamp, {46, 41, 34}, {-3.2f, 4.6f, 2.2f}, {0, 0.7f, 0}, 1.5f, 1.5f);
    add_panel(scene, lamp, {3.6f, 4.8f, 6.6f}, {4.6f, 3.0f, 1.5f}, {0, 0.8f, 0}, 2.0f, 2.6f);

    size_t first = scene.vertices.size();
    const auto moves = [&](const auto &end) {
        add_motion(scene, first, end);
        first = scene.vertices.size();
    };
    const auto flies = [&](Vec3 by) { moves([by](Vec3 p) { return p + by; }); };
    const auto turns = [&](Vec3 middle, Vec3 axis, float angle, Vec3 by) {
        moves([=](Vec3 p) { return turned(p, middle, normalize(axis), angle) + by; });
    };

    // Balls thrown from the left.
    for (int i = 0; i < 5; ++i) {
        const float t = float(i) / 4;
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
        const float angle = PI * float(i) / 3;
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
        const float x = 0.35f + 0.16f * float(i);
        add_bar(scene, i % 2 ? teal : yellow, {x, 0, -0.7f}, {x, 0.8f, -0.7f}, 0.025f);
        if (i % 2) flies({-0.2f, 0, 0});
        first = scene.vertices.size();
    }

    // A pendulum that swings to the right; it hangs from above the image.
    const Vec3 pivot = {0.62f, 3.2f, -0.6f}, bob = {0.40f, 1.76f, -0.6f};
    add_bar(scene, dark, pivot, bob, 0.012f);
    add_sphere(scene, teal, bob, 0.13f);
    turns(pivot, {0, 0, 1}, 0.15f, {0, 0, 0});

    // Three balls low over the floor: one rolls towards the camera, one rolls away and one rests.
    add_sphere(scene, teal, {-0.35f, 0.2f, 1.05f}, 0.2f);
    flies({-0.30f, 0, 0.22f});
    add_sphere(scene, yellow, {0.75f, 0.14f, 1.0f}, 0.14f);
    flies({0.32f, 0, -0.25f});
    add_sphere(scene, red, {0.2f, 0.12f, 1.35f}, 0.12f);
    return scene;
}

// Smooth, rough and tinted glass in a studio.
Scene scene_glass() {
    Scene scene = scene_from({0, 1.45f, 5.0f}, {0.02f, 0.42f, 0}, 0.265f);

    const uint32_t paper = add_diffuse(scene, {0.66f, 0.65f, 0.63f});
    const uint32_t red = add_diffuse(scene, {0.60f, 0.10f, 0.07f});
    const uint32_t teal = add_diffuse(scene, {0.07f, 0.36f, 0.38f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    const uint32_t frosted = add_dielectric(scene, 1.45f, 0.5f, {0.80f, 0.95f, 0.90f});
    const uint32_t amber = add_dielectric(scene, 1.6f, 0.05f, {0.95f, 0.70f, 0.30f});

    add_backdrop(scene, paper, 9, {-2.6f, 8}, {-1.4f, 1.2f}, 1.2f, {9, 0});

    add_panel(scene, black, {5.5f, 5.3f, 5.0f}, {-2.6f, 3.2f, 1.0f}, {0, 0.3f, 0}, 2.4f, 2.4f);
    add_panel(scene, black, {2.2f, 2.6f, 3.2f}, {3.2f, 2.0f, 1.6f}, {0, 0.4f, 0}, 1.0f, 2.6f);

    for (int i = 0; i < 9; ++i) {
        const float x = -1.5f + 0.375f * float(i);
        add_bar(scene, i % 2 ? red : teal, {x, 0, -1.1f}, {x, 1.3f, -1.1f}, 0.05f);
    }
    add_sphere(scene, add_dielectric(scene, 1.5f, 0), {-0.78f, 0.401f, 0.25f}, 0.4f);
    add_sphere(scene, add_dielectric(scene, 1.5f, 0.22f), {0.08f, 0.401f, -0.1f}, 0.4f);
    add_sphere(scene, frosted, {0.9f, 0.351f, 0.25f}, 0.35f);
    add_box(scene, amber, {0.2f, 0.121f, 0.85f}, {0.22f, 0, 0.1f}, {0, 0.12f, 0},
            {-0.06f, 0, 0.132f});
    return scene;
}

// A room lit through a small window by a bright panel outside.
Scene scene_interior() {
    Scene scene = scene_from({1.9f, 1.5f, 2.6f}, {-0.5f, 1.1f, -1.6f}, 0.46f);

    const uint32_t plaster = add_diffuse(scene, {0.76f, 0.74f, 0.70f});
    const uint32_t wood = add_diffuse(scene, {0.46f, 0.30f, 0.17f});
    const uint32_t rug = add_diffuse(scene, {0.45f, 0.14f, 0.12f});
    const uint32_t cloth = add_diffuse(scene, {0.20f, 0.34f, 0.42f});
    const uint32_t outside = add_diffuse(scene, {0.3f, 0.3f, 0.3f});
    const uint32_t steel = add_conductor(scene, {0.72f, 0.70f, 0.66f}, 0.3f);

    // The room, with a window in the left wall from (low_z, low_y) to (high_z, high_y).
    const float left = -2.4f, right = 2.4f, back = -3.2f, front = 3.0f, top = 2.7f;
    const float low_z = -1.9f, high_z = -0.7f, low_y = 0.95f, high_y = 2.15f, sill = -2.65f;
    const auto wall = [&](uint32_t material, Vec3 a, Vec3 b, Vec3 c) {
        const Vec3 d = Point3d(a) + Point3d(c) - Point3d(b);
        add_quad(scene, material, a, b, c, d);
    };
    wall(wood, {left, 0, front}, {right, 0, front}, {right, 0, back});
    wall(plaster, {left, top, back}, {right, top, back}, {right, top, front});
    wall(plaster, {left, 0, back}, {right, 0, back}, {right, top, back});
    wall(plaster, {right, 0, front}, {left, 0, front}, {left, top, front});
    wall(cloth, {right, 0, back}, {right, 0, front}, {right, top, front});
    const auto left_wall = [&](float z0, float z1, float y0, float y1) {
        wall(plaster, {left, y0, z1}, {left, y0, z0}, {left, y1, z0});
    };
    left_wall(back, low_z, 0, top);
    left_wall(high_z, front, 0, top);
    left_wall(low_z, high_z, 0, low_y);
    left_wall(low_z, high_z, high_y, top);
    // The window's reveal.
    wall(plaster, {sill, low_y, low_z}, {sill, low_y, high_z}, {left, low_y, high_z});
    wall(plaster, {sill, high_y, high_z}, {sill, high_y, low_z}, {left, high_y, low_z});
    wall(plaster, {sill, low_y, low_z}, {left, low_y, low_z}, {left, high_y, low_z});
    wall(plaster, {left, low_y, high_z}, {sill, low_y, high_z}, {sill, high_y, high_z});

    add_panel(scene, outside, {15, 17, 20}, {-4.4f, 2.2f, -2.2f}, {0, 1.2f, -1.6f}, 6.5f, 3.6f);

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

constexpr Vec3 FOG_LOW = {-6, -0.1f, -6}, FOG_HIGH = {6, 4.4f, 6};

// Banks of fog that thin out with height and are broken up by waves that distort each other.
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

// A pergola at night between two lamps, above drifting fog.
Scene scene_fog() {
    Scene scene = scene_from({-0.6f, 2.0f, 8.8f}, {0, 1.2f, 0}, 0.265f);
    scene.medium = std::make_shared<Medium>(
        medium_create(FOG_LOW, FOG_HIGH, {96, 40, 96}, {0.92f, 0.94f, 0.96f}, 0.5f, fog_density));

    const uint32_t stone = add_diffuse(scene, {0.42f, 0.38f, 0.33f});
    const uint32_t ground = add_diffuse(scene, {0.28f, 0.26f, 0.24f});
    const uint32_t black = add_diffuse(scene, {0.02f, 0.02f, 0.02f});
    add_quad(scene, ground, {-40, 0, 40}, {40, 0, 40}, {40, 0, -40}, {-40, 0, -40});

    add_panel(scene, black, {1700, 950, 400}, {-4.2f, 7.6f, -6.5f}, {0.2f, 0.8f, 0}, 0.7f, 0.7f);
    add_panel(scene, black, {80, 150, 270}, {6.8f, 5.6f, 0.8f}, {0, 0.8f, 0.4f}, 0.8f, 0.8f);

    for (int row = 0; row < 2; ++row) {
        const float z = row == 0 ? -1.6f : 1.2f;
        for (int i = 0; i < 4; ++i) {
            const float x = -2.55f + 1.7f * float(i);
            add_box(scene, stone, {x, 1.2f, z}, {0.11f, 1.2f, 0.11f});
            add_box(scene, stone, {x, 0.07f, z}, {0.19f, 0.07f, 0.19f});
        }
        add_box(scene, stone, {0, 2.5f, z}, {2.9f, 0.1f, 0.12f});
    }
    for (int i = 0; i < 9; ++i)
        add_box(scene, stone, {-2.72f + 0.68f * float(i), 2.66f, -0.2f}, {0.16f, 0.06f, 1.9f});
    return scene;
}

// A closed cube whose walls emit and reflect half each: every pixel's radiance is 1 - 2^-(bounces + 1).
Scene scene_furnace() {
    Scene scene = scene_from({0.1f, 0.2f, -0.3f}, {1, 0.5f, 1}, 0.8f);
    const uint32_t wall = add_diffuse(scene, {0.5f, 0.5f, 0.5f});
    const auto side = [&](Vec3 a, Vec3 b, Vec3 c) { add_light(scene, wall, Vec3(0.5f), a, b, c); };
    side({-1, -1, -1}, {-1, -1, 1}, {1, -1, 1});
    side({-1, 1, -1}, {1, 1, -1}, {1, 1, 1});
    side({-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1});
    side({1, -1, -1}, {1, -1, 1}, {1, 1, 1});
    side({-1, -1, -1}, {1, -1, -1}, {1, 1, -1});
    side({-1, -1, 1}, {-1, 1, 1}, {1, 1, 1});
    return scene;
}

} // namespace

const std::vector<SceneEntry> &scene_entries() {
    static const std::vector<SceneEntry> entries = {
        {"cornell", "the Cornell box: soft shadows, colour bleeding", scene_cornell},
        {"penumbra", "soft and hard shadows of thin bars: visibility varies between pixels",
         scene_penumbra},
        {"glossy", "Veach's plates: MIS combines light sampling and BSDF sampling", scene_glossy},
        {"lens", "depth of field: positions in the pixel, on the lens and on the light",
         scene_lens},
        {"motion", "motion blur: edges move in different directions", scene_motion},
        {"glass", "smooth and rough glass: caustics, which only scattered rays find", scene_glass},
        {"interior", "a room lit through a small window: light after many bounces", scene_interior},
        {"fog", "drifting fog: free flight and shadow rays, loops of unknown length", scene_fog},
        {"furnace", "white furnace: the exact value of every pixel is known", scene_furnace},
    };
    return entries;
}
