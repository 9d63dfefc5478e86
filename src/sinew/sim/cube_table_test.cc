#include "sinew/sim/cube_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_machine.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_machine.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/tool_body.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using EventKind = CubeEvent::Kind;

constexpr double kCube = 0.025;

/// For tests that have one thread.
struct OwnCubes : SharedCubes {
  explicit OwnCubes(const CubeWorldSettings& settings) : world(settings) {}
  void with(const std::function<void(CubeWorld&)>& what) override { what(world); }
  CubeWorld world;
};

/// A LeArm over a table, driven over its own bytes.
struct LearmCell {
  explicit LearmCell(const CubeWorldSettings& settings = {}) : cubes(settings) {
    auto machine = std::make_unique<LscMachine>(model, LscProfile::kLsc6, 3, now);
    machine->receive(
        lsc::encode(lsc::Request{
            lsc::Move{1000, {{6, 1500}, {5, 1500}, {4, 1500}, {3, 1500}, {2, 1500}, {1, 1500}}}}),
        now);
    now += 4s;
    machine->advance(now);
    table = std::make_unique<CubeTable>(std::move(machine), model, X_WB, cubes, 0, now);
  }

  void wait(Duration time) { table->advance(now += time); }
  void tell(const lsc::Move& move) {
    table->receive(lsc::encode(lsc::Request{move}), now);
    wait(2s);
  }
  /// The tips, as they are when the jaws are as wide as the cube, as nearly straight down as the
  /// wrist can.
  void reach(const Vec3& p_BT) {
    const auto& geometry = std::get<SerialGeometry>(model.geometry);
    const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry, kCube));
    const auto branches = arm.inverse_nearest_pitch(p_BT, kPi).value().branches;
    ASSERT_TRUE(branches[0].within_limits);
    const auto& servos = model.device.settings.get<LscDevice>().servos;
    lsc::Move move{1500, {}};
    for (std::size_t i = 0; i < servos.size(); ++i) {
      const double units =
          servos[i].centre + servos[i].trim + servos[i].units_per_rad * branches[0].q[i];
      move.servos.push_back({servos[i].id, static_cast<std::uint16_t>(std::lround(units))});
    }
    tell(move);
  }
  void jaws(double width) {
    const auto units = std::lround(2500 - 1000 * width / 0.06);
    tell({500, {{1, static_cast<std::uint16_t>(units)}}});
  }
  double width() const { return table->truth().tool; }
  double shoulder() const { return table->truth().joints[1].q; }
  long count(EventKind kind) const {
    return std::ranges::count(world.events(), kind, &CubeEvent::kind);
  }

  RobotModel model = test::robot("learm");
  Pose<frame::World, frame::Base> X_WB{rotation_z(kPi / 2), {0.1, -0.05, 0}};
  OwnCubes cubes;
  CubeWorld& world = cubes.world;
  Instant now{};
  std::unique_ptr<CubeTable> table;
};

constexpr Vec3 kAbove{0.15, 0.02, 0.08};
constexpr Vec3 kAt{0.15, 0.02, 0.012};

TEST(CubeTable, hand_of_a_straight_arm_is_above_it_and_its_jaws_are_wide_open) {
  const LearmCell cell;
  const auto hand = hand_of(cell.model, cell.table->truth(), cell.X_WB);
  ASSERT_TRUE(hand);
  EXPECT_NEAR(hand->X_WT.p.x, 0.1, 0.01);
  EXPECT_NEAR(hand->X_WT.p.y, -0.05, 0.01);
  EXPECT_NEAR(hand->X_WT.p.z, 0.095 + 0.105 + 0.098 + 0.095 + 0.055, 0.002);
  EXPECT_NEAR(std::get<JawTruth>(hand->grip).width, 0.06, 1e-3);
  EXPECT_EQ(std::get<JawTruth>(hand->grip).finger_half, (Vec3{0.007, 0.006, 0.03}));
}

