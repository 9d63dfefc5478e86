#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/planning/paths/move_path.h"
#include "sinew/planning/paths/move_path_test_robot.h"
#include "sinew/planning/paths/move_proposal.h"

namespace sinew::planning {
namespace {

using test::for_random_cases;
using test::Random;

constexpr double kLookStep = 1e-4;

/// A line as nobody would plan it: the inverse every tenth of a millimetre, each the nearest to the
/// one before.
struct BruteForce {
  bool ended = false;  ///< the inverse fails, or jumps
  double ended_at = 0;
  bool out = false;  ///< a joint leaves its limits by more than rounding
  double out_at = 0;
  std::vector<bool> joints_out;                               ///< at that look
  double rate_min = std::numeric_limits<double>::infinity();  ///< m/s that the joints allow
  double rate_min_at = 0;
  std::vector<JointArray> q;  ///< at each look

  BruteForce(const PathRobot& robot, const ToolWay& way, const JointArray& q_from)
      : robot_(robot), way_(way) {
    const double length = way.length();
    const int looks = static_cast<int>(std::ceil(length / kLookStep));
    const double step = length / looks;
    q.push_back(q_from);
    before_ = q_from;
    last_ = q_from;
    joints_out.assign(robot.space.size(), false);
    for (int k = 1; k <= looks && !ended; ++k) {
      const double s = length * (k - 1) / looks;
      const JointArray before = before_;
      const JointArray last = last_;
      // Where joints do not go on as they did, a hundred times closer.
      const double surprise = look(s, step, k == 1);
      if (surprise > 2e-3) {
        constexpr int kFiner = 200;
        before_ = before;
        last_ = last;
        for (int i = 0; i < kFiner && !ended; ++i) {
          look(s + step * i / kFiner, step / kFiner, i == 0);
          settle(s + step * (i + 1) / kFiner, step / kFiner, i < 2);
        }
      } else {
        settle(s + step, step, k < 3);
      }
      q.push_back(last_);
    }
  }

 private:
  /// The next joints, and how far they are from where the last two would lead.
  double look(double s, double step, bool first) {
    failed_ = false;
    const auto next = robot_.space.inverse_near(way_.at(s + step), last_);
    if (!next) {
      failed_ = true;
      return 1;
    }
    double surprise = 0;
    for (std::size_t j = 0; j < robot_.space.size(); ++j) {
      const double straight = first ? last_[j] : 2 * last_[j] - before_[j];
      surprise = std::max(surprise, std::abs((*next)[j] - straight));
    }
    bend_ = first ? JointArray{} : before_;
    before_ = last_;
    last_ = *next;
    return surprise;
  }
  void settle(double s, double step, bool first) {
    if (failed_) {
      ended = true;
      ended_at = s;
      return;
    }
    double rate = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < robot_.space.size(); ++j) {
      const Joint& joint = robot_.model.joints[j];
      const double turned = std::abs(last_[j] - before_[j]);
      rate = std::min(rate, joint.velocity_max * step / turned);
      const double bend = last_[j] - 2 * before_[j] + bend_[j];
      if (!first) rate = std::min(rate, step * std::sqrt(joint.acceleration_max / std::abs(bend)));
      if (!out && !within_limits(joint, last_[j])) joints_out[j] = true;
      if (turned > 0.2) ended = true;
    }
    if (ended) ended_at = s;
    if (rate < rate_min) {
      rate_min = rate;
      rate_min_at = s;
    }
    if (!out && std::find(joints_out.begin(), joints_out.end(), true) != joints_out.end()) {
      out = true;
      out_at = s;
    }
  }

  const PathRobot& robot_;
  const ToolWay& way_;
  bool failed_ = false;
  JointArray bend_{};
  JointArray before_{};
  JointArray last_{};
};

class Refusal : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, Refusal, testing::ValuesIn(kPathRobots), path_robot_name);

