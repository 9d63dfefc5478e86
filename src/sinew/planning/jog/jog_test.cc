#include "sinew/planning/jog/jog.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/motion/synchronised.h"
#include "sinew/planning/jog/jog_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::planning {
namespace {

using namespace std::chrono_literals;

class JogOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, JogOf, testing::ValuesIn(kJogRobots), jog_robot_name);

TEST_P(JogOf, any_commands_at_any_times_keep_all_limits_at_every_step) {
  JogRun run(GetParam());
  const bool hexapod = run.is_hexapod();
  test::for_random_cases(hexapod ? 150 : 400, [&](test::Random& random) {
    run.start(random.chance(0.1) ? run.home() : run.random_place(random));
    constexpr std::array kCycles{0.001, 0.002, 0.004, 0.01};
    for (int part = 0; part < 5 && !testing::Test::HasFatalFailure(); ++part) {
      const double dt = kCycles[static_cast<std::size_t>(random.integer(0, 3))];
      const JogCommand command = run.random_command(random);
      run.hold(command, random.uniform(0.01, 1.0), dt);
      if (testing::Test::HasFatalFailure()) break;
      if (random.chance(0.2)) run.jog.stop();
      if (random.chance(0.2)) run.step(random.uniform(0, 0.3));  // a gap
      for (int k = 0; k < 5 && !testing::Test::HasFatalFailure(); ++k) {
        run.step(random.uniform(1e-4, 0.02));
      }
      JointArray q{};
      for (std::size_t j = 0; j < run.joints(); ++j) q[j] = run.jog.setpoint().q[j];
      EXPECT_LE(run.jog.space().violation(q, run.jog.pose()), 1e-5);
    }
    if (!testing::Test::HasFatalFailure()) run.settle(0.01);
  });
}

TEST_P(JogOf, comes_back_out_of_wherever_a_jog_got_stuck) {
  JogRun run(GetParam());
  if (run.is_hexapod()) GTEST_SKIP() << "none of its random jogs gets stuck";
  int stuck = 0;
  test::for_random_cases(60, [&](test::Random& random) {
    run.start(run.random_place(random));
    JogCommand command = run.random_command(random);
    command.frame = random.chance(0.5) ? JogFrame::kBase : JogFrame::kTool;
    command.velocity.clear();
    for (int k = 0; k < 3; ++k) {
      command.velocity.push_back(run.tool_speed() * random.uniform(-1, 1));
    }
    // On and on, until the boundary has taken nearly everything.
    double t = 0;
    for (; t < 40; t += 0.5) {
      run.hold(command, 0.5, 0.01);
      if (testing::Test::HasFatalFailure()) return;
      const JogStatus status = run.jog.status();
      if (t > 5 && status.reason != JogReason::kJointSpeed && std::abs(status.share) < 0.02) break;
    }
    if (t >= 40) return random.discard();
    ++stuck;
    for (double& number : command.velocity) number = -number;
    const Vec3 from = run.jog.pose().p;
    const motion::AxisStates stuck_at = run.jog.setpoint();
    const Vec3 back = normalized({command.velocity[0], command.velocity[1], command.velocity[2]});
    bool out = false;
    for (t = 0; t < 20 && !out; t += 0.25) {
      const PoseBT X = run.jog.pose();
      run.hold(command, 0.25, 0.01);
      if (testing::Test::HasFatalFailure()) return;
      const Vec3 way = command.frame == JogFrame::kBase ? back : X.R * back;
      out = run.jog.status().share > 0.1 || dot(run.jog.pose().p - from, way) > 0.002;
    }
    EXPECT_TRUE(out) << "still " << static_cast<int>(run.jog.status().reason) << " at "
                     << testing::PrintToString(stuck_at.q) << " of "
                     << testing::PrintToString(
                            std::vector<double>(command.velocity.begin(), command.velocity.end()))
                     << (command.frame == JogFrame::kBase);
  });
  if (!run.is_hexapod()) {
    EXPECT_GT(stuck, 3);
  }
}

