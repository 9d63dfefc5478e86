#include "support/robot_promises.h"

#include <cmath>
#include <set>

#include "sinew/core/units.h"
#include "support/visit_kind.h"

namespace sinew::test {
namespace {

bool finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool unit(const Vec3& v) {
  return std::abs(norm(v) - 1) < 1e-12;
}
bool positive(double value) {
  return std::isfinite(value) && value > 0;
}
bool proper(const Rotation& R) {
  return unit(R.x) && unit(R.y) && unit(R.z) && norm(cross(R.x, R.y) - R.z) < 1e-12;
}

std::string broken(const SerialGeometry& geometry) {
  if (geometry.rows.empty()) return "chain without rows";
  for (const DhRow& row : geometry.rows) {
    if (!finite({row.d, row.a, row.alpha}) || !std::isfinite(row.theta_offset)) return "DH row";
  }
  if (!proper(geometry.X_FT.R) || !finite(geometry.X_FT.p)) return "tool pose";
  if (const auto& gripper = geometry.gripper) {
    if (!positive(gripper->width_max)) return "gripper width";
    if (!std::isfinite(gripper->reach_open + gripper->reach_closed)) return "gripper reach";
  }
  return geometry.pitch_preferred >= 0 && geometry.pitch_preferred <= kPi ? "" : "pitch";
}

std::string broken(const PalletizerGeometry& geometry) {
  if (!positive(geometry.upper_arm) || !positive(geometry.forearm)) return "palletizer link";
  const double sum = geometry.base_height + geometry.shoulder_offset + geometry.tool_offset;
  if (!std::isfinite(sum) || !std::isfinite(geometry.base_front)) return "palletizer offset";
  return geometry.radius_min >= 0 ? "" : "palletizer radius";
}

std::string broken(const HexapodGeometry& geometry) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!finite(geometry.p_BA[i]) || !finite(geometry.p_PA[i])) return "anchor";
    if (!unit(geometry.motor_axis_B[i]) || !unit(geometry.skewer_axis_P[i])) return "axis";
  }
  if (!positive(geometry.cardan_angle_max) || !positive(geometry.ball_angle_max)) return "cone";
  if (!positive(geometry.condition_max) || geometry.condition_max < 1 ||
      !positive(geometry.platform_radius))
    return "condition";
  return proper(geometry.X_BP_home.R) ? "" : "home pose";
}

std::size_t joints_of(const Geometry& geometry) {
  if (const auto* serial = std::get_if<SerialGeometry>(&geometry)) return serial->rows.size();
  return std::holds_alternative<PalletizerGeometry>(geometry) ? 3 : kLegs;
}

std::string broken(const BigRobotArmDevice& device) {
  for (const BigRobotArmJoint& joint : device.joints) {
    if (!positive(std::abs(joint.steps_per_rad))) return "steps per rad";
    if (!positive(joint.steps_per_motor_rev)) return "steps per motor rev";
    if (joint.multiplier_boot < 1 || joint.multiplier_boot > device.multiplier_max) {
      return "multiplier";
    }
  }
  return "";
}

std::string broken(const ArmLinkDevice& device) {
  if (device.deadline < std::chrono::milliseconds(20)) return "deadline";
  return broken(device.arm);
}

std::string broken(const LscDevice& device) {
  std::set<int> ids{device.gripper.id};
  for (const LscServo& servo : device.servos) {
    if (!positive(std::abs(servo.units_per_rad))) return "units per rad";
    if (servo.lower >= servo.upper || servo.lower < 0) return "pulse range";
    if (!std::isfinite(servo.centre + servo.trim)) return "centre";
    if (!ids.insert(servo.id).second) return "servo id";
  }
  return device.gripper.open != device.gripper.closed ? "" : "gripper";
}

std::string broken(const MaxArmDevice& device) {
  for (const MaxArmServo& servo : device.servos) {
    if (!positive(std::abs(servo.pulses_per_rad)) || !std::isfinite(servo.offset)) return "pulses";
  }
  return "";
}

std::string broken(const IcpDevice& device) {
  if (!positive(device.units_per_m) || device.tries < 1) return "units per m";
  return device.units_per_down >= 1 && device.units_per_down <= 2 ? "" : "units per down";
}

template <class Boards>
std::string broken_boards(const Boards& boards, std::uint32_t clock_hz) {
  std::set<int> selects;
  for (const AxisBoard& board : boards) {
    if (!selects.insert(board.select_gpio).second) return "chip select";
    if (!std::isfinite(board.zero)) return "zero";
  }
  return clock_hz > 0 ? "" : "clock";
}
std::string broken(const AxisRegistersDevice& device) {
  return broken_boards(device.boards, device.clock_hz);
}
std::string broken(const AxisLinkDevice& device) {
  if (device.deadline < std::chrono::milliseconds(20)) return "deadline";
  return broken_boards(device.boards, device.clock_hz);
}
std::string broken(const GrblDevice& device) {
  if (device.axes.empty()) return "axes";
  for (const GrblDevice::Axis& axis : device.axes) {
    if (!(std::abs(axis.steps_per_unit) > 0) || !std::isfinite(axis.steps_per_unit)) return "steps";
    if (!std::isfinite(axis.zero)) return "machine zero";
  }
  return "";
}

