#pragma once

#include <array>

namespace sinew::vision {

/// The curve of sRGB (IEC 61966-2-1), both 0 to 1.
double light_of_srgb(double value);
double srgb_of_light(double light);
/// The light of each byte of sRGB.
const std::array<float, 256>& linear_light();

}  // namespace sinew::vision
