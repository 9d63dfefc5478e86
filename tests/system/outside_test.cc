// Joints that stand beyond a limit: every robot, every joint, both sides, with its own driver, wire
// and device. For its host the limits are narrower than for the machine, so that where the machine
// rests (sunk, pushed, switched on there) is outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "faults/fault_cell.h"
#include "sinew/control/jog_motion.h"
#include "sinew/control/path_motion.h"
#include "sinew/control/piece_motion.h"
#include "sinew/core/units.h"
#include "sinew/program/row_planner.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/robot_variant.h"
#include "support/robots.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using control::MachineState;

class Host {
 public:
  /// @param robot  its limits are narrowed here; the cell outlives this
  Host(FaultCell& cell, RobotModel& robot, bool told) : cell_(cell), robot_(robot) {
    control::ControllerSettings settings;
    settings.opening_limit = runtime::opening_of(robot).limit;
    control::ControllerStart start;
    const sim::Truth truth = cell.machine().truth();
    for (const sim::JointTruth& joint : truth.joints) {
      if (told) start.positions.push_back({PositionQuality::kCommanded, joint.q, joint.q, joint.q});
    }
    loop_.emplace(robot, cell.driver(), settings, start, nullptr);
    next_ = cell.now();
  }

  bool wait(const std::function<bool()>& done, Duration longest) {
    const Instant end = cell_.now() + longest;
    while (!done() && cell_.now() < end) {
      cell_.run_to(next_, 1ms, [] { return false; });
      next_ = std::max(next_ + 2ms, cell_.now());
      loop_->step(cell_.now());
      while (const auto event = machine().take_event()) {
        if (event->kind == control::ControlEvent::Kind::kRefused ||
            event->kind == control::ControlEvent::Kind::kFailed) {
          if (!error_) error_ = event->error;
        }
      }
    }
    return done();
  }
  bool rests() const {
    return loop_->controller().state() == MachineState::kReady && loop_->controller().task() == 0;
  }
  bool enable() {
    machine().give(control::TakeLease{});
    wait([] { return false; }, 4ms);
    machine().give(control::Enable{});
    wait([] { return false; }, 4ms);
    return wait([&] { return rests(); }, 60s);
  }
  bool home() {
    machine().give(control::Home{});
    wait([] { return false; }, 10ms);
    return wait([&] { return rests(); }, 20min);
  }
  JointVector here() { return machine().reference().value(); }

  /// A row that moves one joint by `way`, as a program or a step by hand does. Nothing: refused.
  std::optional<JointVector> step(std::size_t joint, double way) {
    program::JointStep row;
    row.q.resize(robot_.joints.size());
    row.q[joint] = way;
    row.given = row.relative = static_cast<std::uint8_t>(1U << joint);
    return go(row, robot_);
  }
  std::optional<JointVector> go(const program::JointStep& row, const RobotModel& planned,
                                const std::function<void()>& look = {}) {
    const program::Step one{1, row, 0};
    program::RowPlanner planner(planned);
    const JointVector from = here();
    const auto motion = planner.plan(from, {}, std::span(&one, 1));
    error_.reset();
    if (!motion) {
      error_ = motion.error().error;
      return std::nullopt;
    }
    motion_ = std::make_unique<control::PieceMotion>(from, motion->pieces, robot_);
    machine().give(control::Begin{motion_.get()});
    wait([] { return false; }, 4ms);
    const auto done = [&] {
      if (look) look();
      return rests();
    };
    wait(done, 10min);
    if (error_) return std::nullopt;
    return motion->q_end;
  }
  /// A jog of one joint that is held for a second.
  void jog(std::size_t joint, double speed) {
    error_.reset();
    for (int k = 0; k < 10; ++k) {
      planning::JogCommand command{
          .frame = planning::JogFrame::kJoint, .velocity = {}, .expiry = 150ms};
      command.velocity.resize(robot_.joints.size());
      command.velocity[joint] = speed;
      machine().give(control::JogAt{command});
      wait([] { return false; }, 100ms);
    }
    wait([&] { return rests(); }, 10s);
  }
  bool nudge(std::size_t joint, double way) {
    error_.reset();
    machine().give(control::Nudge{static_cast<std::uint8_t>(joint), way});
    wait([] { return false; }, 4ms);
    return wait([&] { return rests(); }, 60s) && !error_;
  }
  std::string error() const { return error_ ? describe(*error_) : "nothing"; }
  const std::optional<Error>& told() const { return error_; }
  control::LocalMachine& machine() { return loop_->machine(); }

 private:
  FaultCell& cell_;
  const RobotModel& robot_;
  std::optional<runtime::ControlLoop> loop_;
  std::unique_ptr<control::MotionSource> motion_;
  Instant next_;
  std::optional<Error> error_;
};

struct Case {
  const char* id;
  std::optional<std::string> profile;
  bool told;  ///< its host knows from the journal where it is; else the device measures
  Duration warm_up;
};

