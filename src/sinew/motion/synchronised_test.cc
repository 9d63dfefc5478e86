#include "sinew/motion/synchronised.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/motion/joint_test_problem.h"
#include "support/allocation_guard.h"

namespace sinew::motion::test {
namespace {

struct Motion {
  std::vector<AxisState> start, target;
  std::vector<ProfileBounds> bounds;

  void add(const JointProblem& joint) {
    start.push_back(joint.start);
    target.push_back(joint.target);
    bounds.push_back(joint.bounds);
  }
  JointProblem joint(std::size_t i) const { return {start[i], target[i], bounds[i]}; }
  std::size_t size() const { return start.size(); }
  Expected<MotionProfile> plan(Synchronisation how = Synchronisation::kTime) const {
    return plan_motion(start, target, bounds, how);
  }
};

Motion random_motion(Random& random) {
  Motion motion;
  const std::int64_t joints = random.integer(1, 8);
  for (std::int64_t i = 0; i < joints; ++i) motion.add(random_problem(random, 0.5));
  return motion;
}

/// States along a line: every joint does its share of what one does.
Motion random_line(Random& random) {
  Motion motion;
  const JointProblem lead = random_problem(random, 0.5);
  const std::int64_t joints = random.integer(2, 8);
  for (std::int64_t i = 0; i < joints; ++i) {
    const double share = i == 0 ? 1 : random.uniform(-1, 1);
    // Far from 0, the direction of a tiny way is lost in rounding.
    const bool far = std::abs(lead.target.q - lead.start.q) > 0.1;
    const double begin = far ? random.uniform(-1, 1) : 0;
    const auto along = [&](const AxisState& s) {
      return AxisState{begin + share * (s.q - lead.start.q), share * s.qd, share * s.qdd};
    };
    const double room = random.chance(0.5) ? 1 : random.uniform(1, 3);
    JointProblem joint{along(lead.start), along(lead.target), lead.bounds};
    if (share < 0) joint.bounds = joint.bounds.mirrored();
    joint.bounds.velocity_lower *= room;
    joint.bounds.velocity_upper *= room;
    joint.bounds.acceleration_lower *= room;
    joint.bounds.acceleration_upper *= room;
    motion.add(joint);
  }
  return motion;
}

TEST(Synchronised, all_joints_take_the_same_time_and_arrive_exactly) {
  sinew::test::for_random_cases(cases_wanted(200'000) / 4, [](Random& random) {
    const Motion motion = random_motion(random);
    const auto plan = motion.plan();
    ASSERT_TRUE(plan.has_value());
    ASSERT_EQ(plan->size(), motion.size());
    AxisStates end{};
    plan->sample(plan->duration(), end);
    for (std::size_t i = 0; i < motion.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "J" << i + 1 << ' ' << motion.joint(i));
      ASSERT_NEAR(plan->joint(i).duration(), plan->duration(), 1e-13 * plan->duration() + 1e-12);
      expect_sound(motion.joint(i), plan->joint(i));
      ASSERT_EQ(end.q[i], motion.target[i].q);
      ASSERT_EQ(end.qd[i], motion.target[i].qd);
      ASSERT_EQ(end.qdd[i], motion.target[i].qdd);
    }
  });
}

// StateToState is held against brute force in farthest_test.cc; here by its answers for single
// durations: none below the common one suits all joints.
TEST(Synchronised, no_shorter_time_suits_all_joints) {
  std::uint64_t beyond_the_slowest = 0;
  sinew::test::for_random_cases(20'000, [&](Random& random) {
    const Motion motion = random_motion(random);
    const double duration = motion.plan()->duration();
    double slowest = 0;
    std::vector<StateToState> joints;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      joints.push_back(planner(motion.joint(i)));
      slowest = std::max(slowest, joints.back().next(0).duration);
    }
    ASSERT_GE(duration, slowest * (1 - 1e-12) - 1e-12);
    if (duration <= slowest * (1 + 1e-9)) return;
    ++beyond_the_slowest;
    for (int k = 0; k < 200; ++k) {
      const double T = slowest + (duration - slowest) * k / 200;
      const bool all = std::all_of(joints.begin(), joints.end(), [&](const StateToState& joint) {
        return joint.next(T).duration <= T * (1 + 1e-9);
      });
      ASSERT_FALSE(all) << T << " < " << duration;
    }
  });
  EXPECT_GT(beyond_the_slowest, 100U) << "no blocked time was ever in the way";
}

