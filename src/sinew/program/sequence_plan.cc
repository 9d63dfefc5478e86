#include "sinew/program/sequence_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "sinew/driver/bigrobotarm_multipliers.h"
#include "sinew/wire/bigrobotarm_byte.h"

namespace sinew::sequence {
namespace {

/// Above this the device reports positions wrongly.
constexpr double kStepMax = (1 << 24) - 1;

Error joint_error(ErrorCode code, std::size_t joint, double measured, double limit) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

/// Follows a program with the device's state in mind and writes the orders down.
class Planner {
 public:
  Planner(const RobotModel& robot, const DeviceState& start)
      : robot_(robot),
        device_(std::get<BigRobotArmDevice>(robot.device.settings)),
        positions_(start.positions),
        wanted_{start.speeds, start.accelerations},
        set_(wanted_) {}

  std::optional<Error> add(const Step& step, int round, int rounds) {
    line_ = step.line;
    round_ = round;
    rounds_ = rounds;
    return std::visit([this](const auto& command) { return take(command); }, step.command);
  }

  std::size_t orders() const { return plan_.orders.size(); }

  Plan finish() {
    if (const auto error = set_multipliers(wanted_)) return plan_;  // they were accepted before
    return std::move(plan_);
  }

 private:
  template <class What>
  void order(const What& what) {
    plan_.orders.push_back({line_, round_, rounds_, what, wanted_, set_});
  }

  static Words overlay(Words base, const GivenWords& given) {
    std::copy_n(given.words.begin(), given.count, base.begin());
    return base;
  }

  BigRobotArmAngles angles(const Words& steps) const {
    BigRobotArmAngles q;
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      q[i] = static_cast<double>(zero_[i] + steps[i]) / device_.joints[i].steps_per_rad;
    }
    return q;
  }

  bool byte_wire() const { return device_.wire == BigRobotArmWire::kByte; }

  /// Nothing, or why the joint may not go to `steps`.
  std::optional<Error> check_place(std::size_t i, std::int32_t steps) const {
    const Joint& joint = robot_.joints[i];
    const double per_rad = device_.joints[i].steps_per_rad;
    const double q = static_cast<double>(zero_[i] + steps) / per_rad;
    // Whole steps are coarser than the limit's rounding: half a step is still on the limit.
    const double half_step = 0.5 / std::abs(per_rad);
    if (q < joint.lower - half_step) return joint_error(ErrorCode::kJointLimit, i, q, joint.lower);
    if (q > joint.upper + half_step) return joint_error(ErrorCode::kJointLimit, i, q, joint.upper);
    if (std::abs(steps) >= kStepMax) return joint_error(ErrorCode::kStepRange, i, steps, kStepMax);
    if (byte_wire() && !bigrobotarm::byte::sendable(steps)) {
      return joint_error(ErrorCode::kUnsendable, i, steps, 0);
    }
    return {};
  }

  std::optional<Error> take(const Move& move) {
    return move_to(overlay(positions_, move.steps), false);
  }
  std::optional<Error> take(const Home&) { return move_to(Words{}, true); }

  std::optional<Error> take(const Reset&) {
    order(ResetOrder{});
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) zero_[i] += positions_[i];
    positions_ = {};
    return {};
  }
  std::optional<Error> take(const Speeds& speeds) {
    wanted_.speeds = overlay(wanted_.speeds, speeds.multipliers);
    return set_multipliers(wanted_);
  }
  std::optional<Error> take(const Accelerations& accelerations) {
    wanted_.accelerations = overlay(wanted_.accelerations, accelerations.multipliers);
    return set_multipliers(wanted_);
  }
  std::optional<Error> take(const Gripper& gripper) {
    if (gripper.position < 0 || gripper.position > device_.gripper_max) {
      return Error{ErrorCode::kGripperRange, -1, 1.0 * gripper.position, 1.0 * device_.gripper_max};
    }
    if (byte_wire() && !bigrobotarm::byte::sendable(gripper.position)) {
      return Error{ErrorCode::kUnsendable, -1, 1.0 * gripper.position};
    }
    order(GripperOrder{gripper.enabled, gripper.position});
    return {};
  }
  std::optional<Error> take(const Synchronise& synchronise) {
    synchronise_ = synchronise.on;
    return synchronise_ ? std::nullopt : set_multipliers(wanted_);
  }

