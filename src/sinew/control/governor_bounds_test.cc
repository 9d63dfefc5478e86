#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "sinew/control/governor.h"
#include "sinew/core/error_code.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/move_check.h"
#include "support/property.h"
#include "support/robots.h"

/// At each bound of the governor: what is just inside passes, what is just outside is refused by
/// that bound and no other. "Just" is a third more or less than the tolerance.
namespace sinew::control {
namespace {

using motion::AxisLimits;

constexpr double kRelative = 1e-6;  // Governor::kTolerance, said here again so that it cannot grow
constexpr double kAbsolute = 1e-9;  // rad or m, of every place and limit
/// So large that another bound is never met; small enough that nothing is lost by rounding.
constexpr double kFree = 1e6;

RobotModel streaming(bool touches) {
  RobotModel model = test::robot("robot-arm-2");
  model.device.capability.motion = MotionKind::kStream;
  model.device.capability.nudge_max = 0.01;
  if (touches) model.collision.shapes.clear();
  // Room to move in.
  for (Joint& joint : model.joints) {
    if (!touches) continue;
    joint.lower = -kFree;
    joint.upper = kFree;
  }
  return model;
}

/// `limit` and a share of its tolerance: 0.7 is inside, 1.3 outside.
double beside(double limit, double share) {
  return limit * (1 + share * kRelative) + share * kAbsolute;
}

struct Bench {
  explicit Bench(const AxisLimits& limits)
      : model(streaming(true)),
        governor(model, std::vector<AxisLimits>(model.joints.size(), limits)) {
    governor.rest(std::vector<double>(model.joints.size(), 0));
  }

  /// One joint moves, the others stay.
  Expected<void> pass(std::size_t joint, double way, double qd, Duration time) {
    JointMove move{.q = JointVector(governor.q()), .qd = {}, .duration = time};
    for (std::size_t i = 0; i < model.joints.size(); ++i) move.qd.push_back(0);
    move.q[joint] += way;
    move.qd[joint] = qd;
    return governor.pass(move);
  }

  RobotModel model;
  Governor governor;
};

/// A piece from a machine that is ready for it, at so much of the bound.
using Piece = std::function<Expected<void>(Bench&, std::size_t joint, double sign, double share)>;

/// Both sides of the bound, in both directions.
void expect_bound(const AxisLimits& limits, ErrorCode code, std::size_t joint, const Piece& piece) {
  for (const double sign : {1.0, -1.0}) {
    Bench inside(limits);
    const auto passed = piece(inside, joint, sign, 0.7);
    ASSERT_TRUE(passed) << describe(passed.error());
    Bench outside(limits);
    const auto refused = piece(outside, joint, sign, 1.3);
    ASSERT_FALSE(refused) << info(code).name << " of joint " << joint;
    EXPECT_EQ(refused.error().code, code) << describe(refused.error());
    EXPECT_EQ(refused.error().index, static_cast<int>(joint));
  }
}

/// Of what a robot may have, and of how a device is told; T in whole nanoseconds, as time is.
struct Drawn {
  explicit Drawn(test::Random& random)
      : joint(static_cast<std::size_t>(random.integer(0, 5))),
        bound(std::pow(10, random.uniform(-2, 2))),
        time(from_seconds(random.uniform(0.02, 0.5))),
        before(from_seconds(random.uniform(0.02, 0.5))) {}
  double T() const { return to_seconds(time); }

  std::size_t joint;
  double bound;
  Duration time;
  Duration before;
};

constexpr std::uint64_t kCases = 2000;

TEST(GovernorBounds, velocity_at_the_end_of_a_piece) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    expect_bound({drawn.bound, kFree, kFree * kFree}, ErrorCode::kVelocityLimit, drawn.joint,
                 [&](Bench& bench, std::size_t joint, double sign, double share) {
                   return bench.pass(joint, 0, sign * beside(drawn.bound, share), drawn.time);
                 });
  });
}

TEST(GovernorBounds, mean_velocity_over_a_piece) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    expect_bound({drawn.bound, kFree, kFree * kFree}, ErrorCode::kVelocityLimit, drawn.joint,
                 [&](Bench& bench, std::size_t joint, double sign, double share) {
                   const double way = beside(drawn.bound * drawn.T(), share);
                   return bench.pass(joint, sign * way, 0, drawn.time);
                 });
  });
}

TEST(GovernorBounds, velocity_on_the_way_out_of_an_overlap_is_a_tenth) {
  const RobotModel model = streaming(false);
  const double velocity = 2;
  const planning::CollisionModel bodies(model);
  JointVector folded = home_joints(model);
  folded[2] = model.joints[2].lower;
  const planning::Clearance nearest = bodies.distance({folded.data(), folded.size()});
  ASSERT_LT(nearest.distance, 0);
  const LinkPair own{planning::link_of(model, nearest.first),
                     planning::link_of(model, nearest.second)};
  for (const double share : {0.7, 1.3}) {
    Governor governor(model, std::vector<AxisLimits>(model.joints.size(),
                                                     AxisLimits{velocity, kFree, kFree * kFree}));
    governor.rest({folded.data(), folded.size()});
    governor.leave({&own, 1});
    JointMove move{folded, {}, std::chrono::milliseconds(100)};
    for (std::size_t i = 0; i < folded.size(); ++i) move.qd.push_back(0);
    move.qd[0] = beside(velocity / 10, share);
    const auto passed = governor.pass(move);
    EXPECT_EQ(passed.has_value(), share < 1);
    if (!passed) {
      EXPECT_EQ(passed.error().code, ErrorCode::kVelocityLimit);
    }
  }
}

