#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "faults/fault_cell.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/links/robot_variant.h"
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
  bool at_home = false;     ///< somebody has to say where it stands
  std::uint64_t seeds = 1;  ///< machines whose boards answer at other times
};

/// What became of one motion.
struct Arrival {
  double predicted = 0;    ///< s, from the order to the arrival
  double arrived = 0;      ///< s, when the last joint came near its resting place to stay
  double done = 0;         ///< s, when the program went on
  double duration = 0;     ///< s, the same predicted
  std::size_t pieces = 0;  ///< whole moves that it took
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

  /// When every joint was nearer than that to where it rests in the end, for good.
  double arrival(double near) const {
    std::size_t last_away = 0;
    const JointVector& to = q.back();
    for (std::size_t k = 0; k < q.size(); ++k) {
      for (std::size_t j = 0; j < to.size(); ++j) {
        if (std::abs(q[k][j] - to[j]) > near) last_away = k;
      }
    }
    return t[last_away];
  }
};

double longest(const JointVector& from, const JointVector& to) {
  double way = 0;
  for (std::size_t j = 0; j < to.size(); ++j) way = std::max(way, std::abs(to[j] - from[j]));
  return way;
}

/// How near a whole move's end counts as there. The last hundredth of a jerk-limited way takes a
/// tenth of its time, in which an arm only creeps; a stepper arrives with its last step; a bus
/// servo is told whole pulses, and a dead band of about another one is its own.
double near_end(const JointVector& from, const JointVector& to, const RobotModel& model) {
  const double hundredth = 0.01 * longest(from, to);
  // Its joints arrive one after the other, and the last one need not have the longest way.
  if (model.device.settings.is<AxisRegistersDevice>()) return 5e-4;
  if (const auto* board = model.device.settings.as<BigRobotArmDevice>()) {
    double most_steps = 0;
    for (const BigRobotArmJoint& joint : board->joints) {
      most_steps = std::max(most_steps, std::abs(joint.steps_per_rad));
    }
    return 0.5 / most_steps;
  }
  if (const auto* arm = model.device.settings.as<MaxArmDevice>()) {
    return std::max(hundredth, 2 / std::abs(arm->servos[0].pulses_per_rad));
  }
  return hundredth;
}

/// How long before its end a whole move is so near it, by the profile that its device makes.
double tail(const JointVector& from, const JointMove& piece, double near, const RobotModel& model) {
  const auto& settings = model.device.settings;
  if (settings.is<AxisRegistersDevice>()) {
    const auto profile = program::profile_between(from, piece.q, model, 1);
    return std::cbrt(6 * near / model.joints[profile.slowest()].jerk_max);
  }
  if (settings.is<BigRobotArmDevice>()) return 0;
  return std::min(1.0, near / longest(from, piece.q)) * to_seconds(piece.duration);
}

/// When a motion was predicted to be so near its end, told before it began.
struct Planned {
  double arrival = 0;
  double near = 0;
  std::size_t pieces = 0;
};
Planned planned_arrival(const program::Record& record, const RobotModel& model) {
  const auto& order = std::get<program::MoveOrder>(record.order->what);
  program::RowPlanner planner(model);
  const auto motion = planner.plan(*record.q_start, order.tool, order.rows);
  EXPECT_TRUE(motion);
  const auto& pieces = motion->pieces;
  if (model.device.capability.motion == MotionKind::kPointToPoint) {
    // Only the last whole move's end is one.
    const JointVector from = pieces.size() > 1 ? pieces[pieces.size() - 2].q : *record.q_start;
    const double near = near_end(from, pieces.back().q, model);
    return {record.arrival - tail(from, pieces.back(), near, model), near, pieces.size()};
  }
  const auto trajectory = planner.motion().trajectory();
  Way way;
  constexpr double kStep = 1e-3;
  for (double t = 0; t <= motion->duration + kStep; t += kStep) {
    sim::Truth truth;
    planning::JointMotion at;
    trajectory.sample(t, at);
    for (std::size_t j = 0; j < model.joints.size(); ++j) truth.joints.push_back({.q = at.q[j]});
    way.add(t, truth);
  }
  const double near = near_end(way.q.front(), way.q.back(), model);
  return {way.arrival(near) + record.arrival - trajectory.duration(), near, 1};
}

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Arrivals : public testing::TestWithParam<Case> {};

