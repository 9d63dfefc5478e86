// Jogs that are let go, or that nobody renews: how the robot comes to rest.
#include <gtest/gtest.h>

#include <vector>

#include "sinew/planning/jog/jog_test_robot.h"

namespace sinew::planning {
namespace {

using namespace std::chrono_literals;

class JogRelease : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, JogRelease, testing::ValuesIn(kJogRobots), jog_robot_name);

/// What the joints do at one instant, and what they need from there.
struct Release {
  explicit Release(const JogRun& run) : X_BT(run.jog.pose()) {
    const auto& at = run.jog.setpoint();
    for (std::size_t j = 0; j < run.joints(); ++j) {
      const auto& [velocity, acceleration, jerk] = run.limits[j];
      const motion::AxisState state{at.q[j], at.qd[j], at.qdd[j]};
      const auto stop = run.checks[j].stop(state);
      states.push_back(state);
      own_way.push_back(stop.range().upper - stop.range().lower);
      growth.push_back(state.qdd * state.qdd / (2 * jerk));
      if (stop.duration() > slowest) slowest_joint = j;
      slowest = std::max(slowest, stop.duration());
    }
  }
  /// In proportion to the slowest joint, whose way is its own.
  double way(std::size_t j) const {
    const double qd = std::abs(states[slowest_joint].qd);
    const double share = qd > 0 ? std::abs(states[j].qd) / qd * own_way[slowest_joint] : 0;
    // At full speed for as long as all take it could be twice as far as with even braking.
    return std::max(own_way[j], std::min(share, std::abs(states[j].qd) * slowest));
  }

  PoseBT X_BT;
  std::vector<motion::AxisState> states;
  std::vector<double> own_way;
  std::vector<double> growth;  ///< of the speed, before the jerk ends it
  double slowest = 0;
  std::size_t slowest_joint = 0;
};

/// How fast (m/s) the tool's tip is where the joints are at q and go at qd.
double tool_speed(const JogRun& run, const motion::AxisStates& at, const JointArray& qd) {
  constexpr double kStep = 1e-4;  // s
  JointArray ahead{}, behind{};
  for (std::size_t j = 0; j < run.joints(); ++j) {
    ahead[j] = at.q[j] + kStep * qd[j];
    behind[j] = at.q[j] - kStep * qd[j];
  }
  const auto X_ahead = run.jog.space().place(ahead, run.jog.pose());
  const auto X_behind = run.jog.space().place(behind, run.jog.pose());
  return norm(X_ahead->p - X_behind->p) / (2 * kStep);
}

enum class How { kZero, kExpiry, kStop };

void let_go(JogRun& run, JogCommand command, How how) {
  if (how == How::kStop) return run.jog.stop();
  if (how == How::kExpiry) {
    command.expiry = Duration{1};
    ASSERT_FALSE(run.jog.command(command, run.now));
    return;
  }
  for (double& number : command.velocity) number = 0;
  ASSERT_FALSE(run.jog.command(command, run.now));
}

TEST_P(JogRelease, joints_rest_together_when_the_slowest_can_and_none_goes_astray) {
  JogRun run(GetParam());
  double worst_time = 0, worst_way = 0;
  test::for_random_cases(run.is_hexapod() ? 100 : 400, [&](test::Random& random) {
    run.start(run.random_place(random));
    const JogCommand command = run.random_command(random);
    run.hold(command, random.uniform(0.1, 3.0), 0.004);
    if (testing::Test::HasFatalFailure()) return;
    const Release from(run);
    if (from.slowest == 0) return random.discard();
    let_go(run, command, static_cast<How>(random.integer(0, 2)));
    constexpr double kCycle = 1e-3;
    double time = 0;
    std::vector<double> low, high;
    for (const auto& state : from.states) {
      low.push_back(state.q);
      high.push_back(state.q);
    }
    do {
      run.step(kCycle);
      if (testing::Test::HasFatalFailure()) return;
      time += kCycle;
      for (std::size_t j = 0; j < run.joints(); ++j) {
        low[j] = std::min(low[j], run.last.q[j]);
        high[j] = std::max(high[j], run.last.q[j]);
      }
    } while (!run.jog.at_rest() && time < 60);
    EXPECT_LE(time, 1.01 * from.slowest + kCycle);
    worst_time = std::max(worst_time, (time - kCycle) / from.slowest);
    for (std::size_t j = 0; j < run.joints(); ++j) {
      const double full = run.limits[j].velocity * from.slowest;
      const double beyond = (high[j] - low[j] - from.way(j)) / full;
      EXPECT_LE(beyond, 0.06) << "J" << j + 1;
      worst_way = std::max(worst_way, beyond);
    }
  });
  std::cout << "  " << worst_time << " of the slowest joint's time; ways longer by " << worst_way
            << " of what a joint goes in that time at full speed, at most\n";
}

/// As fast as the line of the joints lets it be, but for what their accelerations add at first.
TEST_P(JogRelease, tool_is_not_faster_than_along_the_line_of_its_joints) {
  JogRun run(GetParam());
  double worst = 0, quickened = 0;
  int slower = 0, all = 0;
  test::for_random_cases(run.is_hexapod() ? 50 : 200, [&](test::Random& random) {
    run.start(run.random_place(random));
    JogCommand command = run.random_command(random);
    run.hold(command, random.uniform(0.3, 3.0), 0.004);
    if (testing::Test::HasFatalFailure()) return;
    const Release from(run);
    const double main = std::abs(from.states[from.slowest_joint].qd);
    const bool steady = main > 0.1 * run.limits[from.slowest_joint].velocity;
    if (from.slowest == 0 || !steady) return random.discard();
    JointArray qd{};
    double speeds = 0;
    for (std::size_t j = 0; j < run.joints(); ++j) {
      qd[j] = from.states[j].qd;
      speeds = std::max(speeds, tool_speed(run, run.jog.setpoint(), [&] {
                          JointArray one{};
                          one[j] = run.limits[j].velocity;
                          return one;
                        }()));
    }
    const double before = tool_speed(run, run.jog.setpoint(), qd);
    let_go(run, command, static_cast<How>(random.integer(0, 2)));
    double fastest = 0;
    while (!run.jog.at_rest()) {
      run.step(0.005);
      if (testing::Test::HasFatalFailure()) return;
      const auto& at = run.jog.setpoint();
      JointArray now{};
      double more = 0;
      for (std::size_t j = 0; j < run.joints(); ++j) {
        now[j] = at.qd[j];
        JointArray grown{};
        grown[j] = from.growth[j];
        more += tool_speed(run, at, grown);
      }
      const double speed = tool_speed(run, at, now);
      fastest = std::max(fastest, speed);
      worst = std::max(worst, (speed - more - tool_speed(run, at, qd)) / speeds);
    }
    ++all;
    slower += fastest <= 1.02 * before ? 1 : 0;
    quickened = std::max(quickened, (fastest - before) / speeds);
  });
  EXPECT_LE(worst, 0.08);
  std::cout << "  beyond the line by " << worst << ", faster than at first by " << quickened
            << " of a joint's full speed; " << slower << " of " << all << " never faster\n";
}

}  // namespace
}  // namespace sinew::planning
