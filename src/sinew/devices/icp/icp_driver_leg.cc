#include "sinew/devices/icp/icp_driver_leg.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {
namespace {

/// Every status that tells of it clears these: the next one tells of another time.
bool tells_of_supply(const tmc222::Flags& flags) {
  return flags.vdd_reset || flags.under_voltage || flags.charge_pump_failure;
}

}  // namespace

IcpLegClaim::IcpLegClaim(std::int8_t index, const IcpLeg& leg, double units_per_m,
                         std::int64_t units_per_down)
    : index_(index),
      invert_(leg.invert),
      address_(leg.address),
      units_per_m_(units_per_m),
      units_per_down_(units_per_down) {
  SINEW_ASSERT(units_per_m > 0 && (units_per_down == 1 || units_per_down == 2));
}

void IcpLegClaim::declare(const JointPosition& position) {
  known_ = position.quality != PositionQuality::kLost && std::isfinite(position.q);
  origin_ = known_ ? position.q : 0;
  units_ = 0;
  below_ = 0;
  above_ = 0;
  if (known_ && position.quality == PositionQuality::kUncertain) {
    const auto units = [&](double way) {
      return static_cast<std::int64_t>(std::ceil(std::max(0.0, way) * units_per_m_));
    };
    below_ = units(position.q - position.lower);
    above_ = units(position.upper - position.q);
  }
  const double open = std::max(position.q - position.lower, position.upper - position.q);
  const bool wide = known_ && position.quality == PositionQuality::kCommanded && open > 0;
  slack_ = wide ? std::max<std::int64_t>(0, std::llround(open * units_per_m_) - 1) : 0;
  hull_lower_ = -below_;
  hull_upper_ = above_;
  suspected_ = false;
  confirmed_ = false;
  withdrawn_ = false;
  moved_ = false;
  unseen_ = {};
}

void IcpLegClaim::declare_standing(const JointPosition& position) {
  // Where it was let go of before, it may be on the hill still.
  on_hill_ = on_hill_ || suspected_;
  declare(position);
  if (known_ && on_hill_) slack_ = std::max(slack_, kHillUnits);
}

std::int64_t IcpLegClaim::lower() const {
  const std::int64_t plain = units_ - below_;
  return suspected_ ? std::min(plain, hull_lower_ - kPowerCutUnits) : plain;
}

std::int64_t IcpLegClaim::upper() const {
  const std::int64_t plain = units_ + above_;
  return suspected_ ? std::max(plain, hull_upper_ + kPowerCutUnits) : plain;
}

JointPosition IcpLegClaim::position() const {
  if (!known_) return {};
  const auto at = [&](std::int64_t units) {
    return origin_ + static_cast<double>(units) / units_per_m_;
  };
  if (uncertainty() == 0) {
    const std::int64_t open = slack_ + 1;
    return {PositionQuality::kCommanded, at(units_), at(units_ - open), at(units_ + open)};
  }
  return {PositionQuality::kUncertain, at(units_), at(lower() - slack_), at(upper() + slack_)};
}

std::int64_t IcpLegClaim::steps_to(double q) const {
  const std::int64_t way = std::llround((q - origin_) * units_per_m_) - units_;
  return way / size_of(way < 0 ? -1 : 1);
}

double IcpLegClaim::way_of(std::int64_t steps) const {
  return static_cast<double>(steps * size_of(steps < 0 ? -1 : 1)) / units_per_m_;
}

void IcpLegClaim::grow_hull() {
  hull_lower_ = std::min(hull_lower_, units_ - below_);
  hull_upper_ = std::max(hull_upper_, units_ + above_);
}

void IcpLegClaim::stepped(int direction) {
  units_ += direction * size_of(direction);
  last_direction_ = direction;
  tag_ = size_of(direction);
  last_maybe_ = false;
  moved_ = true;
  withdrawn_ = false;
  ++unseen_[wire_bit(direction) ? 1 : 0];
  grow_hull();
}

void IcpLegClaim::maybe_stepped(int direction) {
  const std::int64_t size = size_of(direction);
  units_ += direction * size;
  (direction > 0 ? below_ : above_) += size;
  if (tag_ == 0) last_direction_ = direction;
  last_maybe_ = true;
  moved_ = true;
  withdrawn_ = false;
  ++unseen_[wire_bit(direction) ? 1 : 0];
  grow_hull();
}

void IcpLegClaim::status_lost() {
  if (!moved_) return;
  (last_direction_ > 0 ? below_ : above_) += size_of(last_direction_);
}

