#include "sinew/planning/collision/collision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"
#include "sinew/planning/collision/collision_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using kinematics::PoseBL;
using kinematics::PoseBP;
using test::Random;
using test::robot;

/// A link in base, row by row, without the model's own way of placing it.
PoseBL link_pose(const RobotModel& model, const JointVector& q, std::size_t link) {
  PoseBL X_BL;
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    for (std::size_t i = 0; i < std::min(link, q.size()); ++i) {
      const DhRow& row = serial->rows[i];
      const Rotation Rz = rotation_z(q[i] + row.theta_offset);
      X_BL = X_BL *
             Pose<frame::Link, frame::Link>{Rz * rotation_x(row.alpha), Rz * Vec3{row.a, 0, row.d}};
    }
    if (link > q.size()) X_BL = X_BL * relabel<frame::Link, frame::Link>(serial->X_FT);
  } else if (link > 0) {
    const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
    X_BL = kinematics::palletizer_links(geometry, q)[link - 1];
  }
  return X_BL;
}

/// The same robot with plain boxes and balls for its fingers and what they hold, worked out anew:
/// between jaws of 60 mm and closed ones the tips go from 55 to 85 mm.
RobotModel with_plain_jaws(const RobotModel& model, const ToolState& tool = {}) {
  RobotModel plain = model;
  const auto tip = [](double width) { return 0.085 - width / 2; };
  const double most = tool.jaws.value_or(0.06), least = tool.jaws.value_or(0);
  for (CollisionShape& shape : plain.collision.shapes) {
    if (const auto* finger = std::get_if<JawFinger>(&shape.form)) {
      const Vec3 half = finger->half;
      const double inner = least / 2, outer = most / 2 + 2 * half.y;
      const double begin = tip(most) - 2 * half.z, end = tip(least);
      CollisionBox box;
      box.X_LX.p = {0, finger->side * (inner + outer) / 2, (begin + end) / 2};
      box.half = {half.x, (outer - inner) / 2, (end - begin) / 2};
      shape.form = box;
    } else if (std::holds_alternative<HeldBall>(shape.form)) {
      const double radius = tool.held ? *tool.held / 2 - model.collision.margin - 1e-4 : 1e-4;
      const Vec3 middle{0, 0, tip(most) - (tool.held ? 0 : radius)};
      shape.form = Capsule{middle, middle, radius};
    }
  }
  return plain;
}

using PlacedForm = std::variant<PlacedCapsule, PlacedBox>;

PlacedForm placed(const CollisionShape& shape, const PoseBL& X_BL) {
  if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
    return PlacedCapsule{X_BL * capsule->p_LA, X_BL * capsule->p_LB, capsule->radius};
  }
  const auto& box = std::get<CollisionBox>(shape.form);
  return PlacedBox{X_BL * box.X_LX, box.half};
}

double apart(const PlacedForm& first, const PlacedForm& second) {
  return std::visit(
      [](const auto& a, const auto& b) {
        if constexpr (std::is_same_v<decltype(a), const PlacedBox&> &&
                      std::is_same_v<decltype(b), const PlacedCapsule&>) {
          return distance(b, a);
        } else {
          return distance(a, b);
        }
      },
      first, second);
}

class CollisionRobots : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Robots, CollisionRobots, testing::ValuesIn(kCollisionRobots), test_name);
INSTANTIATE_TEST_SUITE_P(Slides, CollisionRobots, testing::Values("scara"), test_name);

