// Joints beyond a limit: every robot and wire, every joint, both sides, with its own driver and
// device. Three ways lead there: limits that are narrower for the host than for the machine, a limp
// arm that is pushed or sinks, and a jog to the limit. Inward must work by row, step, jog, home and
// recovery.
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
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/row_planner.h"
#include "sinew/program/procedures/procedures.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/links/robot_variant.h"
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
    settings.opening_limit = robot.device.settings->opening().limit;
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
  /// The row `home` of a robot without end stops.
  std::optional<JointVector> home_row() {
    program::JointStep row{.q = home_joints(robot_), .given = 0, .how = {}};
    row.given = static_cast<std::uint8_t>((1U << robot_.joints.size()) - 1);
    return go(row, robot_);
  }
  /// `commission --procedure recover`, its questions answered. @return  why not, as a sentence
  std::string recover() {
    program::Procedure procedure(program::recovery_procedure(robot_, runtime::homing_of(robot_)),
                                 machine());
    procedure.start(cell_.now());
    std::optional<std::size_t> answered;
    const Instant end = cell_.now() + 5min;
    while (!procedure.finished() && cell_.now() < end) {
      cell_.run_to(next_, 1ms, [] { return false; });
      next_ = std::max(next_ + 2ms, cell_.now());
      loop_->step(cell_.now());
      procedure.poll(cell_.now());
      if (procedure.phase() != program::Procedure::Phase::kAsking) continue;
      if (answered == procedure.place()) return procedure.trouble();
      answered = procedure.place();
      const bool told = std::holds_alternative<program::TellStep>(procedure.step().what);
      const bool place = std::holds_alternative<program::PlaceStep>(procedure.step().what);
      const bool adjust = std::holds_alternative<program::AdjustStep>(procedure.step().what);
      const char* answer = told ? "yes" : place ? "home" : adjust ? "done" : "go";
      if (const auto taken = procedure.answer(answer, cell_.now()); !taken) {
        return taken.error();
      }
    }
    const bool done = procedure.phase() == program::Procedure::Phase::kDone;
    return done ? "" : "not done: " + procedure.trouble();
  }
  /// A jog of one joint that is held for some tenths of a second.
  void jog(std::size_t joint, double speed, int tenths = 10) {
    error_.reset();
    for (int k = 0; k < tenths; ++k) {
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
  std::optional<std::string> wire;
  bool told;  ///< its host knows from the journal where it is; else the device measures
  Duration warm_up;
  bool moved_before = false;  ///< an earlier host has made its first move
};

std::string name_of(const testing::TestParamInfo<Case>& one) {
  std::string name = one.param.id;
  if (one.param.profile) name += "_" + *one.param.profile;
  if (one.param.wire) name += "_" + *one.param.wire;
  std::ranges::replace(name, '-', '_');
  return name;
}

RobotModel model_of(const Case& what) {
  RobotModel robot = runtime::variant_of(test::robot(what.id), what.profile, what.wire).value();
  robot.collision = {};
  return robot;
}

bool streams(const RobotModel& robot) {
  return robot.device.capability.motion == MotionKind::kStream;
}

/// A machine with a host that has a joint beyond a limit.
struct Scene {
  RobotModel robot;
  std::optional<FaultCell> cell;
  std::optional<Host> host;
  std::size_t joint = 0;
  double inward = 1;
  double beyond = 0;  ///< rad or m, at least

  double truth() const { return cell->machine().truth().joints[joint].q; }
  const Joint& limits() const { return robot.joints[joint]; }
  double limit() const { return inward > 0 ? limits().lower : limits().upper; }

  void expect_rows_and_jogs_go_inward() {
    const double begin = host->here()[joint];
    ASSERT_FALSE(within_limits(limits(), begin)) << begin;
    EXPECT_FALSE(host->step(joint, -inward * beyond / 4)) << "outward";
    EXPECT_NE(host->error(), "nothing");
    const std::size_t other = (joint + 1) % robot.joints.size();
    const double middle = (robot.joints[other].lower + robot.joints[other].upper) / 2;
    const double aside = host->here()[other] > middle ? -1 : 1;
    EXPECT_TRUE(host->step(other, aside * beyond / 2)) << "another joint: " << host->error();
    EXPECT_TRUE(host->step(joint, inward * beyond / 4)) << "still outside: " << host->error();
    EXPECT_GT((truth() - begin) * inward, 0);
    const double before = host->here()[joint];
    if (streams(robot)) {
      host->jog(joint, inward * std::min(limits().velocity_max / 4, beyond / 4));
      EXPECT_GT((host->here()[joint] - before) * inward, beyond / 8) << host->error();
    }
    EXPECT_TRUE(host->step(joint, limit() - host->here()[joint] + inward * beyond))
        << "into the limits: " << host->error();
    EXPECT_TRUE(within_limits(limits(), host->here()[joint])) << host->here()[joint];
  }
  void expect_home() {
    ASSERT_FALSE(within_limits(limits(), host->here()[joint]));
    EXPECT_TRUE(host->home_row()) << "home: " << host->error();
    EXPECT_NEAR(truth(), limits().home, beyond / 2);
  }
  void expect_recovery() {
    ASSERT_FALSE(within_limits(limits(), host->here()[joint]));
    EXPECT_EQ(host->recover(), "");
    EXPECT_NEAR(truth(), limits().home, beyond / 2);
  }
};

class Outside : public testing::TestWithParam<Case> {
 protected:
  /// Limits narrowed so that where the joint rests lies beyond one. False: it rests by the other.
  static bool narrow(Scene& scene, double here) {
    Joint& limits = scene.robot.joints[scene.joint];
    if (scene.inward > 0) limits.lower = std::max(limits.lower, here + scene.beyond);
    if (scene.inward < 0) limits.upper = std::min(limits.upper, here - scene.beyond);
    limits.home = std::clamp(limits.home, limits.lower, std::max(limits.lower, limits.upper));
    return limits.upper - limits.lower >= 4 * scene.beyond;
  }
  /// @return  false where that joint cannot be beyond that limit
  static bool set(Scene& scene, std::size_t joint, bool low) {
    const Case& what = GetParam();
    scene.robot = model_of(what);
    scene.joint = joint;
    scene.inward = low ? 1 : -1;
    scene.beyond = scene.limits().kind == JointKind::kPrismatic ? 1e-4 : from_deg(3);
    const auto rest = runtime::homing_of(scene.robot).rest;
    scene.cell.emplace(scene.robot, MachineVariant{.profile = what.profile, .seed = 5},
                       what.warm_up);
    double here = rest ? (*rest)[joint] : scene.truth();
    if (what.moved_before) {
      Host before(*scene.cell, scene.robot, false);
      EXPECT_TRUE(before.enable());
      EXPECT_EQ(before.recover(), "");
      // At its home an ESP32 says the same as one that was just switched on.
      EXPECT_TRUE(before.step((joint + 1) % scene.robot.joints.size(), 0.1));
      here = before.here()[joint];
    }
    if (!narrow(scene, here)) return false;
    scene.cell->replace_driver();
    scene.host.emplace(*scene.cell, scene.robot, what.told);
    EXPECT_TRUE(scene.host->enable());
    if (rest) {
      EXPECT_TRUE(scene.host->home());
    }
    return true;
  }
  static void look(std::size_t joint, bool low, int& looked) {
    Scene scene;
    if (!set(scene, joint, low)) return;
    ++looked;
    if (!scene.host->machine().reference()) {
      return nudge_back(scene, scene.inward * scene.beyond / 4);
    }
    scene.expect_rows_and_jogs_go_inward();
    Scene again;
    if (set(again, joint, low)) again.expect_home();
    const bool asks_to_nudge = again.robot.device.capability.nudge_max > 0;
    if (runtime::homing_of(again.robot).rest || asks_to_nudge) return;
    Scene recovered;
    if (set(recovered, joint, low)) recovered.expect_recovery();
  }
  /// A machine that nobody knows the place of any more takes small steps of one joint.
  static void nudge_back(Scene& scene, double way) {
    const double before = scene.truth();
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(scene.host->nudge(scene.joint, way)) << scene.host->error();
    }
    EXPECT_NEAR(scene.truth(), before + 3 * way, std::abs(way) / 10);
  }
};

