#include "sinew/program/sequence_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/core/units.h"
#include "sinew/driver/bigrobotarm_multipliers.h"
#include "sinew/program/sequence_test_cell.h"
#include "support/property.h"

namespace sinew::sequence {
namespace {

constexpr auto kByte = BigRobotArmWire::kByte;
constexpr auto kText = BigRobotArmWire::kText;

std::expected<Plan, PlanRefusal> try_plan(std::string_view text, BigRobotArmWire wire = kByte) {
  const RobotModel model = arm(wire);
  return make_plan(program_of(text), model, boot_state(device_of(model)));
}

Plan plan_of(std::string_view text, BigRobotArmWire wire = kByte) {
  auto plan = try_plan(text, wire);
  if (!plan) throw std::runtime_error(describe(plan.error().error));
  return std::move(*plan);
}

/// "2: joint_limit 0", the line, the name of the error and the joint.
std::string refusal(std::string_view text, BigRobotArmWire wire = kByte) {
  const auto plan = try_plan(text, wire);
  if (plan) return "accepted";
  const auto& [line, error] = plan.error();
  return std::to_string(line) + ": " + std::string(info(error.code).name) + " " +
         std::to_string(error.index);
}

template <class What>
std::vector<What> all(const Plan& plan) {
  std::vector<What> found;
  for (const Order& order : plan.orders) {
    if (const auto* what = std::get_if<What>(&order.what)) found.push_back(*what);
  }
  return found;
}

/// Targets in motor steps from power-up.
std::vector<Words> targets(const Plan& plan) {
  const RobotModel model = arm();
  std::vector<Words> result;
  for (const MoveOrder& move : all<MoveOrder>(plan)) {
    Words steps{};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      steps[i] = static_cast<std::int32_t>(
          std::lround(move.q[i] * device_of(model).joints[i].steps_per_rad));
    }
    result.push_back(steps);
  }
  return result;
}

TEST(SequencePlan, documented_sequence_takes_what_its_trapezoids_take) {
  const Plan plan =
      plan_of("BEGIN I5\nG0 B100 S200 E300 WR400 W300\nG0 B0 S50 E5000 WR1500 W0\nEND\n");
  ASSERT_EQ(plan.orders.size(), 10U);
  EXPECT_EQ(plan.moves, 10U);
  // First the shoulder: half a motor turn at 1 rev/s^2 is a triangle. Then the elbow: 4700 of 3200
  // steps a turn at 1 rev/s, and 1 s for both ramps.
  const double first = 2 * std::sqrt(0.5);
  const double other = 4700.0 / 3200 + 1;
  EXPECT_NEAR(std::get<MoveOrder>(plan.orders[0].what).duration, first, 1e-9);
  EXPECT_NEAR(std::get<MoveOrder>(plan.orders[9].what).duration, other, 1e-9);
  EXPECT_NEAR(plan.duration, first + 9 * other, 1e-9);
  for (int i = 0; i < 10; ++i) {
    const Order& order = plan.orders[static_cast<std::size_t>(i)];
    EXPECT_EQ(order.line, 2 + i % 2);
    EXPECT_EQ(order.round, 1 + i / 2);
    EXPECT_EQ(order.rounds, 5);
  }
}

TEST(SequencePlan, every_joint_is_held_to_its_limits_on_both_sides) {
  // base, elbow and wrist_rotate: 6500, 14000 and 2000 steps for 90, 126 and 90 deg.
  EXPECT_EQ(refusal("G0 B6500 S2500 E14000 WR2000 W3000"), "accepted");
  EXPECT_EQ(refusal("G0 B-6500 S-2500 E-14000 WR-2000 W-3000"), "accepted");
  EXPECT_EQ(refusal("G28\nG0 B6501"), "2: joint_limit 0");
  EXPECT_EQ(refusal("G0 B-6501"), "1: joint_limit 0");
  EXPECT_EQ(refusal("G0 B0 S2501"), "1: joint_limit 1");
  EXPECT_EQ(refusal("G0 B0 S-2501"), "1: joint_limit 1");
  EXPECT_EQ(refusal("G0 B0 S0 E14001"), "1: joint_limit 2");
  EXPECT_EQ(refusal("G0 B0 S0 E0 WR-2001"), "1: joint_limit 3");
  EXPECT_EQ(refusal("G0 B0 S0 E0 WR0 W3001"), "1: joint_limit 4");
  const auto plan = try_plan("G0 B0 S2501");
  // Steps of the shoulder count against the model: 2501 of them are below -90 deg.
  EXPECT_NEAR(to_deg(plan.error().error.measured), -90.036, 1e-9);
  EXPECT_NEAR(to_deg(plan.error().error.limit), -90, 1e-9);
}

TEST(SequencePlan, joint_that_the_program_does_not_name_stays) {
  EXPECT_EQ(targets(plan_of("G0 B100 S200 E300 WR400 W500\nG0 B1 S2\nG0 B9")),
            (std::vector<Words>{
                {100, 200, 300, 400, 500}, {1, 2, 300, 400, 500}, {9, 2, 300, 400, 500}}));
}

TEST(SequencePlan, target_that_would_be_cut_goes_to_its_neighbour_and_says_so) {
  const Plan plan = plan_of("G0 B13\nG0 B3327\nG0 B3584");
  EXPECT_EQ(targets(plan), (std::vector<Words>{{14}, {3327}, {3584}}));
  const auto move = all<MoveOrder>(plan)[0];
  EXPECT_NEAR(move.q_asked[0], angles_of(arm(), {13})[0], 1e-12);
  EXPECT_EQ(targets(plan_of("G0 B13", kText)), (std::vector<Words>{{13}}));
  // The whole second byte is 0D there: no neighbour helps.
  EXPECT_EQ(refusal("G0 B3400"), "1: unsendable 0");
  EXPECT_EQ(refusal("G0 B0 S0 E-3328"), "accepted");
  EXPECT_EQ(refusal("G0 B3400", kText), "accepted");
}

TEST(SequencePlan, neighbour_beyond_a_limit_is_no_neighbour) {
  RobotModel model = arm();
  model.joints[0].upper = angles_of(model, {269})[0];
  const auto state = boot_state(device_of(model));
  const auto plan = make_plan(program_of("G0 B269"), model, state);
  ASSERT_TRUE(plan);
  EXPECT_EQ(targets(*plan), (std::vector<Words>{{268}}));
}

TEST(SequencePlan, gripper_and_multipliers_are_checked_before_anything_moves) {
  EXPECT_EQ(refusal("G28\nG1 E1 P13"), "2: unsendable -1");
  EXPECT_EQ(refusal("G28\nG1 E1 P13", kText), "accepted");
  EXPECT_EQ(refusal("M203 B100 S13"), "1: unsendable 1");
  EXPECT_EQ(refusal("M201 B269"), "1: unsendable 0");
  EXPECT_EQ(refusal("M201 B269", kText), "accepted");
  const Program program = program_of("G1 E1 P180\nM203 B300");
  RobotModel model = arm();
  auto& device = std::get<BigRobotArmDevice>(model.device.settings);
  device.gripper_max = 150;
  const auto grip = make_plan(program, model, boot_state(device));
  ASSERT_FALSE(grip);
  EXPECT_EQ(grip.error().error,
            (Error{.code = ErrorCode::kGripperRange, .index = -1, .measured = 180, .limit = 150}));
  device.gripper_max = 180;
  device.multiplier_max = 200;
  const auto speed = make_plan(program, model, boot_state(device));
  ASSERT_FALSE(speed);
  EXPECT_EQ(speed.error().line, 2);
  EXPECT_EQ(
      speed.error().error,
      (Error{.code = ErrorCode::kMultiplierRange, .index = 0, .measured = 300, .limit = 200}));
}

TEST(SequencePlan, reset_moves_the_zero_and_the_limits_stay_where_they_are) {
  const Plan plan = plan_of("G0 B6000\nG92\nG0 B500\nG28\nG92\nG0 B-6000");
  EXPECT_EQ(targets(plan), (std::vector<Words>{{6000}, {6500}, {6000}, {0}}));
  EXPECT_EQ(all<ResetOrder>(plan).size(), 2U);
  EXPECT_EQ(refusal("G0 B6000\nG92\nG0 B501"), "3: joint_limit 0");
}

TEST(SequencePlan, reset_counts_from_the_neighbour_that_was_sent) {
  // 13 goes to 14; counted from 13, the next would be 3328 on the wire, which has no neighbour.
  const Plan plan = plan_of("G0 B13\nG92\nG0 B3327");
  EXPECT_EQ(targets(plan), (std::vector<Words>{{14}, {14 + 3327}}));
}

TEST(SequencePlan, home_goes_to_the_present_zero) {
  const Plan plan = plan_of("G0 B100 S200\nG92\nG0 B50\nG28");
  const auto moves = all<MoveOrder>(plan);
  EXPECT_FALSE(moves[1].home);
  EXPECT_TRUE(moves[2].home);
  EXPECT_EQ(targets(plan).back(), (Words{100, 200}));
}

TEST(SequencePlan, rounds_start_where_the_last_one_ended) {
  EXPECT_EQ(targets(plan_of("BEGIN I3\nG0 B1000\nG92\nEND")),
            (std::vector<Words>{{1000}, {2000}, {3000}}));
  EXPECT_EQ(refusal("BEGIN I6\nG0 B1000\nG92\nEND"), "accepted");
  EXPECT_EQ(refusal("BEGIN I7\nG0 B1000\nG92\nEND"), "2: joint_limit 0");
}

TEST(SequencePlan, only_multipliers_that_change_are_ordered) {
  const Plan plan = plan_of("M203 B200\nM203 B150\nM203 B150 S100\nM201 B200 S90\nG0 B6400");
  const auto speeds = all<SpeedsOrder>(plan);
  ASSERT_EQ(speeds.size(), 1U);
  EXPECT_EQ(speeds[0].multipliers, (Words{150, 100, 100, 100, 100}));
  const auto accelerations = all<AccelerationsOrder>(plan);
  ASSERT_EQ(accelerations.size(), 1U);
  EXPECT_EQ(accelerations[0].multipliers, (Words{200, 90, 100, 100, 100}));
  // Two motor turns at 1.5 rev/s and 2 rev/s^2.
  EXPECT_NEAR(plan.duration, 2 / 1.5 + 1.5 / 2, 1e-9);
}

TEST(SequencePlan, synchronised_joints_arrive_together_and_get_their_speeds_back) {
  const Plan plan = plan_of(
      "M203 B150 S110\nS1\nG0 B4000 S900 E3000 WR1500 W2000\nG0 B0 S0 E0 WR1500 W0\nS0\nG28");
  const auto moves = all<MoveOrder>(plan);
  ASSERT_EQ(moves.size(), 3U);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      const double duration = moves[k].profiles[i].duration();
      if (k == 1 && i == 3) {
        EXPECT_EQ(duration, 0);
        continue;
      }
      EXPECT_GT(duration, 0.97 * moves[k].duration) << "move " << k << " joint " << i;
      EXPECT_LE(duration, moves[k].duration);
    }
  }
  // After S0 the joints are as the program set them, and arrive when they like.
  EXPECT_EQ(all<SpeedsOrder>(plan).front().multipliers, (Words{150, 110, 100, 100, 100}));
  EXPECT_EQ(all<SpeedsOrder>(plan).back().multipliers, (Words{150, 110, 100, 100, 100}));
  EXPECT_EQ(all<AccelerationsOrder>(plan).back().multipliers, (Words{200, 100, 100, 100, 100}));
}