TEST(GovernorBounds, acceleration) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    expect_bound({kFree, drawn.bound, kFree * kFree}, ErrorCode::kAccelerationLimit, drawn.joint,
                 [&](Bench& bench, std::size_t joint, double sign, double share) {
                   const double qd = beside(drawn.bound * drawn.T(), share);
                   return bench.pass(joint, sign * qd * drawn.T() / 2, sign * qd, drawn.time);
                 });
  });
}

TEST(GovernorBounds, jerk_from_rest_and_behind_another_piece) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    const AxisLimits limits{kFree, kFree, drawn.bound};
    for (const bool from_rest : {true, false}) {
      const double middles = (drawn.T() + (from_rest ? 0 : to_seconds(drawn.before))) / 2;
      expect_bound(limits, ErrorCode::kJerkLimit, drawn.joint,
                   [&](Bench& bench, std::size_t joint, double sign, double share) {
                     if (!from_rest) {
                       const auto still = bench.pass(joint, 0, 0, drawn.before);
                       if (!still) return still;
                     }
                     const double qd = beside(drawn.bound * middles * drawn.T(), share);
                     return bench.pass(joint, sign * qd * drawn.T() / 2, sign * qd, drawn.time);
                   });
    }
  });
}

/// Acceleration that ends counts as much as one that begins.
TEST(GovernorBounds, jerk_where_an_acceleration_ends) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    const double before = to_seconds(drawn.before);
    const AxisLimits limits{kFree, kFree, drawn.bound};
    // From rest the first piece may reach a mean of j T1 / 2; the second one takes it away.
    const double first = 0.99 * drawn.bound * before / 2;
    const double change = drawn.bound * (before + drawn.T()) / 2;
    expect_bound(limits, ErrorCode::kJerkLimit, drawn.joint,
                 [&](Bench& bench, std::size_t joint, double sign, double share) {
                   const double qd = sign * first * before;
                   const auto sped_up = bench.pass(joint, qd * before / 2, qd, drawn.before);
                   if (!sped_up) return sped_up;
                   const double slower =
                       sign * (first * drawn.T() - beside(change * drawn.T(), share));
                   const double way = (qd + qd + slower) * drawn.T() / 2;
                   return bench.pass(joint, way, qd + slower, drawn.time);
                 });
  });
}

TEST(GovernorBounds, jump_between_what_place_and_velocity_tell) {
  test::for_random_cases(kCases, [](test::Random& random) {
    const Drawn drawn(random);
    const double T = drawn.T();
    expect_bound({kFree, kFree, drawn.bound}, ErrorCode::kJump, drawn.joint,
                 [&](Bench& bench, std::size_t joint, double sign, double share) {
                   const double apart = beside(drawn.bound * T * T * T / 12, share);
                   return bench.pass(joint, sign * apart, 0, drawn.time);
                 });
  });
}

TEST(GovernorBounds, joint_limits_of_pieces_blind_moves_and_nudges) {
  RobotModel model = streaming(true);
  for (Joint& joint : model.joints) {
    joint.lower = -1;
    joint.upper = 1;
  }
  const std::vector<AxisLimits> limits(model.joints.size(), {kFree, kFree, kFree * kFree});
  const JointVector zero(std::vector<double>(model.joints.size(), 0));
  for (std::size_t joint = 0; joint < model.joints.size(); ++joint) {
    for (const double sign : {1.0, -1.0}) {
      for (const double share : {0.7, 1.3}) {
        Governor governor(model, limits);
        JointMove move{zero, zero, std::chrono::hours(1)};
        move.q[joint] = sign * (1 + share * kAbsolute);
        const auto expect = [&](const Expected<void>& passed, const char* what) {
          EXPECT_EQ(passed.has_value(), share < 1) << what << joint << sign;
          if (!passed) {
            EXPECT_EQ(passed.error().code, ErrorCode::kJointLimit) << what;
          }
        };
        expect(governor.pass_blind(move), "blind ");
        std::vector<JointPosition> at(model.joints.size(),
                                      {PositionQuality::kMeasured, sign * 0.995, -1, 1});
        expect(governor.pass_nudge(joint, move.q[joint] - sign * 0.995, at), "nudge ");
        governor.rest({zero.data(), zero.size()});
        expect(governor.pass(move), "piece ");
      }
    }
  }
}

