#include "sinew/devices/lsc/lsc_machine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using Kind = Disturbance::Kind;

/// The built-in arm; on the bus with the units of its servos there: 1000 for 240 degrees.
RobotModel learm(LscProfile profile = LscProfile::kLsc6) {
  RobotModel model = test::robot("learm");
  auto& device = model.device.settings.get<LscDevice>();
  device.profile = profile;
  if (profile != LscProfile::kBus) return model;
  for (LscServo& servo : device.servos) {
    servo.centre = 500;
    servo.units_per_rad = std::copysign(750 / kPi, servo.units_per_rad);
  }
  device.gripper = {1, 200, 700};
  return model;
}

struct Bench {
  explicit Bench(LscProfile profile = LscProfile::kLsc6, std::uint64_t seed = 3)
      : machine(learm(profile), profile, seed, Instant{}) {}

  void tell(const lsc::Request& request) { machine.receive(lsc::encode(request), now); }
  void wait(Duration duration) {
    now += duration;
    machine.advance(now);
  }
  double q(std::size_t joint) const { return machine.truth().joints[joint].q; }
  /// All servos to the middle, jaws open.
  void stand() {
    tell(lsc::Move{1000, {{6, 1500}, {5, 1500}, {4, 1500}, {3, 1500}, {2, 1500}, {1, 1500}}});
    wait(4s);
  }

  LscMachine machine;
  Instant now{};
};

TEST(LscMachine, nobody_knows_how_it_stands_when_it_is_switched_on) {
  std::set<double> poses;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Bench bench(LscProfile::kLsc6, seed);
    poses.insert(bench.q(0));
    EXPECT_EQ(bench.machine.truth().joints[0].believed, 0);
    EXPECT_LE(std::abs(bench.q(0)), kPi / 2);
    EXPECT_EQ(bench.q(0), Bench(LscProfile::kLsc6, seed).q(0)) << "the same seed, the same pose";
  }
  EXPECT_EQ(poses.size(), 20U);
}

TEST(LscMachine, weight_pulls_a_limp_arm_down_and_pulses_hold_it) {
  Bench limp;
  limp.machine.disturb({Kind::kPayload, -1, 0.2});
  const double before = limp.q(1);
  limp.wait(3s);
  EXPECT_GT(std::abs(limp.q(1)), std::abs(before));
  EXPECT_GT(std::abs(limp.q(1)), 1.5) << "down to the servo's stop";
  Bench held;
  held.stand();
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(held.q(i), 0, 0.01) << i;
  EXPECT_FALSE(held.machine.truth().moving);
}