TEST(SequencePlan, program_that_ends_synchronised_gives_the_speeds_back_too) {
  const Plan plan = plan_of("S1\nG0 B4000 S900 E3000 WR1500 W2000");
  ASSERT_FALSE(std::holds_alternative<MoveOrder>(plan.orders.back().what));
  EXPECT_EQ(all<SpeedsOrder>(plan).back().multipliers, (Words{200, 100, 100, 100, 100}));
  EXPECT_EQ(all<AccelerationsOrder>(plan).back().multipliers, (Words{200, 100, 100, 100, 100}));
  EXPECT_TRUE(plan_of("S1\nS0\nS1").orders.empty());
}

TEST(SequencePlan, starts_from_what_the_device_says) {
  const RobotModel model = arm();
  DeviceState state = boot_state(device_of(model));
  state.positions = {1000, -200, 0, 0, 0};
  state.speeds = {50, 50, 50, 50, 50};
  const auto plan = make_plan(program_of("G0 B4200"), model, state);
  ASSERT_TRUE(plan);
  const auto move = all<MoveOrder>(*plan)[0];
  EXPECT_LT(apart(move.q_start, angles_of(model, state.positions)), 1e-12);
  EXPECT_EQ(targets(*plan), (std::vector<Words>{{4200, -200}}));
  // A motor turn at half a turn per s and 2 rev/s^2.
  EXPECT_NEAR(move.duration, 1 / 0.5 + 0.5 / 2, 1e-9);
}

