#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sinew/vision/picture.h"
#include "sinew/vision/reused_memory.h"

namespace sinew::vision {

/// CIE L*a*b*, D65: lightness 0 to 100, a from green to red, b from blue to yellow.
struct Lab {
  float L = 0;
  float a = 0;
  float b = 0;
};
/// How far two colours are apart (CIE76).
float distance(const Lab& one, const Lab& other);

/// A picture in L*a*b*, converted tile by tile on first access.
class LabPicture {
 public:
  /// @param picture  outlives this
  explicit LabPicture(const Picture& picture);

  int width() const { return picture_.width; }
  int height() const { return picture_.height; }
  /// @pre inside. From one thread.
  Lab at(int x, int y) const {
    const std::size_t tile = tile_at(x / kTile, y / kTile);
    if (is_filled_[tile] == 0) fill(x / kTile, y / kTile);
    const float* value = &values_[3 * pixel_at(x, y)];
    return {value[0], value[1], value[2]};
  }

 private:
  static constexpr int kTile = 32;  // px

  std::size_t tile_at(int i, int j) const { return static_cast<std::size_t>(j * across_ + i); }
  std::size_t pixel_at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
           static_cast<std::size_t>(x);
  }
  void fill(int i, int j) const;

  const Picture& picture_;
  int across_;  ///< tiles
  mutable std::vector<std::uint8_t> is_filled_;
  mutable std::vector<float, ReusedMemory<float>> values_;
};

}  // namespace sinew::vision
