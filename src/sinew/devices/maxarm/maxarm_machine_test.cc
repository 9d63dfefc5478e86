#include "sinew/devices/maxarm/maxarm_machine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_test_model.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::sim {
namespace {

using namespace maxarm;
using namespace std::chrono_literals;
using Kind = Disturbance::Kind;

struct Bench {
  explicit Bench(MaxArmVariant variant = MaxArmVariant::kArduino)
      : machine(test::maxarm_model(), MaxArmChecksum::kSpec, variant, 3, Instant{}) {
    run_for(20s);
  }
  void send(const Request& request) { machine.receive(encode_request(request), now); }
  void run_for(Duration duration) { machine.advance(now += duration); }
  double pulse(std::size_t i) const {
    const auto robot = test::maxarm_model();
    const auto& servo = robot.device.settings.get<MaxArmDevice>().servos[i];
    return servo.offset + servo.pulses_per_rad * machine.truth().joints[i].q;
  }
  std::optional<Angles> read() {
    send(ReadAngle{});
    run_for(700ms);
    ReplyDecoder decoder;
    std::array<std::uint8_t, 64> piece{};
    std::optional<Angles> angles;
    const std::size_t count = machine.take_output(piece);
    for (std::size_t i = 0; i < count; ++i) {
      if (const auto frame = decoder.push(piece[i])) angles = std::get<Angles>(frame->reply);
    }
    return angles;
  }

