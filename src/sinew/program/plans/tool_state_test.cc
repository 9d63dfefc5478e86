#include "sinew/model/tool_state.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/program/plans/row_offers.h"
#include "support/robots.h"

// Programs of a gripper with jaws: where the tips are follows their width, and so does what they
// may hit.

namespace sinew::program {
namespace {

constexpr double kOpen = 60e-3, kGrip = 24e-3;  // m

/// A cube of 25 mm on the LeArm's own table, 180 mm before it: fetched and put down elsewhere.
constexpr std::string_view kFetch =
    "joint base=0deg shoulder=20deg elbow=60deg wrist=60deg roll=0deg\n"
    "jaws 60mm\n"
    "move x=180mm y=0mm z=60mm\n"
    "line z=30.5mm\n"
    "jaws 24mm holds=25mm\n"
    "line z=80mm\n"
    "move y=100mm\n"
    "line z=12.5mm\n"
    "jaws 60mm\n"
    "line z=80mm\n";

std::expected<Plan, Refusal> planned(std::string_view text, const Standing& start) {
  const RobotModel& robot = test::robot("learm");
  return make_plan(*parse(text, "p", robot), robot, start);
}
std::expected<Plan, Refusal> planned(std::string_view text) {
  return planned(text, home_joints(test::robot("learm")));
}

Vec3 tips(const JointVector& q, double jaws) {
  const RobotModel& robot = test::robot("learm");
  const auto& geometry = std::get<SerialGeometry>(robot.geometry);
  const kinematics::SerialArm arm(geometry, robot.joints, kinematics::tool_pose(geometry, jaws));
  return arm.forward({q.data(), q.size()}).p;
}

std::vector<MoveOrder> moves_of(const Plan& plan) {
  std::vector<MoveOrder> moves;
  for (const Order& order : plan.orders) {
    if (const auto* move = std::get_if<MoveOrder>(&order.what)) moves.push_back(*move);
  }
  return moves;
}

TEST(ToolState, a_cube_on_the_table_is_grasped_and_put_down_where_the_rows_say) {
  const auto plan = planned(kFetch);
  ASSERT_TRUE(plan) << plan.error().line << info(plan.error().error.code).name;
  const auto moves = moves_of(*plan);
  ASSERT_EQ(moves.size(), 7U);
  const auto expect_tips = [](const MoveOrder& move, double jaws, const Vec3& p_mm) {
    EXPECT_EQ(move.tool.jaws, jaws);
    const Vec3 p = tips(move.q, jaws);
    EXPECT_LT(norm(p - 1e-3 * p_mm), 1e-6) << 1e3 * p.x << " " << 1e3 * p.y << " " << 1e3 * p.z;
  };
  EXPECT_EQ(moves[0].tool.jaws, std::nullopt) << "nobody has told them yet";
  expect_tips(moves[2], kOpen, {180, 0, 30.5});
  // Closing by 36 mm takes the tips 18 mm farther along an approach that is nearly straight down.
  EXPECT_NEAR(tips(moves[2].q, kGrip).z, 12.5e-3, 0.5e-3);
  const Vec3 fetched = tips(moves[2].q, kGrip);
  expect_tips(moves[3], kGrip, {1e3 * fetched.x, 1e3 * fetched.y, 80});
  expect_tips(moves[4], kGrip, {1e3 * fetched.x, 100, 80});
  EXPECT_EQ(moves[4].tool.held, 25e-3);
  const Vec3 put_down = tips(moves[4].q, kGrip);
  expect_tips(moves[5], kGrip, {1e3 * put_down.x, 100, 12.5});
  const Vec3 let_go = tips(moves[5].q, kOpen);
  expect_tips(moves[6], kOpen, {1e3 * let_go.x, 1e3 * let_go.y, 80});
  EXPECT_EQ(moves[6].tool.held, std::nullopt);
}

TEST(ToolState, jaws_that_would_close_into_the_table_are_refused_and_their_remedy_works) {
  const std::string low =
      "joint base=0deg shoulder=20deg elbow=60deg wrist=60deg roll=0deg\n"
      "jaws 60mm\nmove x=180mm y=0mm z=60mm\nline z=12.5mm\n";
  const auto refused = planned(low + "jaws 24mm\n");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().line, 5);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kJawsContact);
  EXPECT_NEAR(refused.error().error.limit, 18e-3, 1e-9);
  EXPECT_TRUE(planned(low + "line frame=tool dz=-18mm\njaws 24mm\n"));
}