TEST_P(Outside, every_joint_beyond_each_limit_goes_inward) {
  const RobotModel& robot = test::robot(GetParam().id);
  int looked = 0;
  for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
    for (const bool low : {true, false}) {
      SCOPED_TRACE(robot.joints[joint].name + (low ? " below" : " above"));
      look(joint, low, looked);
    }
  }
  EXPECT_GE(looked, static_cast<int>(robot.joints.size()));
}

/// A bus servo without current is pushed to its end, 9 to 10 deg beyond the joint's limit, and
/// measured there.
struct Limp : testing::TestWithParam<bool> {
  /// @param sags  what pushes it goes on pushing; else the hand is gone
  static void set(Scene& scene, std::size_t joint, bool low, bool sags) {
    using Kind = sim::Disturbance::Kind;
    scene.robot = model_of({"learm", "bus", std::nullopt, false, 1s});
    scene.joint = joint;
    scene.inward = low ? 1 : -1;
    scene.beyond = from_deg(8);
    scene.cell.emplace(scene.robot, MachineVariant{.profile = "bus", .seed = 5}, 1s);
    const auto index = static_cast<std::int8_t>(joint);
    scene.cell->machine().disturb({Kind::kLoad, index, -4 * scene.inward});
    scene.cell->run_to(scene.cell->now() + 2s, 10ms, [] { return false; });
    scene.cell->machine().disturb({Kind::kLoad, index, sags ? -0.4 * scene.inward : 0});
    scene.host.emplace(*scene.cell, scene.robot, false);
    ASSERT_TRUE(scene.host->enable());
    ASSERT_GT((scene.limit() - scene.host->here()[joint]) * scene.inward, scene.beyond);
  }
};

