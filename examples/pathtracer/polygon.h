// SPDX-License-Identifier: Apache-2.0
// Splitting polygons into triangles.
#pragma once

#include <array>
#include <vector>

#include "scene.h"

// The triangles of a polygon without holes, as numbers of its corners, turning as it turns: n - 2
// of them, whatever its shape. It may be concave and nearly flat; of one that crosses itself or is
// degenerate they cover something. Takes n^3 steps at worst.
std::vector<std::array<size_t, 3>> polygon_triangles(const std::vector<Point3d> &corners);