TEST_P(JogOf, command_that_nobody_renews_ends_as_quickly_as_the_limits_allow) {
  JogRun run(GetParam());
  test::for_random_cases(40, [&](test::Random& random) {
    run.start(run.random_place(random));
    JogCommand command = run.random_command(random);
    if (std::ranges::all_of(command.velocity, [](double v) { return v == 0; }))
      return random.discard();
    run.hold(command, 1, 0.002);
    command.expiry = from_seconds(random.uniform(0.02, 0.3));
    ASSERT_FALSE(run.jog.command(command, run.now));
    const Instant given = run.now;
    while (run.now + 1ms < given + command.expiry) run.step(0.001);
    EXPECT_NE(run.jog.status().reason, JogReason::kExpired);
    std::vector<motion::AxisState> states;
    std::vector<motion::ProfileBounds> bounds;
    for (std::size_t j = 0; j < run.joints(); ++j) {
      const auto& at = run.jog.setpoint();
      states.push_back({at.q[j], at.qd[j], at.qdd[j]});
      bounds.emplace_back(run.limits[j]);
    }
    const auto stop = motion::plan_stop(states, bounds);
    ASSERT_TRUE(stop);
    const Instant begin = run.now;
    while (run.now < begin + 100s &&
           (run.jog.status().reason != JogReason::kExpired || !run.jog.at_rest())) {
      run.step(0.001);
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_LE(to_seconds(run.now - begin), stop->duration() + 0.0021);
  });
}

/// The arm's way to do what it can at all; near 0 at a singularity.
double least_singular_value(const JogRun& run) {
  if (run.jog.space().tool().hexapod() != nullptr) return 1;
  JointArray q{};
  for (std::size_t j = 0; j < run.joints(); ++j) q[j] = run.jog.setpoint().q[j];
  TaskJacobian J;
  run.jog.space().look(JogFrame::kBase, q, J);
  TaskSolver solver;
  solver.factor(J, 0);
  TaskArray values;
  for (std::size_t k = 0; k < kTasksMax; ++k) values[k] = solver.singular_value(k);
  std::sort(values.begin(), values.end(), std::greater<>());
  return values[std::min(run.joints(), kTasksMax) - 1];
}

TEST_P(JogOf, tool_goes_straight_away_from_boundaries) {
  JogRun run(GetParam());
  int straight = 0;
  int crooked = 0;
  double worst = 0;
  test::for_random_cases(run.is_hexapod() ? 20 : 200, [&](test::Random& random) {
    const auto q = run.random_place(random);
    run.start(q);
    JogCommand command = run.random_command(random);
    command.frame = random.chance(0.5) ? JogFrame::kBase : JogFrame::kTool;
    command.velocity.clear();
    Vec3 way{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    way = (0.3 * run.tool_speed()) * normalized(way);
    for (const double number : {way.x, way.y, way.z}) command.velocity.push_back(number);
    const PoseBT X_start = run.jog.pose();
    if (command.frame == JogFrame::kTool) way = X_start.R * way;
    const Vec3 along = normalized(way);
    const TaskSpace task = run.jog.space().tool().task();
    const bool turns = task != TaskSpace::kPose;
    if (turns && command.frame == JogFrame::kTool)
      return random.discard();  // its axes turn on the way
    const int pieces = run.limits[0].acceleration < 0.5 ? 150 : 50;
    double least = least_singular_value(run);
    for (int k = 0; k < pieces; ++k) {
      run.hold(command, 0.02, 0.002, 0.05);
      if (testing::Test::HasFatalFailure()) return;
      const JogStatus status = run.jog.status();
      const bool fast = status.reason == JogReason::kJointSpeed;
      if (status.reason != JogReason::kNone && status.reason != JogReason::kWire && !fast)
        return random.discard();
      least = std::min(least, least_singular_value(run));
      if (least < 3 * TaskSolver::kNearSingular) return random.discard();
    }
    const Vec3 gone = run.jog.pose().p - X_start.p;
    const double far = dot(gone, along);
    if (far < 0.2 * run.tool_speed() * 0.3)
      return random.discard();  // slow country: a singularity is near
    ++straight;
    const double off = norm(gone - far * along) / far;
    worst = std::max(worst, off);
    crooked += off > 1e-3 ? 1 : 0;
    EXPECT_LE(off, 2e-2) << "least singular value " << least << ", " << testing::PrintToString(q)
                         << " " << (command.frame == JogFrame::kBase)
                         << testing::PrintToString(std::vector<double>(command.velocity.begin(),
                                                                       command.velocity.end()));
    if (task == TaskSpace::kPose) {
      EXPECT_LE(angle_between(run.jog.pose().R, X_start.R), 2e-3);
    }
  });
  EXPECT_GT(straight, 10);
  EXPECT_LE(crooked, straight / 10) << "joints at their limits of acceleration";
  std::cout << "  " << straight << " ways, off by " << worst << " of their length at most\n";
}

TEST_P(JogOf, renewing_a_command_often_or_seldom_makes_the_same_way) {
  JogRun often(GetParam());
  JogRun seldom(GetParam());
  test::for_random_cases(20, [&](test::Random& random) {
    const auto q = often.random_place(random);
    seldom.X_near = often.X_near;
    const JogCommand command = often.random_command(random);
    often.start(q);
    seldom.start(q);
    for (int k = 0; k < 20; ++k) {
      often.hold(command, 0.05, 0.001, 0.001);
      seldom.hold(command, 0.05, 0.001, 0.05);
      if (testing::Test::HasFatalFailure()) return;
      for (std::size_t j = 0; j < often.joints(); ++j) {
        ASSERT_EQ(often.jog.setpoint().q[j], seldom.jog.setpoint().q[j]);
      }
    }
  });
}

TEST_P(JogOf, cycle_rate_hardly_changes_the_way) {
  JogRun quick(GetParam());
  JogRun slow(GetParam());
  int compared = 0;
  int different = 0;
  test::for_random_cases(60, [&](test::Random& random) {
    const auto q = quick.random_place(random);
    slow.X_near = quick.X_near;
    const JogCommand command = quick.random_command(random);
    quick.start(q);
    slow.start(q);
    quick.hold(command, 0.4, 0.001);
    slow.hold(command, 0.4, 0.01);
    if (testing::Test::HasFatalFailure()) return;
    const auto free = [](const JogStatus& status) {
      return status.reason == JogReason::kNone || status.reason == JogReason::kJointSpeed;
    };
    if (!free(quick.jog.status()) || !free(slow.jog.status())) return random.discard();
    double worst = 0;
    for (std::size_t j = 0; j < quick.joints(); ++j) {
      const double off = std::abs(quick.jog.setpoint().q[j] - slow.jog.setpoint().q[j]);
      worst = std::max(worst, off / (0.4 * quick.limits[j].velocity));
    }
    ++compared;
    different += worst > 0.01 ? 1 : 0;
    EXPECT_LE(worst, 0.15) << "of the way at full speed";
  });
  EXPECT_GT(compared, 10);
  EXPECT_LE(different, compared / 4);
  std::cout << "  " << different << " of " << compared << " differ by more than a hundredth\n";
}

TEST_P(JogOf, nothing_allocates_after_construction) {
  JogRun run(GetParam(), true);
  test::for_random_cases(5, [&](test::Random& random) {
    const auto q = run.random_place(random);
    run.start(q);
    FixedVector<JogCommand, 8> commands;
    while (!commands.full()) commands.push_back(run.random_command(random));
    const test::AllocationCounter counter;
    bool fine = true;
    for (const JogCommand& command : commands) {
      fine = fine && !run.jog.command(command, run.now);
      for (int k = 0; k < 50; ++k) {
        run.now += 2ms;
        fine = fine && !run.jog.step(run.now);
        fine = fine && std::isfinite(run.jog.status().share);
      }
    }
    run.jog.stop();
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_TRUE(fine);
  });
}

TEST_P(JogOf, hostile_commands_are_refused_and_change_nothing) {
  JogRun run(GetParam());
  run.start(run.home());
  const auto refused = [&](const JogCommand& command, ErrorCode code, Instant now) {
    const auto error = run.jog.command(command, now);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, code);
  };
  run.now += 10ms;
  ASSERT_FALSE(run.jog.step(run.now));
  for (const JogFrame frame : {JogFrame::kJoint, JogFrame::kBase, JogFrame::kTool}) {
    JogCommand good;
    good.frame = frame;
    good.velocity.resize(run.jog.space().numbers(frame));
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity(), 1e300, -100.5}) {
      JogCommand command = good;
      command.velocity[1] = bad;
      refused(command, ErrorCode::kMoveInput, run.now);
    }
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{2}, kMaxJoints}) {
      JogCommand command = good;
      command.velocity.resize(size);
      refused(command, ErrorCode::kTaskNotSupported, run.now);
    }
    for (const Duration expiry : {Duration{0}, Duration{-1}, kJogExpiryMax + Duration{1},
                                  Duration::max(), Duration::min()}) {
      JogCommand command = good;
      command.expiry = expiry;
      refused(command, ErrorCode::kSegmentTime, run.now);
    }
    refused(good, ErrorCode::kSegmentTime, run.now - Duration{1});
  }
  if (!run.is_hexapod()) {
    JogCommand platform;
    platform.frame = JogFrame::kPlatform;
    platform.velocity.resize(3);
    refused(platform, ErrorCode::kTaskNotSupported, run.now);
  }
  EXPECT_EQ(run.jog.status().reason, JogReason::kNoCommand);
  EXPECT_TRUE(run.jog.at_rest());
  const auto back = run.jog.step(run.now - 1ms);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->code, ErrorCode::kSegmentTime);
  EXPECT_FALSE(run.jog.step(run.now));
}