TEST_P(Limp, every_joint_of_a_learm_comes_in_from_the_ends_of_its_servo) {
  for (std::size_t joint = 0; joint < 5; ++joint) {
    for (const bool low : {true, false}) {
      SCOPED_TRACE(std::to_string(joint) + (low ? " below" : " above"));
      Scene rows, home, recovery;
      set(rows, joint, low, GetParam());
      rows.expect_rows_and_jogs_go_inward();
      set(home, joint, low, GetParam());
      home.expect_home();
      set(recovery, joint, low, GetParam());
      recovery.expect_recovery();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Learm, Limp, testing::Bool(),
                         [](const auto& one) { return one.param ? "sagged" : "pushed_by_hand"; });

/// Each wire that can be jogged: to a limit, where what is measured may lie a count beyond it.
class Jogged : public testing::TestWithParam<Case> {};

TEST_P(Jogged, to_each_limit_every_joint_goes_on_and_comes_back) {
  Scene scene;
  scene.robot = model_of(GetParam());
  scene.cell.emplace(scene.robot, MachineVariant{.profile = GetParam().profile, .seed = 5},
                     GetParam().warm_up);
  scene.host.emplace(*scene.cell, scene.robot, GetParam().told);
  Host& host = *scene.host;
  ASSERT_TRUE(host.enable());
  if (runtime::homing_of(scene.robot).rest) {
    ASSERT_TRUE(host.home());
  }
  if (!host.machine().reference()) {
    ASSERT_EQ(host.recover(), "");
  }
  for (std::size_t joint = 0; joint < scene.robot.joints.size(); ++joint) {
    const Joint& limits = scene.robot.joints[joint];
    const double fast = limits.velocity_max, small = (limits.upper - limits.lower) / 200;
    const std::size_t other = (joint + 1) % scene.robot.joints.size();
    for (const double out : {-1.0, 1.0}) {
      SCOPED_TRACE(limits.name + (out < 0 ? " down" : " up"));
      const double limit = out < 0 ? limits.lower : limits.upper;
      const double ramps =
          fast / limits.acceleration_max + 2 * limits.acceleration_max / limits.jerk_max;  // s
      const double seconds = std::abs(limit - host.here()[joint]) / fast + ramps;
      host.jog(joint, out * fast, static_cast<int>(10 * seconds) + 10);
      EXPECT_EQ(host.error(), "nothing") << "jog to the limit";
      ASSERT_TRUE(host.machine().reference());
      EXPECT_NEAR(host.here()[joint], limit, 2 * small);
      EXPECT_TRUE(host.step(other, small)) << "another joint: " << host.error();
      EXPECT_TRUE(host.step(joint, -out * small)) << "inward: " << host.error();
      host.jog(joint, out * fast, 20);
      const double before = host.here()[joint];
      host.jog(joint, -out * fast / 4, 5);
      EXPECT_EQ(host.error(), "nothing") << "jog inward";
      EXPECT_GT((before - host.here()[joint]) * out, 0);
    }
    ASSERT_TRUE(host.home_row()) << host.error();
  }
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
                         testing::Values(Case{"bigrobotarm", "document", "byte", true, 1s},
                                         Case{"bigrobotarm", "document", "text", true, 1s},
                                         Case{"bigrobotarm", "sinew", "framed", true, 1s},
                                         Case{"maxarm", "arduino", std::nullopt, false, 20s},
                                         Case{"maxarm", "micropython", std::nullopt, false, 20s},
                                         Case{"learm", "lsc6", std::nullopt, true, 1s, true},
                                         Case{"learm", "bus", std::nullopt, false, 1s},
                                         Case{"learm", "esp32", std::nullopt, false, 3s, true},
                                         Case{"hexapod", std::nullopt, std::nullopt, true, 1s},
                                         Case{"robot-arm-2", std::nullopt, std::nullopt, false,
                                              1s}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(Robots, Jogged,
                         testing::Values(Case{"learm", "lsc6", std::nullopt, false, 1s},
                                         Case{"learm", "bus", std::nullopt, false, 1s},
                                         Case{"learm", "esp32", std::nullopt, false, 3s},
                                         Case{"bigrobotarm", "sinew", "framed", true, 1s},
                                         Case{"robot-arm-2", std::nullopt, "link", false, 1s}),
                         name_of);

}  // namespace
}  // namespace sinew::test
