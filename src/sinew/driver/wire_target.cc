#include "sinew/driver/wire_target.h"

#include "sinew/core/assert.h"

namespace sinew {
namespace {

/// Further than the 256 steps in which one byte may stay the same.
constexpr int kUnitsMax = 2000;

}  // namespace

std::optional<Error> WireTarget::refusal(std::span<const double> q,
                                         std::span<const double> from) const {
  SINEW_ASSERT(q.size() == robot_.joints.size());
  return robot_.device.settings->target_refusal(robot_, q, from);
}

std::optional<JointVector> WireTarget::nearest(std::span<const double> q) const {
  JointVector near(q);
  for (std::size_t fixed = 0; fixed <= near.size(); ++fixed) {
    const auto error = refusal({near.data(), near.size()});
    if (!error) return near;
    if (error->index < 0) return std::nullopt;
    const auto joint = static_cast<std::size_t>(error->index);
    const double step = robot_.device.settings->resolution(joint);
    const double from = near[joint];
    const auto works = [&](double angle) {
      near[joint] = angle;
      if (!within_limits(robot_.joints[joint], angle)) return false;
      const auto left = refusal({near.data(), near.size()});
      return !left || left->index > error->index;
    };
    int k = 1;
    while (k <= kUnitsMax && !works(from - k * step) && !works(from + k * step)) ++k;
    if (step == 0 || k > kUnitsMax) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace sinew
