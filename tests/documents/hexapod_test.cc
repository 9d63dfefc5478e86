#include "sinew/kinematics/hexapod.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_test_cell.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/pose_file.h"
#include "sinew/program/plans/bullride.h"
#include "sinew/program/procedures/procedures.h"
#include "support/robots.h"

// The Stewart platform's document: its numbers and its words, typed as they stand there. Its bytes
// are in tests/golden/icp.txt and tmc222.txt, the census of all 256 and its controller's states in
// devices/icp, its files in program/formats/foreign_files_test.cc.

namespace sinew {
namespace {

using namespace std::chrono_literals;

/// s that driver and simulated controller take for so many units of one leg.
double seconds_for(std::int64_t units, Duration processing) {
  IcpQuirks quirks;
  quirks.processing = processing;
  test::IcpCell cell(quirks);
  cell.begin();
  const Instant start = cell.now;
  EXPECT_TRUE(cell.go({units, 0, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.truth(0), units);
  return to_seconds(cell.now - start);
}

/// Of one unit on the way: what a motion costs once, status and sync, does not count.
double seconds_per_unit(Duration processing) {
  return (seconds_for(1200, processing) - seconds_for(200, processing)) / 1000;
}

TEST(HexapodDocument, it_takes_the_hours_that_its_document_tells) {
  struct Row {
    Duration processing;
    double millimetre_s, stroke_h, six_strokes_h;
  };
  // The document rounds to three digits.
  for (const Row& row :
       {Row{0ms, 19.0, 47.6 / 60, 4.76}, Row{5ms, 41.9, 1.75, 10.5}, Row{10ms, 64.8, 2.70, 16.2}}) {
    const double unit_s = seconds_per_unit(row.processing);
    const double per_mm = test::kIcpUnitsPerM / 1000;
    EXPECT_NEAR(unit_s * per_mm, row.millimetre_s, 0.005 * row.millimetre_s);
    EXPECT_NEAR(unit_s * per_mm * 150 / 3600, row.stroke_h, 0.005 * row.stroke_h);
    EXPECT_NEAR(unit_s * per_mm * 900 / 3600, row.six_strokes_h, 0.005 * row.six_strokes_h);
  }
  EXPECT_NEAR(1 / seconds_per_unit(0ms), 240, 1.2) << "moves a second, as the wire carries";
}

TEST(HexapodDocument, a_unit_is_a_microstep_of_0_7_mm_a_turn) {
  const auto& device = test::robot("hexapod").device.settings.get<IcpDevice>();
  EXPECT_NEAR(1e9 / device.units_per_m, 218.75, 1e-6) << "nm: 0.7 mm / (200 x 16)";
  EXPECT_NEAR(device.units_per_m / 1000, 4571.43, 0.005) << "units a mm";
  // -1 in two's complement. The document also calls it "binary complement", which would be FFFE:
  // commissioning reads TagPos and finds out.
  EXPECT_EQ(device.units_per_down, 1);
}

TEST(HexapodDocument, the_example_geometry_is_ours_until_somebody_measures_the_machine) {
  const RobotModel& robot = test::robot("hexapod");
  const kinematics::Hexapod platform(std::get<HexapodGeometry>(robot.geometry));
  const kinematics::PoseBP home{{}, {0, 0, from_mm(250)}};
  for (const double leg : platform.inverse(home)) EXPECT_NEAR(to_mm(leg), 268.36, 0.005);
  for (const Joint& joint : robot.joints) {
    EXPECT_NEAR(to_mm(joint.lower), 195, 1e-9);
    EXPECT_NEAR(to_mm(joint.upper), 345, 1e-9);
  }
  struct Row {
    double yaw_deg, condition, tolerance;
  };
  for (const Row& row : {Row{0, 3.7, 0.06}, Row{30, 3.9, 0.06}, Row{60, 6.0, 0.06},
                         Row{80, 18, 0.6}, Row{89, 184, 1}}) {
    const kinematics::PoseBP X_BP{rotation_from_fixed_xyz({0, 0, from_deg(row.yaw_deg)}), home.p};
    EXPECT_NEAR(platform.dexterity(X_BP).condition, row.condition, row.tolerance) << row.yaw_deg;
  }
}

TEST(HexapodDocument, lowered_is_a_word_and_means_every_leg_at_its_shortest) {
  const auto plan = program::recovery_procedure(test::robot("hexapod"), {});
  const auto& place = std::get<program::PlaceStep>(plan.steps.back().what);
  ASSERT_EQ(place.places.size(), 2U);
  EXPECT_EQ(place.places[1].name, "lowered");
  for (const double leg : place.places[1].q) EXPECT_NEAR(to_mm(leg), 195, 1e-9);
}

TEST(HexapodDocument, bullriding_for_10_s_takes_the_amplitude_that_is_asked_for) {
  const RobotModel& robot = test::robot("hexapod");
  const JointVector home = home_joints(robot);
  // Six legs share 240 moves a second: 87.5 um for each in 10 s, there and back together.
  const double stroke = robot.joints[0].upper - robot.joints[0].lower;
  const auto ride = [&](double micrometres, double seconds) {
    return program::make_ride(
        robot, home, {.duration = seconds, .seed = 1, .amplitude = 2e-6 * micrometres / stroke});
  };
  for (const double micrometres : {5.0, 20.0, 50.0}) {
    const auto made = ride(micrometres, 10);
    ASSERT_TRUE(made) << micrometres;
    EXPECT_LE(made->duration, 10) << micrometres;
    EXPECT_NEAR(made->amplitude * stroke / 2, 1e-6 * micrometres, 1e-12);
  }
  // What the wire cannot carry in that time is refused, with what it could.
  const auto much = ride(1000, 10);
  ASSERT_FALSE(much);
  EXPECT_EQ(much.error().error.code, ErrorCode::kRideTime);
  EXPECT_TRUE(ride(1000, std::ceil(much.error().error.measured)));
  const double fits =
      program::fitting_ride(robot, home, {.duration = 10, .seed = 1, .amplitude = 0.5});
  EXPECT_GT(fits * stroke / 2, 20e-6);
  EXPECT_TRUE(program::make_ride(robot, home, {.duration = 10, .seed = 1, .amplitude = fits}));
}

TEST(HexapodDocument, a_position_is_24_numbers_of_which_18_count) {
  const RobotModel& robot = test::robot("hexapod");
  const auto& geometry = std::get<HexapodGeometry>(robot.geometry);
  const kinematics::PoseBP X_BP{rotation_from_fixed_xyz({0.02, -0.03, 0.1}),
                                {0.003, -0.004, 0.251}};
  const std::string text =
      program::pose_text(program::pose_file(X_BP, geometry), program::DecimalMark::kComma);
  EXPECT_EQ(std::ranges::count(text, '\n'), 24);
  EXPECT_EQ(text.find('.'), std::string::npos) << "de-DE reads 1.5 as 15";
  const auto read = program::read_pose_file(text, "p.pos");
  ASSERT_TRUE(read);
  const auto fit = program::fit_platform(read->heads, geometry);
  EXPECT_LT(norm(fit.X_BP.p - X_BP.p), 1e-9);
  EXPECT_LT(angle_between(fit.X_BP.R, X_BP.R), 1e-9);
}

}  // namespace
}  // namespace sinew
