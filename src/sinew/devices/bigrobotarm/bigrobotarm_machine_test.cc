#include "sinew/devices/bigrobotarm/bigrobotarm_machine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_test_robot.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::sim {
namespace {

using namespace bigrobotarm;
using namespace std::chrono_literals;

struct Bench {
  explicit Bench(BigRobotArmProfile profile = BigRobotArmProfile::kDocument, std::uint64_t seed = 1)
      : machine(robot, profile, BigRobotArmDialect::k2021, seed, Instant{}) {}

  void send(const Request& request) {
    machine.receive(byte::encode_request(request), now);
    machine.receive(std::array{byte::kTerminator}, now);
  }
  void run(Duration duration) {
    now += duration;
    machine.advance(now);
  }
  /// 0 where the arm stands as its counters say, from its place at `start`; rad.
  double apart(std::size_t joint, const Truth& start) const {
    const Truth truth = machine.truth();
    return truth.joints[joint].q - start.joints[joint].q - truth.joints[joint].believed;
  }
  double full_step(std::size_t joint) const {
    const auto& own = robot.device.settings.get<BigRobotArmDevice>().joints[joint];
    return std::abs(own.steps_per_motor_rev / 200 / own.steps_per_rad);
  }
  std::vector<Reply> replies() {
    std::vector<Reply> all;
    std::array<std::uint8_t, 128> piece{};
    while (const std::size_t count = machine.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        const auto reply = decoder.push(piece[i]);
        if (reply && *reply) all.push_back(**reply);
      }
    }
    return all;
  }

  const RobotModel robot = test::big_robot_arm();
  BigRobotArmMachine machine;
  byte::ReplyDecoder decoder;
  Instant now{};
};

const Goto kDocumented{{-2400, 600, -5000, 800, -1000}};

TEST(BigRobotArmMachine, at_power_up_it_stands_upright_within_two_full_steps) {
  bool moved = false;
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    Bench bench(BigRobotArmProfile::kDocument, seed);
    bench.run(2s);
    const Truth truth = bench.machine.truth();
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_LE(std::abs(truth.joints[i].q), 3 * bench.full_step(i));
      moved = moved || std::abs(truth.joints[i].q) > bench.full_step(i);
      EXPECT_EQ(truth.joints[i].believed, 0);
    }
    EXPECT_FALSE(truth.moving);
    EXPECT_FALSE(truth.deaf);
  }
  EXPECT_TRUE(moved) << "nobody places an arm to the step";
}

TEST(BigRobotArmMachine, arm_follows_its_counters_within_a_full_step_under_its_own_weight) {
  for (const auto profile : {BigRobotArmProfile::kDocument, BigRobotArmProfile::kAsBuilt}) {
    Bench bench(profile);
    bench.run(1s);
    const Truth start = bench.machine.truth();
    bench.send(Goto{{3000, -2000, -2600, 800, -1000}});
    for (int i = 0; i < 800; ++i) {
      bench.run(10ms);
      for (std::size_t k = 0; k < kJoints; ++k) {
        ASSERT_LE(std::abs(bench.apart(k, start)), bench.full_step(k)) << k << " at " << i;
      }
    }
    EXPECT_FALSE(bench.machine.truth().moving);
    EXPECT_NEAR(bench.machine.truth().joints[1].q, 72 * kPi / 180, 3 * bench.full_step(1));
  }
}

TEST(BigRobotArmMachine, motion_that_never_ends_is_none_once_every_joint_stands) {
  for (const auto profile : {BigRobotArmProfile::kDocument, BigRobotArmProfile::kAsBuilt}) {
    Bench bench(profile);
    bench.run(1s);
    // The shoulder has somewhere to go and no speed: the firmware waits for it for ever.
    bench.send(SetSpeeds{{100, 0, 100, 100, 100}});
    bench.run(100ms);
    bench.send(kDocumented);
    bench.run(200ms);
    EXPECT_TRUE(bench.machine.truth().moving);
    bench.run(60s);
    EXPECT_TRUE(bench.machine.firmware().moving());
    const Truth truth = bench.machine.truth();
    for (const JointTruth& joint : truth.joints) EXPECT_EQ(joint.qd, 0);
    EXPECT_FALSE(truth.moving);
    EXPECT_TRUE(truth.deaf);
  }
}

