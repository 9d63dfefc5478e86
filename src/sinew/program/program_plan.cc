#include "sinew/program/program_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sinew/core/units.h"

namespace sinew::program {
namespace {

constexpr double kFirstMoveSpeed = 0.1;  // of a joint's top speed
constexpr double kFirstMoveMin = 2;      // s

constexpr std::size_t kTurnsMax = 4 * kOrdersMax;

Error too_long() {
  constexpr auto kMax = static_cast<double>(kOrdersMax);
  return {ErrorCode::kProgramTooLong, -1, kMax + 1, kMax};
}

/// What this robot's tool cannot do; nothing where it can.
std::optional<Error> tool_refusal(const RobotModel& robot, const ToolAction& action) {
  const auto& settings = robot.device.settings;
  constexpr double kNozzleMax = kPi / 2;  // either way: 500 to 2500 us
  constexpr double kTolerance = 1e-9;
  if (const auto* jaws = std::get_if<JawsTo>(&action)) {
    const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
    const bool fitted =
        geometry != nullptr && geometry->gripper && std::holds_alternative<LscDevice>(settings);
    if (!fitted) return Error{ErrorCode::kToolNotFitted};
    const double widest = geometry->gripper->width_max;
    if (jaws->width >= 0 && jaws->width <= widest + kTolerance) return std::nullopt;
    return Error{ErrorCode::kJawWidth, -1, jaws->width, widest};
  }
  if (const auto* gripper = std::get_if<GripperTo>(&action)) {
    const auto* device = std::get_if<BigRobotArmDevice>(&settings);
    if (device == nullptr) return Error{ErrorCode::kToolNotFitted};
    const double widest = from_deg(device->gripper_max);
    const bool fine = gripper->angle >= 0 && gripper->angle <= widest + kTolerance;
    if (!gripper->enabled || fine) return std::nullopt;
    return Error{ErrorCode::kToolAngle, -1, gripper->angle, gripper->angle < 0 ? 0 : widest};
  }
  if (!std::holds_alternative<MaxArmDevice>(settings)) return Error{ErrorCode::kToolNotFitted};
  const auto* nozzle = std::get_if<NozzleTo>(&action);
  if (nozzle == nullptr || std::abs(nozzle->angle) <= kNozzleMax + kTolerance) return std::nullopt;
  return Error{ErrorCode::kToolAngle, -1, nozzle->angle, std::copysign(kNozzleMax, nozzle->angle)};
}

/// Only axis boards have end stops, and only those that report can say that they were found.
bool can_home(const RobotModel& robot) {
  const auto* registers = std::get_if<AxisRegistersDevice>(&robot.device.settings);
  if (registers != nullptr) return registers->reports_status;
  return std::holds_alternative<AxisLinkDevice>(robot.device.settings);
}

class Planner {
 public:
  Planner(const RobotModel& robot, const Start& start, const HomingTimes& homing)
      : robot_(robot), q_(start), homing_(std::accumulate(homing.begin(), homing.end(), 0.0)) {}

  std::optional<Refusal> take(const Step& step, int round, int rounds) {
    if (plan_.orders.size() >= kOrdersMax) {
      return Refusal{step.line, too_long()};
    }
    Order order{step.line, round, rounds, HomeOrder{homing_}};
    if (const auto* joint = std::get_if<JointStep>(&step.what)) {
      auto move = plan_move(*joint);
      if (!move) return Refusal{step.line, move.error()};
      plan_.duration += move->duration;
      q_ = move->q;
      order.what = *move;
    } else if (const auto* wait = std::get_if<WaitStep>(&step.what)) {
      plan_.duration += to_seconds(wait->duration);
      order.what = WaitOrder{wait->duration};
    } else if (const auto* tool = std::get_if<ToolStep>(&step.what)) {
      if (const auto refusal = tool_refusal(robot_, tool->action)) {
        return Refusal{step.line, *refusal};
      }
      order.what = ToolOrder{tool->action};
    } else {
      if (!can_home(robot_)) return Refusal{step.line, Error{ErrorCode::kNoEndStops}};
      plan_.homing_max += homing_;
      q_.emplace();
      for (const Joint& homed : robot_.joints) q_->push_back(homed.home);
    }
    plan_.orders.push_back(order);
    return std::nullopt;
  }