/// The nearest pair, everything against everything, placed and measured without a shortcut.
Clearance nearest_by_words(const RobotModel& real, const JointVector& q,
                           const ToolState& tool = {}) {
  const RobotModel model = with_plain_jaws(real, tool);
  const std::vector<CollisionShape>& shapes = model.collision.shapes;
  const bool bolted = std::holds_alternative<SerialGeometry>(model.geometry);
  const auto body = [&](std::size_t i) {
    return bolted ? std::min<std::size_t>(shapes[i].link, q.size()) : shapes[i].link;
  };
  Clearance nearest;
  const auto consider = [&](double distance, std::size_t i, std::size_t j) {
    if (distance >= nearest.distance) return;
    nearest = {distance, static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j)};
  };
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const PlacedForm first = placed(shapes[i], link_pose(model, q, shapes[i].link));
    if (body(i) >= 2) {
      const double height = *model.collision.table_height;
      consider(std::visit([&](const auto& form) { return distance_above(form, height); }, first), i,
               kTableShape);
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (body(i) <= body(j) + 1 && body(j) <= body(i) + 1) continue;
      // The one pair that a file excuses.
      if (model.id == "robot-arm-2" && body(j) == 4 && body(i) == 6) continue;
      consider(apart(first, placed(shapes[j], link_pose(model, q, shapes[j].link))), j, i);
    }
  }
  return nearest;
}

TEST(Collision, distance_is_the_least_of_all_pairs_that_are_not_joined) {
  test::for_random_cases(5000, [&](Random& random) {
    for (const char* id : {"robot-arm-2", "bigrobotarm", "learm", "maxarm", "puma560"}) {
      const RobotModel& model = robot(id);
      const CollisionModel collision(model);
      const JointVector q = random_joints(model, random);
      const Clearance found = collision.distance(q);
      const Clearance wanted = nearest_by_words(model, q);
      ASSERT_NEAR(found.distance, wanted.distance, 1e-12) << id;
      ASSERT_EQ(found.first, wanted.first) << id;
      ASSERT_EQ(found.second, wanted.second) << id;
      ASSERT_FALSE(collision.clear(q, wanted.distance + 1e-9));
      ASSERT_TRUE(collision.clear(q, wanted.distance - 1e-9));
    }
  });
}

TEST(Collision, fingers_and_what_they_hold_are_where_the_jaws_are) {
  const RobotModel& model = robot("learm");
  CollisionModel collision(model);
  test::for_random_cases(2000, [&](Random& random) {
    ToolState tool;
    if (random.chance(0.8)) tool.jaws = random.uniform(0, 0.06);
    if (tool.jaws && random.chance(0.5)) tool.held = random.uniform(0.015, 0.2);
    collision.fit(tool);
    const JointVector q = random_joints(model, random);
    const Clearance wanted = nearest_by_words(model, q, tool);
    ASSERT_NEAR(collision.distance(q).distance, wanted.distance, 1e-12);
  });
}

TEST(Collision, jaws_on_their_way_come_no_nearer_than_the_margin_or_than_they_are) {
  const RobotModel& model = robot("learm");
  CollisionModel collision(model);
  int blocked = 0, free = 0;
  test::for_random_cases(3000, [&](Random& random) {
    ToolState from;
    if (random.chance(0.8)) from.jaws = random.uniform(0, 0.06);
    const double to = random.uniform(0, 0.06);
    const JointVector q = random_joints(model, random);
    collision.fit(from);
    const double at_first = collision.distance(q).distance;
    double least = at_first;
    for (int k = 0; k <= 40; ++k) {
      const double begin = from.jaws.value_or(to);
      least =
          std::min(least, nearest_by_words(model, q, {begin + (to - begin) * k / 40, {}}).distance);
    }
    const double limit = std::min(model.collision.margin, at_first);
    const auto error = collision.jaws_contact(q, from, to);
    ++(error ? blocked : free);
    if (!error) {
      ASSERT_GE(least, limit - 2 * CollisionModel::kResolution);
    } else {
      ASSERT_LT(error->measured, limit);
      ASSERT_EQ(error->code == ErrorCode::kJawsContact, to < from.jaws.value_or(0.06));
    }
    ASSERT_EQ(collision.distance(q).distance, at_first) << "fitted as before";
  });
  EXPECT_GT(blocked, 50);
  EXPECT_GT(free, 500);
}