/// Runs a case's program and watches each of its motions.
std::vector<Arrival> arrivals_of(const Case& c, const RobotModel& model, std::uint64_t seed) {
  std::vector<Arrival> arrivals;
  const auto program = program::parse(c.program, "p", model);
  EXPECT_TRUE(program) << to_text(program.error().front());
  if (!program) return arrivals;
  FaultCell cell(model, {.profile = c.profile, .seed = seed}, 1s);
  runtime::ControlLoop loop(model, cell.driver(),
                            {.opening_limit = model.device.settings->opening().limit}, {}, nullptr);
  program::Run run(*program, loop.machine());
  run.expect_homing(runtime::homing_of(model));
  if (c.at_home) run.declare({.q = home_joints(model), .has_looked = false});
  Way way;
  const program::Order* under_way = nullptr;
  std::size_t records = 0;
  run.start(cell.now());
  const bool ended = cell.run_to(Instant{} + 3h, 2ms, [&] {
    loop.step(cell.now(), [&] { run.poll(cell.now()); });
    if (run.records().size() > records) {
      const program::Record& record = run.records()[records++];
      const bool watched = under_way == record.order && !way.q.empty();
      // A slow first move takes as long as its segment says, and the servo's regulator behind it.
      const auto* move = std::get_if<program::MoveOrder>(&record.order->what);
      const bool planned_whole = move != nullptr && !move->first_move;
      if (watched && planned_whole && program::plannable(record.q_start, model)) {
        const Planned planned = planned_arrival(record, model);
        arrivals.push_back({planned.arrival, way.arrival(planned.near),
                            to_seconds(record.done - record.asked), record.duration,
                            planned.pieces});
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
  EXPECT_TRUE(ended);
  EXPECT_EQ(run.phase(), program::Run::Phase::kDone)
      << (run.failure() ? describe(run.failure()->error) : "");
  return arrivals;
}

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
  for (std::uint64_t seed = 7; seed < 7 + c.seeds; ++seed) {
    const auto arrivals = arrivals_of(c, model, seed);
    ASSERT_GE(arrivals.size(), 2U);
    for (const Arrival& a : arrivals) {
      // Boards look at their port every 20 ms, and so do their servos.
      EXPECT_NEAR(a.arrived, a.predicted, std::max(0.02 * a.predicted, 0.03)) << seed;
      EXPECT_NEAR(a.done, a.duration, std::max(0.02 * a.duration, 0.03)) << seed;
      if (seed > 7) continue;
      std::cout << "  " << a.pieces << ": predicted " << a.predicted << " s, arrived " << a.arrived
                << " s (" << 100 * (a.arrived / a.predicted - 1) << " %); told "
                << a.done - a.duration << " s later than predicted\n";
    }
  }
}

constexpr const char* kMaxArmMoves =
    "joint base=120deg shoulder=110deg forearm=30deg\njoint base=60deg speed=30%\n"
    "joint base=170deg shoulder=125deg\nwait 0.5s\njoint base=120deg\nwait 1s\n"
    "joint base=150deg\nwait 2s\njoint base=120deg forearm=20deg\n";
// Devices that take whole moves only are led along these from stop to stop: by one move and by
// many, at the joints' own pace and at the tool's.
constexpr const char* kMaxArmWays =
    "joint base=90deg shoulder=110deg forearm=30deg\nmove x=-40mm y=-180mm z=140mm\n"
    "line z=132mm\nline z=110mm speed=40mm/s\nline z=150mm\nline x=40mm\n"
    "line x=-60mm y=-160mm z=120mm speed=15mm/s\n"
    "arc via=0mm,-200mm,140mm x=60mm y=-160mm z=160mm\nline x=0mm y=-170mm\n";
constexpr const char* kBigRobotArmWays =
    "joint base=30deg shoulder=30deg elbow=60deg wrist=30deg\nline y=260mm speed=50mm/s\n"
    "line z=180mm speed=50mm/s\nline z=184mm\nline y=200mm\n";
constexpr const char* kRegistersWays =
    "home\njoint J1=0deg J2=-10deg J3=-10deg J4=0deg J5=20deg J6=0deg\n"
    "line y=5mm\nline y=30mm\nline y=0mm\n";

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
             "joint base=80deg speed=30%\njoint base=-80deg elbow=60deg\n"
             "joint base=0deg shoulder=10deg elbow=70deg wrist=20deg\n"
             "line z=185mm y=40mm blend=10mm speed=30mm/s\nline y=-40mm speed=30mm/s\n"},
        Case{"bigrobotarm",
             "bigrobotarm",
             "document",
             {},
             "joint base=60deg\njoint base=-60deg elbow=30deg\njoint base=0deg\n",
             true},
        Case{"bigrobotarm_framed",
             "bigrobotarm",
             {},
             "framed",
             "joint base=60deg\njoint base=-60deg elbow=30deg\njoint base=0deg\n"
             "joint base=30deg shoulder=30deg elbow=60deg wrist=30deg\n"
             "line y=260mm speed=50mm/s blend=10mm\nline z=180mm speed=50mm/s\n",
             true},
        Case{"bigrobotarm_ways", "bigrobotarm", "document", {}, kBigRobotArmWays, true},
        Case{"registers_ways", "robot-arm-2", "document", {}, kRegistersWays},
        Case{"maxarm", "maxarm", "arduino", {}, kMaxArmMoves, false, 5},
        Case{"maxarm_micropython", "maxarm", "micropython", {}, kMaxArmMoves, false, 5},
        Case{"maxarm_ways", "maxarm", "arduino", {}, kMaxArmWays, false, 20},
        Case{"maxarm_micropython_ways", "maxarm", "micropython", {}, kMaxArmWays, false, 20},
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
