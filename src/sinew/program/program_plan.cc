#include "sinew/program/program_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>

#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::program {
namespace {

constexpr double kFirstMoveSpeed = 0.1;  // of a joint's top speed
constexpr double kFirstMoveMin = 2;      // s

constexpr std::size_t kTurnsMax = 4 * kOrdersMax;
/// Different motions of one program: each takes about a millisecond to plan.
constexpr std::size_t kMotionsMax = 20'000;

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
  Planner(const RobotModel& robot, const Start& start, const Homing& homing)
      : robot_(robot), q_(start), homing_(homing) {}

  /// One row in the order in which they come. @param place  of the row in its program
  std::optional<Refusal> take(const Step& step, std::size_t place, int round, int rounds) {
    if (motion_of(step) != nullptr) {
      if (rows_.empty()) first_ = {round, rounds};
      rows_.push_back(step);
      places_.push_back(place);
      // Too many for one motion: what there is goes first.
      const bool more = motion_of(step)->blends() && rows_.size() < RowPlanner::kRowsMax;
      return more ? std::nullopt : finish();
    }
    if (auto refusal = finish()) return refusal;
    Order order{step.line, step.line, round, rounds, HomeOrder{}};
    if (const auto* wait = std::get_if<WaitStep>(&step.what)) {
      plan_.duration += to_seconds(wait->duration);
      order.what = WaitOrder{wait->duration};
    } else if (const auto* tool = std::get_if<ToolStep>(&step.what)) {
      if (const auto refusal = tool_refusal(robot_, tool->action)) {
        return Refusal{step.line, *refusal, std::nullopt};
      }
      const double duration = to_seconds(tool_time(robot_, tool->action, jaws_));
      if (const auto* jaws = std::get_if<JawsTo>(&tool->action)) jaws_ = jaws->width;
      plan_.duration += duration;
      order.what = ToolOrder{tool->action, duration};
    } else {
      const auto home = plan_home(step.line);
      if (!home) return home.error();
      plan_.homing_max += home->duration_max;
      order.what = *home;
      q_ = home_joints(robot_);
    }
    return add(std::move(order));
  }

  /// Plans the motions that are still waiting for rows to blend with.
  std::optional<Refusal> finish() {
    std::span<const Step> rows = rows_;
    std::span<const std::size_t> places = places_;
    while (!rows.empty()) {
      const auto motion = plan_motion(rows, places);
      if (!motion) return motion.error();
      const auto taken = rows.first(motion->rows);
      Order order{taken.front().line, taken.back().line, first_.round, first_.rounds, {}};
      order.what = MoveOrder{{taken.begin(), taken.end()},
                             q_,
                             motion->q_end,
                             motion->duration,
                             motion->stop,
                             motion->stop_saves,
                             motion->first_move};
      plan_.duration += motion->duration;
      q_ = motion->q_end;
      if (auto refusal = add(std::move(order))) return refusal;
      rows = rows.subspan(motion->rows);
      places = places.subspan(motion->rows);
    }
    rows_.clear();
    places_.clear();
    return std::nullopt;
  }

  Plan& plan() { return plan_; }

 private:
  struct Planned {
    std::size_t rows = 0;
    JointVector q_end;
    double duration = 0;
    CornerStopReason stop = CornerStopReason::kNone;
    double stop_saves = 0;
    bool first_move = false;
  };
  /// The rows of a motion and where it begins: loops come by the same ones again and again.
  struct Key {
    std::vector<std::size_t> places;
    std::vector<double> q_start;
    auto operator<=>(const Key&) const = default;
  };
  struct First {
    int round = 1;
    int rounds = 1;
  };

  std::optional<Refusal> add(Order order) {
    if (plan_.orders.size() >= kOrdersMax) return Refusal{order.line, too_long(), std::nullopt};
    plan_.orders.push_back(std::move(order));
    return std::nullopt;
  }