IcpLegClaim::Verdict IcpLegClaim::judge(const icp::Status& status, Error& error) const {
  const tmc222::Flags& flags = status.one.flags;
  if (flags.thermal_shutdown) {
    error = {ErrorCode::kOverheated, index_};
    return Verdict::kBad;
  }
  error = {tells_of_supply(flags) ? ErrorCode::kSupplyFlag : ErrorCode::kMotionIgnored, index_};
  if (flags.vdd_reset || flags.step_loss || flags.electrical_defect || flags.under_voltage ||
      flags.over_current_1 || flags.over_current_2 || flags.charge_pump_failure) {
    return Verdict::kBad;
  }
  const bool right_module = address_ == 0 || status.one.address == address_;
  const bool at_rest =
      status.one.motion == tmc222::Motion::kAtTarget && status.two.actual == status.two.target;
  if (status.one.parameters != icp::kMotorParameters) {
    // Its firmware writes them when it is switched on, and never again.
    error = {ErrorCode::kSupplyFlag, index_};
    return Verdict::kDoubtful;
  }
  if (!right_module || !at_rest) return Verdict::kDoubtful;
  const std::int64_t tag = std::abs(std::int64_t{status.two.target});
  if (forgot(status)) {
    error = {ErrorCode::kSupplyFlag, index_};
    return Verdict::kDoubtful;
  }
  // Where the last step is in doubt, either size may stand there, and 0 before the first.
  const bool either = tag == 1 || tag == units_per_down_ || (tag == 0 && tag_ == 0);
  if (tag == tag_ || (last_maybe_ && either) || (!last_maybe_ && tag_ == 0)) return Verdict::kGood;
  if (tag != 0) {
    error = {ErrorCode::kReplyMismatch, index_, static_cast<double>(tag),
             static_cast<double>(tag_ != 0 ? tag_ : 1)};
  }
  return Verdict::kDoubtful;
}

/// A run before left it with a target position, and the power-up since took that.
bool IcpLegClaim::forgot(const icp::Status& status) const {
  return counted_ && tag_ == 0 && status.two.target == 0;
}

bool IcpLegClaim::shows_supply_loss(const icp::Status& status) const {
  const bool told = tells_of_supply(status.one.flags);
  const bool forgotten = (tag_ != 0 && status.two.target == 0) || forgot(status);
  return told || forgotten || status.one.parameters != icp::kMotorParameters;
}

void IcpLegClaim::round_passed() {
  if (std::exchange(suspected_, false) && withdrawn_) widen_by_power_cut();
  if (!std::exchange(confirmed_, false)) return;
  hull_lower_ = units_ - below_;
  hull_upper_ = units_ + above_;
}

void IcpLegClaim::confirm(const icp::Status& status) {
  // The hull stays until the round has ended: another leg may still tell of the supply.
  confirmed_ = true;
  if (moved_ && !last_maybe_) on_hill_ = false;
  if (moved_ && !last_maybe_) unseen_[wire_bit(last_direction_) ? 1 : 0] = 0;
  moved_ = false;
  // From before this program, or from a step that may have been made: it stays until it is lost.
  tag_ = std::abs(std::int64_t{status.two.target});
  counted_ = false;
  last_maybe_ = false;
}

void IcpLegClaim::widen(std::int64_t lower, std::int64_t upper) {
  below_ = std::max(below_, units_ - lower);
  above_ = std::max(above_, upper - units_);
}

void IcpLegClaim::widen_by_power_cut() {
  widen(hull_lower_ - kPowerCutUnits, hull_upper_ + kPowerCutUnits);
  hull_lower_ = units_ - below_;
  hull_upper_ = units_ + above_;
}

void IcpLegClaim::withdraw(const icp::Status& status) {
  // A module that counts otherwise than was thought did so at every step that no status has shown.
  const std::int64_t tag = std::abs(std::int64_t{status.two.target});
  if (tag_ != 0 && tag != 0 && tag != tag_) {
    const std::int64_t more =
        (tag - tag_) * last_direction_ * unseen_[wire_bit(last_direction_) ? 1 : 0];
    hull_lower_ = std::min(hull_lower_, hull_lower_ + more);
    hull_upper_ = std::max(hull_upper_, hull_upper_ + more);
  }
  on_hill_ = true;
  const bool again = tells_of_supply(status.one.flags) || suspected_;
  if (!std::exchange(withdrawn_, true) || again) widen_by_power_cut();
  suspected_ = false;
  confirmed_ = false;
  moved_ = false;
  // What the module holds now is where the next comparison starts.
  tag_ = 0;
  counted_ = false;
  last_maybe_ = false;
}

}  // namespace sinew
