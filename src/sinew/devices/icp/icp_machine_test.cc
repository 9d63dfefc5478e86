#include "sinew/devices/icp/icp_machine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using Kind = Disturbance::Kind;

constexpr double kUnit = 0.7e-3 / 3200;  // m

struct Bench {
  explicit Bench(const IcpQuirks& quirks = {}, const IcpDevice& device = test::icp_device(),
                 std::uint64_t seed = 1)
      : machine(test::icp_robot(device), quirks, seed, Instant{}) {
    run_for(100ms);
  }
  void run_for(Duration duration) {
    now += duration;
    machine.advance(now);
  }
  void steps(std::uint8_t motor, bool direction, int count) {
    std::array<std::uint8_t, 64> out{};
    for (int i = 0; i < count; ++i) {
      machine.receive(std::array{icp::kInit}, now);
      machine.receive(std::array{icp::encode_step({motor, direction})}, now);
      run_for(4167us);
      (void)machine.take_output(out);
    }
  }
  JointTruth leg(std::size_t index) const { return machine.truth().joints[index]; }
  /// Units off home, as the rotor has it.
  double units(std::size_t index) const { return (leg(index).q - from_mm(268)) / kUnit; }

  IcpMachine machine;
  Instant now{};
};

TEST(IcpMachine, legs_stand_at_home_and_stay_there) {
  Bench bench;
  bench.run_for(24h);
  const Truth truth = bench.machine.truth();
  ASSERT_EQ(truth.joints.size(), kLegs);
  EXPECT_FALSE(truth.moving);
  for (const JointTruth& joint : truth.joints) {
    EXPECT_NEAR(joint.q, from_mm(268), 2 * kUnit);
    EXPECT_FALSE(joint.lost_steps || joint.at_end_stop);
  }
}

TEST(IcpMachine, a_loose_lead_is_noticed_in_the_next_motion_and_the_leg_stays_where_it_was) {
  Bench bench;
  bench.steps(3, false, 100);
  const double before = bench.units(2);
  bench.machine.disturb({Kind::kLead, 2, 0});
  bench.run_for(1s);
  EXPECT_FALSE(bench.machine.module(2).flags().electrical_defect) << "nothing turns";
  bench.steps(3, false, 100);
  bench.steps(4, false, 100);
  const auto flags = bench.machine.module(2).flags();
  EXPECT_TRUE(flags.electrical_defect && flags.step_loss);
  EXPECT_FALSE(bench.machine.module(3).flags().step_loss);
  // Without current the magnets take it to the nearest full step.
  EXPECT_NEAR(bench.units(2), before, 17);
  EXPECT_NEAR(bench.units(3), 100, 2);
}

TEST(IcpMachine, a_turn_of_steps_is_a_lead_of_the_spindle) {
  Bench bench;
  bench.steps(2, false, 3200);
  EXPECT_NEAR(bench.leg(1).believed - from_mm(268), 0.7e-3, 1e-12);
  EXPECT_NEAR(bench.units(1), 3200, 2) << "behind its field by friction and load";
  bench.steps(2, true, 1600);
  EXPECT_NEAR(bench.units(1), 1600, 2);
  EXPECT_FALSE(bench.leg(1).lost_steps);
}

TEST(IcpMachine, inverted_leg_becomes_shorter_with_bit_0) {
  IcpDevice device = test::icp_device();
  device.legs[4].invert = true;
  Bench bench({}, device);
  bench.steps(5, false, 50);
  EXPECT_NEAR(bench.units(4), -50, 2);
}

TEST(IcpMachine, mechanical_end_holds_the_leg_and_the_motor_loses_steps) {
  RobotModel robot = test::icp_robot();
  robot.joints[0].home = from_mm(344.99);
  IcpMachine machine(robot, {}, 1, Instant{});
  Instant now{100ms};
  machine.advance(now);
  std::array<std::uint8_t, 64> out{};
  for (int i = 0; i < 6000; ++i) {
    machine.receive(std::array{icp::kInit}, now);
    machine.receive(std::array{icp::encode_step({1, false})}, now);
    machine.advance(now += 4167us);
    (void)machine.take_output(out);
  }
  const JointTruth leg = machine.truth().joints[0];
  // Each time it slips it springs back by an electrical turn at most.
  EXPECT_LE(leg.q, from_mm(346) + 2 * kUnit);
  EXPECT_GE(leg.q, from_mm(346) - 66 * kUnit);
  EXPECT_TRUE(leg.lost_steps);
  EXPECT_NEAR(leg.believed, from_mm(344.99) + 6000 * kUnit, 1e-9) << "nobody is told";
}

