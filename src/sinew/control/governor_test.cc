#include "sinew/control/governor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/planning/motion_planner.h"
#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::control {
namespace {

using motion::AxisLimits;
using motion::AxisStates;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A robot of the files, that nothing keeps from touching itself where that is not the point.
RobotModel streaming(const char* id, bool touches) {
  RobotModel model = test::robot(id);
  model.device.capability.motion = MotionKind::kStream;
  if (touches) model.collision.shapes.clear();
  return model;
}

std::vector<AxisLimits> limits_of(const RobotModel& model) {
  std::vector<AxisLimits> limits;
  for (const Joint& joint : model.joints) {
    limits.push_back({joint.velocity_max, joint.acceleration_max, joint.jerk_max});
  }
  return limits;
}

JointVector random_place(test::Random& random, const RobotModel& model) {
  // Legs of any lengths are no platform; near its home they are.
  const double share = model.joints[0].kind == JointKind::kPrismatic ? 0.02 : 1;
  JointVector q;
  for (const Joint& joint : model.joints) {
    q.push_back(joint.home + share * (random.uniform(joint.lower, joint.upper) - joint.home));
  }
  return q;
}

JointMove piece(const AxisStates& states, std::size_t joints, double seconds) {
  JointMove move;
  for (std::size_t i = 0; i < joints; ++i) {
    move.q.push_back(states.q[i]);
    move.qd.push_back(states.qd[i]);
  }
  move.duration = from_seconds(seconds);
  return move;
}

std::span<const double> span_of(const JointVector& q) {
  return {q.data(), q.size()};
}

TEST(Governor, no_motion_inside_the_limits_is_ever_refused) {
  for (const char* id : {"robot-arm-2", "learm", "hexapod", "puma560"}) {
    const RobotModel model = streaming(id, true);
    const std::vector<AxisLimits> limits = limits_of(model);
    Governor governor(model, limits);
    test::for_random_cases(100, [&](test::Random& random) {
      const JointVector from = random_place(random, model);
      const JointVector to = random_place(random, model);
      const motion::RestToRest way(span_of(from), span_of(to), limits);
      // Pieces of changing lengths, in whole nanoseconds as time is.
      governor.rest(span_of(from));
      Instant now{};
      const Instant end = Instant{} + from_seconds(way.duration());
      while (now < end) {
        const Instant before = now;
        now = std::min(end, now + from_seconds(random.uniform(0.001, 0.1)));
        AxisStates states;
        way.sample(now == end ? way.duration() : to_seconds(now - Instant{}), states);
        const JointMove move = piece(states, model.joints.size(), to_seconds(now - before));
        const auto passed = governor.pass(move);
        ASSERT_TRUE(passed) << id << ": " << describe(passed.error());
      }
    });
  }
}

/// What a piece may be, from where the machine is: mostly nearly right.
JointMove hostile_piece(test::Random& random, const RobotModel& model, const Governor& governor) {
  static constexpr double kBad[] = {kNan, kInf, -kInf, 1e308, -1e308, 0, -1, 5e-324};
  JointMove move;
  const double seconds = random.chance(0.9) ? random.uniform(0.001, 0.1) : random.uniform(-1, 100);
  const double size = std::pow(10, random.uniform(-6, 1));
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const double jerk = model.joints[i].jerk_max;
    const double qd = jerk * seconds * seconds / 2 * random.uniform(-size, size);
    move.q.push_back(governor.q()[i] + qd * seconds / 3);
    move.qd.push_back(qd);
  }
  move.duration = from_seconds(std::clamp(seconds, -1e6, 1e6));
  const auto any = [&] {
    return static_cast<std::size_t>(random.integer(0, static_cast<int>(model.joints.size()) - 1));
  };
  if (random.chance(0.1)) move.q[any()] = kBad[random.integer(0, 7)];
  if (random.chance(0.1)) move.qd[any()] = kBad[random.integer(0, 7)];
  if (random.chance(0.05)) move.q[any()] += random.uniform(-7, 7);
  if (random.chance(0.05)) move.qd = {};
  if (random.chance(0.02)) move.q.push_back(0);
  return move;
}