TEST(SequencePlan, nonsense_from_the_device_is_a_refusal_or_a_plan_but_no_accident) {
  const RobotModel model = arm(kText);
  DeviceState state;
  for (const std::int32_t word : {std::numeric_limits<std::int32_t>::min(), -1, 0,
                                  std::numeric_limits<std::int32_t>::max()}) {
    state.positions.fill(word);
    state.speeds.fill(word);
    state.accelerations.fill(word);
    const auto plan = make_plan(program_of("G0 B1 S1 E1 WR1 W1\nG92\nG0 B5"), model, state);
    ASSERT_FALSE(plan) << word;
    EXPECT_EQ(plan.error().error.code, ErrorCode::kMultiplierRange) << word;
    EXPECT_FALSE(make_plan(program_of("S1\nG0 B1 S1 E1 WR1 W1"), model, state)) << word;
    const auto reset = make_plan(program_of("G92\nG0 B16777215"), model, state);
    ASSERT_FALSE(reset) << word;
    EXPECT_EQ(reset.error().error.code, ErrorCode::kJointLimit) << word;
  }
}

TEST(SequencePlan, joint_that_moves_needs_sane_settings_in_the_device) {
  const RobotModel model = arm();
  for (const std::int32_t speed : {-5, 0, 301, 3000}) {
    DeviceState state = boot_state(device_of(model));
    state.speeds[0] = speed;
    const auto plan = make_plan(program_of("G0 B50"), model, state);
    ASSERT_FALSE(plan) << speed;
    EXPECT_EQ(plan.error().error, (Error{ErrorCode::kMultiplierRange, 0, 1.0 * speed, 300}));
    EXPECT_TRUE(make_plan(program_of("G0 B0 S50"), model, state)) << "the base stays";
    EXPECT_TRUE(make_plan(program_of("M203 B100\nG0 B50"), model, state)) << "set first";
  }
}

