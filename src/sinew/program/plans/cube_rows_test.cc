#include "sinew/program/plans/cube_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>

#include "sinew/core/error_code.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/language/conditions.h"
#include "sinew/program/plans/table_things.h"
#include "support/robots.h"

/// Rows that look, pick and place: what is read of them, and what they are made of.
namespace sinew::program {
namespace {

std::expected<Program, std::vector<Complaint>> read_cubes(std::string_view text,
                                                          std::string_view robot = "learm") {
  static const TaughtPoints points{
      {.name = "basket",
       .robot = "learm",
       .place = JointVector{from_deg(60), from_deg(25), from_deg(60), from_deg(55), 0},
       .source = "here",
       .taught_at = ""}};
  return parse(text, "p.sinew", test::robot(robot), {.points = &points, .load = {}});
}

std::string first_complaint(std::string_view text) {
  const auto program = read_cubes(text);
  return program ? "none" : to_text(program.error().front());
}

Standing ready() {
  return {JointVector{from_deg(-40), from_deg(20), from_deg(40), from_deg(40), 0},
          {.jaws = 0.06, .held = {}}};
}

kinematics::PoseBT tool_at(const RobotModel& robot, const JointVector& q, double jaws) {
  const planning::ToolSpace space(robot, jaws);
  return *space.forward({q.data(), q.size()}, space.home());
}

TEST(CanPick, says_which_arms_have_grasps) {
  const auto with_jaws = [](const char* id) {
    RobotModel robot = test::robot(id);
    robot.device = {};  // the ideal one
    std::get<SerialGeometry>(robot.geometry).gripper = JawGripper{0.06, 0.09, 0.09};
    return robot;
  };
  EXPECT_TRUE(can_pick(test::robot("learm")));
  EXPECT_TRUE(can_pick(test::robot("maxarm")));
  EXPECT_TRUE(can_pick(with_jaws("puma560")));
  EXPECT_FALSE(can_pick(test::robot("puma560"))) << "it has no jaws";
  EXPECT_FALSE(can_pick(test::robot("hexapod")));
  EXPECT_FALSE(can_pick(with_jaws("bigrobotarm"))) << "its forearm rolls";
  RobotModel undriven = with_jaws("robot-arm-2");
  undriven.device = test::robot("robot-arm-2").device;
  EXPECT_FALSE(can_pick(undriven)) << "no board of it drives jaws";
}

TEST(CubeRows, are_read_with_their_colors_and_places) {
  const auto program = read_cubes(
      "look\npick\npick any\npick color=red\nplace basket\nplace to=basket speed=50%\n"
      "place x=200mm y=0mm z=40mm\nif seen\nend\nif seen color=blue\nend\n"
      "repeat while seen color=green\n wait 1s\nend\n");
  ASSERT_TRUE(program) << to_text(program.error().front());
  const auto& steps = program->steps;
  EXPECT_TRUE(std::holds_alternative<LookStep>(steps[0].what));
  EXPECT_FALSE(std::get<PickCubeStep>(steps[1].what).color);
  EXPECT_FALSE(std::get<PickCubeStep>(steps[2].what).color);
  EXPECT_EQ(std::get<PickCubeStep>(steps[3].what).color, vision::ColorName::kRed);
  const auto& basket = std::get<PlaceCubeStep>(steps[4].what);
  EXPECT_EQ(std::get<JointStep>(basket.there).q[0], from_deg(60));
  const auto& slow = std::get<PlaceCubeStep>(steps[5].what);
  EXPECT_EQ(std::get<JointStep>(slow.there).how.joint_share, 0.5);
  const auto& there = std::get<PlaceCubeStep>(steps[6].what);
  EXPECT_EQ(std::get<ToolMoveStep>(there.there).to.p_BT[2], 0.04);
  EXPECT_EQ(condition_text(std::get<IfStep>(steps[7].what).condition, test::robot("learm")),
            "seen");
  EXPECT_EQ(condition_text(std::get<IfStep>(steps[9].what).condition, test::robot("learm")),
            "seen color=blue");
  const auto& loop = std::get<LoopStep>(steps[11].what);
  ASSERT_TRUE(loop.goes_on);
  EXPECT_EQ(loop.goes_on->color, vision::ColorName::kGreen);
  EXPECT_EQ(loop.rounds, kSeenRoundsMax);
  EXPECT_EQ(loop.end, 13U);
}

TEST(CubeRows, pick_at_takes_the_cube_that_lies_there_and_no_other) {
  const RobotModel& robot = test::robot("learm");
  RowPlanner planner(robot);
  const auto program = parse("pick at=180mm,40mm,25mm\n", "p.sinew", robot);
  ASSERT_TRUE(program) << to_text(program.error().front());
  const Standing standing{home_joints(robot), {}};
  const grasping::Cube near{{0.15, -0.02, 0.0125}, 0.1, 0.025, 0};
  const grasping::Cube there{{0.183, 0.043, 0.0125}, 0.4, 0.025, 1};
  const auto rows = rows_to_pick(planner, standing, program->steps[0], {{near, there}});
  ASSERT_TRUE(rows) << describe(rows.error().error);
  EXPECT_EQ(rows->cube.p_BO, there.p_BO);
  const auto none = rows_to_pick(planner, standing, program->steps[0], {{near}});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().error.code, ErrorCode::kNothingSeen);
}

TEST(CubeRows, what_is_wrong_with_a_row_is_said_with_what_would_be_right) {
  const std::pair<const char*, const char*> wrong[] = {
      {"look here now", "p.sinew:1:11: too many words; write look, or look CAMERA"},
      {"pick red", "p.sinew:1:6: 'red': write pick, pick color=red, or pick at=180mm,0mm,25mm"},
      {"pick at=180mm,0mm", "p.sinew:1:6: '180mm,0mm': a point is X,Y,Z, as in 200mm,0mm,150mm"},
      {"pick color=read",
       "p.sinew:1:6: 'read' is no color of a cube; there are red, orange, yellow, green, blue, "
       "purple, pink, black, wood"},
      {"place",
       "p.sinew:1:1: say where: place basket, place NAME (a basket or a taught point), or place "
       "x=200mm y=0mm z=30mm"},
      {"place baskte", ""},
      {"place basket blend=10mm", "p.sinew:1:1: place stops where it lets go: without blend="},
      {"if seen red\nend", "p.sinew:1:9: write seen, or seen color=red"},
      {"wait until seen for 3s",
       "p.sinew:1:12: a wait does not look; write if seen, or repeat while seen"},
      {"repeat 3\nend", "p.sinew:1:1: write repeat while seen, or repeat while seen color=red"},
      {"repeat while seen", "p.sinew:1:1: repeat without end: write end behind its last step"},
      {"repeat while seen\nelse\nend", "p.sinew:2:1: else without if"},
  };
  for (const auto& [text, complaint] : wrong) {
    const std::string told = first_complaint(text);
    EXPECT_NE(told, "none") << text;
    if (*complaint != '\0') {
      EXPECT_EQ(told, complaint);
    }
  }
}

TEST(CubeRows, are_laid_out_like_all_others) {
  const auto laid_out =
      format("repeat while seen color=red\nif seen color=blue\npick color=blue\nend\nend", "p");
  ASSERT_TRUE(laid_out);
  EXPECT_EQ(*laid_out,
            "repeat while seen color=red\n  if seen color=blue\n    pick color=blue\n  end\nend\n");
}

TEST(CubeRows, place_lets_go_there_from_above_and_ends_where_it_began) {
  const RobotModel robot = test::robot("learm");
  RowPlanner planner(robot);
  for (const char* text : {"place basket", "place x=150mm y=60mm z=60mm"}) {
    const auto program = read_cubes(text);
    ASSERT_TRUE(program);
    Standing standing = ready();
    standing.tool = {.jaws = 0.021, .held = 0.025};
    const auto rows = rows_to_place(planner, standing, program->steps[0]);
    ASSERT_TRUE(rows) << text << ": " << describe(rows.error().error);
    EXPECT_EQ(rows->tool.held, std::nullopt);
    EXPECT_GE(*rows->tool.jaws, 0.025 + 0.01);
    EXPECT_GT(rows->duration, 1);
    // The rows, one by one, as a run carries them out.
    JointVector q = *standing.q;
    ToolState tool = standing.tool;
    int let_go = 0;
    double highest = -1;
    for (const Step& step : rows->steps) {
      if (const auto* action = std::get_if<ToolStep>(&step.what)) {
        const double z = tool_at(robot, q, *tool.jaws).p.z;
        EXPECT_LT(z, highest - 0.019) << "it came from above";
        ++let_go;
        const auto& jaws = std::get<JawsTo>(action->action);
        tool = {jaws.width, jaws.held};
        continue;
      }
      const auto motion = planner.plan(q, tool, std::span(&step, 1));
      ASSERT_TRUE(motion) << describe(motion.error().error);
      q = motion->q_end;
      highest = std::max(highest, tool_at(robot, q, *tool.jaws).p.z);
    }
    EXPECT_EQ(let_go, 1);
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], (*standing.q)[i], 1e-9);
  }
}