TEST(GovernorBounds, longest_nudge_and_longest_piece) {
  Bench bench({1, kFree, kFree * kFree});
  const std::vector<JointPosition> lost(bench.model.joints.size());
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(bench.governor.pass_nudge(1, sign * beside(0.01, 0.7), lost));
    const auto refused = bench.governor.pass_nudge(1, sign * beside(0.01, 1.3), lost);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kNudgeRange);
  }
  EXPECT_TRUE(bench.pass(0, 0, 0, std::chrono::hours(24)));
  const auto refused = bench.pass(0, 0, 0, std::chrono::hours(24) + std::chrono::nanoseconds(100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kSegmentTime);
}

/// Where the elbow folds the arm to so much clearance, m.
JointVector folded_to(const RobotModel& model, const planning::CollisionModel& bodies,
                      double clearance) {
  JointVector q = home_joints(model);
  double open = q[2];
  double closed = model.joints[2].lower;
  for (int i = 0; i < 200; ++i) {
    q[2] = (open + closed) / 2;
    (bodies.distance({q.data(), q.size()}).distance > clearance ? open : closed) = q[2];
  }
  return q;
}

TEST(GovernorBounds, clearance_from_itself) {
  const RobotModel model = streaming(false);
  const planning::CollisionModel bodies(model);
  const std::vector<AxisLimits> limits(model.joints.size(), {kFree, kFree, kFree * kFree});
  const double resolution = planning::CollisionModel::kResolution;
  const JointVector home = home_joints(model);
  const JointVector still(std::vector<double>(model.joints.size(), 0));
  const auto tried = [&](const JointVector& from, double clearance, bool known) {
    Governor governor(model, limits);
    governor.rest({from.data(), from.size()});
    if (!known) governor.lose();
    const JointMove move{folded_to(model, bodies, clearance), still, std::chrono::hours(1)};
    const auto passed = known ? governor.pass(move) : governor.pass_blind(move);
    return passed ? ErrorCode{} : passed.error().code;
  };
  const double least = bodies.margin() - resolution;
  for (const bool known : {true, false}) {
    EXPECT_EQ(tried(home, least + 0.2 * resolution, known), ErrorCode{});
    EXPECT_EQ(tried(home, least - 0.2 * resolution, known), ErrorCode::kCollision);
  }
  // From nearer than that: no nearer.
  const double begun = 0.5 * bodies.margin();
  const JointVector near = folded_to(model, bodies, begun);
  EXPECT_EQ(tried(near, begun - 0.8 * resolution, true), ErrorCode{});
  EXPECT_EQ(tried(near, begun - 1.2 * resolution, true), ErrorCode::kCollision);
  EXPECT_EQ(tried(near, begun, false), ErrorCode::kCollision) << "a blind move has no such excuse";
}

TEST(GovernorBounds, clearance_of_a_nudge) {
  const RobotModel model = streaming(false);
  const planning::CollisionModel bodies(model);
  const std::vector<AxisLimits> limits(model.joints.size(), {kFree, kFree, kFree * kFree});
  const double resolution = planning::CollisionModel::kResolution;
  const double least = bodies.margin() - resolution;
  const JointVector from = folded_to(model, bodies, bodies.margin() + 2 * resolution);
  std::vector<JointPosition> known;
  for (const double q : from) known.push_back({PositionQuality::kCommanded, q, q, q});
  Governor governor(model, limits);
  governor.rest({from.data(), from.size()});
  const auto nudged = [&](double clearance, std::span<const JointPosition> positions) {
    const double way = folded_to(model, bodies, clearance)[2] - from[2];
    const auto passed = governor.pass_nudge(2, way, positions);
    return passed ? ErrorCode{} : passed.error().code;
  };
  EXPECT_EQ(nudged(least + 0.2 * resolution, known), ErrorCode{});
  EXPECT_EQ(nudged(least - 0.2 * resolution, known), ErrorCode::kCollision);
  const std::vector<JointPosition> lost(model.joints.size());
  EXPECT_EQ(nudged(least - 0.2 * resolution, lost), ErrorCode{}) << "a person looks instead";
}

TEST(GovernorBounds, jaws_that_would_meet_something) {
  const RobotModel& model = test::robot("learm");
  const std::vector<AxisLimits> limits(model.joints.size(), {kFree, kFree, kFree * kFree});
  Governor governor(model, limits);
  planning::CollisionModel bodies(model);
  int refused = 0;
  test::for_random_cases(kCases, [&](test::Random& random) {
    JointVector q;
    for (const Joint& joint : model.joints) q.push_back(random.uniform(joint.lower, joint.upper));
    const ToolState tool{.jaws = random.uniform(0, 0.06)};
    const double to = random.uniform(0, 0.06);
    governor.rest({q.data(), q.size()});
    governor.fit(tool);
    const auto passed = governor.pass_jaws(to);
    const auto meets = bodies.jaws_contact({q.data(), q.size()}, tool, to);
    ASSERT_EQ(passed ? std::nullopt : std::optional(passed.error()), meets);
    refused += meets ? 1 : 0;
    governor.lose();
    ASSERT_TRUE(governor.pass_jaws(to)) << "position unknown";
  });
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace sinew::control
