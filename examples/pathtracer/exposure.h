// SPDX-License-Identifier: Apache-2.0
// Automatic exposure of previews, and warnings about pictures that show nothing.
#pragma once

#include <string>

#include "film.h"

// The exposure in stops that maps the geometric mean of the picture's luminance to middle grey,
// 0.18, rounded to a quarter of a stop. Only pixels that mostly show a surface count, or all pixels
// if there are hardly any. The mean is over averages of 16x16 pixels: noise and black shadows
// hardly change it, and previews of different samplers get the same exposure. 0 for a black
// picture.
float auto_exposure(const Film &film);

// One line that warns about a picture without visible surfaces or light, or a preview that is black
// or mostly clipped to white, and says what to do; otherwise empty. `extent` says where the scene
// is.
std::string film_warning(const Film &film, float exposure, const std::string &extent);
