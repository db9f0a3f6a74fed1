// Colours for numbers in [0, 1]: even in lightness, dark blue over green to yellow; the limit itself is marked in red.
#pragma once

#include "render/image/image.h"

namespace umax {

/// Linear Rec. 709 colour of a value. Below 1 the lightness (OKLab) rises evenly; from 1 on it is the signal red of a
/// limit that is reached; NaN is grey. Values below 0 count as 0.
Vector3f color_of_value(double value);

/// The same as 8-bit sRGB codes, for bars and plots.
Eigen::Matrix<std::uint8_t, 3, 1> code_of_value(double value);

/// FLIP maps and the like: black, violet, orange, pale yellow.
Image8 difference_picture(const Image& map);

}  // namespace umax