TEST(BigRobotArmMachine, block_makes_a_joint_slip_and_nobody_is_told) {
  Bench bench;
  bench.run(1s);
  const Truth start = bench.machine.truth();
  bench.machine.disturb({Disturbance::Kind::kBlock, 0, -0.2});
  bench.send(kDocumented);
  bench.run(6s);
  const Truth truth = bench.machine.truth();
  EXPECT_TRUE(truth.joints[0].lost_steps);
  EXPECT_GT(std::abs(bench.apart(0, start)), 0.2);
  EXPECT_NEAR(truth.joints[0].q, -0.2, 0.1);
  EXPECT_FALSE(truth.joints[2].lost_steps);
  EXPECT_EQ(bench.replies().back(), Reply{GotoDone{kDocumented.positions}});
}

TEST(BigRobotArmMachine, too_much_weight_makes_the_shoulder_slip) {
  Bench bench;
  bench.run(1s);
  bench.machine.disturb({Disturbance::Kind::kPayload, -1, 40});
  bench.send(Goto{{0, -2400, 0, 0, 0}});
  bench.run(10s);
  EXPECT_TRUE(bench.machine.truth().joints[1].lost_steps);
}

TEST(BigRobotArmMachine, supply_dip_resets_the_counters_wherever_the_arm_stands) {
  Bench bench;
  bench.run(1s);
  bench.send(kDocumented);
  bench.run(6s);
  (void)bench.replies();
  const Truth before = bench.machine.truth();
  bench.machine.disturb({Disturbance::Kind::kSupply, -1, 3});
  bench.run(100ms);
  bench.send(ReadStatus{});
  bench.machine.disturb({Disturbance::Kind::kSupply, -1, 12});
  bench.run(2s);
  EXPECT_TRUE(bench.replies().empty());
  bench.send(ReadStatus{});
  EXPECT_EQ(std::get<Status>(bench.replies().at(0)).positions, Words{});
  const Truth after = bench.machine.truth();
  bool snapped = false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double snap = std::abs(after.joints[i].q - before.joints[i].q);
    EXPECT_LE(snap, 3 * bench.full_step(i)) << i;
    snapped = snapped || snap > 0.5 * bench.full_step(i);
    EXPECT_EQ(after.joints[i].believed, 0);
  }
  EXPECT_TRUE(snapped);
}

TEST(BigRobotArmMachine, port_that_opens_resets_the_board_and_its_boot_loader_is_deaf) {
  Bench bench;
  bench.send(Goto{{1000, 0, 0, 0, 0}});
  bench.run(3s);
  bench.machine.port_opened(bench.now);
  (void)bench.replies();
  bench.run(1s);
  bench.send(ReadStatus{});
  bench.run(1s);
  bench.send(ReadStatus{});
  const auto replies = bench.replies();
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(std::get<Status>(replies[0]).positions, Words{});
}

TEST(BigRobotArmMachine, outcome_does_not_depend_on_how_often_it_is_asked) {
  Bench often(BigRobotArmProfile::kAsBuilt);
  Bench once(BigRobotArmProfile::kAsBuilt);
  often.send(kDocumented);
  once.send(kDocumented);
  for (int i = 0; i < 5000; ++i) often.run(1ms);
  once.run(5s);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(often.machine.truth().joints[i].q, once.machine.truth().joints[i].q, 1e-9);
  }
}

TEST(BigRobotArmMachine, life_does_not_allocate) {
  Bench bench(BigRobotArmProfile::kAsBuilt);
  std::array<std::uint8_t, 128> out{};
  const test::AllocationCounter allocations;
  bench.send(kDocumented);
  for (int i = 0; i < 500; ++i) {
    bench.run(10ms);
    (void)bench.machine.take_output(out);
    (void)bench.machine.truth();
  }
  bench.machine.disturb({Disturbance::Kind::kSupply, -1, 3});
  bench.machine.disturb({Disturbance::Kind::kSupply, -1, 12});
  bench.run(3s);
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
