// SPDX-License-Identifier: Apache-2.0
// The difference between a picture and its reference, as it is and as seen from a distance.
#pragma once

#include "image.h"

// The root mean square over pixels and channels of image - reference, blurred by a Gaussian of
// sigma pixels that ends at four sigma and mirrors the picture at its edges. Sigma 0 is the plain
// RMSE. Both images hold the same pixels.
double blurred_rmse(const Image &image, const Image &reference, double sigma);

// The root mean square of (image - reference) / (reference + a tenth of the reference's mean), over
// pixels and channels: dark parts count as much as bright ones.
double relative_rmse(const Image &image, const Image &reference);

// The part of an image inside a crop. The crop must lie within that of the image.
Image image_crop(const Image &image, const Crop &crop);
