#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "faults/fault_cell.h"
#include "sinew/core/units.h"
#include "sinew/program/program_run.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/robot_variant.h"
#include "support/robots.h"

/// Whether a motion takes as long as was said before it began, on each robot's own bytes against
/// the physics of its simulation.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

struct Case {
  const char* name;
  const char* robot;
  std::optional<std::string> profile;
  std::optional<std::string> wire;
  std::string program;
  bool at_home = false;  ///< somebody has to say where it stands
};

/// What became of one motion.
struct Arrival {
  double predicted = 0;  ///< s, from the order to the arrival
  double arrived = 0;    ///< s, when the last joint came near its resting place to stay
  double done = 0;       ///< s, when the program went on
  double duration = 0;   ///< s, the same predicted
};

/// The truth while a motion is under way.
struct Way {
  std::vector<double> t;
  std::vector<JointVector> q;

  void add(double at, const sim::Truth& truth) {
    JointVector now;
    for (const sim::JointTruth& joint : truth.joints) now.push_back(joint.q);
    t.push_back(at);
    q.push_back(now);
  }

  /// When every joint was within `share` of the longest way from where it rests in the end, for
  /// good.
  double arrival(double share) const {
    std::size_t last_away = 0;
    const JointVector& from = q.front();
    const JointVector& to = q.back();
    double longest = 0;
    for (std::size_t j = 0; j < to.size(); ++j) {
      longest = std::max(longest, std::abs(to[j] - from[j]));
    }
    for (std::size_t k = 0; k < q.size(); ++k) {
      for (std::size_t j = 0; j < to.size(); ++j) {
        if (std::abs(q[k][j] - to[j]) > share * longest) last_away = k;
      }
    }
    return t[last_away];
  }
};

/// A motion's end is seen best a little before it: the last hundredth of a jerk-limited way takes a
/// tenth of its time, in which an arm only creeps.
constexpr double kNear = 0.01;

/// How long before its end a whole move has kNear of its longest way left, by the profile that its
/// device makes: jerk-limited (our boards), with constant deceleration (AccelStepper), or even.
double tail(const program::Record& record, const RobotModel& model) {
  double left = 0;
  for (std::size_t j = 0; j < record.q.size(); ++j) {
    left = std::max(left, kNear * std::abs(record.q[j] - (*record.q_start)[j]));
  }
  const auto profile = program::profile_between(*record.q_start, record.q, model, 1);
  const Joint& slowest = model.joints[profile.slowest()];
  const auto& settings = model.device.settings;
  if (std::holds_alternative<AxisRegistersDevice>(settings)) {
    return std::cbrt(6 * left / slowest.jerk_max);
  }
  if (std::holds_alternative<BigRobotArmDevice>(settings)) {
    return std::sqrt(2 * left / slowest.acceleration_max);
  }
  return kNear * record.arrival;
}

/// When a motion was predicted to be so near its end, told before it began.
double planned_arrival(const program::Record& record, const RobotModel& model) {
  if (model.device.capability.motion == MotionKind::kPointToPoint) {
    return record.arrival - tail(record, model);
  }
  const auto& order = std::get<program::MoveOrder>(record.order->what);
  program::RowPlanner planner(model);
  const auto pieces = planner.plan(*record.q_start, order.rows);
  EXPECT_TRUE(pieces);
  const auto trajectory = planner.motion().trajectory();
  Way way;
  constexpr double kStep = 1e-3;
  for (double t = 0; t <= pieces->duration + kStep; t += kStep) {
    sim::Truth truth;
    planning::JointMotion at;
    trajectory.sample(t, at);
    for (std::size_t j = 0; j < model.joints.size(); ++j) truth.joints.push_back({.q = at.q[j]});
    way.add(t, truth);
  }
  return way.arrival(kNear) + record.arrival - trajectory.duration();
}

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Arrivals : public testing::TestWithParam<Case> {};

