// Motions against many samples of them: contacts along paths, time that is left, jogs that stop.

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/collision/collision_test_robot.h"

namespace sinew::planning {
namespace {

using test::Random;
using test::robot;

class CollisionMotions : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Robots, CollisionMotions, testing::ValuesIn(kCollisionRobots), test_name);
INSTANTIATE_TEST_SUITE_P(Slides, CollisionMotions, testing::Values("scara"), test_name);

double distance_at(const CollisionModel& collision, const JointPath& path, double s) {
  PathPoint point;
  path.sample(s, point);
  return collision.distance({point.q.data(), path.joints()}).distance;
}

TEST_P(CollisionMotions, no_contact_is_missed_between_the_places_that_were_looked_at) {
  const RobotModel& whole = robot(GetParam());
  const bool legs = whole.joints[0].kind == JointKind::kPrismatic;
  const RobotModel thin = legs ? built_up(whole) : worn_down(whole, 1e-3);
  int contacts = 0, clear = 0;
  test::for_random_cases(250, [&](Random& random) {
    const RobotModel& model = random.chance(0.5) ? thin : whole;
    const CollisionModel collision(model);
    const double margin = random.chance(0.5) ? 0 : random.uniform(0, 0.01);
    JointPath path = random_path(model, random);
    for (int k = 0; k < 50 && distance_at(collision, path, 0) < 2 * margin + 0.001; ++k) {
      path = random_path(model, random);
    }
    const auto contact = collision.check_path(path, margin);
    const double end = contact ? contact->s : path.length();
    contact ? ++contacts : ++clear;
    const int samples = legs ? 300 : 1500;
    for (int i = 0; i < samples && end > 0; ++i) {
      const double s = end * i / samples;
      ASSERT_GE(distance_at(collision, path, s), margin) << s << " before " << end;
    }
    if (!contact || contact->nearest.distance == -kInfinity) return;
    EXPECT_LE(contact->nearest.distance, margin + CollisionModel::kResolution);
    EXPECT_NEAR(contact->nearest.distance, distance_at(collision, path, contact->s), 1e-9);
  });
  EXPECT_GT(contacts, 5);
  EXPECT_GT(clear, 5);
}

TEST(CollisionMotion, part_of_a_path_is_checked_by_itself) {
  const RobotModel& model = robot("robot-arm-2");
  const CollisionModel collision(model);
  JointPath path(6, 4);
  const JointVector up{0, 0, 0, 0, 0, 0};
  // Down through the table and up again.
  const JointVector down{0, from_deg(-90), from_deg(-90), 0, 0, 0};
  path.append_line(up, down, 1);
  path.append_line(down, up, 1);
  const auto whole = collision.check_path(path, 0);
  ASSERT_TRUE(whole);
  EXPECT_GT(whole->s, 0.1);
  EXPECT_LT(whole->s, 1);
  EXPECT_FALSE(collision.check_path(path, 0, 0, 0.9 * whole->s));
  EXPECT_FALSE(collision.check_path(path, 0, 2 - 0.9 * whole->s, 2));
  EXPECT_FALSE(collision.check_path(path, 0, 2 - 0.9 * whole->s, kInfinity));
  const auto inside = collision.check_path(path, 0, 1, 1.1);
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->s, 1) << "already there";
}

TEST(CollisionMotion, platform_that_leaves_its_condition_or_has_no_pose_is_no_clear_path) {
  RobotModel model = robot("hexapod");
  const JointVector home = home_of(model);
  JointVector longer = home;
  for (double& leg : longer) leg += 0.02;
  JointPath path(kLegs, 4);
  path.append_line(home, longer, 0.02);
  EXPECT_FALSE(CollisionModel(model).check_path(path, 0));
  std::get<HexapodGeometry>(model.geometry).condition_max = 3;
  const auto broken = CollisionModel(model).check_path(path, 0);
  ASSERT_TRUE(broken);
  EXPECT_EQ(broken->nearest.distance, -kInfinity);
  JointVector none = home;
  none[0] = 0.01;
  EXPECT_EQ(CollisionModel(robot("hexapod")).distance(none).distance, -kInfinity);
}

TEST_P(CollisionMotions, time_that_is_left_is_clear_to_its_end_and_no_longer) {
  const RobotModel& model = robot(GetParam());
  const CollisionModel collision(model);
  int ended = 0, whole = 0, to_the_end = 0;
  test::for_random_cases(600, [&](Random& random) {
    const JointVector q = random_joints(model, random);
    const double margin = random.uniform(0, 0.01);
    if (collision.distance(q).distance < margin + 2 * CollisionModel::kResolution)
      return random.discard();
    JointVector qd, to = q;
    for (const Joint& joint : model.joints)
      qd.push_back(random.uniform(-1, 1) * joint.velocity_max);
    const Joint& first = model.joints[0];
    const double horizon =
        first.kind == JointKind::kPrismatic ? random.uniform(0, 4.4e-3) / first.velocity_max : 1.5;
    const double free = collision.free_time(q, qd, horizon, margin);
    ASSERT_GE(free, 0);
    ASSERT_LE(free, horizon);
    const auto at = [&](double t) {
      for (std::size_t k = 0; k < q.size(); ++k) to[k] = q[k] + t * qd[k];
      return collision.distance(to).distance;
    };
    for (int i = 0; i <= 300; ++i) ASSERT_GE(at(free * i / 300), margin) << i;
    free < horizon ? ++ended : ++whole;
    if (free < horizon && at(free) < margin + 2 * CollisionModel::kResolution) ++to_the_end;
  });
  // The others are as far as it looked, which is bounded.
  EXPECT_GE(to_the_end, 0.9 * ended);
  EXPECT_GT(whole, 5);
  if (std::string_view(GetParam()) != "hexapod") {
    EXPECT_GT(ended, 5);
  }
}