TEST_P(Refusal, tells_the_place_that_a_dense_look_finds_and_a_path_has_none) {
  PathRobot robot(GetParam());
  int planned = 0;
  int limits = 0;
  int reach = 0;
  for_random_cases(120, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    RobotPlace to = robot.random_neighbour(random, from, robot.space.size() > 3 ? 0.6 : 2);
    if (robot.is_hexapod()) to.X_BT.p = to.X_BT.p + Vec3{0, 0, random.uniform(-0.1, 0.1)};
    const std::vector<Move> moves{line_to(to.X_BT)};
    MoveWay way(robot.space);
    if (way.make(moves[0], from) || way.length() < 1e-3) return random.discard();
    const BruteForce truth(robot, way.tool(), from.q);
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (stretch) {
      ++planned;
      // A line may be let through a singularity that it misses by less than its tolerance; then
      // what is exact has no answer there.
      EXPECT_TRUE(!truth.out || truth.ended) << truth.out_at;
      for (std::size_t k = 0; !truth.ended && k < truth.q.size(); k += 10) {
        PathPoint at;
        robot.path.joints.sample(
            way.length() * static_cast<double>(k) / static_cast<double>(truth.q.size() - 1), at);
        const auto X_BT = robot.space.forward(robot.joints(at.q), from.X_BT);
        if (!X_BT) continue;
        for (std::size_t j = 0; j < robot.space.size(); ++j) {
          EXPECT_NEAR(at.q[j], truth.q[k][j], 5e-3) << "J" << j + 1;
        }
      }
      return;
    }
    const Error& error = stretch.error().error;
    const double s = stretch.error().place.at;
    const std::string said = describe(error) + " at " + std::to_string(s);
    EXPECT_NEAR(stretch.error().place.share, s / way.length(), 1e-12);
    if (error.code == ErrorCode::kJointLimit || error.code == ErrorCode::kLegLength) {
      ++limits;
      ASSERT_TRUE(truth.out) << said;
      EXPECT_NEAR(s, truth.out_at, 1.1 * kLookStep) << said;
      EXPECT_TRUE(truth.joints_out[static_cast<std::size_t>(error.index)]) << said;
      EXPECT_GT(excess(error), 0);
    } else if (error.code == ErrorCode::kOutOfReach || error.code == ErrorCode::kTooClose) {
      ++reach;
      ASSERT_TRUE(truth.ended) << said;
      EXPECT_NEAR(s, truth.ended_at, 1.1 * kLookStep) << said;
    } else if (error.code == ErrorCode::kRollNotFree) {
      ASSERT_FALSE(truth.ended);
      const auto X_end = robot.space.forward(robot.joints(truth.q.back()), {});
      EXPECT_NEAR(angle_between(X_end->R, to.X_BT.R), error.measured, 1e-6) << said;
    } else if (!robot.is_hexapod()) {
      // A singularity: there the joints hold the tool to a creep, or cannot follow at all.
      EXPECT_TRUE(truth.ended || truth.rate_min < 1e-3) << said << " " << truth.rate_min;
    }
  });
  EXPECT_GT(planned, 30);
  if (!robot.is_hexapod()) {
    EXPECT_GT(limits + reach, robot.space.size() > 3 ? 5 : 0);
  }
}

TEST(Refusal, of_a_hexapod_is_the_first_place_that_its_check_refuses) {
  PathRobot robot("hexapod");
  int refused = 0;
  for_random_cases(100, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const auto check = [&](const PoseBT& X_BT) {
      return robot.space.hexapod()->check(relabel<frame::Base, frame::Platform>(X_BT),
                                          robot.space.joints());
    };
    if (!check(from.X_BT).empty()) return random.discard();
    PoseBT X_BT = from.X_BT;
    X_BT.p = X_BT.p +
             Vec3{random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1)};
    X_BT.R = rotation_from_vector({0, 0, random.uniform(-1.4, 1.4)}) * X_BT.R;
    const std::vector<Move> moves{line_to(X_BT)};
    MoveWay way(robot.space);
    ASSERT_FALSE(way.make(moves[0], from));
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    double first = way.length();
    for (double s = 0; s < way.length(); s += kLookStep) {
      if (check(robot.space.pose(way.tool().at(s))).empty()) continue;
      first = s;
      break;
    }
    if (stretch) {
      EXPECT_EQ(first, way.length());
      return;
    }
    ++refused;
    EXPECT_NEAR(stretch.error().place.at, first, 0.3e-3) << describe(stretch.error().error);
    const auto wrong = check(robot.space.pose(way.tool().at(first)));
    EXPECT_TRUE(std::any_of(wrong.begin(), wrong.end(), [&](const Error& error) {
      return error.code == stretch.error().error.code && error.index == stretch.error().error.index;
    })) << describe(stretch.error().error);
  });
  EXPECT_GT(refused, 20);
}