TEST_P(JogOf, start_refuses_what_is_no_state) {
  JogRun run(GetParam());
  const auto home = run.home();
  std::vector<motion::AxisState> states;
  for (const double q : home) states.push_back({q, 0, 0});
  ASSERT_FALSE(run.jog.start(states, run.now));
  const auto refuses = [&](const motion::AxisState& bad) {
    auto some = states;
    some[1] = bad;
    const auto error = run.jog.start(some, run.now);
    return error && error->code == ErrorCode::kMotionInput;
  };
  EXPECT_TRUE(refuses({std::nan(""), 0, 0}));
  EXPECT_TRUE(refuses({1e9, 0, 0}));
  EXPECT_TRUE(refuses({home[1], std::nan(""), 0}));
  EXPECT_TRUE(refuses({home[1], 1.01 * run.limits[1].velocity, 0}));
  EXPECT_TRUE(refuses({home[1], 0, -1.01 * run.limits[1].acceleration}));
  states.pop_back();
  EXPECT_TRUE(run.jog.start(states, run.now));
}

TEST(JogWire, one_leg_alone_has_all_of_it_and_six_share_it) {
  JogRun run("hexapod");
  const double whole = shared_velocity(run.model);
  run.start(run.home());
  run.hold({.frame = JogFrame::kJoint, .velocity = {1e-3, 0, 0, 0, 0, 0}}, 2);
  EXPECT_NEAR(run.last.qd[0], whole, 1e-9 * whole);
  EXPECT_EQ(run.jog.status().reason, JogReason::kWire);
  // The others come up as the first one leaves them room.
  run.hold({.frame = JogFrame::kJoint, .velocity = {1e-3, -1e-3, 1e-3, 1e-3, 1e-3, 1e-3}}, 4);
  for (std::size_t j = 0; j < kLegs; ++j) {
    EXPECT_NEAR(std::abs(run.last.qd[j]), whole / 6, 1e-6 * whole) << j;
  }
  run.settle();
  EXPECT_LE(run.shared_worst, 1 + 1e-9);
}

