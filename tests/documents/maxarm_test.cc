#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "sinew/devices/maxarm/maxarm_test_cell.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/program/plans/row_planner.h"
#include "support/golden.h"
#include "support/robots.h"

// The MaxArm's document: its numbers and its words, typed as they stand there. Its frames are in
// tests/golden/maxarm.txt, its points, angles, pulses and reach in kinematics/palletizer_test.cc,
// what its firmware does in devices/maxarm/maxarm_device_test.cc.

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Whether the frame left the host.
testing::AssertionResult sends(const test::MaxArmCell& cell, const std::string& frame) {
  const Bytes bytes = test::from_hex(frame);
  if (!std::ranges::search(cell.sent, bytes).empty()) return testing::AssertionSuccess();
  auto out = testing::AssertionFailure() << "sent:" << std::hex;
  for (const std::uint8_t byte : cell.sent) out << " " << int{byte};
  return out;
}

TEST(MaxArmDocument, tool_rows_send_the_frames_that_it_prints) {
  struct Row {
    const char* row;
    const char* frame;
  };
  // set_pwmservo takes 0..180 degrees of the servo, 500..2500 us.
  for (const Row& row :
       {Row{"nozzle 90deg time=1s", "AA 55 05 04 DC 05 E8 03 2A"},
        Row{"nozzle 45deg time=1s", "AA 55 05 04 E8 03 E8 03 20"},
        Row{"nozzle 45deg", "AA 55 05 04 E8 03 E8 03 20"},
        Row{"nozzle 135deg time=1s", "AA 55 05 04 D0 07 E8 03 34"},
        Row{"suction on", "AA 55 07 01 01 F6"},
        // The document prints F6 for it, a slip: the sum is F5.
        Row{"suction release", "AA 55 07 01 02 F5"}, Row{"suction off", "AA 55 07 01 03 F4"}}) {
    test::MaxArmCell cell;
    const auto program = program::parse(row.row, "p", cell.robot);
    ASSERT_TRUE(program) << row.row;
    const auto& action = std::get<program::ToolStep>(program->steps[0].what).action;
    ASSERT_TRUE(cell.driver.tool(action, cell.now));
    cell.run_to_end(std::chrono::seconds(10));
    EXPECT_TRUE(sends(cell, row.frame)) << row.row;
  }
}

TEST(MaxArmDocument, the_nozzles_range_is_0_to_180_deg_and_nothing_else_is_sent) {
  const RobotModel& robot = test::robot("maxarm");
  for (const auto& [row, fine] : {std::pair{"nozzle 0deg time=20ms", true},
                                  {"nozzle 180deg time=1s", true},
                                  {"nozzle -1deg time=1s", false},
                                  {"nozzle 181deg time=1s", false}}) {
    const auto program = program::parse(row, "p", robot);
    ASSERT_TRUE(program) << row;
    EXPECT_EQ(program::make_plan(*program, robot, home_joints(robot)).has_value(), fine) << row;
  }
}

/// The SET_ANGLE that a row becomes from where the arm stands.
maxarm::SetAngle set_angle_of(const std::string& row) {
  test::MaxArmCell cell;
  const RobotModel& robot = test::robot("maxarm");
  const auto program = program::parse(row, "p", robot);
  EXPECT_TRUE(program) << row;
  JointVector from;
  for (const JointPosition& position : cell.driver.positions()) from.push_back(position.q);
  program::RowPlanner planner(robot);
  const auto motion = planner.plan(from, {}, program->steps);
  EXPECT_TRUE(motion && motion->pieces.size() == 1) << row;
  EXPECT_TRUE(cell.driver.move(motion->pieces[0], cell.now));
  cell.run_to_end(std::chrono::seconds(10));
  maxarm::RequestDecoder decoder;
  maxarm::SetAngle sent;
  for (const std::uint8_t byte : cell.sent) {
    const auto request = decoder.push(byte);
    if (request && std::holds_alternative<maxarm::SetAngle>(*request)) {
      sent = std::get<maxarm::SetAngle>(*request);
    }
  }
  return sent;
}

TEST(MaxArmDocument, a_row_says_the_milliseconds_of_its_move) {
  // 0..1000 is 0..240 deg: p1 = a1 1000/240, p2 = (210 - a2) 1000/240, p3 = (a3 + 120) 1000/240.
  struct Row {
    const char* row;
    std::array<int, 3> pulses;
    int time_ms;
  };
  for (const Row& row :
       {Row{"joint base=48deg shoulder=90deg forearm=0deg time=2s", {200, 500, 500}, 2000},
        Row{"joint base=90deg shoulder=100deg forearm=20deg time=3s", {375, 458, 583}, 3000}}) {
    const maxarm::SetAngle sent = set_angle_of(row.row);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(sent.pulses[i], row.pulses[i]) << row.row;
    // Ours may be a few ms longer: there is no acknowledgement, so a frame is chosen that no single
    // fault on the wire turns into another one.
    EXPECT_GE(sent.time_ms, row.time_ms) << row.row;
    EXPECT_LE(sent.time_ms, row.time_ms + 20) << row.row;
  }
}

TEST(MaxArmDocument, points_that_its_firmware_would_throw_to_the_end_stops_are_refused) {
  // set_xyz (03) is never sent: the Arduino firmware swings servos 2 and 3 to pulse 0 there.
  const auto& robot = test::robot("maxarm");
  const auto& geometry = std::get<PalletizerGeometry>(robot.geometry);
  for (const Vec3& p : {Vec3{0, -100, 240}, Vec3{100, 100, 100}, Vec3{0, 0, 214}}) {
    EXPECT_FALSE(kinematics::inverse(geometry, robot.joints, 1e-3 * p)) << p.x << " " << p.y;
  }
  // The vendor's home sits exactly on a limit.
  EXPECT_TRUE(kinematics::inverse(geometry, robot.joints, 1e-3 * Vec3{0, -162.94, 212.8}));
}

/// How far the nozzle strays from the straight line while the three servos go evenly: from the line
/// itself, and from where an even motion on it would be; mm.
std::array<double, 2> bow(const Vec3& from, const Vec3& to) {
  const RobotModel& model = test::robot("maxarm");
  const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
  const Vec3 a = 1e-3 * from;
  const Vec3 b = 1e-3 * to;
  const auto start = kinematics::inverse(geometry, model.joints, a);
  const auto end = kinematics::inverse(geometry, model.joints, b);
  EXPECT_TRUE(start && end);
  std::array<double, 2> worst{};
  for (int k = 0; k <= 1000; ++k) {
    const double share = k / 1000.0;
    JointVector q = *start;
    // Pulses are a straight function of the angles, so even in the one is even in the other.
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += share * ((*end)[i] - (*start)[i]);
    const Vec3 p = kinematics::forward(geometry, {q.data(), q.size()}).p - a;
    const Vec3 line = b - a;
    const double along = dot(p, line) / dot(line, line);
    worst[0] = std::max(worst[0], 1e3 * norm(p - along * line));
    worst[1] = std::max(worst[1], 1e3 * norm(p - share * line));
  }
  return worst;
}

TEST(MaxArmDocument, it_bows_by_as_much_as_was_measured_where_nobody_gives_it_waypoints) {
  EXPECT_NEAR(bow({120, -180, 85}, {-120, -180, 85})[0], 36.3, 0.05);
  const auto out = bow({0, -160, 100}, {0, -250, 100});
  EXPECT_NEAR(out[0], 2.4, 0.05);
  EXPECT_NEAR(out[1], 5.6, 0.05);
}

}  // namespace
}  // namespace sinew