  MaxArmMachine machine;
  Instant now{};
};

TEST(MaxArmMachine, goes_where_it_is_sent_up_to_what_its_weight_bends) {
  Bench bench;
  bench.send(SetAngle{{359, 317, 674}, 1000});
  bench.run_for(2s);
  EXPECT_NEAR(bench.pulse(0), 359, 1);
  EXPECT_NEAR(bench.pulse(1), 317, 4);
  EXPECT_NEAR(bench.pulse(2), 674, 4);
  EXPECT_FALSE(bench.machine.truth().moving);
  const auto joint = bench.machine.truth().joints[1];
  EXPECT_GT(joint.q, joint.believed) << "a leaning arm sags forward";
}

TEST(MaxArmMachine, question_is_answered_with_the_sensor_and_not_with_what_was_commanded) {
  Bench bench;
  bench.machine.disturb({Kind::kBlock, 0, from_deg(130)});
  bench.send(SetAngle{{700, 500, 500}, 500});
  bench.run_for(1s);
  EXPECT_NEAR(bench.machine.truth().joints[0].q, from_deg(130), 1e-9);
  EXPECT_NEAR(bench.machine.truth().joints[0].believed, from_deg(168), 1e-9);
  EXPECT_TRUE(bench.machine.truth().joints[0].at_end_stop);
  const auto angles = bench.read();
  ASSERT_TRUE(angles);
  EXPECT_EQ(angles->pulses[0], 542);
  bench.machine.disturb({Kind::kUnblock, 0, 0});
  bench.run_for(2s);
  EXPECT_NEAR(bench.pulse(0), 700, 1);
}

TEST(MaxArmMachine, object_hangs_only_while_the_pump_runs) {
  Bench bench;
  bench.machine.disturb({Kind::kPayload, -1, 0.3});
  EXPECT_EQ(bench.machine.carried(), 0);
  bench.send(SetSuction{1});
  bench.run_for(100ms);
  EXPECT_EQ(bench.machine.carried(), 0.3);
  EXPECT_TRUE(bench.machine.truth().suction);
  bench.send(SetSuction{2});
  bench.run_for(100ms);
  EXPECT_EQ(bench.machine.carried(), 0);
  bench.send(SetSuction{1});
  bench.run_for(100ms);
  EXPECT_EQ(bench.machine.carried(), 0) << "it fell";
}

TEST(MaxArmMachine, object_bends_the_arm_farther) {
  Bench light;
  Bench heavy;
  heavy.machine.disturb({Kind::kPayload, -1, 0.3});
  for (Bench* bench : {&light, &heavy}) {
    bench->send(SetSuction{1});
    bench->run_for(20ms);
    bench->send(SetAngle{{500, 188, 576}, 1000});
    bench->run_for(3s);
  }
  EXPECT_GT(heavy.machine.truth().joints[1].q, light.machine.truth().joints[1].q + from_deg(0.3));
}

TEST(MaxArmMachine, lost_supply_lets_it_fall_and_its_return_homes_it) {
  Bench bench;
  bench.send(SetAngle{{500, 188, 576}, 1000});
  bench.run_for(2s);
  const double before = bench.machine.truth().joints[1].q;
  bench.machine.disturb({Kind::kSupply, -1, 0});
  EXPECT_FALSE(bench.machine.next_event());
  bench.run_for(2s);
  EXPECT_GT(bench.machine.truth().joints[1].q, before + from_deg(10));
  EXPECT_FALSE(bench.read());
  bench.machine.disturb({Kind::kSupply, -1, 12});
  bench.run_for(5s);
  EXPECT_NEAR(bench.pulse(1), 500, 4);
  EXPECT_EQ(bench.machine.firmware().restarts(), 1U);
}

TEST(MaxArmMachine, servo_without_its_magnet_answers_nothing) {
  Bench arduino;
  arduino.machine.disturb({Kind::kMagnet, 2, 0});
  EXPECT_EQ(arduino.read().value().pulses[2], -1);
  Bench python(MaxArmVariant::kMicroPython);
  python.machine.disturb({Kind::kMagnet, 2, 0});
  EXPECT_FALSE(python.read());
  EXPECT_TRUE(python.machine.firmware().dead());
}

TEST(MaxArmMachine, unreachable_point_drives_shoulder_and_forearm_into_their_ends) {
  Bench bench;
  bench.send(SetXyz{{0, -400, 100}, 500});
  bench.run_for(3s);
  EXPECT_NEAR(bench.machine.truth().joints[1].q, from_deg(210), from_deg(1.5));
  EXPECT_TRUE(bench.machine.truth().joints[2].at_end_stop);
  EXPECT_NEAR(bench.machine.truth().joints[2].q, from_deg(-5), 1e-9);
}

TEST(MaxArmMachine, nozzle_turns_in_its_time) {
  Bench bench;
  bench.send(SetPwmServo{2500, 1000});
  bench.run_for(500ms);
  EXPECT_NEAR(bench.machine.truth().tool, 3 * kPi / 4, 1e-9);
  bench.run_for(1s);
  EXPECT_NEAR(bench.machine.truth().tool, kPi, 1e-9);
}

TEST(MaxArmMachine, same_seed_same_run_and_no_allocation) {
  test::for_random_cases(20, [](test::Random& random) {
    const std::uint64_t seed = random.bits();
    const auto variant = random.chance(0.5) ? MaxArmVariant::kArduino : MaxArmVariant::kMicroPython;
    const RobotModel robot = test::maxarm_model();
    MaxArmMachine one(robot, MaxArmChecksum::kSpec, variant, seed, Instant{});
    MaxArmMachine two(robot, MaxArmChecksum::kSpec, variant, seed, Instant{});
    Instant now{};
    std::array<std::uint8_t, 64> a{};
    std::array<std::uint8_t, 64> b{};
    const test::AllocationCounter allocations;
    for (int i = 0; i < 60; ++i) {
      now += std::chrono::milliseconds(random.integer(1, 900));
      const auto pulse = [&] { return static_cast<std::uint16_t>(random.integer(1, 1000)); };
      const auto frame = random.chance(0.5)
                             ? encode_request(ReadXyz{})
                             : encode_request(SetAngle{{pulse(), pulse(), pulse()}, pulse()});
      one.receive(frame, now);
      two.receive(frame, now);
      const std::size_t count = one.take_output(a);
      EXPECT_EQ(two.take_output(b), count);
      EXPECT_EQ(a, b);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(one.truth().joints[k].q, two.truth().joints[k].q);
        // Mechanical ends hold whatever the board wants.
        EXPECT_GE(one.truth().joints[k].q, robot.joints[k].lower - from_deg(5) - 1e-9);
        EXPECT_LE(one.truth().joints[k].q, robot.joints[k].upper + from_deg(5) + 1e-9);
      }
    }
    EXPECT_EQ(allocations.count(), 0U);
  });
}

}  // namespace
}  // namespace sinew::sim