// Targets that a sequence of full jerks reaches in n steps, for each joint another sequence.
TEST(Synchronised, joints_that_can_do_it_in_the_same_steps_are_not_slower) {
  sinew::test::for_random_cases(10'000, [](Random& random) {
    Motion motion;
    const std::int64_t steps = random.integer(1, 8);
    const std::int64_t joints = random.integer(2, 4);
    while (static_cast<std::int64_t>(motion.size()) < joints) {
      JointProblem joint;
      joint.bounds = random_bounds(random, 0.5);
      joint.bounds.jerk = 1;
      joint.start = random_state(random, joint.bounds);
      joint.target = joint.start;
      bool fine = true;
      for (std::int64_t n = 0; n < steps && fine; ++n) {
        const auto jerk = static_cast<double>(random.integer(-1, 1));
        const double turn = -joint.target.qdd / jerk;
        if (turn > 0 && turn < 1) {
          const AxisState extreme = advanced(joint.target, jerk, turn);
          fine = !refusal_of_target(extreme, joint.bounds);
        }
        joint.target = advanced(joint.target, jerk, 1);
        fine = fine && !refusal_of_target(joint.target, joint.bounds);
      }
      if (fine) motion.add(joint);
    }
    const auto plan = motion.plan();
    const auto n = static_cast<double>(steps);
    ASSERT_LE(plan->duration(), n * (1 + 2e-5));
  });
}

TEST(Synchronised, joints_along_a_line_stay_on_it) {
  std::uint64_t straight = 0;
  sinew::test::for_random_cases(50'000, [&](Random& random) {
    const Motion motion = random_line(random);
    const auto plan = motion.plan(Synchronisation::kStraight);
    ASSERT_TRUE(plan.has_value());
    ASSERT_TRUE(plan->straight());
    std::size_t lead = 0;
    const auto way = [&](std::size_t i) { return motion.target[i].q - motion.start[i].q; };
    for (std::size_t i = 0; i < motion.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "J" << i + 1 << ' ' << motion.joint(i));
      expect_sound(motion.joint(i), plan->joint(i), 0, 1e-14);
      if (std::abs(way(i)) > std::abs(way(lead))) lead = i;
    }
    AxisStates now{};
    for (int k = 0; k <= 8 && way(lead) != 0; ++k) {
      plan->sample(plan->duration() * k / 8, now);
      const double done = (now.q[lead] - motion.start[lead].q) / way(lead);
      for (std::size_t i = 0; i < motion.size(); ++i) {
        const double scale = 1 + std::abs(done * way(i));
        ASSERT_NEAR(now.q[i], motion.start[i].q + done * way(i), 1e-8 * scale);
      }
    }
    // Where the line costs no time, it is taken anyway; it is never quicker.
    const auto free = motion.plan();
    ASSERT_LE(free->duration(), plan->duration() * (1 + 1e-9) + 1e-12);
    if (free->straight()) ++straight;
  });
  EXPECT_GT(straight, 10'000U);
}

TEST(Synchronised, what_does_not_lie_on_a_line_cannot_stay_on_it) {
  Motion motion;
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  motion.add({{0, 0.2, 0}, {1, 0, 0}, bounds});
  motion.add({{0, -0.2, 0}, {1, 0, 0}, bounds});
  EXPECT_EQ(motion.plan(Synchronisation::kStraight).error().code, ErrorCode::kNotStraight);
  EXPECT_FALSE(motion.plan()->straight());
  motion.start[1].qd = 0.2;
  EXPECT_TRUE(motion.plan()->straight());
}

TEST(Synchronised, rest_to_rest_agrees_with_the_quick_way) {
  sinew::test::for_random_cases(20'000, [](Random& random) {
    Motion motion;
    std::vector<double> from, to;
    std::vector<AxisLimits> limits;
    for (int i = 0; i < 6; ++i) {
      limits.push_back({spread(random, 1), spread(random, 1), spread(random, 1)});
      from.push_back(random.uniform(-3, 3));
      to.push_back(random.uniform(-3, 3));
      motion.add({{from.back(), 0, 0}, {to.back(), 0, 0}, ProfileBounds(limits.back())});
    }
    const RestToRest quick(from, to, limits);
    const auto plan = motion.plan();
    ASSERT_NEAR(plan->duration(), quick.duration(), 1e-11 * quick.duration());
    ASSERT_EQ(plan->slowest(), quick.slowest());
  });
}