TEST(IcpMachine, thing_in_the_way_blocks_a_leg_until_it_is_gone) {
  Bench bench;
  bench.machine.disturb({Kind::kBlock, 2, from_mm(268) + 20 * kUnit});
  bench.steps(3, false, 300);
  EXPECT_NEAR(bench.units(2), 20, 2);
  EXPECT_TRUE(bench.leg(2).lost_steps);
  bench.machine.disturb({Kind::kUnblock, 2, 0});
  const double before = bench.units(2);
  bench.steps(3, false, 128);
  EXPECT_NEAR(bench.units(2) - before, 128, 70) << "on from the pole that it hangs on";
}

TEST(IcpMachine, load_beyond_the_motors_torque_pulls_the_leg_down_and_a_usual_one_does_not) {
  Bench usual;
  usual.machine.disturb({Kind::kPayload, -1, 5});
  usual.steps(1, false, 200);
  EXPECT_NEAR(usual.units(0), 200, 3);
  Bench heavy;
  heavy.machine.disturb({Kind::kLoad, 0, -4000});
  heavy.steps(1, false, 200);
  EXPECT_TRUE(heavy.leg(0).lost_steps);
  EXPECT_LT(heavy.units(0), 0);
}

TEST(IcpMachine, weak_supply_leaves_some_motors_still) {
  Bench bench;
  bench.machine.disturb({Kind::kSupply, -1, 7.5});
  int spinning = 0;
  for (std::uint8_t motor = 1; motor <= kLegs; ++motor) {
    bench.steps(motor, false, 100);
    spinning += bench.units(motor - 1U) > 90 ? 1 : 0;
  }
  EXPECT_GT(spinning, 0);
  EXPECT_LT(spinning, 6);
  EXPECT_EQ(bench.machine.truth().supply_volts, 7.5);
}

TEST(IcpMachine, brown_out_takes_the_modules_memory_and_deeper_the_controllers) {
  Bench bench;
  bench.machine.disturb({Kind::kSupply, -1, 4.5});
  bench.run_for(10ms);
  bench.machine.disturb({Kind::kSupply, -1, 12});
  EXPECT_EQ(bench.machine.controller().state(), IcpController::State::kReady);
  EXPECT_EQ(bench.machine.module(0).parameters(), tmc222::Parameters{});
  EXPECT_FALSE(bench.machine.module(0).powered());
  bench.machine.disturb({Kind::kSupply, -1, 0});
  bench.run_for(10ms);
  bench.machine.disturb({Kind::kSupply, -1, 12});
  EXPECT_EQ(bench.machine.controller().state(), IcpController::State::kBooting);
  bench.run_for(20ms);
  EXPECT_EQ(bench.machine.module(0).parameters(), icp::kMotorParameters);
}

TEST(IcpMachine, power_that_comes_back_turns_the_rotors_to_their_home_phase) {
  for (const int microsteps : {1, 20, 31, 33, 50}) {
    Bench bench;
    bench.steps(1, false, microsteps);
    bench.machine.power_cycle();
    bench.run_for(100ms);
    const double home = microsteps <= 32 ? 0 : 64;
    EXPECT_NEAR(bench.units(0), home, 2) << microsteps;
  }
}

TEST(IcpMachine, one_seed_is_one_machine) {
  const auto ride = [](std::uint64_t seed) {
    Bench bench({}, test::icp_device(), seed);
    bench.machine.disturb({Kind::kSupply, -1, 7.5});
    std::vector<double> q;
    for (std::uint8_t motor = 1; motor <= kLegs; ++motor) {
      bench.steps(motor, motor % 2 == 0, 37);
      q.push_back(bench.leg(motor - 1U).q);
    }
    return q;
  };
  EXPECT_EQ(ride(5), ride(5));
  EXPECT_NE(ride(5), ride(6));
}

TEST(IcpMachine, a_million_idle_instants_and_no_allocation) {
  Bench bench;
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1'000'000; ++i) bench.run_for(1ms);
  bench.steps(1, false, 100);
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