TEST(Refusal, of_a_joint_move_names_the_joint_and_where_it_leaves) {
  PathRobot robot("robot-arm-2");
  const RobotPlace from = robot.place({}, {});
  JointArray q{};
  q[2] = from_deg(150);
  const auto stretch = robot.builder.build(from, std::vector<Move>{joints_to(q)}, 0, robot.path);
  ASSERT_FALSE(stretch);
  const PathRefusal& refusal = stretch.error();
  EXPECT_EQ(refusal.error.code, ErrorCode::kJointLimit);
  EXPECT_EQ(refusal.error.index, 2);
  EXPECT_NEAR(to_deg(refusal.error.measured), 150, 1e-9);
  EXPECT_NEAR(to_deg(refusal.error.limit), 135, 1e-9);
  EXPECT_NEAR(refusal.place.share, 135.0 / 150, 1e-4);
}

TEST(Refusal, names_a_limit_that_is_broken_between_two_good_ends_and_how_far) {
  PathRobot robot("puma560");
  int found = 0;
  int exact = 0;
  for_random_cases(400, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    const RobotPlace to = robot.random_neighbour(random, from, 0.4);
    const std::vector<Move> moves{line_to(to.X_BT)};
    const auto stretch = robot.builder.build(from, moves, 0, robot.path);
    if (stretch || stretch.error().error.code != ErrorCode::kJointLimit) return random.discard();
    MoveWay way(robot.space);
    ASSERT_FALSE(way.make(moves[0], from));
    const BruteForce truth(robot, way.tool(), from.q);
    if (truth.ended) return;
    const auto& error = stretch.error().error;
    const auto j = static_cast<std::size_t>(error.index);
    double far = error.limit;
    for (const JointArray& q : truth.q) {
      far = error.measured > error.limit ? std::max(far, q[j]) : std::min(far, q[j]);
    }
    // A way that ends early may not have gone all the way out.
    EXPECT_LE(excess(error), std::abs(far - error.limit) + 0.02) << "J" << j + 1;
    exact += std::abs(error.measured - far) < 1e-3 ? 1 : 0;
    ++found;
  });
  EXPECT_GT(found, 20);
  EXPECT_GT(exact, 0.8 * found);
}

TEST(Refusal, of_a_way_farther_out_from_outside_of_the_limits_says_so) {
  PathRobot robot("robot-arm-2");
  RobotPlace from = robot.place({}, {});
  from.q[3] = from_deg(171);
  EXPECT_TRUE(robot.builder.build(from, std::vector<Move>{joints_to({})}, 0, robot.path));
  const std::vector<Move> out{joints_to({0, 0, 0, from_deg(171.1), 0, 0})};
  const auto stretch = robot.builder.build(from, out, 0, robot.path);
  ASSERT_FALSE(stretch);
  EXPECT_EQ(stretch.error().error.code, ErrorCode::kJointLimit);
  EXPECT_EQ(stretch.error().error.index, 3);
}

