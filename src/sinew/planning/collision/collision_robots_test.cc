// What the built-in robots' files say of their bodies: sound enough to work with, and not blind.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_sequence.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/collision_links.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/collision/collision_test_robot.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::planning {
namespace {

using test::robot;

std::string words(const RobotModel& model, const Clearance& nearest) {
  return std::string(link_name(model, link_of(model, nearest.first))) + " - " +
         std::string(link_name(model, link_of(model, nearest.second)));
}

/// Straight through joint space from pose to pose, at the margin of the robot's file.
void expect_clear(const RobotModel& model, const std::vector<JointVector>& poses,
                  const std::string& what) {
  JointPath path(model.joints.size());
  for (std::size_t i = 1; i < poses.size(); ++i) path.append_line(poses[i - 1], poses[i], 1);
  const CollisionModel collision(model);
  const auto contact = collision.check_path(path, collision.margin());
  EXPECT_FALSE(contact) << what << " at " << contact->s << ": " << words(model, contact->nearest)
                        << " " << to_mm(contact->nearest.distance) << " mm";
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(CollisionOfRobots, every_robot_has_shapes_and_stands_clear_at_home) {
  for (const char* id : kCollisionRobots) {
    const RobotModel& model = robot(id);
    const CollisionModel collision(model);
    EXPECT_GE(collision.pairs(), 9U) << id;
    EXPECT_GT(collision.margin(), 0) << id;
    const Clearance nearest = collision.distance(home_of(model));
    EXPECT_GT(nearest.distance, 2 * collision.margin()) << id << " " << words(model, nearest);
  }
}

TEST(CollisionOfRobots, sample_programs_hit_nothing) {
  int programs = 0;
  for (const char* id : kCollisionRobots) {
    const RobotModel& model = robot(id);
    const std::filesystem::path folder = std::filesystem::path(SINEW_ROBOTS_DIR) / id;
    if (!std::filesystem::exists(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() != ".sinew") continue;
      const std::string name = entry.path().filename().string();
      const auto program = program::parse(text_of(entry.path()), name, model);
      ASSERT_TRUE(program) << name;
      // Over a wire that has all that a program may ask for.
      RobotModel linked = model;
      if (model.id == "robot-arm-2") linked.device.settings = AxisLinkDevice{};
      const auto plan = program::make_plan(*program, linked, home_of(model));
      ASSERT_TRUE(plan) << id << "/" << name << ":" << plan.error().line << ": "
                        << describe(plan.error().error);
      std::vector<JointVector> poses{home_of(model)};
      for (const program::Order& order : plan->orders) {
        if (const auto* move = std::get_if<program::MoveOrder>(&order.what)) {
          poses.push_back(move->q);
        }
      }
      // Where a camera decides the rest is planned when it is seen.
      const std::size_t least = name == "pick_and_place.sinew" ? 1 : 3;
      EXPECT_GE(poses.size(), least) << name;
      expect_clear(model, poses, std::string(id) + "/" + name);
      ++programs;
    }
  }
  EXPECT_EQ(programs, 17);
}

TEST(CollisionOfRobots, sequence_of_the_bigrobotarm_hits_nothing) {
  const RobotModel& model = robot("bigrobotarm");
  const auto& device = model.device.settings.get<BigRobotArmDevice>();
  const auto sequence =
      sequence::parse(text_of(std::filesystem::path(SINEW_ROBOTS_DIR) / "bigrobotarm/sequence.txt"),
                      "sequence.txt", device);
  ASSERT_TRUE(sequence);
  std::vector<JointVector> poses{home_of(model)};
  for (const sequence::Section& section : sequence->sections) {
    for (const sequence::Step& step : section.steps) {
      const auto* move = std::get_if<sequence::Move>(&step.command);
      if (move == nullptr) continue;
      poses.push_back(poses.back());
      for (std::size_t k = 0; k < move->steps.count; ++k) {
        poses.back()[k] = move->steps.words[k] / device.joints[k].steps_per_rad;
      }
    }
  }
  ASSERT_EQ(poses.size(), 3U);
  expect_clear(model, poses, "sequence.txt");
}

TEST(CollisionOfRobots, arms_that_are_folded_into_themselves_or_their_table_are_found) {
  const struct {
    const char* id;
    std::initializer_list<double> q_deg;
    const char* nearest;
  } kCases[] = {
      {"robot-arm-2", {0, -90, -10, 0, 10, 0}, "flange_roll - table"},
      {"robot-arm-2", {0, -90, -60, 0, 20, 0}, "stand - flange_roll"},
      {"robot-arm-2", {0, -90, -100, 0, 60, 0}, "base - flange_roll"},
      {"robot-arm-2", {0, 0, -110, 0, 0, 0}, "shoulder - forearm_roll"},
      {"learm", {0, 90, 30, 30, 0}, "tool - table"},
      {"learm", {0, -50, -90, -90, 0}, "stand - roll"},
      {"bigrobotarm", {0, 90, 90, 0, 0}, "tool - table"},
      {"bigrobotarm", {0, -70, -120, 0, -60}, "stand - tool"},
      {"maxarm", {120, 170, 60}, "tool - table"},
      {"maxarm", {120, 0, 10}, "base - forearm"},
      {"puma560", {0, -90, -90, 0, 0, 0}, "flange_roll - table"},
      {"puma560", {0, -110, -10, 0, 0, 0}, "stand - elbow"},
  };
  for (const auto& c : kCases) {
    const RobotModel& model = robot(c.id);
    const Clearance nearest = CollisionModel(model).distance(degrees(c.q_deg));
    EXPECT_LT(nearest.distance, 0) << c.id << " " << words(model, nearest);
    EXPECT_EQ(words(model, nearest), c.nearest) << c.id;
  }
}

TEST(CollisionOfRobots, legs_of_the_hexapod_meet_where_the_platform_is_turned_over_them) {
  const RobotModel& model = robot("hexapod");
  const auto& g = std::get<HexapodGeometry>(model.geometry);
  const CollisionModel collision(model);
  bool clear_before = true;
  double first_deg = 0;
  for (double yaw_deg = 0; yaw_deg < 180 && first_deg == 0; yaw_deg += 0.5) {
    const kinematics::PoseBP X_BP{rotation_z(from_deg(yaw_deg)), g.X_BP_home.p};
    const Clearance nearest = collision.distance(X_BP);
    if (yaw_deg <= 30) clear_before = clear_before && nearest.distance > collision.margin();
    if (nearest.distance < 0) {
      first_deg = yaw_deg;
      EXPECT_TRUE(words(model, nearest).starts_with("leg")) << words(model, nearest);
    }
  }
  EXPECT_TRUE(clear_before);
  EXPECT_GT(first_deg, 30);
  const kinematics::PoseBP low{{}, {0, 0, -0.04}};
  EXPECT_LT(collision.distance(low).distance, 0);
}

}  // namespace
}  // namespace sinew::planning