TEST(CubeTable, jaws_of_a_learm_stall_on_a_cube_and_carry_it) {
  LearmCell cell;
  const Vec3 p_W = cell.X_WB * kAt;
  cell.world.add(
      {.edge = kCube, .at = {p_W.x, p_W.y + 0.004}, .yaw = std::atan2(0.02, 0.15) + 0.2});
  cell.jaws(0.05);
  cell.reach(kAbove);
  cell.reach(kAt);
  EXPECT_EQ(cell.world.blocked_width(), kCube);
  cell.jaws(0.005);
  EXPECT_NEAR(cell.width(), kCube, 1e-6) << "the servo stalls";
  ASSERT_EQ(cell.world.cubes()[0].where, CubePlace::kHeld);
  cell.reach(kAbove);
  EXPECT_GT(cell.world.cubes()[0].X_WO.p.z, 0.06);
  cell.reach({0.13, -0.08, 0.07});
  cell.reach({0.13, -0.08, 0.014});
  cell.jaws(0.05);
  const CubeState& cube = cell.world.cubes()[0];
  EXPECT_EQ(cube.where, CubePlace::kTable);
  EXPECT_NEAR(cube.X_WO.p.z, kCube / 2, 1e-9);
  const Vec3 p_B = cell.X_WB.inverse() * cube.X_WO.p;
  EXPECT_NEAR(p_B.x, 0.13, 0.006);
  EXPECT_NEAR(p_B.y, -0.08, 0.006);
  EXPECT_EQ(cell.count(EventKind::kGrasped), 1);
  EXPECT_EQ(cell.count(EventKind::kReleased), 1);
  EXPECT_EQ(cell.count(EventKind::kCrash), 0);
  EXPECT_EQ(cell.count(EventKind::kTipped), 0);
}

TEST(CubeTable, the_jaws_close_for_good_once_the_cube_is_gone) {
  LearmCell cell;
  const Vec3 p_W = cell.X_WB * kAt;
  cell.world.add({.edge = kCube, .at = {p_W.x, p_W.y}, .yaw = std::atan2(0.02, 0.15)});
  cell.jaws(0.05);
  cell.reach(kAbove);
  cell.reach(kAt);
  cell.jaws(0.005);
  ASSERT_NEAR(cell.width(), kCube, 1e-6);
  cell.world.take_away(0);
  cell.wait(1s);
  EXPECT_NEAR(cell.width(), 0.005, 1e-3);
}

TEST(CubeTable, what_is_held_weighs_on_the_joints) {
  std::array<double, 2> shoulder{};
  for (const std::size_t cubes : {0U, 1U}) {
    CubeWorldSettings settings;
    settings.density = 16'000;  // a quarter of a kilogram
    LearmCell cell(settings);
    const Vec3 p_W = cell.X_WB * kAt;
    if (cubes > 0) cell.world.add({.edge = kCube, .at = {p_W.x, p_W.y}});
    cell.jaws(0.05);
    cell.reach(kAbove);
    cell.reach(kAt);
    cell.jaws(kCube);
    cell.reach({0.2, 0, 0.1});
    EXPECT_EQ(cell.world.held_mass() > 0.2, cubes > 0);
    shoulder[cubes] = cell.shoulder();
  }
  EXPECT_GT(shoulder[1], shoulder[0] + 0.005) << "the arm sags forward";
}

TEST(CubeTable, an_arm_that_is_put_somewhere_else_sweeps_nothing_and_holds_nothing) {
  LearmCell cell;
  const LastingState upright = cell.table->lasting_state();
  const Vec3 p_W = cell.X_WB * kAt;
  cell.world.add({.edge = kCube, .at = {p_W.x, p_W.y}, .yaw = std::atan2(0.02, 0.15)});
  cell.jaws(0.05);
  cell.reach(kAbove);
  cell.reach(kAt);
  cell.jaws(0.005);
  ASSERT_TRUE(cell.world.is_held(0));
  EXPECT_FALSE(cell.table->restore({}));
  EXPECT_TRUE(cell.world.is_held(0)) << "a state that is none changes nothing";
  ASSERT_TRUE(cell.table->restore(upright));
  EXPECT_FALSE(cell.world.is_held(0));
  EXPECT_EQ(cell.world.held_mass(), 0);
  const CubeState& cube = cell.world.cubes()[0];
  EXPECT_EQ(cube.where, CubePlace::kTable);
  EXPECT_LT(std::hypot(cube.X_WO.p.x - p_W.x, cube.X_WO.p.y - p_W.y), 0.005);
  EXPECT_EQ(cell.count(EventKind::kPushed), 0);
}