/// m, from bodies of the arm to boxes, all along the rows; the jaws as they are in each.
double nearest_on_way(RowPlanner& planner, const Standing& begin, const CubeRows& rows,
                      std::span<const planning::Surrounding> boxes) {
  planning::CollisionModel bodies(planner.robot());
  planning::CollisionModel alone(planner.robot());
  bodies.surround(boxes);
  JointVector q = *begin.q;
  ToolState tool = begin.tool;
  double nearest = 1;
  for (const Step& step : rows.steps) {
    if (const auto* action = std::get_if<ToolStep>(&step.what)) {
      const auto& jaws = std::get<JawsTo>(action->action);
      tool = {jaws.width, jaws.held};
      continue;
    }
    const auto motion = planner.plan(q, tool, std::span(&step, 1));
    EXPECT_TRUE(motion) << describe(motion.error().error);
    if (!motion) return -1;
    bodies.fit(tool);
    alone.fit(tool);
    const auto& path = planner.motion().path.joints;
    for (double s = 0; s <= path.length(); s += path.length() / 200) {
      planning::PathPoint at;
      path.sample(s, at);
      const std::span<const double> joints{at.q.data(), q.size()};
      const double near = bodies.distance(joints).distance;
      if (near < alone.distance(joints).distance - 1e-9) nearest = std::min(nearest, near);
    }
    q = motion->q_end;
  }
  return nearest;
}

