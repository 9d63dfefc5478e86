#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// Color of the light in a picture: red, green and blue in linear light, with the geometric mean 1.
///
/// The geometric mean of two estimates that fail on different pictures: shades of grey (Finlayson
/// and Trezzi 2004), by bright pixels, and grey edges (van de Weijer, Gevers and Gijsenij 2007), by
/// the strongest changes. Clipped and dark pixels do not count. An estimate is white where fewer
/// than 15 % of the pixels are left; a channel has 0.5 to 2 times the mean of all.
std::array<double, 3> light_of(const Picture& picture);

/// Makes pictures of one light nearly white balanced: seven tenths of a tint go (of its logarithm).
/// A dim picture is brightened, up to four times.
class WhiteBalance {
 public:
  using Curve = std::array<std::uint8_t, 256>;

  /// @param picture  of this light, in any size
  explicit WhiteBalance(const Picture& picture);

  /// New value of each byte of a channel: 0 red, 1 green, 2 blue.
  const Curve& curve(std::size_t channel) const { return curves_[channel]; }

 private:
  std::array<Curve, 3> curves_{};
};

}  // namespace sinew::vision
