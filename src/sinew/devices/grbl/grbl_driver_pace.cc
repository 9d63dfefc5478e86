#include "sinew/devices/grbl/grbl_driver_pace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew {

double GrblPace::line_duration(const grbl::Values& way, double peak, double duration, bool rest) {
  SINEW_ASSERT(way.size() == acceleration_.size() && duration > 0);
  double length = 0;
  for (const double one : way) length += one * one;
  length = std::sqrt(length);
  SINEW_ASSERT(length > 0);
  double acceleration = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < way.size(); ++i) {
    const double share = std::abs(way[i]) / length;
    if (share > 0) acceleration = std::min(acceleration, acceleration_[i] / share);
  }
  double turn = 0;  // < 0: back
  for (std::size_t i = 0; i < way_.size(); ++i) turn += way[i] * way_[i];
  const auto late_at = [&](double v) {
    const double change = v - before_;
    const double lost = turn < 0 ? (before_ + v) / (2 * acceleration)
                                 : change * change / (2 * acceleration * std::max(v, before_));
    return late_ + length / v + lost + (rest ? v / (2 * acceleration) : 0) - duration;
  };
  const double mean = length / duration;
  double slow = mean;
  // A piece that turns back is short for its speed: half of its time has to stay.
  double fast = std::clamp(peak, mean, 2 * mean);
  if (late_at(slow) <= 0) {
    fast = slow;
  } else if (late_at(fast) < 0) {
    constexpr int kHalvings = 20;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (slow + fast) / 2;
      (late_at(middle) > 0 ? slow : fast) = middle;
    }
  }
  late_ = late_at(fast);
  before_ = fast;
  way_ = way;
  return length / fast;
}

}  // namespace sinew