/// Means over its pieces are all that a sequence of places and times can tell of its derivatives.
class Watcher {
 public:
  Watcher(const RobotModel& model, const Governor& governor) : model_(model) {
    for (std::size_t i = 0; i < model.joints.size(); ++i) q_[i] = governor.q()[i];
  }
  void see(const JointMove& move) {
    const double seconds = to_seconds(move.duration);
    ASSERT_GT(seconds, 0);
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const Joint& joint = model_.joints[i];
      const double q = move.q[i];
      const double qd = move.qd.empty() ? 0 : move.qd[i];
      ASSERT_TRUE(q >= joint.lower - 2e-9 && q <= joint.upper + 2e-9) << q;
      ASSERT_LE(std::abs(qd), joint.velocity_max * 1.00001 + 2e-9);
      ASSERT_LE(std::abs(q - q_[i]), joint.velocity_max * 1.00001 * seconds + 2e-9);
      const double a = (qd - qd_[i]) / seconds;
      ASSERT_LE(std::abs(a), joint.acceleration_max * 1.00001 + 2e-9 / seconds);
      ASSERT_LE(std::abs(a - a_[i]),
                joint.jerk_max * (seconds + seconds_) / 2 * 1.00001 + 2e-9 / seconds);
      const double trapezoid = (qd + qd_[i]) * seconds / 2;
      ASSERT_LE(std::abs(q - q_[i] - trapezoid),
                joint.jerk_max * std::pow(seconds, 3) / 12 * 1.00001 + 2e-9);
      q_[i] = q, qd_[i] = qd, a_[i] = a;
    }
    seconds_ = seconds;
  }

 private:
  const RobotModel& model_;
  std::array<double, kMaxJoints> q_{}, qd_{}, a_{};
  double seconds_ = 0;
};

class HostileSequences : public ::testing::TestWithParam<const char*> {};

TEST_P(HostileSequences, what_passes_is_inside_the_limits_whatever_was_asked_for) {
  const RobotModel model = streaming(GetParam(), true);
  Governor governor(model, limits_of(model));
  std::uint64_t passed = 0;
  test::for_random_cases(340'000, [&](test::Random& random) {
    governor.rest(span_of(random_place(random, model)));
    Watcher watcher(model, governor);
    for (int i = 0; i < 4; ++i) {
      const std::vector<double> before(governor.q().begin(), governor.q().end());
      const JointMove move = hostile_piece(random, model, governor);
      const auto fine = governor.pass(move);
      if (!fine) {
        ASSERT_TRUE(std::ranges::equal(governor.q(), before)) << "a refusal changed something";
        continue;
      }
      ++passed;
      watcher.see(move);
      if (::testing::Test::HasFatalFailure()) return;
    }
  });
  EXPECT_GT(passed, 100'000U) << "most of what is tried is no test";
}