TEST_P(CollisionMotions, moving_apart_is_always_allowed_and_coming_nearer_is_not) {
  const bool legs = robot(GetParam()).joints[0].kind == JointKind::kPrismatic;
  const RobotModel model = legs ? built_up(robot(GetParam())) : robot(GetParam());
  const CollisionModel whole(model);
  int apart = 0, nearer = 0;
  test::for_random_cases(1500, [&](Random& random) {
    const JointVector q = random_joints(model, random);
    // Only the nearest pair, with a margin that it has just broken.
    const Clearance before = whole.distance(q);
    const double margin = before.distance + 1e-6;
    RobotModel lone = model;
    lone.collision.ignored = {};
    lone.collision.shapes = {model.collision.shapes[before.first]};
    if (before.second != kTableShape) {
      lone.collision.shapes.push_back(model.collision.shapes[before.second]);
      lone.collision.table_height.reset();
    }
    const CollisionModel collision(lone);
    JointVector qd, to = q;
    double fastest = 0;
    for (const Joint& joint : model.joints) {
      qd.push_back(random.uniform(-1, 1) * joint.velocity_max);
      fastest = std::max(fastest, std::abs(qd.back()));
    }
    // Where two corners are equally near, both of two opposite directions may bring one nearer.
    for (std::size_t k = 0; k < q.size(); ++k) to[k] += 1e-6 / fastest * qd[k];
    const double change = collision.distance(to).distance - before.distance;
    if (std::abs(change) < 1e-10) return random.discard();
    (change > 0 ? apart : nearer) += 1;
    ASSERT_EQ(collision.speed_share(q, qd, margin), change > 0 ? 1 : 0);
  });
  EXPECT_GT(apart, 100);
  EXPECT_GT(nearer, 100);
}

/// A jog that builds up speed with the joints' own limits, asks every millisecond how fast it may
/// be, and brakes as soon as it has promised too much.
struct Jog {
  Jog(const RobotModel& model, const JointVector& wanted) : qd(wanted) {
    for (std::size_t k = 0; k < qd.size(); ++k) {
      if (qd[k] == 0) continue;
      acceleration = std::min(acceleration, model.joints[k].acceleration_max / std::abs(qd[k]));
      jerk = std::min(jerk, model.joints[k].jerk_max / std::abs(qd[k]));
    }
  }
  void step(double share, double dt, JointVector& q) {
    const double next = std::min(a + jerk * dt, acceleration);
    const double promised = v + next * dt + (next > 0 ? next * next / (2 * jerk) : 0);
    a = promised <= share ? next : std::max(a - jerk * dt, -acceleration);
    v = std::max(v + a * dt, 0.0);
    if (v == 0) a = std::max(a, 0.0);
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += v * dt * qd[k];
  }

  JointVector qd;
  double acceleration = kInfinity, jerk = kInfinity;
  double v = 0, a = 0;  ///< share of qd, and its rate
};

TEST(CollisionMotion, jog_slows_down_and_stops_before_the_margin) {
  constexpr double kCycle = 1e-3;  // s
  int stopped = 0;
  test::for_random_cases(15, [&](Random& random) {
    for (const char* id : {"robot-arm-2", "learm", "maxarm"}) {
      const RobotModel& model = robot(id);
      const CollisionModel collision(model);
      JointVector q = home_of(model), qd;
      for (const Joint& joint : model.joints) {
        qd.push_back(random.uniform(-1, 1) * joint.velocity_max);
      }
      Jog jog(model, qd);
      double share = 1, slowest = 1;
      for (int cycle = 0; cycle < 6000 && (cycle < 100 || jog.v > 1e-3); ++cycle) {
        share = collision.speed_share(q, qd, collision.margin());
        slowest = std::min(slowest, share);
        jog.step(share, kCycle, q);
        // A cycle passes between question and answer: 0.3 mm at the speeds of these arms.
        ASSERT_GT(collision.distance(q).distance, collision.margin() - 3e-4) << id << " " << cycle;
      }
      if (slowest < 1e-2) ++stopped;
    }
  });
  EXPECT_GT(stopped, 8);
}

TEST(CollisionMotion, share_falls_without_a_jump) {
  const RobotModel& model = robot("robot-arm-2");
  const CollisionModel collision(model);
  // Upright with the forearm level; the shoulder bows it to the table.
  const JointVector qd{0, -0.4, 0, 0, 0, 0};
  double last = 1;
  double largest = 0;
  bool stopped = false;
  for (double angle = 0; angle > -1.5 && !stopped; angle -= 1e-4) {
    const double share =
        collision.speed_share(JointVector{0, angle, -0.3, 0, 0, 0}, qd, collision.margin());
    largest = std::max(largest, std::abs(share - last));
    EXPECT_LE(share, last + 0.01) << "towards contact it does not grow";
    last = share;
    stopped = share == 0;
  }
  EXPECT_TRUE(stopped);
  EXPECT_LT(largest, 0.01);
}

}  // namespace
}  // namespace sinew::planning
