#include <gtest/gtest.h>

#include <cmath>

#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_device_test_cell.h"

namespace sinew {
namespace {

using test::AxisCell;
using test::homed_cell;
using test::kTruth;
using test::LimitWatch;

TEST(AxisFaults, thing_in_the_way_is_a_stall_within_a_tenth_of_a_second_and_no_step_more) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(2.5);
  cell.plant.block(cell.plant.q() + from_deg(1));
  ASSERT_TRUE(cell.run_until([&] { return cell.plant.at_end(); }, 2));
  const Instant touched = cell.now;
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 2));
  EXPECT_LT(to_seconds(cell.now - touched), 0.1);
  EXPECT_TRUE(cell.status().fault == AxisFault::kStalled ||
              cell.status().fault == AxisFault::kFollowingError);
  cell.run(1);
  EXPECT_FALSE(cell.status().motor_ok);
  // The motor's encoder saw it all: the position is as right as before.
  EXPECT_TRUE(cell.status().position_ok);
  EXPECT_LT(cell.error(), from_deg(0.3));
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kFaulted);

  cell.plant.unblock();
  cell.controller.clear_faults();
  const double rest = cell.plant.q();
  cell.run(1);
  EXPECT_NEAR(cell.plant.q(), rest, from_deg(0.5));
  ASSERT_EQ(cell.controller.move_to(from_deg(-160)), AxisVerdict::kAccepted);
  ASSERT_TRUE(cell.run_to_rest());
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_LT(cell.error(), kTruth);
}

TEST(AxisFaults, load_beyond_the_motor_is_a_stall_or_following_error) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(2.5);
  cell.plant.set_extra_load(-40);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 1));
  EXPECT_TRUE(cell.status().fault == AxisFault::kStalled ||
              cell.status().fault == AxisFault::kFollowingError);
}

TEST(AxisFaults, load_within_the_motor_is_carried_and_taken_out) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(from_deg(-150)), AxisVerdict::kAccepted);
  cell.run(2);
  cell.plant.set_extra_load(-6);  // of 15 Nm
  ASSERT_TRUE(cell.run_to_rest());
  cell.run(1);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_NEAR(cell.status().q, from_deg(-150), from_deg(0.02));
}

TEST(AxisFaults, supply_dip_stops_and_a_brown_out_cuts_the_current) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(2);
  cell.plant.set_supply(17);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 0.05));
  EXPECT_EQ(cell.status().fault, AxisFault::kSupplyLow);
  EXPECT_TRUE(cell.outputs.enabled);
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().moving; }, 5));
  EXPECT_TRUE(cell.status().position_ok);
  // The cause is still there: clearing does not help for long.
  cell.controller.clear_faults();
  cell.run(0.05);
  EXPECT_EQ(cell.status().fault, AxisFault::kSupplyLow);
  cell.plant.set_supply(24);
  cell.run(0.05);
  cell.controller.clear_faults();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(1);
  cell.plant.set_supply(5);
  cell.run(0.002);
  EXPECT_FALSE(cell.outputs.enabled);
  EXPECT_EQ(cell.status().fault, AxisFault::kSupplyLow);
  EXPECT_FALSE(cell.status().motor_ok);
}

/// An arm in a hot place, some degrees short of a temperature that it reaches while it moves.
AxisCell heated(double celsius, const AxisSettings& settings) {
  AxisCell cell(from_deg(-165), settings);
  EXPECT_TRUE(cell.home());
  cell.plant.set_ambient(700);
  EXPECT_TRUE(cell.run_until([&] { return cell.inputs.temperature_c > celsius; }, 400));
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  return cell;
}

TEST(AxisFaults, hot_power_stage_and_its_shut_down_stop_the_axis) {
  AxisCell cell = heated(88, test::test_settings());
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 8));
  EXPECT_EQ(cell.status().fault, AxisFault::kTooHot);
  EXPECT_TRUE(cell.status().moving) << "it brakes";
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().moving; }, 5));

  // Nobody looks at the temperature here: the power stage gives up by itself, at 120 C.
  AxisSettings blind = test::test_settings();
  blind.supervision.temperature_max = 1000;
  AxisCell other = heated(118, blind);
  ASSERT_EQ(other.controller.move_to(0), AxisVerdict::kAccepted);
  ASSERT_TRUE(other.run_until([&] { return other.status().fault != AxisFault::kNone; }, 8));
  const auto steps = other.outputs.steps;
  EXPECT_EQ(other.status().fault, AxisFault::kStalled);
  EXPECT_FALSE(other.status().motor_ok);
  EXPECT_FALSE(other.outputs.enabled);
  other.run(0.5);
  EXPECT_EQ(other.outputs.steps, steps);
}

TEST(AxisFaults, lost_magnet_of_the_motor_brakes_and_asks_for_a_new_home) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(2);
  cell.plant.set_field(0);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 0.03));
  EXPECT_EQ(cell.status().fault, AxisFault::kMotorEncoder);
  EXPECT_FALSE(cell.status().homed);
  EXPECT_FALSE(cell.status().position_ok);
  EXPECT_FALSE(cell.status().sensor_ok);
  LimitWatch watch(cell, cell.controller.settings().limits.jerk);
  cell.run_until(
      [&] {
        watch.look(cell);
        return std::abs(cell.controller.reference().qd) < 1e-9;
      },
      5);
  EXPECT_LT(watch.worst, 1e-6);
  const double rest = cell.plant.q();
  cell.run(1);
  EXPECT_NEAR(cell.plant.q(), rest, from_deg(0.05));
  cell.plant.set_field(1);
  cell.run(0.1);
  cell.controller.clear_faults();
  cell.run(0.1);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kNotHomed);
}