/// The same with the robot's bodies: slow pieces are long ones here, so that some lead into itself.
TEST_P(HostileSequences, what_passes_keeps_its_distance_from_itself) {
  const RobotModel model = streaming(GetParam(), false);
  Governor governor(model, limits_of(model));
  planning::CollisionModel bodies(model);
  std::uint64_t passed = 0;
  std::uint64_t refused = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    const JointVector begin = random_place(random, model);
    governor.rest(span_of(begin));
    const double least = std::min(bodies.margin(), bodies.distance(span_of(begin)).distance);
    for (int i = 0; i < 4; ++i) {
      JointMove move = hostile_piece(random, model, governor);
      if (random.chance(0.5)) {
        // To anywhere, slowly enough.
        move = {random_place(random, model), {}, std::chrono::seconds(100)};
        for (std::size_t j = 0; j < model.joints.size(); ++j) move.qd.push_back(0);
      }
      const auto fine = governor.pass(move);
      if (!fine) {
        refused += fine.error().code == ErrorCode::kCollision ? 1 : 0;
        continue;
      }
      ++passed;
      const double now = bodies.distance(span_of(move.q)).distance;
      ASSERT_GE(now, least - 2 * planning::CollisionModel::kResolution - 1e-9);
    }
  });
  EXPECT_GT(passed, 10'000U);
  if (std::string_view(GetParam()) != "hexapod") {
    EXPECT_GT(refused, 100U) << "nothing led into itself";
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, HostileSequences,
                         ::testing::Values("robot-arm-2", "learm", "hexapod"), [](const auto& one) {
                           std::string name = one.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(Governor, every_fault_has_its_own_name) {
  const RobotModel model = streaming("robot-arm-2", true);
  const auto limits = limits_of(model);
  Governor governor(model, limits);
  const JointVector home = home_joints(model);
  const auto tried = [&](const JointMove& move) {
    governor.rest(span_of(home));
    const auto passed = governor.pass(move);
    return passed ? ErrorCode{} : passed.error().code;
  };
  JointMove still{home, {}, std::chrono::milliseconds(50)};
  for (std::size_t i = 0; i < home.size(); ++i) still.qd.push_back(0);
  EXPECT_TRUE(governor.known() || !governor.pass(still)) << "nobody has said where it is";
  governor.rest(span_of(home));
  EXPECT_TRUE(governor.pass(still));

  JointMove move = still;
  move.q[2] = kNan;
  EXPECT_EQ(tried(move), ErrorCode::kMoveInput);
  move = still;
  move.duration = {};
  EXPECT_EQ(tried(move), ErrorCode::kSegmentTime);
  move = still;
  move.qd[1] = 1.01 * limits[1].velocity;
  EXPECT_EQ(tried(move), ErrorCode::kVelocityLimit);
  move = still;
  move.qd[1] = 0.9 * limits[1].velocity;
  move.duration = std::chrono::milliseconds(1);
  EXPECT_EQ(tried(move), ErrorCode::kAccelerationLimit);
  move = still;
  move.duration = std::chrono::milliseconds(1);
  move.qd[1] = 0.9 * limits[1].acceleration * 1e-3;
  EXPECT_EQ(tried(move), ErrorCode::kJerkLimit);
  move = still;
  move.q[1] += 0.5 * limits[1].velocity * 0.05;
  EXPECT_EQ(tried(move), ErrorCode::kJump);
  move = still;
  move.duration = std::chrono::seconds(1000);
  move.q[1] = model.joints[1].upper + 0.01;
  EXPECT_EQ(tried(move), ErrorCode::kJointLimit);
  governor.lose();
  EXPECT_EQ(governor.pass(still).error().code, ErrorCode::kPositionUnknown);
  EXPECT_TRUE(governor.pass_blind(still));
}

TEST(Governor, joint_that_is_left_out_is_never_moved) {
  RobotModel model = streaming("robot-arm-2", true);
  model.device.settings.get<AxisRegistersDevice>().boards[5].homing_place = kLeftOut;
  const auto limits = limits_of(model);
  Governor governor(model, limits);
  const JointVector home = home_joints(model);
  governor.rest(span_of(home));
  JointMove move{home, {}, std::chrono::seconds(10)};
  for (std::size_t i = 0; i < home.size(); ++i) move.qd.push_back(0);
  EXPECT_TRUE(governor.pass(move));
  move.q[5] += 1e-3;
  const auto passed = governor.pass(move);
  ASSERT_FALSE(passed);
  EXPECT_EQ(passed.error().code, ErrorCode::kPositionUnknown);
  EXPECT_EQ(passed.error().index, 5);
}

TEST(Governor, machine_outside_its_limits_may_come_back_and_never_go_farther_out) {
  RobotModel model = streaming("robot-arm-2", true);
  model.device.capability.motion = MotionKind::kPointToPoint;
  Governor governor(model, limits_of(model));
  JointVector q = home_joints(model);
  q[0] = model.joints[0].upper + 0.1;
  governor.rest(span_of(q));
  JointMove move{q, {}, std::chrono::seconds(1)};
  move.q[0] += 1e-3;
  EXPECT_EQ(governor.pass(move).error().code, ErrorCode::kJointLimit);
  move.q[0] -= 0.05;
  EXPECT_TRUE(governor.pass(move));
  move.q[0] += 0.02;
  EXPECT_EQ(governor.pass(move).error().code, ErrorCode::kJointLimit);
}

TEST(Governor, robot_does_not_touch_itself_and_may_come_out_where_it_does) {
  RobotModel model = streaming("robot-arm-2", false);
  model.device.capability.motion = MotionKind::kPointToPoint;
  Governor governor(model, limits_of(model));
  const JointVector home = home_joints(model);
  governor.rest(span_of(home));
  JointMove folded{home, {}, std::chrono::seconds(10)};
  folded.q[2] = model.joints[2].lower;
  const auto refused = governor.pass(folded);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCollision);
  governor.rest(span_of(folded.q));
  EXPECT_TRUE(governor.pass({home, {}, std::chrono::seconds(10)}));
}

TEST(Governor, what_leads_out_of_an_overlap_may_deepen_it_slowly_until_it_rests) {
  const RobotModel model = streaming("robot-arm-2", false);
  const auto limits = limits_of(model);
  const planning::CollisionModel bodies(model);
  JointVector folded = home_joints(model);
  folded[2] = model.joints[2].lower;
  JointVector deeper = folded;
  deeper[2] += 0.1;
  const planning::Clearance nearest = bodies.distance(span_of(folded));
  ASSERT_LT(nearest.distance, 0);
  ASSERT_LT(bodies.distance(span_of(deeper)).distance, nearest.distance - 1e-3);
  const LinkPair own{planning::link_of(model, nearest.first),
                     planning::link_of(model, nearest.second)};
  const LinkPair other{own.first, static_cast<std::uint8_t>(own.second + 1)};

  Governor governor(model, limits);
  const auto tried = [&](const JointVector& from, const LinkPair& named, const JointMove& move) {
    governor.rest(span_of(from));
    governor.leave(std::span(&named, 1));
    const auto passed = governor.pass(move);
    return passed ? ErrorCode{} : passed.error().code;
  };
  JointMove move{deeper, {}, std::chrono::hours(1)};
  for (std::size_t j = 0; j < folded.size(); ++j) move.qd.push_back(0);
  EXPECT_EQ(tried(folded, own, move), ErrorCode{});
  EXPECT_EQ(tried(folded, other, move), ErrorCode::kCollision);
  EXPECT_EQ(tried(home_joints(model), own, move), ErrorCode::kCollision) << "into it";
  governor.rest(span_of(folded));
  EXPECT_EQ(governor.pass(move).error().code, ErrorCode::kCollision) << "it has rested";
  governor.leave(std::span(&own, 1));
  governor.lose();
  EXPECT_EQ(governor.pass_blind(move).error().code, ErrorCode::kCollision)
      << "nor where it is lost";
  move.qd[2] = 1.01 * Governor::kLeavingShare * limits[2].velocity;
  EXPECT_EQ(tried(folded, own, move), ErrorCode::kVelocityLimit);
}

/// What a planner makes from a start that no other motion may come to.
void expect_passed(const RobotModel& model, const JointVector& from, const JointVector& to) {
  planning::MotionPlanner planner(model);
  planning::PlannedMotion motion = planner.make_motion();
  planning::MoveJ way;
  std::ranges::copy(to, way.q.begin());
  const auto start = planner.place_at(span_of(from));
  ASSERT_TRUE(start);
  const auto planned = planner.plan(*start, std::vector<planning::Move>{{.way = way}}, 0, motion);
  ASSERT_TRUE(planned) << describe(planned.error().error);
  Governor governor(model, limits_of(model));
  governor.rest(span_of(from));
  planning::JointMotion at;
  constexpr double kPiece = 0.02;
  const double pieces = std::ceil(motion.law.duration() / kPiece);
  for (double k = 1; k <= pieces; ++k) {
    motion.trajectory().sample(k * kPiece, at);
    JointMove piece{.q = {}, .qd = {}, .duration = from_seconds(kPiece)};
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      piece.q.push_back(at.q[j]);
      piece.qd.push_back(at.qd[j]);
    }
    const auto passed = governor.pass(piece);
    ASSERT_TRUE(passed) << describe(passed.error()) << " at " << k * kPiece << " s";
  }
}

TEST(Governor, planned_ways_back_into_the_limits_and_out_of_contact_pass) {
  const RobotModel model = streaming("robot-arm-2", false);
  JointVector outside = home_joints(model);
  outside[0] = model.joints[0].upper + 0.1;
  JointVector inside = outside;
  inside[0] = 1;
  expect_passed(model, outside, inside);
  JointVector folded = home_joints(model);
  folded[1] = from_deg(-60);
  JointVector open = folded;
  folded[2] = from_deg(-55);
  open[2] = 0;
  expect_passed(model, folded, open);
  // Inside the margin, and again as near on the way, but no nearer.
  JointVector near = open;
  const planning::CollisionModel collision(model);
  while (collision.distance(span_of(near)).distance > 0.7 * collision.margin()) {
    near[2] -= from_deg(0.1);
  }
  ASSERT_GT(collision.distance(span_of(near)).distance, 0);
  expect_passed(model, near, open);
  RobotModel whole = model;
  whole.device.capability.motion = MotionKind::kPointToPoint;
  Governor governor(whole, limits_of(whole));
  governor.rest(span_of(near));
  EXPECT_TRUE(governor.pass({open, {}, std::chrono::seconds(10)}));
  EXPECT_TRUE(governor.pass({near, {}, std::chrono::seconds(10)}));
  near[2] -= from_deg(0.5);
  EXPECT_EQ(governor.pass({near, {}, std::chrono::seconds(10)}).error().code,
            ErrorCode::kCollision);
}

TEST(Governor, looks_without_the_heap) {
  const RobotModel model = streaming("robot-arm-2", false);
  Governor governor(model, limits_of(model));
  const JointVector home = home_joints(model);
  JointMove still{home, {}, std::chrono::milliseconds(50)};
  const test::AllocationCounter allocations;
  governor.rest(span_of(home));
  ASSERT_TRUE(governor.pass(still));
  still.q[0] = 100;
  ASSERT_FALSE(governor.pass(still));
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::control