  std::expected<HomeOrder, Refusal> plan_home(int line) {
    if (!can_home(robot_)) {
      return std::unexpected(Refusal{line, Error{ErrorCode::kNoEndStops}, std::nullopt});
    }
    HomeOrder home{std::accumulate(homing_.times.begin(), homing_.times.end(), 0.0), nullptr};
    if (!back_ && homing_.rest) {
      auto back = home_return(robot_, *homing_.rest, line);
      if (!back) return std::unexpected(back.error());
      back_ = std::make_shared<const HomeReturn>(std::move(*back));
    }
    home.back = back_;
    if (back_) home.duration_max += back_->duration;
    return home;
  }

  std::expected<Planned, Refusal> plan_motion(std::span<const Step> rows,
                                              std::span<const std::size_t> places) {
    if (!plannable(q_, robot_)) {
      const auto q = first_target(rows[0], q_, robot_);
      if (!q) return std::unexpected(q.error());
      return Planned{1, *q, first_move_duration(robot_), CornerStopReason::kNone, 0, true};
    }
    Key key{{places.begin(), places.end()}, {q_->begin(), q_->end()}};
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    if (known_.size() == kMotionsMax) {
      constexpr auto kMax = static_cast<double>(kMotionsMax);
      return std::unexpected(
          Refusal{rows[0].line, {ErrorCode::kProgramTooLong, -1, kMax + 1, kMax}, std::nullopt});
    }
    if (!planner_) planner_ = std::make_unique<RowPlanner>(robot_);
    const auto motion = planner_->plan(*q_, rows);
    if (!motion) return std::unexpected(motion.error());
    const Planned planned{motion->rows, motion->q_end,      motion->duration,
                          motion->stop, motion->stop_saves, false};
    known_.emplace(std::move(key), planned);
    return planned;
  }

  const RobotModel& robot_;
  Start q_;
  const Homing& homing_;
  std::optional<double> jaws_;              ///< m, where the program told them
  std::shared_ptr<const HomeReturn> back_;  ///< the same for each `home`
  Plan plan_;
  std::unique_ptr<RowPlanner> planner_;
  std::map<Key, Planned> known_;
  std::vector<Step> rows_;  ///< that wait for the next one to blend with
  std::vector<std::size_t> places_;
  First first_;
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

bool plannable(const Start& q, const RobotModel& robot) {
  if (!q) return false;
  for (std::size_t i = 0; i < q->size(); ++i) {
    if (!within_limits(robot.joints[i], (*q)[i])) return false;
  }
  return true;
}

std::expected<JointVector, Refusal> first_target(const Step& row, const Start& q,
                                                 const RobotModel& robot) {
  const auto refused = [&](const Error& error) {
    return std::unexpected(Refusal{row.line, error, std::nullopt});
  };
  const auto* joint = std::get_if<JointStep>(&row.what);
  JointVector target;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const auto index = static_cast<std::int8_t>(i);
    const bool given = joint != nullptr && (joint->given >> i & 1) != 0;
    if (!given && !q) return refused(Error{ErrorCode::kPositionUnknown, index});
    target.push_back(given ? joint->q[i] : (*q)[i]);
    const Joint& limits = robot.joints[i];
    if (within_limits(limits, target[i])) continue;
    const bool leg = limits.kind == JointKind::kPrismatic;
    return refused(Error{leg ? ErrorCode::kLegLength : ErrorCode::kJointLimit, index, target[i],
                         target[i] < limits.lower ? limits.lower : limits.upper});
  }
  if (joint == nullptr) return refused(Error{ErrorCode::kPositionUnknown, 0});
  if (const auto error = WireTarget(robot).refusal({target.data(), target.size()})) {
    return refused(*error);
  }
  return target;
}

std::expected<Plan, Refusal> make_plan(const Program& program, const RobotModel& robot,
                                       const Start& start, const Homing& homing) {
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
        return std::unexpected(Refusal{step.line, too_long(), std::nullopt});
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
    if (const auto refusal =
            planner.take(step, place, open.empty() ? 1 : open.back().round, rounds)) {
      return std::unexpected(*refusal);
    }
  }
  if (const auto refusal = planner.finish()) return std::unexpected(*refusal);
  return std::move(planner.plan());
}

}  // namespace sinew::program