TEST(CubeRows, pick_keeps_clear_of_cubes_of_others_and_of_baskets_on_its_whole_way) {
  const RobotModel robot = test::robot("learm");
  RowPlanner planner(robot);
  const Basket basket{"tray", {Rotation{}, {0.06, 0.18, 0}}, {0.12, 0.12, 0.05}};
  int picked = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SplitMix64 random(seed);
    Sighting seen;
    for (int tries = 0; tries < 40; ++tries) {
      const double far = random.uniform(0.12, 0.21), turn = random.uniform(-0.6, 0.6);
      const grasping::Cube cube{{far * std::cos(turn), far * std::sin(turn), 0.0125},
                                random.uniform(0, kPi / 2),
                                0.025,
                                0};
      const auto apart = [&](const Vec3& p_BO) { return norm(p_BO - cube.p_BO) > 0.04; };
      const auto at = [](const OtherThing& other) { return other.body.p_BO; };
      if (!std::ranges::all_of(seen.cubes, apart, &grasping::Cube::p_BO) ||
          !std::ranges::all_of(seen.others, apart, at)) {
        continue;
      }
      if (tries % 3 == 2) {
        seen.others.push_back({grasping::body_of(cube)});
      } else {
        seen.cubes.push_back(cube);
      }
    }
    const auto rows =
        rows_to_pick(planner, ready(), {1, PickCubeStep{}, 0}, seen, std::span(&basket, 1));
    if (!rows) continue;
    ++picked;
    std::optional<std::size_t> which;
    for (std::size_t i = 0; i < seen.cubes.size(); ++i) {
      if (seen.cubes[i].p_BO == rows->cube.p_BO) which = i;
    }
    ASSERT_TRUE(which) << "never one of the others";
    const auto things = things_on_table(robot, seen, which, std::span(&basket, 1), 0.025);
    EXPECT_EQ(things.bare.size(), 4 + seen.cubes.size() - 1 + seen.others.size());
    // Of its own start a motion may be as near as it stands.
    EXPECT_GT(nearest_on_way(planner, ready(), *rows, things.bare), robot.collision.margin - 3e-4)
        << "seed " << seed;
  }
  EXPECT_GE(picked, 6);
}

