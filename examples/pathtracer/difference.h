// SPDX-License-Identifier: Apache-2.0
// The difference between a picture and its reference, as is and as seen from a distance.
#pragma once

#include <vector>

#include "image.h"

// The RMS of image - reference over pixels and channels, after a Gaussian of sigma pixels that is
// cut off at four sigma and mirrors the picture at its edges. Sigma 0 is the plain RMSE. Both
// images must cover the same pixels.
double blurred_rmse(const Image &image, const Image &reference, double sigma);

// The part of an image inside a crop, which must lie within the image's own crop.
Image image_crop(const Image &image, const Crop &crop);