TEST(Collision, legs_of_a_hexapod_run_from_anchor_to_anchor) {
  const RobotModel& model = robot("hexapod");
  const auto& g = std::get<HexapodGeometry>(model.geometry);
  const CollisionModel collision(model);
  const kinematics::Hexapod hexapod(g);
  test::for_random_cases(2000, [&](Random& random) {
    const auto vector = [&](double size) {
      return Vec3{random.uniform(-size, size), random.uniform(-size, size),
                  random.uniform(-size, size)};
    };
    const PoseBP X_BP{rotation_from_vector(vector(0.2)), g.X_BP_home.p + vector(0.02)};
    double least = kInfinity;
    for (std::size_t i = 0; i < kLegs; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const PlacedCapsule a{g.p_BA[i], X_BP * g.p_PA[i], 0.006};
        const PlacedCapsule b{g.p_BA[j], X_BP * g.p_PA[j], 0.006};
        least = std::min(least, distance(a, b));
      }
    }
    // Base plate and platform are never nearer than two legs here.
    ASSERT_NEAR(collision.distance(X_BP).distance, least, 1e-12);
    ASSERT_NEAR(collision.distance(hexapod.inverse(X_BP)).distance, least, 1e-9);
  });
}

/// Two balls in the same place: only what is joined, excused or the same may be there.
TEST(Collision, links_that_are_joined_or_excused_are_not_held_against_each_other) {
  for (const char* id : {"robot-arm-2", "maxarm"}) {
    RobotModel model = robot(id);
    const std::size_t links = link_count(model);
    const bool bolted = std::holds_alternative<SerialGeometry>(model.geometry);
    for (std::size_t i = 0; i < links; ++i) {
      for (std::size_t j = 0; j < links; ++j) {
        model.collision = {};
        for (const std::size_t link : {i, j}) {
          model.collision.shapes.push_back(
              {static_cast<std::uint8_t>(link), Capsule{{}, {}, 10.0}});
        }
        const auto body = [&](std::size_t link) {
          return static_cast<int>(bolted && link == links - 1 ? link - 1 : link);
        };
        const bool joined = std::abs(body(i) - body(j)) <= 1;
        const double apart_m = CollisionModel(model).distance(home_of(model)).distance;
        EXPECT_EQ(apart_m == kInfinity, joined) << id << " " << i << " " << j;
        if (joined) continue;
        EXPECT_LT(apart_m, 0);
        model.collision.ignored = {{static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(i)}};
        EXPECT_EQ(CollisionModel(model).pairs(), 0U);
      }
      model.collision.table_height = 0;
      model.collision.ignored = {};
      model.collision.shapes.resize(1);
      EXPECT_EQ(CollisionModel(model).pairs(), i <= 1 ? 0U : 1U) << "the table carries the stand";
      model.collision.ignored = {{kTableLink, static_cast<std::uint8_t>(i)}};
      EXPECT_EQ(CollisionModel(model).pairs(), 0U);
    }
  }
  RobotModel hexapod = robot("hexapod");
  EXPECT_EQ(CollisionModel(hexapod).pairs(), 15U + 1U) << "legs among each other, and the plates";
  hexapod.collision.table_height = -1;
  EXPECT_EQ(CollisionModel(hexapod).pairs(), 15U + 1U + 1U) << "and the platform on the table";
}

TEST(Collision, robot_without_shapes_is_always_clear) {
  RobotModel model = robot("learm");
  model.collision = {};
  const CollisionModel collision(model);
  const JointVector q = home_of(model);
  const JointVector qd = degrees({10, 10, 10, 10, 10});
  EXPECT_EQ(collision.distance(q).distance, kInfinity);
  EXPECT_TRUE(collision.clear(q, 1));
  EXPECT_EQ(collision.speed_share(q, qd, 1), 1);
  JointPath path(5, 4);
  EXPECT_FALSE(collision.check_path(path, 1));
  path.append_line(q, qd, 1);
  EXPECT_FALSE(collision.check_path(path, 1));
}

/// A robot with two of its shapes, or one and its table, and the bound that goes with them.
struct LonePair {
  LonePair(const RobotModel& all, std::size_t i, std::size_t j) : model(all) {
    const std::vector<CollisionShape>& shapes = all.collision.shapes;
    const bool table = j == shapes.size();
    model.collision.ignored = {};
    model.collision.shapes = {shapes[i]};
    if (!table) {
      model.collision.shapes.push_back(shapes[j]);
      model.collision.table_height.reset();
    }
    collision.emplace(model);
    // As the reach has it: shapes of the tool on the last link.
    const CollisionShape first = on_its_joint(shapes[i]);
    const CollisionShape second = on_its_joint(shapes[table ? i : j]);
    reach = joint_reach(model, first, table ? nullptr : &second);
  }

