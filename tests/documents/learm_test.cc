#include <gtest/gtest.h>

#include <array>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_device_jog.h"
#include "sinew/devices/lsc/lsc_driver_units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

// The LeArm's document: the numbers of its tables, typed as they stand there. Its frames are in
// tests/golden/lsc.txt, its poses in config/builtin_geometry_test.cc, its reach straight down in
// kinematics/serial_ik_test.cc, its boards in devices/lsc/lsc_device_test.cc.

namespace sinew {
namespace {

TEST(LearmDocument, at_rest_it_has_the_servos_where_its_makers_firmware_puts_them) {
  // The built-in arm with the firmware's lengths: x 150 mm, z 20 mm above its turntable, the hand
  // 53 deg below the horizon.
  RobotModel model = test::robot("learm");
  auto& geometry = std::get<SerialGeometry>(model.geometry);
  geometry.rows[0].d = from_mm(Esp32Links::kBase);
  geometry.rows[1].a = from_mm(Esp32Links::kUpper);
  geometry.rows[2].a = from_mm(Esp32Links::kFore);
  geometry.rows[4].d = from_mm(Esp32Links::kHand);
  geometry.gripper.reset();
  const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry));
  const auto branches = arm.inverse_at_pitch({from_mm(150), 0, from_mm(20)}, from_deg(90 + 53));
  ASSERT_TRUE(branches);
  ASSERT_TRUE((*branches)[0].within_limits);
  const auto& servos = model.device.settings.get<LscDevice>().servos;
  const auto pulse = [&](std::size_t i) {
    return servos[i].centre + servos[i].trim + servos[i].units_per_rad * (*branches)[0].q[i];
  };
  EXPECT_NEAR(pulse(0), 1500, 1e-6);
  // The chain's own figures, to the microsecond, and the firmware's table within one degree.
  const std::array<std::array<double, 2>, 3> told{{{1261, 1255}, {522, 511}, {651, 644}}};
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_NEAR(pulse(i + 1), told[i][0], 0.6) << i;
    EXPECT_NEAR(pulse(i + 1), told[i][1], 11.5) << i;
  }
}

/// What a servo is sent with its joint at so many degrees.
double pulse_at(const LscServo& servo, double degrees) {
  return servo.centre + servo.trim + servo.units_per_rad * from_deg(degrees);
}

TEST(LearmDocument, a_quarter_turn_of_each_joint_is_a_whole_end_of_its_servo) {
  struct Row {
    int id;
    double plus, minus;  // us at +90 and -90 deg
  };
  // 1500 + s 2000/180 q; ids 4 and 3 turn against the model. The document's code sends theta 0..180
  // as 500..2500 to all of them, which puts its zero at one end of every servo and turns two the
  // wrong way: ours stands straight up at 1500 everywhere.
  constexpr std::array<Row, 5> kRows{
      {{6, 2500, 500}, {5, 2500, 500}, {4, 500, 2500}, {3, 500, 2500}, {2, 2500, 500}}};
  const auto& servos = test::robot("learm").device.settings.get<LscDevice>().servos;
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    EXPECT_EQ(servos[i].id, kRows[i].id);
    EXPECT_NEAR(pulse_at(servos[i], 90), kRows[i].plus, 1e-9);
    EXPECT_NEAR(pulse_at(servos[i], -90), kRows[i].minus, 1e-9);
    EXPECT_NEAR(pulse_at(servos[i], 0), 1500, 1e-9);
  }
}

TEST(LearmDocument, bus_servos_go_240_deg_in_1000_and_the_jaws_from_200_to_700) {
  const auto bus = runtime::variant_of(test::robot("learm"), "bus", std::nullopt);
  ASSERT_TRUE(bus);
  const auto& device = bus->device.settings.get<LscDevice>();
  for (const LscServo& servo : device.servos) {
    const double low = std::min(pulse_at(servo, 90), pulse_at(servo, -90));
    const double high = std::max(pulse_at(servo, 90), pulse_at(servo, -90));
    EXPECT_NEAR(low, 125, 1e-9);
    EXPECT_NEAR(high, 875, 1e-9);
    EXPECT_NEAR(std::abs(servo.units_per_rad) * from_deg(240), 1000, 1e-9);
  }
  EXPECT_EQ(device.gripper.open, 200);
  EXPECT_EQ(device.gripper.closed, 700);
}

TEST(LearmDocument, each_kits_jaws_open_and_close_where_it_says) {
  struct Row {
    const char* profile;
    double open, closed;  // us
  };
  for (const Row& row : {Row{"lsc6", 1500, 2500}, Row{"esp32", 500, 1500}}) {
    const auto robot = runtime::variant_of(test::robot("learm"), row.profile, std::nullopt);
    ASSERT_TRUE(robot);
    const auto& jaws = robot->device.settings.get<LscDevice>().gripper;
    EXPECT_EQ(jaws.open, row.open) << row.profile;
    EXPECT_EQ(jaws.closed, row.closed) << row.profile;
  }
}

TEST(LearmDocument, the_tips_reach_85_mm_with_closed_jaws_and_half_the_width_less_with_open_ones) {
  // The document's 0 < x < 30 is half the width, although its docstring calls it the whole.
  const auto& jaws = *std::get<SerialGeometry>(test::robot("learm").geometry).gripper;
  EXPECT_NEAR(to_mm(jaws.width_max), 60, 1e-9);
  EXPECT_NEAR(to_mm(jaws.reach_closed), 85, 1e-9);
}

}  // namespace
}  // namespace sinew