/// robot-arm-2 whose hand turns about its wrist, on an arc of 60 degrees that passes the forearm's
/// axis by `miss` rad in its middle. The arm itself stays where it is.
struct PastWrist {
  explicit PastWrist(double miss) {
    const RobotPlace straight = robot.place({0, from_deg(-20), from_deg(40), 0, 0, 0}, {});
    const auto* arm = robot.space.serial();
    const auto X_BF = straight.X_BT * arm->tool().inverse();
    const Vec3 p_BW = X_BF.p - arm->chain().rows()[5].d * X_BF.R.z;
    const Vec3 middle = std::cos(miss) * X_BF.R.z - std::sin(miss) * X_BF.R.x;
    const Vec3 normal = cross(middle, X_BF.R.y);
    const auto turned = [&](double angle) {
      const Rotation R =
          rotation_from_vector(angle * normal) * rotation_from_vector(-miss * X_BF.R.y);
      return PoseBT{R * straight.X_BT.R, p_BW + R * (straight.X_BT.p - p_BW)};
    };
    const PoseBT X_from = turned(from_deg(-30));
    for (const JointArray& q : robot.space.branches(robot.space.point(X_from), straight.q)) {
      // Of both flips the one that passes inside the limits: they are sorted by their way from 0.
      const bool same_arm = std::abs(q[1] - straight.q[1]) < 1e-6;
      if (same_arm && from.q[4] == 0) from = robot.place(q, {});
    }
    EXPECT_NE(from.q[4], 0);
    arc = {.way = MoveC{turned(0).p, {turned(from_deg(30))}}};
  }
  PathRobot robot{"robot-arm-2"};
  RobotPlace from;
  Move arc;
};

TEST(Singularity, an_arc_straight_through_the_wrist_s_is_made_without_turning_it_over) {
  PastWrist way(0);
  const auto stretch =
      way.robot.builder.build(way.from, std::vector<Move>{way.arc}, 0, way.robot.path);
  ASSERT_TRUE(stretch) << describe(stretch.error().error);
  EXPECT_NEAR(stretch->end.q[4], -way.from.q[4], 1e-6);
  EXPECT_NEAR(stretch->end.q[3], way.from.q[3], 1e-6);
  EXPECT_TRUE(stretch->slowdowns.empty());
}

TEST(Singularity, an_arc_that_just_misses_one_is_refused_or_slowed_and_says_which_and_where) {
  int slowed = 0;
  int refused = 0;
  for (const double miss : {1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1}) {
    PastWrist way(miss);
    way.arc.tool_speed = 0.05;
    const auto stretch =
        way.robot.builder.build(way.from, std::vector<Move>{way.arc}, 0, way.robot.path);
    MoveWay whole(way.robot.space);
    ASSERT_FALSE(whole.make(way.arc, way.from));
    const double middle = whole.length() / 2;
    if (!stretch) {
      ++refused;
      const auto& refusal = stretch.error();
      EXPECT_EQ(refusal.error.code, ErrorCode::kWristSingular)
          << miss << " " << describe(refusal.error) << " from J4 " << way.from.q[3];
      EXPECT_NEAR(refusal.place.at, middle, 0.05 * whole.length()) << miss;
      EXPECT_LT(miss, 0.02);
      continue;
    }
    EXPECT_GT(miss, 2e-3);
    for (const Slowdown& slowdown : stretch->slowdowns) {
      ++slowed;
      EXPECT_EQ(slowdown.near.code, ErrorCode::kWristSingular) << miss;
      EXPECT_LT(slowdown.tool_speed, 0.05);
      EXPECT_GE(slowdown.by.joint, 0) << "one joint cannot follow";
      EXPECT_NEAR(slowdown.place.at, middle, 0.1 * whole.length()) << miss;
    }
  }
  EXPECT_GE(refused, 2);
  EXPECT_GE(slowed, 2);
}

TEST(Singularity, a_line_out_of_the_workspace_is_refused_where_it_leaves) {
  PathRobot robot("robot-arm-2");
  const RobotPlace from = robot.place({0, 0, 0, 0, from_deg(60), 0}, {});
  PoseBT X_BT = from.X_BT;
  X_BT.p = X_BT.p + Vec3{1, 0, 0};
  const auto stretch = robot.builder.build(from, std::vector<Move>{line_to(X_BT)}, 0, robot.path);
  ASSERT_FALSE(stretch);
  EXPECT_EQ(stretch.error().error.code, ErrorCode::kOutOfReach);
  EXPECT_GT(stretch.error().place.at, 0.01);
  // A hair before, the elbow is straight: the line ends there with a joint that turns too fast.
  X_BT.p = from.X_BT.p + Vec3{stretch.error().place.at - 1e-5, 0, 0};
  const auto shorter = robot.builder.build(from, std::vector<Move>{line_to(X_BT)}, 0, robot.path);
  ASSERT_FALSE(shorter);
  EXPECT_EQ(shorter.error().error.code, ErrorCode::kElbowSingular);
  X_BT.p = from.X_BT.p + Vec3{stretch.error().place.at - 0.02, 0, 0};
  const auto inside = robot.builder.build(from, std::vector<Move>{line_to(X_BT)}, 0, robot.path);
  EXPECT_TRUE(inside) << describe(inside.error().error);
}