  CollisionShape on_its_joint(CollisionShape shape) const {
    const auto* serial = std::get_if<SerialGeometry>(&model.geometry);
    if (serial == nullptr || shape.link <= model.joints.size()) return shape;
    shape.link = static_cast<std::uint8_t>(model.joints.size());
    const auto X_LT = relabel<frame::Link, frame::Link>(serial->X_FT);
    if (auto* box = std::get_if<CollisionBox>(&shape.form)) box->X_LX = X_LT * box->X_LX;
    if (auto* capsule = std::get_if<Capsule>(&shape.form)) {
      capsule->p_LA = X_LT * capsule->p_LA;
      capsule->p_LB = X_LT * capsule->p_LB;
    }
    return shape;
  }

  RobotModel model;
  std::optional<CollisionModel> collision;
  JointReach reach{};
};

/// The bound that everything about motions stands on: one pair of shapes at a time, between any two
/// places, however far apart.
TEST_P(CollisionRobots, no_distance_changes_by_more_than_the_joints_moves_times_their_reach) {
  const RobotModel model = with_plain_jaws(robot(GetParam()));
  const bool legs = std::holds_alternative<HexapodGeometry>(model.geometry);
  std::vector<std::unique_ptr<LonePair>> pairs;
  for (std::size_t i = 0; i < model.collision.shapes.size(); ++i) {
    for (std::size_t j = i + 1; j <= model.collision.shapes.size(); ++j) {
      pairs.push_back(std::make_unique<LonePair>(model, i, j));
      if (pairs.back()->collision->pairs() == 0) pairs.pop_back();
    }
  }
  double fullest = 0;
  test::for_random_cases(4000, [&](Random& random) {
    const JointVector from = random_joints(model, random);
    JointVector to = from;
    JointArray moves{};
    const std::int64_t only = random.integer(-2, static_cast<std::int64_t>(from.size()) - 1);
    const double way = std::pow(10, random.uniform(-4, 0)) * (legs ? 0.004 : 3);
    for (std::size_t k = 0; k < to.size(); ++k) {
      if (only >= 0 && k != static_cast<std::size_t>(only)) continue;
      moves[k] = random.uniform(-1, 1) * way;
      to[k] += moves[k];
    }
    for (const auto& pair : pairs) {
      double bound = 0, squares = 0;
      for (std::size_t k = 0; k < to.size(); ++k) {
        squares += moves[k] * moves[k];
        bound += std::abs(moves[k]) * pair->reach[k];
      }
      if (legs) bound = std::sqrt(squares) * pair->reach[0];
      const double change = std::abs(pair->collision->distance(to).distance -
                                     pair->collision->distance(from).distance);
      ASSERT_LE(change, bound + 1e-9);
      if (bound > 1e-6) fullest = std::max(fullest, change / bound);
    }
  });
  EXPECT_GT(fullest, legs ? 0.02 : 0.8) << "a bound that is never nearly reached costs time";
}

TEST(Collision, nothing_is_taken_from_the_heap) {
  for (const char* id : kCollisionRobots) {
    const RobotModel& model = robot(id);
    const CollisionModel collision(model);
    const JointVector q = home_of(model);
    JointVector qd;
    for (const Joint& joint : model.joints) qd.push_back(joint.velocity_max);
    Random random(test::seed());
    const JointPath path = random_path(model, random);
    const test::AllocationCounter allocations;
    const bool clear = collision.clear(q, 0);
    const bool contact = collision.check_path(path, 10).has_value();
    static_cast<void>(collision.check_path(path, 0));
    const double share = collision.speed_share(q, qd, 0);
    EXPECT_EQ(allocations.count(), 0U) << id;
    EXPECT_TRUE(clear && contact && share > 0) << id;
  }
}

}  // namespace
}  // namespace sinew::planning
