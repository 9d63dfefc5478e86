#include "sinew/planning/collision/cell_claim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/planning/collision/collision_test_robot.h"

namespace sinew::planning {
namespace {

using test::Random;
using test::robot;
using PoseWB = Pose<frame::World, frame::Base>;

constexpr std::array kTallRobots{"robot-arm-2", "bigrobotarm", "learm", "maxarm", "hexapod"};

PoseWB somewhere(Random& random, double far) {
  PoseWB X;
  X.p = {random.uniform(-far, far), random.uniform(-far, far), random.uniform(-0.2, 0.2)};
  X.R = rotation_from_fixed_xyz({0, 0, random.uniform(-kPi, kPi)});
  return X;
}

std::vector<CellBody> bodies_at(const RobotBodies& robot, const JointPath& path, double s) {
  PathPoint at;
  path.sample(s, at);
  std::vector<CellBody> bodies(robot.size());
  kinematics::PoseBP X_near = robot.start_pose();
  if (!robot.place({at.q, {}}, X_near, bodies)) bodies.clear();
  return bodies;
}

/// The least distance of what moves on `a` from all of `b`, at so many places of each.
double least_distance(const RobotBodies& a, const JointPath& path_a, int looks_a,
                      const RobotBodies& b, const JointPath& path_b, int looks_b) {
  std::vector<std::vector<CellBody>> all;
  for (int k = 0; k <= looks_b; ++k) {
    all.push_back(bodies_at(b, path_b, path_b.length() * k / looks_b));
  }
  double least = kInfinity;
  for (int k = 0; k <= looks_a; ++k) {
    for (const CellBody& own : bodies_at(a, path_a, path_a.length() * k / looks_a)) {
      if (own.link == 0) continue;
      for (const auto& others : all) {
        for (const CellBody& other : others) {
          if (ball_distance(own, other) < least) least = std::min(least, distance(own, other));
        }
      }
    }
  }
  return least;
}

/// A robot somewhere, on some way.
struct Mover {
  Mover(const char* id, double far, Random& random)
      : bodies(robot(id), somewhere(random, far)), path(random_path(robot(id), random)) {}
  JointBox start() const {
    PathPoint at;
    path.sample(0, at);
    return {at.q, {}};
  }
  RobotBodies bodies;
  JointPath path;
};

const char* any_robot(Random& random) {
  return kTallRobots[static_cast<std::size_t>(random.integer(0, kTallRobots.size() - 1))];
}

TEST(CellClaim, of_a_motion_has_every_body_in_it_at_every_place) {
  test::for_random_cases(300, [](Random& random) {
    const Mover mover(any_robot(random), 1, random);
    const CellClaim claim = claim_of_way(mover.bodies, CellWay(mover.path));
    const auto inside = [&](const Vec3& p, std::uint8_t link, double deep) {
      const CellBody point{PlacedCapsule{p, p, 0}, 0, p, 0, link};
      return std::ranges::any_of(claim.bodies(), [&](const CellBody& body) {
        return body.link == link && distance(point, body) <= 1e-6 - deep;
      });
    };
    for (int k = 0; k < 20; ++k) {
      const double s = random.uniform(0, mover.path.length());
      for (const CellBody& body : bodies_at(mover.bodies, mover.path, s)) {
        if (const auto* capsule = std::get_if<PlacedCapsule>(&body.form)) {
          ASSERT_TRUE(inside(capsule->a, body.link, capsule->radius));
          ASSERT_TRUE(inside(capsule->b, body.link, capsule->radius));
          continue;
        }
        const auto& box = std::get<PlacedBox>(body.form);
        ASSERT_TRUE(inside(box.X * box.half, body.link, 0));
        ASSERT_TRUE(inside(box.X * (-box.half), body.link, 0));
      }
    }
  });
}

/// Nothing that comes too near is ever passed, and what is refused is nearly too near.
TEST(CellClaim, no_contact_with_a_robot_at_rest_is_missed_and_hardly_one_is_made_up) {
  int refused = 0, made_up = 0, missed = 0, passed = 0;
  test::for_random_cases(1500, [&](Random& random) {
    const Mover a(any_robot(random), 0.45, random);
    const Mover b(any_robot(random), 0.45, random);
    const double margin = random.uniform(0, 0.02);
    const CellClaim claim = claim_of_rest(b.bodies, b.start());
    const CellObstacle obstacle{&claim, margin, 0};
    // Who begins too near leaves: that is another test's.
    if (nearest_obstacle(a.bodies, a.start().q, {&obstacle, 1}).distance < margin)
      return random.discard();
    const auto contact = first_contact(a.bodies, CellWay(a.path), {&obstacle, 1});
    JointPath stands(b.path.joints(), 1);
    const JointArray q = b.start().q;
    ASSERT_TRUE(stands.append_line({q.data(), b.path.joints()}, {q.data(), b.path.joints()}, 1));
    const double least = least_distance(a.bodies, a.path, 400, b.bodies, stands, 1);
    (contact ? refused : passed) += 1;
    if (!contact && least < margin - 1e-9) ++missed;
    // A body may have been 1/400 of the way nearer than any place that was looked at.
    if (contact && std::isfinite(contact->distance) && least > margin + 5e-3) ++made_up;
    ASSERT_EQ(missed, 0) << least;
  });
  std::cout << "  " << passed << " passed, " << refused << " refused, " << made_up
            << " of them for nothing\n";
  EXPECT_GT(refused, 100);
  EXPECT_GT(passed, 100);
  EXPECT_LE(made_up, refused / 50);
}

TEST(CellClaim, two_motions_that_both_were_granted_never_meet_whatever_their_times) {
  int refused = 0, made_up = 0, passed = 0;
  test::for_random_cases(400, [&](Random& random) {
    const Mover a(any_robot(random), 0.45, random);
    const Mover b(any_robot(random), 0.45, random);
    const double margin = 0.01;
    const CellClaim claim = claim_of_way(b.bodies, CellWay(b.path));
    const CellObstacle obstacle{&claim, margin, 0};
    const auto contact = first_contact(a.bodies, CellWay(a.path), {&obstacle, 1});
    const double least = least_distance(a.bodies, a.path, 100, b.bodies, b.path, 60);
    if (!contact) {
      ASSERT_GE(least, margin - 1e-9);
      ++passed;
      return;
    }
    ++refused;
    if (least > margin + 2 * kSweepSwell + 0.01) ++made_up;
  });
  std::cout << "  " << passed << " passed, " << refused << " refused, " << made_up
            << " of them for nothing\n";
  EXPECT_GT(passed, 40);
  EXPECT_GT(refused, 40);
  EXPECT_LE(made_up, refused / 10);
}

TEST(CellClaim, of_a_lost_robot_is_never_left_by_any_of_its_bodies) {
  test::for_random_cases(2000, [](Random& random) {
    const RobotBodies bodies(robot(any_robot(random)), somewhere(random, 1));
    const JointVector q = random_joints(bodies.model(), random);
    std::vector<CellBody> placed(bodies.size());
    kinematics::PoseBP X_near = bodies.start_pose();
    if (!bodies.place({array_of(q), {}}, X_near, placed)) return random.discard();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies.stands(i)) continue;
      const CellBody ball = bodies.whole_reach(i);
      const double radius = std::get<PlacedCapsule>(ball.form).radius;
      if (const auto* capsule = std::get_if<PlacedCapsule>(&placed[i].form)) {
        ASSERT_LE(norm(capsule->a - ball.centre) + capsule->radius, radius + 1e-9) << i;
        ASSERT_LE(norm(capsule->b - ball.centre) + capsule->radius, radius + 1e-9) << i;
      } else {
        const auto& box = std::get<PlacedBox>(placed[i].form);
        ASSERT_LE(norm(box.X * box.half - ball.centre), radius + 1e-9) << i;
        ASSERT_LE(norm(box.X * (-box.half) - ball.centre), radius + 1e-9) << i;
      }
    }
  });
}