  /// Orders only what differs from what the device has.
  std::optional<Error> set_multipliers(const BigRobotArmMultipliers& multipliers) {
    if (multipliers.speeds != set_.speeds) {
      if (const auto fine = check_multipliers(device_, multipliers.speeds); !fine) {
        return fine.error();
      }
      set_.speeds = multipliers.speeds;
      order(SpeedsOrder{multipliers.speeds});
    }
    if (multipliers.accelerations != set_.accelerations) {
      if (const auto fine = check_multipliers(device_, multipliers.accelerations); !fine) {
        return fine.error();
      }
      set_.accelerations = multipliers.accelerations;
      order(AccelerationsOrder{multipliers.accelerations});
    }
    return {};
  }

  std::optional<Error> move_to(const Words& asked, bool home) {
    Words target = asked;
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      const auto error = check_place(i, asked[i]);
      if (error && error->code != ErrorCode::kUnsendable) return error;
      if (!error) continue;
      const std::int32_t side = check_place(i, asked[i] + 1) ? -1 : 1;
      if (check_place(i, asked[i] + side)) return error;
      target[i] = asked[i] + side;
    }
    if (synchronise_) {
      if (const auto error = scale_multipliers(target)) return error;
    }
    if (const auto error = check_settings(target)) return error;
    MoveOrder move = predict(target);
    move.q_asked = angles(asked);
    move.home = home;
    plan_.duration += move.duration;
    ++plan_.moves;
    order(move);
    positions_ = target;
    return {};
  }

  /// Another host may have left the device with settings that freeze it or race: a joint that is to
  /// move has to have sane ones.
  std::optional<Error> check_settings(const Words& target) const {
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      if (target[i] == positions_[i]) continue;
      for (const std::int32_t value : {set_.speeds[i], set_.accelerations[i]}) {
        if (value >= 1 && value <= device_.multiplier_max) continue;
        return joint_error(ErrorCode::kMultiplierRange, i, value, device_.multiplier_max);
      }
    }
    return {};
  }

  /// So that all joints arrive together.
  std::optional<Error> scale_multipliers(const Words& target) {
    Words deltas;
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      const std::int64_t delta = std::int64_t{target[i]} - positions_[i];
      // Only a device that reports nonsense is so far away.
      if (std::abs(delta) > std::numeric_limits<std::int32_t>::max()) {
        return joint_error(ErrorCode::kStepRange, i, positions_[i], kStepMax);
      }
      deltas[i] = static_cast<std::int32_t>(delta);
    }
    const auto scaled = synchronised_multipliers(device_, deltas, wanted_);
    if (!scaled) return scaled.error();
    return set_multipliers(*scaled);
  }

  MoveOrder predict(const Words& target) const {
    MoveOrder move{
        .q_start = angles(positions_), .q = angles(target), .q_asked = {}, .profiles = {}};
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      if (target[i] == positions_[i]) continue;
      const BigRobotArmJoint& joint = device_.joints[i];
      const double unit = joint.steps_per_motor_rev / 100 / std::abs(joint.steps_per_rad);
      move.profiles[i] = motion::Trapezoid(move.q[i] - move.q_start[i], set_.speeds[i] * unit,
                                           set_.accelerations[i] * unit);
      move.duration = std::max(move.duration, move.profiles[i].duration());
    }
    return move;
  }

  const RobotModel& robot_;
  const BigRobotArmDevice& device_;
  Words positions_;
  /// The device's zero, in steps from the first one.
  std::array<std::int64_t, kBigRobotArmJoints> zero_{};
  BigRobotArmMultipliers wanted_;
  BigRobotArmMultipliers set_;
  bool synchronise_ = false;
  int line_ = 0;
  int round_ = 1;
  int rounds_ = 1;
  Plan plan_;
};

}  // namespace

DeviceState boot_state(const BigRobotArmDevice& device) {
  DeviceState state;
  for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
    state.speeds[i] = device.joints[i].multiplier_boot;
    state.accelerations[i] = device.joints[i].multiplier_boot;
  }
  return state;
}

std::expected<Plan, PlanRefusal> make_plan(const Program& program, const RobotModel& robot,
                                           const DeviceState& start) {
  Planner planner(robot, start);
  for (const Section& section : program.sections) {
    for (int round = 1; round <= section.repeats; ++round) {
      for (const Step& step : section.steps) {
        if (const auto error = planner.add(step, round, section.repeats)) {
          return std::unexpected(PlanRefusal{step.line, *error});
        }
        if (planner.orders() > kOrdersMax) {
          return std::unexpected(PlanRefusal{
              step.line, {ErrorCode::kProgramTooLong, -1, 1.0 * kOrdersMax, 1.0 * kOrdersMax}});
        }
      }
    }
  }
  return planner.finish();
}

}  // namespace sinew::sequence