TEST(JogWire, any_commands_to_the_legs_ask_no_more_of_it_than_it_carries) {
  JogRun run("hexapod");
  JogRun tools("hexapod");
  test::for_random_cases(100, [&](test::Random& random) {
    const auto q = run.random_place(random);
    tools.X_near = run.X_near;
    run.start(q);
    tools.start(q);
    for (int part = 0; part < 6 && !testing::Test::HasFatalFailure(); ++part) {
      JogCommand command = run.random_command(random);
      if (command.frame != JogFrame::kJoint) tools.hold(command, random.uniform(0.05, 1.5), 0.005);
      command.frame = JogFrame::kJoint;
      command.velocity.resize(kLegs);
      for (double& velocity : command.velocity) {
        velocity = random.uniform(-1, 1) * std::pow(10, random.uniform(-6, -3));
      }
      run.hold(command, random.uniform(0.05, 1.5), 0.005);
    }
    run.settle(0.01);
    tools.settle(0.01);
  });
  std::cout << "  legs " << run.shared_worst << ", tools " << tools.shared_worst
            << " of what the wire carries, at most\n";
  EXPECT_LE(run.shared_worst, 1.01);
  EXPECT_GT(run.shared_worst, 0.99);
  EXPECT_LE(tools.shared_worst, 1.25);
}

}  // namespace
}  // namespace sinew::planning