TEST_P(Arrivals, are_as_predicted) {
  const Case& c = GetParam();
  RobotModel model = *runtime::variant_of(robot(c.robot), c.profile, c.wire);
  if (model.id == "robot-arm-2") {
    // Homing searches a whole joint's range at 3 deg/s: minutes, in which nothing is learnt here.
    for (Joint& joint : model.joints) {
      joint.lower = std::max(joint.lower, from_deg(-40));
      joint.upper = std::min(joint.upper, from_deg(40));
    }
  }
  const auto program = program::parse(c.program, "p", model);
  ASSERT_TRUE(program) << to_text(program.error().front());
  FaultCell cell(model, {.profile = c.profile, .seed = 7}, 1s);
  program::Run run(*program, model, cell.driver(), runtime::opening_of(model).limit);
  run.expect_homing(runtime::homing_of(model));
  if (c.at_home) {
    JointVector home;
    for (const Joint& joint : model.joints) home.push_back(joint.home);
    run.declare(home);
  }
  std::vector<Arrival> arrivals;
  Way way;
  const program::Order* under_way = nullptr;
  std::size_t records = 0;
  run.start(cell.now());
  const bool ended = cell.run_to(Instant{} + 3h, 2ms, [&] {
    run.poll(cell.now());
    if (run.records().size() > records) {
      const program::Record& record = run.records()[records++];
      if (under_way == record.order && !way.q.empty()) {
        if (program::plannable(record.q_start, model)) {
          arrivals.push_back({planned_arrival(record, model), way.arrival(kNear),
                              to_seconds(record.done - record.asked), record.duration});
        }
      }
      way = {};
      under_way = nullptr;
    }
    const auto& current = run.under_way();
    const bool moves = current && std::holds_alternative<program::MoveOrder>(current->order->what);
    if (moves) {
      under_way = current->order;
      way.add(to_seconds(cell.now() - current->asked), cell.machine().truth());
    }
    return run.finished();
  });
  ASSERT_TRUE(ended);
  ASSERT_EQ(run.phase(), program::Run::Phase::kDone)
      << (run.failure() ? describe(run.failure()->error) : "");
  ASSERT_GE(arrivals.size(), 2U);
  for (const Arrival& a : arrivals) {
    // Boards look at their port every 20 ms, and so do their servos.
    EXPECT_NEAR(a.arrived, a.predicted, std::max(0.02 * a.predicted, 0.03));
    std::cout << "  predicted " << a.predicted << " s, arrived " << a.arrived << " s ("
              << 100 * (a.arrived / a.predicted - 1) << " %); told " << a.done - a.duration
              << " s later than predicted\n";
  }
}

INSTANTIATE_TEST_SUITE_P(
    Robots, Arrivals,
    testing::Values(
        Case{"registers",
             "robot-arm-2",
             "document",
             {},
             "home\njoint J1=0deg J2=0deg J3=0deg J4=0deg J5=0deg J6=0deg\n"
             "joint J1=30deg J2=20deg\njoint J1=-30deg J3=-20deg J5=30deg\n"},
        Case{"link",
             "robot-arm-2",
             {},
             "link",
             "home\njoint J1=0deg J2=0deg J3=0deg J4=0deg J5=0deg J6=0deg\n"
             "joint J1=30deg J2=20deg\njoint J1=-30deg J3=-20deg J5=30deg\n"},
        Case{"lsc6",
             "learm",
             "lsc6",
             {},
             "joint base=0deg shoulder=20deg elbow=40deg wrist=30deg roll=0deg\n"
             "joint base=80deg speed=30%\njoint base=-80deg elbow=60deg\n"
             "joint base=0deg shoulder=0deg speed=20%\n"
             "joint shoulder=10deg elbow=70deg wrist=20deg\n"
             "line z=185mm y=40mm blend=10mm speed=30mm/s\nline y=-40mm speed=30mm/s\n"},
        Case{"bus",
             "learm",
             "bus",
             {},
             "joint base=0deg shoulder=20deg elbow=40deg wrist=30deg roll=0deg\n"
             "joint base=80deg speed=30%\njoint base=-80deg elbow=60deg\n"},
        Case{"bigrobotarm",
             "bigrobotarm",
             "document",
             {},
             "joint base=60deg\njoint base=-60deg elbow=30deg\njoint base=0deg\n",
             true},
        Case{"maxarm",
             "maxarm",
             "arduino",
             {},
             "joint base=120deg shoulder=110deg forearm=30deg\njoint base=60deg speed=30%\n"
             "joint base=170deg shoulder=125deg\n"},
        Case{"maxarm_micropython",
             "maxarm",
             "micropython",
             {},
             "joint base=120deg shoulder=110deg forearm=30deg\njoint base=60deg speed=30%\n"
             "joint base=170deg shoulder=125deg\n"},
        Case{"hexapod",
             "hexapod",
             {},
             {},
             "joint leg1=268.40mm leg2=268.40mm\n"
             "joint leg1=268.36mm leg2=268.36mm leg3=268.40mm leg4=268.40mm leg5=268.40mm "
             "leg6=268.40mm\n",
             true},
        Case{"hexapod_legs_alone",
             "hexapod",
             {},
             {},
             "joint leg1=268.60mm\njoint leg2=268.50mm leg5=268.30mm\njoint leg2=268.36mm\n"
             "joint leg1=268.36mm speed=40%\nline z=250.1mm\nline z=250.2mm blend=0.02mm\n"
             "line x=0.1mm\n",
             true}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace sinew::test