  Plan& plan() { return plan_; }

 private:
  std::expected<MoveOrder, Error> plan_move(const JointStep& step) const {
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const bool given = (step.given >> i & 1) != 0;
      const auto index = static_cast<std::int8_t>(i);
      if (!given) {
        if (!q_) return std::unexpected(Error{ErrorCode::kPositionUnknown, index});
        continue;
      }
      const Joint& joint = robot_.joints[i];
      if (within_limits(joint, step.q[i])) continue;
      const double limit = step.q[i] < joint.lower ? joint.lower : joint.upper;
      const bool leg = joint.kind == JointKind::kPrismatic;
      return std::unexpected(
          Error{leg ? ErrorCode::kLegLength : ErrorCode::kJointLimit, index, step.q[i], limit});
    }
    if (!q_) return MoveOrder{step, q_, step.q, first_move_duration(robot_)};
    const JointVector q = resolved(step, *q_);
    return MoveOrder{step, q_, q, profile_between(*q_, q, robot_, step.speed).duration()};
  }

  const RobotModel& robot_;
  Start q_;
  double homing_;  ///< s at most, all joints
  Plan plan_;
};

/// One loop that is being unrolled.
struct Open {
  std::size_t loop = 0;
  int round = 1;
};

}  // namespace

double first_move_duration(const RobotModel& robot) {
  double longest = kFirstMoveMin;
  for (const Joint& joint : robot.joints) {
    longest =
        std::max(longest, (joint.upper - joint.lower) / (kFirstMoveSpeed * joint.velocity_max));
  }
  return longest;
}

JointVector resolved(const JointStep& step, const JointVector& from) {
  JointVector q = from;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if ((step.given >> i & 1) != 0) q[i] = step.q[i];
  }
  return q;
}

motion::RestToRest profile_between(const JointVector& from, const JointVector& to,
                                   const RobotModel& robot, double speed) {
  std::array<motion::AxisLimits, kMaxJoints> limits{};
  const DeviceCapability& device = robot.device.capability;
  const double share = (device.takes_speed ? speed : 1) * device.limits_share;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    limits[i] = {joint.velocity_max * share, joint.acceleration_max * share,
                 joint.jerk_max * share};
  }
  const std::size_t size = robot.joints.size();
  return {std::span(from.data(), size), std::span(to.data(), size),
          std::span<const motion::AxisLimits>(limits.data(), size)};
}

std::expected<Plan, Refusal> make_plan(const Program& program, const RobotModel& robot,
                                       const Start& start, const HomingTimes& homing) {
  Planner planner(robot, start, homing);
  std::vector<Open> open;
  std::size_t turns = 0;  // empty loops turn without an order
  for (std::size_t place = 0; place < program.steps.size(); ++place) {
    const Step& step = program.steps[place];
    if (std::holds_alternative<LoopStep>(step.what)) {
      open.push_back({place, 1});
      continue;
    }
    if (std::holds_alternative<EndStep>(step.what)) {
      const auto& loop = std::get<LoopStep>(program.steps[open.back().loop].what);
      if (++turns > kTurnsMax) {
        return std::unexpected(Refusal{step.line, too_long()});
      }
      if (open.back().round < loop.rounds) {
        ++open.back().round;
        place = open.back().loop;
      } else {
        open.pop_back();
      }
      continue;
    }
    const int rounds =
        open.empty() ? 1 : std::get<LoopStep>(program.steps[open.back().loop].what).rounds;
    if (const auto refusal = planner.take(step, open.empty() ? 1 : open.back().round, rounds)) {
      return std::unexpected(*refusal);
    }
  }
  return std::move(planner.plan());
}

}  // namespace sinew::program