TEST(AxisFaults, reading_or_two_may_be_missing) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(from_deg(-150)), AxisVerdict::kAccepted);
  for (int i = 0; i < 6'000; ++i) {
    cell.plant.set_field(i % 50 < 5 ? 0.4 : 1);  // too weak for 5 ms: noise, and it says so
    cell.tick();
  }
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_TRUE(cell.status().position_ok);
  EXPECT_LT(cell.error(), kTruth);
}

TEST(AxisFaults, glitch_of_an_encoder_is_not_a_motion) {
  AxisCell cell = homed_cell();
  const double before = cell.status().q;
  for (int i = 0; i < 1'000; ++i) {
    cell.spoil = i % 100 == 7 ? [](AxisInputs& inputs) { inputs.motor_counts ^= 0x400; }
                              : [](AxisInputs&) {};
    cell.tick();
    ASSERT_NEAR(cell.status().q, before, from_deg(0.02));
  }
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
}

TEST(AxisFaults, broken_line_of_the_joint_encoder_is_found) {
  AxisCell cell = homed_cell();
  cell.spoil = [](AxisInputs& inputs) { inputs.joint_encoder_ok = false; };
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 0.03));
  EXPECT_EQ(cell.status().fault, AxisFault::kJointEncoder);
  EXPECT_FALSE(cell.status().position_ok);
}

TEST(AxisFaults, joint_encoder_whose_coupling_slips_disagrees) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.plant.set_coupling(false);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 5));
  EXPECT_EQ(cell.status().fault, AxisFault::kEncodersDisagree);
  EXPECT_FALSE(cell.status().homed);
  EXPECT_LT(to_deg(std::abs(cell.plant.q() - cell.controller.settings().homing.clear_angle)), 4);
}

TEST(AxisFaults, end_stop_that_closes_far_from_its_place_takes_the_home_away) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(3);
  cell.plant.hold_switch(true);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 0.02));
  EXPECT_EQ(cell.status().fault, AxisFault::kEndStop);
  EXPECT_TRUE(cell.status().end_stop);
  EXPECT_FALSE(cell.status().position_ok);
  const auto steps = cell.outputs.steps;
  cell.run(0.5);
  EXPECT_EQ(cell.outputs.steps, steps);
}

TEST(AxisFaults, first_fault_stays_until_it_is_cleared) {
  AxisCell cell = homed_cell();
  cell.controller.stop(AxisFault::kLinkSilent);
  cell.controller.stop(AxisFault::kTooHot);
  cell.run(0.1);
  EXPECT_EQ(cell.status().fault, AxisFault::kLinkSilent);
  EXPECT_FALSE(cell.status().communication_ok);
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kFaulted);
  EXPECT_EQ(cell.controller.home(), AxisVerdict::kFaulted);
  cell.controller.clear_faults();
  EXPECT_TRUE(cell.status().communication_ok);
  EXPECT_TRUE(cell.status().position_ok);
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
}

TEST(AxisFaults, silence_of_the_link_in_motion_brakes_inside_the_limits) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(3);
  LimitWatch watch(cell, cell.controller.settings().limits.jerk);
  cell.controller.stop(AxisFault::kLinkSilent);
  ASSERT_TRUE(cell.run_until(
      [&] {
        watch.look(cell);
        return !cell.status().moving;
      },
      5));
  EXPECT_LT(watch.worst, 1e-6);
  EXPECT_TRUE(cell.status().position_ok);
}

TEST(AxisFaults, encoders_of_the_other_kind_work_as_well) {
  AxisSettings settings = test::test_settings();
  settings.encoders.joint = JointEncoder::kAs5600;
  settings.encoders.joint_counts_per_turn = 4096;
  AxisCell cell(from_deg(-165), settings);
  ASSERT_TRUE(cell.home());
  ASSERT_EQ(cell.controller.move_to(from_deg(-100)), AxisVerdict::kAccepted);
  ASSERT_TRUE(cell.run_to_rest());
  EXPECT_LT(cell.error(), kTruth);
  // Here the plant's magnet is the joint's.
  cell.plant.set_field(0);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 0.03));
  EXPECT_EQ(cell.status().fault, AxisFault::kJointEncoder);
}

TEST(AxisFaults, joint_that_is_carried_over_its_limit_is_stopped_at_once) {
  AxisSettings settings = test::test_settings();
  settings.upper = from_deg(-160);
  // Only the limit itself shall be what stops it.
  settings.supervision.following_error = from_deg(90);
  settings.supervision.stall_angle = 100;
  settings.supervision.disagreement = 100;
  AxisCell cell(from_deg(-165), settings);
  ASSERT_TRUE(cell.home());
  ASSERT_EQ(cell.controller.move_to(from_deg(-160)), AxisVerdict::kAccepted);
  cell.run(2.8);
  ASSERT_TRUE(cell.status().moving);
  // More than its motor holds (15 Nm, and what the gear's losses add) pulls it on.
  cell.plant.set_load(0, 3);
  cell.plant.set_extra_load(35);
  ASSERT_TRUE(cell.run_until([&] { return cell.status().fault != AxisFault::kNone; }, 1));
  EXPECT_EQ(cell.status().fault, AxisFault::kFollowingError);
  EXPECT_LT(to_deg(cell.status().q), -159.4);
}

}  // namespace
}  // namespace sinew