TEST(Synchronised, names_the_joint_and_the_limit_that_hold_it_back) {
  Motion motion;
  const AxisState rest{0, 0, 0};
  motion.add({rest, {0.1, 0, 0}, ProfileBounds(AxisLimits{1, 2, 8})});
  motion.add({rest, {5, 0, 0}, ProfileBounds(AxisLimits{1, 2, 8})});
  EXPECT_EQ(motion.plan()->slowest(), 1U);
  EXPECT_EQ(motion.plan()->limited_by(), MotionLimit::kVelocity);
  // On the same line, but hardly able to accelerate.
  motion.bounds[0].acceleration_upper = 0.001;
  motion.bounds[0].acceleration_lower = -0.001;
  const auto straight = motion.plan(Synchronisation::kStraight);
  EXPECT_EQ(straight->slowest(), 0U);
  EXPECT_EQ(straight->limited_by(), MotionLimit::kAcceleration);
  motion.target = motion.start;
  EXPECT_EQ(motion.plan()->duration(), 0);
  EXPECT_EQ(motion.plan()->limited_by(), MotionLimit::kNone);
}

TEST(Synchronised, refusals_name_the_joint) {
  Motion motion;
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  motion.add({{0, 0, 0}, {1, 0, 0}, bounds});
  motion.add({{0, 0, 0}, {1, 1.5, 0}, bounds});
  const Error fast = motion.plan().error();
  EXPECT_EQ(fast, (Error{ErrorCode::kTargetVelocity, 1, 1.5, 1}));
  EXPECT_EQ(describe(fast, "elbow"),
            "elbow would have to pass its target at 85.9437 deg/s, limit 57.2958 deg/s");
  motion.target[1].qd = 0;
  motion.start[0].q = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(motion.plan().error().code, ErrorCode::kMotionInput);
  EXPECT_EQ(motion.plan().error().index, 0);
}

TEST(Synchronised, no_joints_take_no_time) {
  const auto plan = plan_motion({}, {}, {});
  EXPECT_EQ(plan->duration(), 0);
  EXPECT_EQ(plan->size(), 0U);
}

TEST(Synchronised, stops_all_joints_each_as_quickly_as_it_can) {
  sinew::test::for_random_cases(50'000, [](Random& random) {
    const Motion motion = random_motion(random);
    const auto plan = plan_stop(motion.start, motion.bounds);
    ASSERT_TRUE(plan.has_value());
    double longest = 0;
    AxisStates later{};
    plan->sample(plan->duration() + 1, later);
    for (std::size_t i = 0; i < motion.size(); ++i) {
      longest = std::max(longest, plan->joint(i).duration());
      ASSERT_EQ(later.qd[i], 0);
      ASSERT_EQ(later.qdd[i], 0);
      ASSERT_EQ(later.q[i], plan->joint(i).end().q);
    }
    ASSERT_EQ(plan->duration(), longest);
  });
}

TEST(Synchronised, a_jog_goes_on_at_its_velocity) {
  const std::vector<AxisState> start{{0, 0, 0}, {1, 0.5, 0}};
  const std::vector<double> velocity{0.5, -0.25};
  const std::vector<ProfileBounds> bounds(2, ProfileBounds(AxisLimits{1, 2, 8}));
  const auto plan = plan_velocity(start, velocity, bounds);
  AxisStates end{};
  AxisStates later{};
  plan->sample(plan->duration(), end);
  plan->sample(plan->duration() + 2, later);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(end.qd[i], velocity[i]);
    EXPECT_EQ(later.qd[i], velocity[i]);
    EXPECT_NEAR(later.q[i], end.q[i] + 2 * velocity[i], 1e-15);
  }
  const std::vector<double> too_fast{0.5, -1.25};
  EXPECT_EQ(plan_velocity(start, too_fast, bounds).error(),
            (Error{ErrorCode::kTargetVelocity, 1, -1.25, -1}));
}

TEST(Synchronised, nothing_allocates) {
  Motion motion;
  const ProfileBounds bounds(AxisLimits{1, 2, 8});
  motion.add({{0, 0.2, 0}, {1, 0, 0}, bounds});
  motion.add({{0, -0.2, 1}, {1, 0.5, 0}, bounds});
  const sinew::test::AllocationCounter allocations;
  const auto plan = motion.plan();
  const auto stop = plan_stop(motion.start, motion.bounds);
  AxisStates now{};
  plan->sample(0.3, now);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_GT(plan->duration(), stop->duration());
}

}  // namespace
}  // namespace sinew::motion::test