TEST(LscMachine, the_first_move_jumps_to_the_board_s_idea_of_the_pose) {
  Bench bench;
  const double start = bench.q(0);
  ASSERT_GT(std::abs(start), 0.3);
  bench.tell(lsc::Move{10'000, {{6, 1500}}});
  bench.wait(500ms);
  EXPECT_NEAR(bench.q(0), 0, 0.01) << "in half a second, whatever time was asked for";
}

TEST(LscMachine, every_servo_turns_its_joint_the_way_the_settings_say) {
  Bench bench;
  bench.stand();
  bench.tell(lsc::Move{1000, {{6, 1700}, {5, 1600}, {4, 1400}, {3, 1400}, {2, 1700}}});
  bench.wait(2s);
  const double unit = kPi / 2000;
  const std::vector<double> expected{200 * unit, 100 * unit, 100 * unit, 100 * unit, 200 * unit};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(bench.q(i), expected[i], 0.03) << i;
    EXPECT_NEAR(bench.machine.truth().joints[i].believed, expected[i], 1e-9) << i;
  }
}

TEST(LscMachine, too_much_weight_makes_truth_and_belief_differ_and_the_bus_tells) {
  for (const LscProfile profile : {LscProfile::kLsc6, LscProfile::kBus}) {
    Bench bench(profile);
    const std::uint16_t middle = profile == LscProfile::kBus ? 500 : 1500;
    const std::uint16_t forward = profile == LscProfile::kBus ? 700 : 2000;
    bench.tell(lsc::Move{500, {{6, middle}, {5, middle}, {4, middle}, {3, middle}, {2, middle}}});
    bench.wait(3s);
    bench.machine.disturb({Kind::kPayload, -1, 1.5});
    bench.tell(lsc::Move{500, {{5, forward}}});
    bench.wait(3s);
    const JointTruth shoulder = bench.machine.truth().joints[1];
    EXPECT_GT(shoulder.q, 1.2) << "it sinks below its target";
    if (profile == LscProfile::kBus) {
      EXPECT_EQ(shoulder.believed, shoulder.q);
    } else {
      EXPECT_NEAR(shoulder.believed, kPi / 4, 1e-9);
    }
  }
}

TEST(LscMachine, a_blocked_joint_stalls_and_goes_on_when_it_is_free) {
  Bench bench;
  bench.stand();
  bench.machine.disturb({Kind::kBlock, 0, 0.2});
  bench.tell(lsc::Move{500, {{6, 2000}}});
  bench.wait(2s);
  EXPECT_EQ(bench.q(0), 0.2);
  EXPECT_TRUE(bench.machine.truth().joints[0].stalled);
  EXPECT_LT(bench.machine.truth().supply_volts, 7.25) << "a stalled servo draws current";
  bench.machine.disturb({Kind::kUnblock, 0, 0});
  bench.wait(2s);
  EXPECT_NEAR(bench.q(0), kPi / 4, 0.01);
  EXPECT_FALSE(bench.machine.truth().joints[0].stalled);
}

TEST(LscMachine, jaws_close_to_their_width_or_on_what_is_between_them) {
  Bench bench;
  bench.stand();
  EXPECT_NEAR(bench.machine.truth().tool, 0.06, 1e-3);
  bench.tell(lsc::Move{500, {{1, 2000}}});
  bench.wait(2s);
  EXPECT_NEAR(bench.machine.truth().tool, 0.03, 1e-3);
  bench.machine.disturb({Kind::kBlock, 5, 0.02});
  bench.tell(lsc::Move{500, {{1, 2500}}});
  bench.wait(2s);
  EXPECT_NEAR(bench.machine.truth().tool, 0.02, 1e-6);
}

TEST(LscMachine, a_brown_out_resets_the_board_and_lets_the_arm_go) {
  Bench bench;
  bench.stand();
  bench.tell(lsc::Move{500, {{5, 2000}}});
  bench.wait(2s);
  bench.machine.disturb({Kind::kSupply, -1, 3.5});
  bench.wait(100ms);
  EXPECT_FALSE(bench.machine.powered());
  bench.tell(lsc::ReadBattery{});
  std::array<std::uint8_t, 16> piece{};
  EXPECT_EQ(bench.machine.take_output(piece), 0U);
  EXPECT_EQ(bench.machine.truth().bytes_lost, 4U);
  bench.machine.disturb({Kind::kSupply, -1, 7.4});
  bench.wait(1s);
  EXPECT_TRUE(bench.machine.powered());
  EXPECT_FALSE(bench.machine.board().command(5).driven);
  EXPECT_GT(bench.q(1), 1.0) << "nothing holds the shoulder any more";
  bench.tell(lsc::ReadBattery{});
  EXPECT_EQ(bench.machine.take_output(piece), 6U);
}

TEST(LscMachine, a_load_on_a_joint_bends_it) {
  Bench bench;
  bench.stand();
  bench.machine.disturb({Kind::kLoad, 0, 0.8});
  bench.wait(1s);
  EXPECT_GT(bench.q(0), 0.01);
  EXPECT_LT(bench.q(0), 0.1);
}

TEST(LscMachine, time_in_small_or_large_pieces_is_the_same_time) {
  Bench whole;
  Bench pieces;
  for (Bench* bench : {&whole, &pieces}) bench->tell(lsc::Move{700, {{6, 2100}, {5, 1800}}});
  whole.wait(1s);
  for (int i = 0; i < 500; ++i) pieces.wait(2ms);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(whole.q(i), pieces.q(i));
}

TEST(LscMachine, it_does_not_allocate) {
  Bench bench;
  const lsc::Bytes move = lsc::encode(lsc::Request{lsc::Move{500, {{6, 1700}}}});
  const test::AllocationCounter allocations;
  bench.machine.receive(move, bench.now);
  bench.machine.advance(bench.now + 2s);
  (void)bench.machine.truth();
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
