// SPDX-License-Identifier: Apache-2.0
// How bright a preview has to be, and what is wrong with a picture that shows nothing.
#pragma once

#include <string>

#include "film.h"

// The exposure, in stops, that maps the geometric mean of the picture's luminance to a middle grey
// of 0.18, rounded to quarters of a stop. Only pixels count that show a surface more often than
// not, or all where hardly any do; and they count as means over blocks of 16x16 pixels, so that
// noise and black shadows hardly move it: the previews of two samplers get the same. 0 for a black
// picture.
float auto_exposure(const Film &film);

// What a picture should be looked at again for, and what to do about it, as one line; empty when
// something is seen: no surface, no light, or a preview that is black or mostly clipped to white.
// `extent` says where the scene is.
std::string film_warning(const Film &film, float exposure, const std::string &extent);