TEST(ToolState, what_is_held_keeps_off_the_table_until_it_is_let_go) {
  const std::string low =
      "joint base=0deg shoulder=20deg elbow=60deg wrist=60deg roll=0deg\n"
      "jaws 30mm\nmove x=180mm y=0mm z=120mm\n";
  EXPECT_TRUE(planned(low + "line z=30mm\n"));
  EXPECT_TRUE(planned(low + "jaws 24mm holds=25mm\nline z=30mm\n"));
  const auto refused = planned(low + "jaws 24mm holds=80mm\nline z=30mm\n");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kCollision);
  EXPECT_TRUE(planned(low + "jaws 24mm holds=80mm\njaws 30mm\nline z=30mm\n"));
}

TEST(ToolState, a_plan_begins_with_the_jaws_as_they_are) {
  const JointVector q{0, from_deg(20), from_deg(60), from_deg(60), 0};
  for (const double jaws : {0.0, kGrip, kOpen}) {
    const auto plan = planned("line dz=10mm\n", {Start(q), ToolState{jaws, {}}});
    ASSERT_TRUE(plan);
    const JointVector end = moves_of(*plan)[0].q;
    EXPECT_LT(norm(tips(end, jaws) - tips(q, jaws) - Vec3{0, 0, 10e-3}), 1e-6) << jaws;
  }
}

TEST(ToolState, a_line_to_taught_joints_ends_at_them_whatever_the_jaws_do) {
  const RobotModel& robot = test::robot("learm");
  const JointVector taught{from_deg(10), from_deg(25), from_deg(60), from_deg(60), 0};
  const TaughtPoints points{
      {.name = "there", .robot = "learm", .place = taught, .source = "", .taught_at = ""}};
  const JointVector q{0, from_deg(20), from_deg(60), from_deg(60), 0};
  for (const double jaws : {0.0, kGrip, kOpen}) {
    for (const char* row : {"line to=there\n", "move to=there\n"}) {
      Surroundings around;
      around.points = &points;
      const auto program = parse(row, "p", robot, around);
      ASSERT_TRUE(program);
      const auto plan = make_plan(*program, robot, {Start(q), ToolState{jaws, {}}});
      ASSERT_TRUE(plan);
      const JointVector end = moves_of(*plan)[0].q;
      for (std::size_t j = 0; j < 5; ++j) EXPECT_NEAR(end[j], taught[j], 1e-6) << row << jaws;
    }
  }
}

// Rows that name no orientation.

double pitch_of(const JointVector& q) {
  return q[1] + q[2] + q[3];
}

TEST(OpenAttitude, the_pitch_at_hand_is_kept_where_it_is_in_reach_and_chosen_where_it_is_not) {
  const JointVector level{0, from_deg(30), from_deg(30), from_deg(30), 0};
  const auto kept = planned("move x=280mm z=180mm\n", level);
  ASSERT_TRUE(kept);
  EXPECT_NEAR(pitch_of(moves_of(*kept)[0].q), from_deg(90), 1e-6);
  // From straight up nothing near the table is in reach without a turn.
  for (const char* row : {"move x=200mm y=0mm z=60mm\n", "move x=150mm y=-60mm z=80mm\n"}) {
    const auto chosen = planned(row);
    ASSERT_TRUE(chosen) << row;
    EXPECT_GT(pitch_of(moves_of(*chosen)[0].q), from_deg(120)) << "as its inverse: down first";
    EXPECT_FALSE(planned(std::string(row).insert(std::string(row).find('\n'), " pitch=0deg")));
  }
}

TEST(OpenAttitude, a_line_turns_as_little_as_it_has_to_and_what_is_out_of_reach_stays_refused) {
  const JointVector down{0, from_deg(20), from_deg(75), from_deg(75), 0};
  const auto farther = planned("line x=260mm z=60mm\n", down);
  ASSERT_TRUE(farther);
  EXPECT_LT(norm(tips(moves_of(*farther)[0].q, kOpen) - Vec3{0.260, 0, 0.060}), 1e-6);
  const auto beyond = planned("move x=600mm y=0mm z=60mm\n", down);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().error.code, ErrorCode::kOutOfReach);
}