TEST(Proposal, what_is_proposed_works) {
  int moves_j = 0;
  int starts = 0;
  int tilts = 0;
  for (const char* id : kPathRobots) {
    // Lines between neighbours are never refused there, so nothing is proposed.
    if (std::string_view(id) == "maxarm" || std::string_view(id) == "hexapod") continue;
    PathRobot robot(id);
    for_random_cases(60, [&](Random& random) {
      const RobotPlace from = robot.random_place(random);
      const RobotPlace to = robot.random_neighbour(random, from, 1);
      const std::vector<Move> moves{line_to(to.X_BT)};
      const auto stretch = robot.builder.build(from, moves, 0, robot.path);
      if (stretch) return random.discard();
      const auto proposal = propose(robot.builder, robot.space, stretch.error(), moves, robot.path);
      if (proposal.move_j) {
        ++moves_j;
        ASSERT_TRUE(robot.builder.build(from, std::vector<Move>{joints_to(*proposal.move_j)}, 0,
                                        robot.path));
        const auto X_BT = robot.space.forward(robot.joints(*proposal.move_j), to.X_BT);
        ASSERT_TRUE(X_BT);
        EXPECT_LE(norm(X_BT->p - to.X_BT.p), 1e-9);
      }
      if (proposal.other_start) {
        ++starts;
        const RobotPlace other = robot.place(*proposal.other_start, from.X_BT);
        EXPECT_LE(norm(other.X_BT.p - from.X_BT.p), 1e-9);
        EXPECT_TRUE(robot.builder.build(other, moves, 0, robot.path));
      }
      if (proposal.tilted) {
        ++tilts;
        EXPECT_LE(norm(proposal.tilted->X_BT.p - to.X_BT.p), 1e-12);
      }
    });
  }
  EXPECT_GT(moves_j, 50);
  EXPECT_GT(starts, 5);
  EXPECT_GT(tilts, 5);
}

TEST(Nearest,
     an_orientation_that_five_joints_cannot_have_is_refused_with_the_nearest_that_they_can) {
  PathRobot robot("learm");
  for_random_cases(200, [&](Random& random) {
    const RobotPlace from = robot.random_place(random);
    PoseBT X_asked = from.X_BT;
    const double off = random.uniform(0.01, 0.3);
    const Vec3 across = normalized(cross(X_asked.R.z, Vec3{X_asked.p.x, X_asked.p.y, 0}));
    // Out of the plane: about an axis in it, across the approach axis.
    const Vec3 axis = normalized(cross(across, X_asked.R.z));
    X_asked.R = rotation_from_vector(off * axis) * X_asked.R;
    const auto stretch =
        robot.builder.build(from, std::vector<Move>{line_to(X_asked)}, 0, robot.path);
    ASSERT_FALSE(stretch);
    EXPECT_EQ(stretch.error().error.code, ErrorCode::kApproachOutOfPlane);
    EXPECT_NEAR(stretch.error().error.measured, off, 1e-9);
    ASSERT_TRUE(stretch.error().nearest);
    EXPECT_LE(angle_between(stretch.error().nearest->X_BT.R, from.X_BT.R), 1e-9);
    // Nothing that it can have is nearer.
    for (int i = 0; i < 20; ++i) {
      TaskPoint other = stretch.error().nearest->point;
      other.attitude[0] += random.uniform(-0.1, 0.1);
      other.attitude[1] += random.uniform(-0.1, 0.1);
      EXPECT_GE(angle_between(robot.space.pose(other).R, X_asked.R), off - 1e-9);
    }
  });
}

}  // namespace
}  // namespace sinew::planning
