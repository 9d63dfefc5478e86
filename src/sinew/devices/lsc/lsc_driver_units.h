#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/driver/send_range.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// rad, the most that a servo is off its target at rest: dead band, and sag under the arm's weight.
inline constexpr double kServoSlack = 0.06;

/// Joint angles and jaw width in a servo board's units, and back. Servos are counted as slots: the
/// joints in their order, and behind them the jaws where the robot has any. @rt
class LscUnits {
 public:
  /// @param joints  one per servo of the device, asserted.
  LscUnits(const LscDevice& device, std::span<const Joint> joints,
           const std::optional<JawGripper>& gripper);

  std::size_t joints() const { return joints_.size(); }
  std::size_t slots() const { return joints_.size() + (gripper_ ? 1U : 0U); }
  std::optional<std::size_t> jaws() const;
  std::uint8_t id(std::size_t slot) const;
  std::optional<std::size_t> slot_of(std::uint8_t id) const;

  /// units = centre + trim + units_per_rad q, to the nearest. From beyond a limit every place on
  /// the way back that the wire has words for.
  /// @param range  where it may be sent
  /// @error kJointLimit (also not a number), kPulseRange
  Expected<std::uint16_t> of_joint(std::size_t joint, double q, const SendRange& range) const;
  Expected<std::uint16_t> of_joint(std::size_t joint, double q) const {
    return of_joint(joint, q, joints_[joint]);
  }
  /// So many units beside `units`, as far as the joint's limits and its servo allow.
  std::uint16_t beside(std::size_t joint, std::uint16_t units, double more) const;
  /// @param width  m; @error kToolNotFitted, kGripperRange (also not a number)
  Expected<std::uint16_t> of_width(double width) const;

  double q_of(std::size_t joint, double units) const;
  /// m between the jaws, of a robot that has some.
  double width_of(double units) const;
  /// Inside the joint's limits, as closely as the servo can tell.
  bool inside(std::size_t joint, double q) const;
  /// Where it may be sent from `here`: from beyond a limit also to where it was told to be there.
  SendRange range_from(std::size_t joint, const JointPosition& here) const;
  /// rad that one unit is.
  double resolution(std::size_t joint) const;
  /// Units per s that the model allows a joint.
  double speed_max(std::size_t joint) const;
  /// Units from open to closed jaws.
  double stroke() const;

 private:
  LscDevice device_;
  FixedVector<Joint, kMaxJoints> joints_;
  std::optional<JawGripper> gripper_;
};

}  // namespace sinew