TEST(SequencePlan, program_without_end_is_refused_before_it_fills_the_memory) {
  std::string text;
  for (int i = 0; i < 100; ++i) {
    text += "BEGIN I127\n";
    for (int line = 0; line < 20; ++line) text += line % 2 == 0 ? "G0 B1\n" : "G0 B2\n";
    text += "END\n";
  }
  const RobotModel model = arm();
  const auto plan = make_plan(program_of(text), model, boot_state(device_of(model)));
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kProgramTooLong);
  EXPECT_GT(plan.error().line, 0);
}

TEST(SequencePlan, steps_that_the_device_reports_wrongly_are_refused) {
  RobotModel model = arm(kText);
  model.joints[0].upper = 1e6;
  const auto state = boot_state(device_of(model));
  EXPECT_TRUE(make_plan(program_of("G0 B16777214"), model, state));
  const auto plan = make_plan(program_of("G0 B16777215"), model, state);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kStepRange);
}

/// A program of all kinds of commands with moves inside the limits, more or less.
std::string random_program(test::Random& random) {
  constexpr std::array<const char*, 5> kLetters{" B", " S", " E", " WR", " W"};
  constexpr std::array<int, 5> kReach{3200, 1200, 6800, 990, 1480};
  std::string text;
  const auto words = [&](const char* name, auto value) {
    text += name;
    const auto count = static_cast<std::size_t>(random.integer(1, 5));
    for (std::size_t i = 0; i < count; ++i) text += kLetters[i] + std::to_string(value(i));
    text += '\n';
  };
  const auto lines = random.integer(1, 12);
  for (int i = 0; i < lines; ++i) {
    const auto kind = random.integer(0, 9);
    if (kind < 5) words("G0", [&](std::size_t k) { return random.integer(-kReach[k], kReach[k]); });
    if (kind == 5) words("M203", [&](std::size_t) { return random.integer(20, 300); });
    if (kind == 6) words("M201", [&](std::size_t) { return random.integer(20, 300); });
    if (kind == 7) text += random.chance(0.5) ? "S1\n" : "S0\n";
    if (kind == 8) text += random.chance(0.3) ? "G92\n" : "G28\n";
    if (kind == 9) text += "G1 E1 P" + std::to_string(random.integer(0, 180)) + "\n";
  }
  return text;
}