TEST(CubeRows, uncertain_obstacles_are_avoided_where_possible_and_never_cause_a_refusal) {
  const RobotModel robot = test::robot("learm");
  RowPlanner planner(robot);
  const grasping::Cube cube{{0.17, 0, 0.0125}, 0, 0.025, 0};
  const auto clearance = [&](const Sighting& seen) {
    const auto rows = rows_to_pick(planner, ready(), {1, PickCubeStep{}, 0}, seen);
    EXPECT_TRUE(rows);
    const auto things = things_on_table(robot, seen, 0, {}, cube.edge);
    return rows ? nearest_on_way(planner, ready(), *rows, things.bare) : -1;
  };
  // Beside the faces that jaws would close on, so that they take the other pair.
  const auto beside = [&](double x, double y) {
    return OtherThing{{cube.p_BO + Vec3{x, y, 0}, 0.1, {0.016, 0.008, 0.0125}}, false};
  };
  EXPECT_GT(clearance({.cubes = {cube}, .others = {beside(0, 0.025)}}), 2e-3);
  EXPECT_GT(clearance({.cubes = {cube}, .others = {beside(0, -0.025)}}), 2e-3);
  EXPECT_GT(clearance({.cubes = {cube}, .others = {beside(0.033, 0)}}), 2e-3);
  Sighting all_around{
      .cubes = {cube},
      .others = {beside(0, 0.025), beside(0, -0.025), beside(0.033, 0), beside(-0.033, 0)}};
  EXPECT_LT(clearance(all_around), 2e-3) << "it is taken all the same";
  for (OtherThing& other : all_around.others) other.is_likely = true;
  EXPECT_FALSE(rows_to_pick(planner, ready(), {1, PickCubeStep{}, 0}, all_around));
}

TEST(CubeRows, a_cube_without_obstacles_beside_it_is_picked_first) {
  const RobotModel robot = test::robot("learm");
  RowPlanner planner(robot);
  const grasping::Cube near{{0.16, 0.03, 0.0125}, 0, 0.025, 0},
      far{{0.2, -0.06, 0.0125}, 0, 0.025, 1};
  Sighting seen{.cubes = {near, far}};
  const auto taken = [&] {
    const auto rows = rows_to_pick(planner, ready(), {1, PickCubeStep{}, 0}, seen);
    return rows ? rows->cube.color : -1;
  };
  EXPECT_EQ(taken(), 0);
  for (const Vec3& at :
       {Vec3{0.03, 0, 0}, Vec3{-0.03, 0, 0}, Vec3{0, 0.03, 0}, Vec3{0, -0.03, 0}}) {
    seen.others.push_back({{near.p_BO + at, 0, {0.014, 0.014, 0.0125}}, false});
  }
  EXPECT_EQ(taken(), 1);
}

TEST(CubeRows, the_lip_of_a_cup_presses_on_the_top_and_more_after_each_grasp_that_held_nothing) {
  const RobotModel robot = test::robot("maxarm");
  RowPlanner planner(robot);
  const auto program = read_cubes("pick", "maxarm");
  ASSERT_TRUE(program);
  const Standing standing{home_joints(robot), {}};
  const grasping::Cube cube{{0.03, -0.21, 0.0125}, 0.2, 0.025, 0};
  for (const auto& [failed, press] : {std::pair(0, 1.5e-3), {1, 2.25e-3}, {2, 3e-3}, {3, 3e-3}}) {
    const auto rows =
        rows_to_pick(planner, standing, program->steps[0], {{cube}}, {}, Tried{cube, failed});
    ASSERT_TRUE(rows) << describe(rows.error().error);
    JointVector q = *standing.q;
    double lowest = 1;
    for (const Step& step : rows->steps) {
      if (motion_of(step) == nullptr) continue;
      const auto motion = planner.plan(q, {}, std::span(&step, 1));
      ASSERT_TRUE(motion) << describe(motion.error().error);
      q = motion->q_end;
      lowest = std::min(lowest, tool_at(robot, q, 0).p.z);
    }
    // Its file: a capsule that ends 30 mm below the tool point, of 10 mm radius.
    EXPECT_NEAR(lowest, 0.025 + 0.04 - press, 1e-4);
  }
}

/// No file of an arm with six joints has jaws, and no wire of one drives them: the LeArm's hand.
RobotModel six_joints_with_jaws() {
  RobotModel robot = test::robot("robot-arm-2");
  const RobotModel& learm = test::robot("learm");
  std::get<SerialGeometry>(robot.geometry).gripper =
      std::get<SerialGeometry>(learm.geometry).gripper;
  const auto tool = static_cast<std::uint8_t>(robot.joints.size() + 1);
  for (const CollisionShape& shape : learm.collision.shapes) {
    if (!std::holds_alternative<JawFinger>(shape.form)) continue;
    robot.collision.shapes.push_back({tool, shape.form});
  }
  return robot;
}