/// A MaxArm over a table, sent to heights of its cup.
struct MaxarmCell {
  MaxarmCell() : cubes({}) {
    auto machine = std::make_unique<MaxArmMachine>(model, MaxArmChecksum::kSpec,
                                                   MaxArmVariant::kArduino, 3, now);
    now += 20s;
    machine->advance(now);
    table = std::make_unique<CubeTable>(std::move(machine), model, X_WB, cubes, 0, now);
  }

  void tell(const maxarm::Request& request, Duration time) {
    table->receive(maxarm::encode_request(request), now);
    table->advance(now += time);
  }
  Vec3 cup() const { return hand_of(model, table->truth(), X_WB)->X_WT.p; }
  /// Twice, since it sags by some millimetres.
  void reach(const Vec3& p_BT) {
    Vec3 sent = p_BT + Vec3{0, 0, cup_reach(model)};
    for (int i = 0; i < 2; ++i) {
      const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
      const auto q = kinematics::inverse(geometry, model.joints, sent).value();
      const auto& servos = model.device.settings.get<MaxArmDevice>().servos;
      maxarm::SetAngle move{{}, 1000};
      for (std::size_t k = 0; k < 3; ++k) {
        move.pulses[k] = static_cast<std::uint16_t>(
            std::lround(servos[k].offset + servos[k].pulses_per_rad * q[k]));
      }
      tell(move, 2s);
      sent.z += (p_BT.z - (X_WB.inverse() * cup()).z);
    }
  }

  RobotModel model = test::robot("maxarm");
  Pose<frame::World, frame::Base> X_WB{rotation_z(0.5), {0.05, 0.1, 0}};
  OwnCubes cubes;
  CubeWorld& world = cubes.world;
  Instant now{};
  std::unique_ptr<CubeTable> table;
};

TEST(CubeTable, cup_of_a_maxarm_takes_a_cube_with_its_pump_and_drops_it_without) {
  MaxarmCell cell;
  constexpr double kLarge = 0.03;
  const Vec3 p_W = cell.X_WB * Vec3{0.03, -0.18, 0};
  cell.world.add({.edge = kLarge, .at = {p_W.x, p_W.y}});
  cell.reach({0.03, -0.18, 0.08});
  cell.reach({0.03, -0.18, kLarge});
  EXPECT_NEAR(cell.cup().z, kLarge, 2e-3);
  EXPECT_EQ(cell.world.cubes()[0].where, CubePlace::kTable);
  cell.tell(maxarm::SetSuction{1}, 200ms);
  ASSERT_EQ(cell.world.cubes()[0].where, CubePlace::kHeld);
  cell.reach({0.03, -0.18, 0.1});
  EXPECT_NEAR(cell.world.cubes()[0].X_WO.p.z, 0.1 - kLarge / 2, 4e-3);
  cell.reach({-0.05, -0.17, 0.045});
  cell.tell(maxarm::SetSuction{2}, 200ms);
  EXPECT_EQ(cell.world.cubes()[0].where, CubePlace::kTable);
  const Vec3 p_B = cell.X_WB.inverse() * cell.world.cubes()[0].X_WO.p;
  EXPECT_NEAR(p_B.x, -0.05, 5e-3);
  EXPECT_NEAR(p_B.z, kLarge / 2, 1e-9);
  EXPECT_EQ(std::ranges::count(cell.world.events(), EventKind::kCrash, &CubeEvent::kind), 0);
}

TEST(CubeTable, robots_without_a_known_hand_have_none) {
  for (const char* id : {"bigrobotarm", "hexapod"}) {
    const RobotModel& model = test::robot(id);
    Truth truth;
    for (const Joint& joint : model.joints) truth.joints.push_back({.q = joint.home});
    EXPECT_FALSE(hand_of(model, truth, {})) << id;
  }
  Truth truth;
  for (int i = 0; i < 5; ++i) truth.joints.push_back({});
  EXPECT_TRUE(hand_of(test::robot("learm"), truth, {}));
  truth.joints.pop_back();
  EXPECT_FALSE(hand_of(test::robot("learm"), truth, {})) << "that is another machine's";
}

}  // namespace
}  // namespace sinew::sim
