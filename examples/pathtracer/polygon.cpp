// SPDX-License-Identifier: Apache-2.0
// Ear clipping (Meisters, "Polygons Have Ears", 1975): corners whose triangle lies inside the
// polygon and contains no other corner are cut off until one triangle is left. The polygon is
// projected along the axis nearest to its normal, which Newell's method gives.
#include "polygon.h"

#include <cmath>
#include <limits>

namespace {

struct Point2d {
    double x, y;
};

// Twice the signed area of a triangle, positive if it is counter-clockwise.
double turn(Point2d a, Point2d b, Point2d c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Projects the polygon so that it is counter-clockwise.
std::vector<Point2d> flattened(const std::vector<Point3d> &corners) {
    double n[3] = {0, 0, 0};
    const Point3d o = corners[0];
    for (size_t i = 0; i < corners.size(); ++i) {
        const Point3d p = corners[i], q = corners[(i + 1) % corners.size()];
        n[0] += (p.y - q.y) * ((p.z - o.z) + (q.z - o.z));
        n[1] += (p.z - q.z) * ((p.x - o.x) + (q.x - o.x));
        n[2] += (p.x - q.x) * ((p.y - o.y) + (q.y - o.y));
    }
    int axis = std::abs(n[0]) > std::abs(n[1]) ? 0 : 1;
    if (std::abs(n[2]) > std::abs(n[axis])) axis = 2;
    const double side = n[axis] < 0 ? -1 : 1;
    std::vector<Point2d> result;
    for (const Point3d p : corners) {
        const double v[3] = {p.x - o.x, p.y - o.y, p.z - o.z};
        result.push_back({v[(axis + 1) % 3], side * v[(axis + 2) % 3]});
    }
    return result;
}

bool same(Point2d a, Point2d b) {
    return a.x == b.x && a.y == b.y;
}

} // namespace

std::vector<std::array<size_t, 3>> polygon_triangles(const std::vector<Point3d> &corners) {
    std::vector<std::array<size_t, 3>> triangles;
    if (corners.size() < 3) return triangles;
    if (corners.size() == 3) return {{0, 1, 2}};
    const std::vector<Point2d> points = flattened(corners);
    std::vector<size_t> left(corners.size());
    for (size_t i = 0; i < left.size(); ++i) left[i] = i;
    const auto neighbours = [&](size_t i) {
        const size_t n = left.size();
        return std::array<size_t, 3>{left[(i + n - 1) % n], left[i], left[(i + 1) % n]};
    };
    const auto is_ear = [&](const std::array<size_t, 3> &t) {
        const Point2d a = points[t[0]], b = points[t[1]], c = points[t[2]];
        if (!(turn(a, b, c) > 0)) return false;
        for (const size_t i : left) {
            const Point2d p = points[i];
            // Coincident corners, as on a bridge to a hole and back, are not inside.
            if (same(p, a) || same(p, b) || same(p, c)) continue;
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    };
    while (left.size() > 3) {
        size_t ear = left.size(), flattest = 0;
        double least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < left.size() && ear == left.size(); ++i) {
            const std::array<size_t, 3> t = neighbours(i);
            if (is_ear(t)) ear = i;
            const double area = std::abs(turn(points[t[0]], points[t[1]], points[t[2]]));
            if (area < least) least = area, flattest = i;
        }
        // Only an invalid polygon has no ear: cutting off the smallest triangle does least harm.
        if (ear == left.size()) ear = flattest;
        triangles.push_back(neighbours(ear));
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({left[0], left[1], left[2]});
    return triangles;
}
