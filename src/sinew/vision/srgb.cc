#include "sinew/vision/srgb.h"

#include <cmath>
#include <cstddef>

namespace sinew::vision {

double light_of_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double srgb_of_light(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

const std::array<float, 256>& linear_light() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> all{};
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = static_cast<float>(light_of_srgb(static_cast<double>(i) / 255));
    }
    return all;
  }();
  return table;
}

}  // namespace sinew::vision