TEST(SequencePlan, any_plan_is_without_gaps_inside_its_limits_and_sendable) {
  std::size_t accepted = 0;
  test::for_random_cases(5'000, [&](test::Random& random) {
    const RobotModel model = arm(random.chance(0.5) ? kByte : kText);
    const bool byte_wire = device_of(model).wire == kByte;
    const std::string text = random_program(random);
    const auto plan = make_plan(program_of(text), model, boot_state(device_of(model)));
    if (!plan) return;
    ++accepted;
    BigRobotArmAngles q{};
    double duration = 0;
    for (const Order& order : plan->orders) {
      if (const auto* speeds = std::get_if<SpeedsOrder>(&order.what)) {
        EXPECT_TRUE(check_multipliers(device_of(model), speeds->multipliers)) << text;
      }
      const auto* move = std::get_if<MoveOrder>(&order.what);
      if (move == nullptr) continue;
      EXPECT_LT(apart(move->q_start, q), 1e-9) << text;
      double slowest = 0;
      for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
        const double step = 1 / std::abs(device_of(model).joints[i].steps_per_rad);
        EXPECT_NEAR(move->q_start[i] + move->profiles[i].distance(), move->q[i], 1e-12) << text;
        EXPECT_GE(move->q[i], model.joints[i].lower - step / 2) << text;
        EXPECT_LE(move->q[i], model.joints[i].upper + step / 2) << text;
        EXPECT_LE(std::abs(move->q[i] - move->q_asked[i]), byte_wire ? 1.001 * step : 1e-12)
            << text;
        slowest = std::max(slowest, move->profiles[i].duration());
      }
      EXPECT_EQ(move->duration, slowest) << text;
      duration += move->duration;
      q = move->q;
    }
    EXPECT_NEAR(plan->duration, duration, 1e-9) << text;
  });
  EXPECT_GT(accepted, 3'000U);
}

}  // namespace
}  // namespace sinew::sequence