TEST(CellClaim, of_an_uncertain_robot_has_it_wherever_it_is_in_its_intervals) {
  test::for_random_cases(300, [](Random& random) {
    const RobotBodies bodies(robot("learm"), somewhere(random, 1));
    JointBox box{array_of(random_joints(bodies.model(), random)), {}};
    const double wide = std::pow(10, random.uniform(-3, 0));
    for (std::size_t k = 0; k < bodies.joints(); ++k) box.half[k] = random.uniform(0, wide);
    const CellClaim claim = claim_of_rest(bodies, box);
    std::vector<CellBody> placed(bodies.size());
    kinematics::PoseBP X_near;
    JointBox at = box;
    at.half = {};
    for (std::size_t k = 0; k < bodies.joints(); ++k) {
      at.q[k] += random.uniform(-1, 1) * box.half[k];
    }
    ASSERT_TRUE(bodies.place(at, X_near, placed));
    for (const CellBody& body : placed) {
      const CellBody middle{PlacedCapsule{body.centre, body.centre, 0}, 0, body.centre, 0, 0};
      ASSERT_TRUE(std::ranges::any_of(claim.bodies(), [&](const CellBody& one) {
        return one.link == body.link && distance(middle, one) <= 1e-6;
      }));
    }
  });
}

/// From a touch on, half of all ways lead nearer still and the other half away.
TEST(CellClaim, who_begins_too_near_may_only_go_away) {
  int away = 0, nearer = 0;
  test::for_random_cases(800, [&](Random& random) {
    const Mover a("robot-arm-2", 0, random);
    const JointArray q = a.start().q;
    std::vector<CellBody> bodies = bodies_at(a.bodies, a.path, 0);
    const CellBody& touched = bodies.back();
    CellObject post{.name = "post", .X_WX = {}, .half = {0.02, 0.02, 0.02}};
    const Vec3 off{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    post.X_WX.p = touched.centre + (touched.ball + 0.02) * normalized(off);
    const CellClaim claim = claim_of(post);
    const double margin = 0.06;
    const CellObstacle obstacle{&claim, margin, 0};
    const double before = nearest_obstacle(a.bodies, q, {&obstacle, 1}).distance;
    if (before >= margin) return random.discard();
    JointArray to = q;
    for (std::size_t k = 0; k < 6; ++k) to[k] += random.uniform(-0.05, 0.05);
    JointPath path(6, 1);
    ASSERT_TRUE(path.append_line({q.data(), 6}, {to.data(), 6}, 1));
    const auto contact = first_contact(a.bodies, CellWay(path), {&obstacle, 1});
    double least = kInfinity;
    for (int k = 0; k <= 100; ++k) {
      PathPoint at;
      path.sample(k / 100.0, at);
      least = std::min(least, nearest_obstacle(a.bodies, at.q, {&obstacle, 1}).distance);
    }
    if (!contact) {
      ++away;
      ASSERT_GE(least, before - 3 * kCellResolution);
    } else {
      ++nearer;
    }
  });
  std::cout << "  " << away << " away, " << nearer << " nearer\n";
  EXPECT_GT(away, 50);
  EXPECT_GT(nearer, 50);
}

TEST(CellClaim, who_stands_on_a_table_is_not_refused_for_it_and_still_keeps_off_it) {
  const RobotBodies bodies(robot("robot-arm-2"), PoseWB{{}, {0, 0, 0.7}});
  CellObject table{.name = "table", .X_WX = {}, .half = {0.6, 0.6, 0.35}};
  table.X_WX.p.z = 0.35;
  const std::uint32_t on = links_on(bodies, body_of(table));
  EXPECT_EQ(on, 3U) << "the stand and the first link";
  CellObject wall = table;
  wall.X_WX.p.x = 3;
  EXPECT_EQ(links_on(bodies, body_of(wall)), 0U);
  const CellClaim claim = claim_of(table);
  const CellObstacle obstacle{&claim, 0.01, on};
  const JointVector q = home_of(bodies.model());
  JointPath path(6, 1);
  JointVector down = q;
  down[1] = bodies.model().joints[1].upper;
  ASSERT_TRUE(path.append_line(q, q, 1));
  EXPECT_FALSE(first_contact(bodies, CellWay(path), {&obstacle, 1}));
  path.clear();
  ASSERT_TRUE(path.append_line(q, down, 1));
  JointVector other = q;
  other[1] = bodies.model().joints[1].lower;
  JointPath back(6, 1);
  ASSERT_TRUE(back.append_line(q, other, 1));
  EXPECT_TRUE(first_contact(bodies, CellWay(path), {&obstacle, 1}) ||
              first_contact(bodies, CellWay(back), {&obstacle, 1}));
}

TEST(CellClaim, a_motion_from_nobody_knows_where_keeps_out_of_everything_in_reach) {
  const RobotBodies lost(robot("learm"), {});
  const RobotBodies near(robot("learm"), PoseWB{{}, {0.4, 0, 0}});
  const RobotBodies far(robot("learm"), PoseWB{{}, {3, 0, 0}});
  const CellWay nowhere;
  const CellClaim beside = claim_of_rest(near, {array_of(home_of(near.model())), {}});
  const CellClaim away = claim_of_rest(far, {array_of(home_of(far.model())), {}});
  const CellObstacle first{&beside, 0.01, 0}, second{&away, 0.01, 0};
  EXPECT_TRUE(first_contact(lost, nowhere, {&first, 1}));
  EXPECT_FALSE(first_contact(lost, nowhere, {&second, 1}));
}

TEST(CellClaim, joints_that_go_each_by_itself_are_held_to_all_their_combinations) {
  const RobotBodies bodies(robot("robot-arm-2"), {});
  const JointArray from = array_of(home_of(bodies.model()));
  JointArray to = from;
  to[0] += 0.5;
  to[1] += 0.2;
  // A body that only one order of the two joints comes to: first the first one, then the second.
  JointArray corner = from;
  corner[0] = to[0];
  std::vector<CellBody> placed(bodies.size());
  kinematics::PoseBP X_near;
  ASSERT_TRUE(bodies.place({corner, {}}, X_near, placed));
  CellObject ball{.name = "ball", .X_WX = {}, .half = {1e-3, 1e-3, 1e-3}};
  ball.X_WX.p = placed.back().centre;
  const CellClaim claim = claim_of(ball);
  const CellObstacle obstacle{&claim, 0, 0};
  CellWay apart;
  apart.apart_to(from, to);
  EXPECT_TRUE(first_contact(bodies, apart, {&obstacle, 1}));
}

/// A line of 300 mm between four robots and ten objects, each as near as it may be but for 30 mm.
TEST(CellClaim, a_line_close_beside_four_robots_and_ten_objects_is_free_and_takes_few_parts) {
  const RobotBodies mover(robot("robot-arm-2"), {});
  JointPath path(6, 160);
  const JointArray from = array_of(home_of(mover.model()));
  // As a planned line has it: 120 pieces of 2.5 mm, the joints a few tenths of a rad in all.
  for (int k = 0; k < 120; ++k) {
    JointArray a = from, b = from;
    for (std::size_t j = 0; j < 6; ++j) {
      a[j] += 0.4 * std::sin(0.01 * k + static_cast<double>(j));
      b[j] += 0.4 * std::sin(0.01 * (k + 1) + static_cast<double>(j));
    }
    ASSERT_TRUE(path.append_line({a.data(), 6}, {b.data(), 6}, 2.5e-3));
  }
  std::vector<CellClaim> claims;
  // From far away inwards until it would be nearer than 30 mm.
  const auto push_up = [&](double turn, const auto& claim_at) {
    CellClaim last;
    for (double far = 1.5; far > 0.1; far -= 5e-3) {
      const CellClaim next = claim_at(Vec3{far * std::cos(turn), far * std::sin(turn), 0});
      const CellObstacle near{&next, 0.03, 0};
      if (first_contact(mover, CellWay(path), {&near, 1})) break;
      last = next;
    }
    claims.push_back(last);
  };
  const std::array ids{"learm", "bigrobotarm", "maxarm", "hexapod"};
  for (std::size_t i = 0; i < 4; ++i) {
    push_up(kPi / 2 * static_cast<double>(i) + 0.7, [&](const Vec3& p) {
      const RobotBodies other(robot(ids[i]), PoseWB{{}, p});
      return claim_of_rest(other, {array_of(home_of(other.model())), {}});
    });
  }
  for (int i = 0; i < 10; ++i) {
    push_up(0.6 * i, [&](const Vec3& p) {
      CellObject object{.name = "o", .X_WX = {}, .half = {0.05, 0.05, 0.2}};
      object.X_WX.p = p + Vec3{0, 0, 0.2};
      return claim_of(object);
    });
  }
  std::vector<CellObstacle> obstacles;
  for (const CellClaim& claim : claims) obstacles.push_back({&claim, 0.01, 0});
  const CellWay way(path);
  EXPECT_FALSE(first_contact(mover, way, obstacles));
  const std::size_t bodies = claim_of_way(mover, way).bodies().size();
  // A part where the swell allows it, and not one for each piece of the path.
  EXPECT_GT(bodies, 50U);
  EXPECT_LT(bodies, 120 * mover.size());
}

}  // namespace
}  // namespace sinew::planning