/// Of all pitches the one that misses the point by least, m.
double missing_at_best(const std::string& row) {
  double least = 1;
  for (int pitch = 0; pitch <= 180; ++pitch) {
    const auto plan = planned(row + " pitch=" + std::to_string(pitch) + "deg\n");
    if (plan) return 0;
    if (plan.error().error.code != ErrorCode::kOutOfReach) continue;
    least = std::min(least, excess(plan.error().error));
  }
  return least;
}

TEST(OpenAttitude, what_no_pitch_reaches_is_refused_by_what_is_missing_and_the_nearest_is_offered) {
  for (const std::string row : {"move x=380mm y=0mm z=100mm", "line x=300mm y=-200mm z=250mm"}) {
    SCOPED_TRACE(row);
    const double missing = missing_at_best("move" + row.substr(4));
    ASSERT_GT(missing, 5e-3);
    const auto refused = planned(row + "\n");
    ASSERT_FALSE(refused);
    ASSERT_TRUE(refused.error().way);
    const planning::MoveProposal& offer = refused.error().way->proposal;
    const Error& error = offer.at_target ? *offer.at_target : refused.error().error;
    EXPECT_EQ(error.code, ErrorCode::kOutOfReach);
    EXPECT_NEAR(excess(error), missing, 0.1e-3);
    ASSERT_TRUE(offer.near);
    EXPECT_NEAR(offer.near->left, missing, 0.2e-3);
    const auto rows = offers(*refused.error().way, test::robot("learm"));
    ASSERT_FALSE(rows.empty());
    EXPECT_TRUE(planned(rows[0].substr(rows[0].find(": ") + 2) + "\n")) << rows[0];
  }
  // Stretched out it reaches 353 mm.
  for (const char* row : {"move x=353.05mm z=95mm\n", "move x=353.08mm z=95mm\n"}) {
    const auto near = planned(row);
    ASSERT_TRUE(near) << row;
    EXPECT_LT(norm(tips(moves_of(*near)[0].q, kOpen) - Vec3{0.35305, 0, 0.095}), 0.12e-3);
  }
}

TEST(OpenAttitude, over_the_table_a_place_is_offered_that_is_clear_of_it) {
  const auto refused = planned("move x=200mm y=0mm z=5mm\n");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().error.code, ErrorCode::kCollision);
  const auto rows = offers(*refused.error().way, test::robot("learm"));
  ASSERT_FALSE(rows.empty());
  for (const std::string& row : rows) {
    const std::string words = row.substr(row.find(": ") + 2) + "\n";
    if (words.starts_with("jaws")) {
      EXPECT_TRUE(planned(words + "move x=200mm y=0mm z=5mm\n")) << row;
    } else {
      EXPECT_TRUE(planned(words)) << row;
    }
  }
}

TEST(ToolState, where_open_jaws_make_a_refused_row_work_that_is_said) {
  const std::string row = "move x=200mm y=0mm z=20mm\n";
  const auto refused = planned(row);
  ASSERT_FALSE(refused);
  ASSERT_TRUE(refused.error().way);
  EXPECT_EQ(refused.error().way->jaws_first, kOpen);
  EXPECT_TRUE(planned("jaws 60mm\n" + row));
  EXPECT_TRUE(offers(*refused.error().way, test::robot("learm"))[0].ends_with(": jaws 60mm"));
  // Known to be shut: nothing is said of what nobody asked.
  const auto shut = planned(row, {Start(home_joints(test::robot("learm"))), ToolState{0.0, {}}});
  EXPECT_TRUE(shut || !shut.error().way->jaws_first);
}

TEST(ToolState, jaws_that_go_30_mm_on_are_told_a_row_that_works) {
  const std::string low =
      "joint base=0deg shoulder=20deg elbow=60deg wrist=60deg roll=0deg\n"
      "jaws 60mm\nmove x=180mm y=0mm z=60mm\nline z=12.5mm\n";
  const auto refused = planned(low + "jaws 0mm\n");
  ASSERT_FALSE(refused);
  const std::string sentence = describe(refused.error().error);
  EXPECT_NE(sentence.find(" 30 mm farther"), std::string::npos) << sentence;
  const std::string remedy = sentence.substr(sentence.find("line frame=tool")) + "\n";
  EXPECT_TRUE(planned(low + remedy + "jaws 0mm\n")) << remedy;
}

}  // namespace
}  // namespace sinew::program
