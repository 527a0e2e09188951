// SPDX-License-Identifier: Apache-2.0
// Splits polygons into triangles.
#pragma once

#include <array>
#include <vector>

#include "scene.h"

// Splits a polygon without holes into n - 2 triangles with the same orientation, each given by
// three corner indices. The polygon may be concave and not quite flat. For a degenerate or
// self-intersecting polygon, the triangles are valid but their area is unspecified. Takes up to n^3
// steps.
std::vector<std::array<size_t, 3>> polygon_triangles(const std::vector<Point3d> &corners);
