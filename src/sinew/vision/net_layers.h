#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/vision/reused_memory.h"

namespace sinew::vision {

/// Planes of numbers: what a layer of a network gives to the next.
struct Maps {
  int channels = 0;
  int height = 0;
  int width = 0;
  /// Plane by plane, row by row; and some beyond, which count nothing.
  std::vector<float, ReusedMemory<float>> values;

  /// Of any values.
  Maps(int channels_count, int rows, int columns);

  std::ptrdiff_t plane() const { return static_cast<std::ptrdiff_t>(height) * width; }
  float* row(int channel, int y) { return values.data() + channel * plane() + y * width; }
  const float* row(int channel, int y) const {
    return values.data() + channel * plane() + y * width;
  }
  float at(int channel, int x, int y) const { return row(channel, y)[x]; }
};

/// Weights of a network in the order in which its layers take them: half floats, little end first.
class Weights {
 public:
  explicit Weights(std::span<const std::uint8_t> file) : left_(file) {}

  /// @pre so many are left
  std::vector<float> take(std::size_t count);
  bool is_empty() const { return left_.empty(); }

 private:
  std::span<const std::uint8_t> left_;
};

/// What a negative result becomes.
enum class Clip : bool { kNone, kZero };

/// 3 x 3 filters over all channels, every second column and row. Outside there are zeros.
Maps halved(const Maps& in, int channels, Weights& weights);
/// 3 x 3 filters, one for each channel.
Maps filtered(const Maps& in, Weights& weights);
/// Sums of the channels with weights of their own.
Maps mixed(const Maps& in, int channels, Clip clip, Weights& weights);
/// Adds mixed() of filtered() with as many channels; negative sums become zero. Takes the weights
/// of the filters, then those of the mix.
void refine(Maps& maps, Weights& weights);
/// Each number four times, and added to `to`. @pre `to` has twice the rows and columns
void add_doubled(const Maps& in, Maps& to);

}  // namespace sinew::vision
