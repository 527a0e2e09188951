// SPDX-License-Identifier: Apache-2.0
// The functions that build the scenes listed in scene.cpp.
#pragma once

#include "scene.h"

// scene_direct.cpp
Scene scene_cornell();
Scene scene_penumbra();
Scene scene_glossy();
Scene scene_lens();
Scene scene_motion();

// scene_indirect.cpp
Scene scene_glass();
Scene scene_interior();
Scene scene_furnace();

// scene_fog.cpp
Scene scene_fog();