std::string broken(const FeetechDevice& device) {
  std::set<int> ids;
  for (const FeetechDevice::Servo& servo : device.servos) {
    if (!ids.insert(servo.id).second) return "servo id";
    if (std::abs(servo.sign) != 1) return "sign";
    if (!(servo.centre >= 0 && servo.centre <= device.units_max())) return "centre";
    if (!(servo.torque_limit > 0 && servo.torque_limit <= 1)) return "torque limit";
  }
  return device.gripper.open != device.gripper.closed ? "" : "gripper";
}

std::string broken(const IdealDevice& /*device*/) {
  return "";
}

std::string broken_form(const Capsule& capsule) {
  return finite(capsule.p_LA) && finite(capsule.p_LB) && positive(capsule.radius) ? "" : "capsule";
}
std::string broken_form(const CollisionBox& box) {
  const bool sized = positive(box.half.x) && positive(box.half.y) && positive(box.half.z);
  return sized && proper(box.X_LX.R) && finite(box.X_LX.p) ? "" : "box";
}
std::string broken_form(const LegCapsule& leg) {
  return positive(leg.radius) ? "" : "leg's radius";
}

std::string broken_form(const JawFinger& finger) {
  const Vec3& half = finger.half;
  const bool sized = positive(half.x) && positive(half.y) && positive(half.z);
  return sized && std::abs(finger.side) == 1 ? "" : "finger";
}
std::string broken_form(const HeldBall& /*ball*/) {
  return "";
}

std::string broken(const Collision& collision, std::size_t links, bool legs) {
  if (collision.shapes.size() > kCollisionShapesMax) return "number of shapes";
  if (!std::isfinite(collision.margin) || collision.margin < 0) return "margin";
  if (!std::isfinite(collision.table_height.value_or(0))) return "table";
  for (const CollisionShape& shape : collision.shapes) {
    if (shape.link >= links) return "link of a shape";
    const bool on_leg = legs && shape.link >= 1 && shape.link <= kLegs;
    if (on_leg != std::holds_alternative<LegCapsule>(shape.form)) return "shape of a leg";
    const std::string form = std::visit([](const auto& is) { return broken_form(is); }, shape.form);
    if (!form.empty()) return form;
  }
  for (const LinkPair& pair : collision.ignored) {
    for (const std::size_t link : {pair.first, pair.second}) {
      if (link >= links && link != kTableLink) return "ignored link";
    }
  }
  return "";
}

/// How many joints the device has settings for.
template <class Settings>
std::size_t joints_of_device(const Settings& settings, std::size_t joints) {
  if constexpr (requires { settings.boards; }) return settings.boards.size();
  if constexpr (requires { settings.servos; }) return settings.servos.size();
  if constexpr (requires { settings.legs; }) return settings.legs.size();
  if constexpr (requires { settings.joints; }) return settings.joints.size();
  return joints;
}

}  // namespace

std::string broken_promise(const RobotModel& model) {
  if (model.id.empty() || model.title.empty()) return "id or title";
  if (model.joints.size() != joints_of(model.geometry)) return "number of joints";
  std::set<std::string> names;
  for (const Joint& joint : model.joints) {
    if (joint.name.empty() || !names.insert(joint.name).second) return "name " + joint.name;
    const bool ordered = joint.lower < joint.upper;  // false for NaN, too
    if (!ordered) return "limits of " + joint.name;
    const bool home_inside = joint.home >= joint.lower && joint.home <= joint.upper;
    if (!home_inside) return "home of " + joint.name;
    if (!positive(joint.velocity_max) || !positive(joint.acceleration_max) ||
        !positive(joint.jerk_max)) {
      return "maxima of " + joint.name;
    }
  }
  std::string device = visit_kind(
      [&](const auto& settings) -> std::string {
        const std::size_t joints = model.joints.size();
        if (joints_of_device(settings, joints) != joints) return "joints of the device";
        return broken(settings);
      },
      model.device.settings);
  if (!device.empty()) return device;
  const bool legs = std::holds_alternative<HexapodGeometry>(model.geometry);
  const std::string body = broken(model.collision, model.joints.size() + 2, legs);
  if (!body.empty()) return body;
  return std::visit([](const auto& geometry) { return broken(geometry); }, model.geometry);
}

}  // namespace sinew::test