class Outside : public testing::TestWithParam<Case> {
 protected:
  /// Joint `joint` beyond its lower (or upper) limit by `beyond`, and what brings it back.
  void look(std::size_t joint, bool low, double beyond) {
    const Case& what = GetParam();
    const RobotModel wide = runtime::variant_of(test::robot(what.id), what.profile, {}).value();
    RobotModel robot = wide;
    robot.collision = {};
    FaultCell cell(robot, {.profile = what.profile, .seed = 5}, what.warm_up);
    const auto rest = runtime::homing_of(robot).rest;
    const double here = rest ? (*rest)[joint] : cell.machine().truth().joints[joint].q;
    const double inward = low ? 1 : -1;
    Joint& limits = robot.joints[joint];
    if (low) limits.lower = std::max(limits.lower, here + beyond);
    if (!low) limits.upper = std::min(limits.upper, here - beyond);
    if (limits.upper - limits.lower < 4 * beyond) return;  // it rests by the other one
    ++looked_;
    limits.home = std::clamp(limits.home, limits.lower, limits.upper);
    cell.replace_driver();
    Host host(cell, robot, what.told);
    ASSERT_TRUE(host.enable());
    if (rest) {
      ASSERT_TRUE(host.home());
    }
    if (!host.machine().reference()) return nudge_back(host, cell, joint, inward * beyond / 4);
    const auto truth = [&] { return cell.machine().truth().joints[joint].q; };
    const double begin = host.here()[joint];
    ASSERT_FALSE(within_limits(limits, begin)) << begin;
    EXPECT_FALSE(host.step(joint, -inward * beyond / 4)) << "outward";
    EXPECT_NE(host.error(), "nothing");
    const std::size_t other = (joint + 1) % robot.joints.size();
    const double middle = (robot.joints[other].lower + robot.joints[other].upper) / 2;
    const double aside = host.here()[other] > middle ? -1 : 1;
    EXPECT_TRUE(host.step(other, aside * beyond / 2)) << "another joint: " << host.error();
    EXPECT_TRUE(host.step(joint, inward * beyond / 4)) << "still outside: " << host.error();
    EXPECT_GT((truth() - begin) * inward, 0);
    const double before = host.here()[joint];
    if (robot.device.capability.motion == MotionKind::kStream) {
      host.jog(joint, inward * std::min(limits.velocity_max / 4, beyond / 4));
      EXPECT_GT((host.here()[joint] - before) * inward, beyond / 8) << host.error();
    }
    const double limit = low ? limits.lower : limits.upper;
    EXPECT_TRUE(host.step(joint, limit - host.here()[joint] + inward * beyond))
        << "into the limits: " << host.error();
    EXPECT_TRUE(within_limits(limits, host.here()[joint])) << host.here()[joint];
  }
  /// A machine that nobody knows the place of any more takes small steps of one joint.
  void nudge_back(Host& host, FaultCell& cell, std::size_t joint, double way) {
    const double before = cell.machine().truth().joints[joint].q;
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(host.nudge(joint, way)) << host.error();
    EXPECT_NEAR(cell.machine().truth().joints[joint].q, before + 3 * way, std::abs(way) / 10);
  }
  int looked_ = 0;
};

TEST_P(Outside, every_joint_beyond_each_limit_goes_inward) {
  const RobotModel& robot = test::robot(GetParam().id);
  const bool legs = robot.joints[0].kind == JointKind::kPrismatic;
  for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
    for (const bool low : {true, false}) {
      SCOPED_TRACE(robot.joints[joint].name + (low ? " below" : " above"));
      look(joint, low, legs ? 1e-4 : from_deg(3));
    }
  }
  EXPECT_GE(looked_, static_cast<int>(robot.joints.size()));
}

/// Register boards start one after another, each at its own pace: what the arm really passes.
TEST(DrivenPath, register_boards_keep_the_margin_to_the_table) {
  const RobotModel solid =
      runtime::variant_of(test::robot("robot-arm-2"), std::nullopt, {}).value();
  // The plan alone has to see to it; and homing leaves the arm folded.
  RobotModel robot = solid;
  robot.collision = {};
  FaultCell cell(robot, {.profile = std::nullopt, .seed = 5}, 1s);
  Host host(cell, robot, false);
  ASSERT_TRUE(host.enable());
  ASSERT_TRUE(host.home());
  const auto to = [](std::initializer_list<double> degrees) {
    program::JointStep row;
    for (const double angle : degrees) row.q.push_back(from_deg(angle));
    row.given = 0x3F;
    return row;
  };
  ASSERT_TRUE(host.go(to({0, 16, -11, 0, -73, 0}), robot)) << host.error();
  const planning::CollisionModel collision(solid);
  double nearest = 1;
  const bool went = host.go(to({-1, -74, -23, 0, 84, 0}), solid,
                            [&] {
                              JointVector q;
                              for (const auto& joint : cell.machine().truth().joints) {
                                q.push_back(joint.q);
                              }
                              nearest =
                                  std::min(nearest, collision.distance({q.data(), 6}).distance);
                            })
                        .has_value();
  EXPECT_TRUE(went) << host.error();
  std::printf("  nearest %.1f mm, margin %.1f mm\n", to_mm(nearest), to_mm(collision.margin()));
  EXPECT_GT(nearest, collision.margin() - 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Robots, Outside,
                         testing::Values(Case{"bigrobotarm", "document", true, 1s},
                                         Case{"maxarm", "arduino", false, 20s},
                                         Case{"maxarm", "micropython", false, 20s},
                                         Case{"hexapod", std::nullopt, true, 1s},
                                         Case{"robot-arm-2", std::nullopt, false, 1s}),
                         [](const auto& one) {
                           std::string name = one.param.id;
                           if (one.param.profile) name += "_" + *one.param.profile;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace sinew::test
