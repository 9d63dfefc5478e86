#include "sinew/devices/grbl/grbl_driver_positions.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew {
namespace {

/// Units: what a report rounds to, twice.
constexpr double kRounding = 1e-3;

}  // namespace

GrblPositions::GrblPositions(const GrblDevice& device) : device_(device) {
  ties_.resize(device.axes.size());
  counts_.resize(device.axes.size());
}

double GrblPositions::place(std::size_t joint, double count) const {
  return *ties_[joint].zero + device_.sign(joint) * device_.from_units(joint, count);
}

/// rad or m that a joint may be from where its count says.
double GrblPositions::slack_of(std::size_t joint) const {
  return device_.step(joint) + device_.from_units(joint, kRounding);
}

double GrblPositions::count_of(std::size_t joint, double place) const {
  return units(joint, place - *ties_[joint].zero);
}

void GrblPositions::lose() {
  for (Tie& tie : ties_) tie = {};
  left_.clear();
}

void GrblPositions::restart() {
  restarted_ = true;
  if (judged_) return lose();
  // A place that was seen, without a count, is still that place.
  for (JointPosition& joint : left_) {
    if (joint.count_zero) joint = {};
  }
}

void GrblPositions::homed() {
  for (std::size_t i = 0; i < ties_.size(); ++i) ties_[i] = {device_.axes[i].zero, true};
}

void GrblPositions::leave(std::span<const JointInterval> reach) {
  if (judged_) {
    left_.clear();
    for (std::size_t i = 0; i < ties_.size(); ++i) {
      JointPosition joint = position(i, 0);
      if (!reach.empty() && joint.quality != PositionQuality::kLost) {
        joint.quality = PositionQuality::kUncertain;
        joint.lower = std::min(joint.lower, reach[i].lower);
        joint.upper = std::max(joint.upper, reach[i].upper);
      }
      left_.push_back(joint);
    }
  }
  judged_ = restarted_ = false;
  mark_.reset();
}

void GrblPositions::declare(std::span<const JointPosition> positions) {
  SINEW_ASSERT(positions.size() == ties_.size());
  left_.clear();
  for (const JointPosition& one : positions) left_.push_back(one);
  if (judged_) {
    for (JointPosition& joint : left_) joint.count_zero.reset();
    judge();
  }
}

void GrblPositions::count(const grbl::Values& counts) {
  SINEW_ASSERT(counts.size() == ties_.size());
  counts_ = counts;
  if (!judged_) judge();
  judged_ = true;
}

/// A board that restarted counts 0 everywhere; without a mark its counts say nothing where it was
/// left at 0.
bool GrblPositions::still_counts(std::span<const JointPosition> left) const {
  bool away = false;
  for (std::size_t i = 0; i < left.size(); ++i) {
    const JointPosition& joint = left[i];
    if (!joint.count_zero) continue;
    away = away || std::abs(counts_[i]) > kRounding;
    if (joint.quality == PositionQuality::kLost) continue;
    if (joint.quality == PositionQuality::kUncertain && !mark_.value_or(true)) return false;
    const double here = *joint.count_zero + device_.sign(i) * device_.from_units(i, counts_[i]);
    const double slack = slack_of(i);
    if (here < joint.lower - slack || here > joint.upper + slack) return false;
  }
  return (away || mark_.value_or(false)) && !restarted_;
}

void GrblPositions::judge() {
  if (left_.empty()) return;
  const bool counts_on = still_counts({left_.data(), left_.size()});
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const JointPosition& joint = left_[i];
    const bool lost = joint.quality == PositionQuality::kLost;
    ties_[i] = {};
    if (joint.count_zero) {
      if (counts_on) ties_[i] = {joint.count_zero, !lost};
    } else if (!lost && joint.quality != PositionQuality::kUncertain) {
      ties_[i] = {joint.q - device_.sign(i) * device_.from_units(i, counts_[i]), true};
    }
  }
  left_.clear();
}

std::optional<std::size_t> GrblPositions::unknown() const {
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    if (!ties_[i].known) return i;
  }
  return std::nullopt;
}

std::optional<JointInterval> GrblPositions::counted(std::size_t joint) const {
  if (!judged_ || !ties_[joint].zero) return std::nullopt;
  const double here = place(joint, counts_[joint]);
  const double slack = slack_of(joint);
  return JointInterval{here - slack, here + slack};
}

std::uint8_t GrblPositions::away_from_zero() const {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (judged_ && std::abs(counts_[i]) > kRounding) bits = std::uint8_t(bits | 1U << i);
  }
  return bits;
}

JointPosition GrblPositions::position(std::size_t joint, double gone) const {
  if (!judged_ && !left_.empty()) return left_[joint];
  const Tie& tie = ties_[joint];
  if (!tie.known || !tie.zero) return {.count_zero = tie.zero};
  const double here = place(joint, counts_[joint]);
  const double slack = slack_of(joint) + gone;
  return {PositionQuality::kCommanded, here, here - slack, here + slack, tie.zero};
}

JointPosition GrblPositions::position(std::size_t joint, double gone,
                                      const JointInterval& ahead) const {
  JointPosition shown = position(joint, gone);
  if (shown.quality != PositionQuality::kCommanded) return shown;
  const double one = place(joint, ahead.lower), other = place(joint, ahead.upper);
  const double slack = slack_of(joint);
  shown.lower = std::max(shown.lower, std::min(one, other) - slack);
  shown.upper = std::min(shown.upper, std::max(one, other) + slack);
  shown.under_way = true;
  return shown;
}

}  // namespace sinew