TEST(CubeRows, an_arm_with_six_joints_takes_cubes_straight_down_as_they_are_turned) {
  const RobotModel robot = six_joints_with_jaws();
  RowPlanner planner(robot);
  const Step pick{1, PickCubeStep{}, 0};
  const Standing standing{JointVector{0, 0, from_deg(-45), 0, from_deg(-45), 0},
                          {.jaws = 0.06, .held = {}}};
  for (const double x : {0.3, 0.4}) {
    for (const double y : {-0.15, 0.0, 0.15}) {
      const grasping::Cube cube{{x, y, 0.0125}, 4 * y + x, 0.025, 0};
      const auto rows = rows_to_pick(planner, standing, pick, {{cube}});
      ASSERT_TRUE(rows) << x << ", " << y << ": " << describe(rows.error().error);
      JointVector q = *standing.q;
      ToolState tool = standing.tool;
      for (const Step& step : rows->steps) {
        const auto* action = std::get_if<ToolStep>(&step.what);
        const auto* jaws = action != nullptr ? std::get_if<JawsTo>(&action->action) : nullptr;
        if (jaws != nullptr && jaws->held) {
          const auto X_BT = tool_at(robot, q, jaws->width);
          EXPECT_LT(X_BT.R.z.z, -0.9999) << "straight down";
          EXPECT_LT(std::hypot(X_BT.p.x - x, X_BT.p.y - y), 1e-3);
          const double turn = std::atan2(X_BT.R.y.y, X_BT.R.y.x);
          EXPECT_NEAR(std::remainder(turn - cube.yaw, kPi / 2), 0, 1e-3);
        }
        if (jaws != nullptr) tool = {jaws->width, jaws->held};
        if (motion_of(step) == nullptr) continue;
        const auto motion = planner.plan(q, tool, std::span(&step, 1));
        ASSERT_TRUE(motion) << describe(motion.error().error);
        q = motion->q_end;
      }
    }
  }
}

TEST(CubeRows, a_place_out_of_reach_is_refused_in_the_plan) {
  const auto program = read_cubes("place x=900mm y=0mm z=40mm");
  ASSERT_TRUE(program);
  const auto plan = make_plan(*program, test::robot("learm"), ready());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().line, 1);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kOutOfReach);
}

TEST(CubeRows, robots_without_jaws_or_suction_refuse_them) {
  for (const char* text : {"pick", "place J1=0deg"}) {
    const auto program =
        parse(text == std::string("pick") ? "pick" : "place x=300mm", "p", test::robot("puma560"));
    ASSERT_TRUE(program);
    const auto plan = make_plan(*program, test::robot("puma560"),
                                JointVector{0, from_deg(20), from_deg(-70), 0, from_deg(60), 0});
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().error.code, ErrorCode::kToolNotFitted);
  }
}

TEST(CubeRows, rounds_that_are_asked_for_end_behind_their_loop) {
  const auto program =
      read_cubes("repeat while seen\n pick\n place basket\nend\njoint base=0deg\n");
  ASSERT_TRUE(program);
  const auto plan = make_plan(*program, test::robot("learm"), ready());
  ASSERT_TRUE(plan) << describe(plan.error().error);
  ASSERT_EQ(plan->orders.size(), 3 * kSeenRoundsMax + 1U);
  for (std::size_t place = 0; place + 1 < plan->orders.size(); place += 3) {
    const auto& branch = std::get<BranchOrder>(plan->orders[place].what);
    EXPECT_EQ(branch.otherwise, plan->orders.size() - 1);
    EXPECT_EQ(plan->orders[place].round, static_cast<int>(place) / 3 + 1);
    EXPECT_TRUE(std::holds_alternative<PickOrder>(plan->orders[place + 1].what));
    EXPECT_TRUE(std::holds_alternative<PlaceOrder>(plan->orders[place + 2].what));
  }
  EXPECT_LT(plan->duration_min, 3);
  EXPECT_GT(plan->duration, 40 * 10);
}

}  // namespace
}  // namespace sinew::program
