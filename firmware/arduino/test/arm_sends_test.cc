#include <SinewMaxArm.h>
#include <gtest/gtest.h>

#include <limits>

#include "arm_line.h"
#include "host/virtual_clock.h"
#include "sinew/core/units.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::arduino {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

struct Bench {
  ArmLine line;
  SinewMaxArm arm{line};
  Bytes last() const { return line.writes.empty() ? Bytes{} : line.writes.back().bytes; }
};

void expect_refused(Bench& bench, const MaxArmResult& result, MaxArmError error, float value,
                    float limit, uint8_t joint = 0) {
  EXPECT_FALSE(result);
  EXPECT_EQ(result.error, error);
  EXPECT_NEAR(result.value, value, 0.02);
  EXPECT_NEAR(result.limit, limit, 0.01);
  EXPECT_EQ(result.joint, joint);
  EXPECT_TRUE(bench.line.writes.empty()) << "no byte is sent";
}

TEST(ArduinoArm, sends_the_documents_frames) {
  Bench bench;
  const std::int16_t pulses[3] = {200, 500, 500};
  const std::int16_t point[3] = {-120, -180, 85};
  const std::uint8_t angles[3] = {120, 100, 120};
  ASSERT_TRUE(bench.arm.set_pulses(pulses, 2000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 01 08 C8 00 F4 01 F4 01 D0 07 6D"));
  ASSERT_TRUE(bench.arm.set_xyz(point, 1000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 03 08 88 FF 4C FF 55 00 E8 03 E2"));
  ASSERT_TRUE(bench.arm.set_pwmservo(90, 1000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 05 04 DC 05 E8 03 2A"));
  ASSERT_TRUE(bench.arm.set_pwmservo(45, 1000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 05 04 E8 03 E8 03 20"));
  ASSERT_TRUE(bench.arm.set_pwmservo(135, 1000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 05 04 D0 07 E8 03 34"));
  ASSERT_TRUE(bench.arm.set_SuctionNozzle(kSuctionOn));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 07 01 01 F6"));
  ASSERT_TRUE(bench.arm.set_SuctionNozzle(kSuctionRelease));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 07 01 02 F5"));
  ASSERT_TRUE(bench.arm.set_SuctionNozzle(kSuctionOff));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 07 01 03 F4"));
  ASSERT_TRUE(bench.arm.set_angles(angles, 1000));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 01 08 F4 01 A1 01 F4 01 E8 03 7F"))
      << "100 deg is pulse 416.67: 417, where the maker's code cuts it to 416";
}

TEST(ArduinoArm, angles_out_of_range_are_refused_and_do_not_wrap) {
  Bench bench;
  const std::int16_t negative[3] = {-5, 100, 120};
  const std::int16_t wrapped[3] = {251, 100, 120};
  const std::int16_t shoulder[3] = {120, 212, 120};
  const std::int16_t right_angles[3] = {90, 90, 90};
  expect_refused(bench, bench.arm.set_angles(negative, 1000), MaxArmError::kServoRange, -5, 0, 1);
  expect_refused(bench, bench.arm.set_angles(wrapped, 1000), MaxArmError::kServoRange, 251, 240, 1);
  expect_refused(bench, bench.arm.set_angles(shoulder, 1000), MaxArmError::kServoRange, 212, 211,
                 2);
  expect_refused(bench, bench.arm.set_angles(right_angles, 1000), MaxArmError::kServoRange, 90, 119,
                 3);
  const float nan[3] = {120, std::numeric_limits<float>::quiet_NaN(), 120};
  expect_refused(bench, bench.arm.set_angles(nan, 1000), MaxArmError::kNotANumber, 0, 0, 2);
  const std::int16_t zero[3] = {0, 500, 500};
  const std::int16_t above[3] = {500, 500, 1001};
  const std::int16_t below[3] = {500, 500, 495};
  expect_refused(bench, bench.arm.set_pulses(zero, 1000), MaxArmError::kPulseRange, 0, 1, 1);
  expect_refused(bench, bench.arm.set_pulses(above, 1000), MaxArmError::kPulseRange, 1001, 1000, 3);
  expect_refused(bench, bench.arm.set_pulses(below, 1000), MaxArmError::kPulseRange, 495, 496, 3);
}

TEST(ArduinoArm, limits_are_inclusive_and_pulse_0_is_never_sent) {
  Bench bench;
  const std::int16_t low[3] = {0, 0, 119};
  const std::int16_t high[3] = {240, 211, 240};
  ASSERT_TRUE(bench.arm.set_angles(low, 20));
  EXPECT_EQ(bench.last(), test::from_hex("AA 55 01 08 01 00 01 00 F0 01 14 00 EF"));
  ASSERT_TRUE(bench.arm.set_angles(high, 30000));
  const auto request = maxarm::encode_request(maxarm::SetAngle{{1000, 879, 1000}, 30000});
  EXPECT_EQ(bench.last(), Bytes(request.begin(), request.end()));
  ASSERT_TRUE(bench.arm.set_pwmservo(0, 20));
  ASSERT_TRUE(bench.arm.set_pwmservo(180, 20));
}

TEST(ArduinoArm, times_out_of_range_are_refused) {
  Bench bench;
  const std::int16_t point[3] = {0, -200, 120};
  const std::int16_t angles[3] = {120, 100, 120};
  for (const std::int32_t time : {-1, 0, 19}) {
    const auto value = static_cast<float>(time);
    expect_refused(bench, bench.arm.set_angles(angles, time), MaxArmError::kTimeRange, value, 20);
    expect_refused(bench, bench.arm.set_xyz(point, time), MaxArmError::kTimeRange, value, 20);
    expect_refused(bench, bench.arm.move_to(0, -200, 120, time), MaxArmError::kTimeRange, value,
                   20);
    expect_refused(bench, bench.arm.set_pwmservo(90, time), MaxArmError::kTimeRange, value, 20);
    expect_refused(bench, bench.arm.halt(time), MaxArmError::kTimeRange, value, 20);
  }
  expect_refused(bench, bench.arm.set_angles(angles, 30001), MaxArmError::kTimeRange, 30001, 30000);
  expect_refused(bench, bench.arm.set_pwmservo(90, 66536), MaxArmError::kTimeRange, 66536, 30000);
}

TEST(ArduinoArm, nozzle_and_suction_out_of_range_are_refused) {
  Bench bench;
  expect_refused(bench, bench.arm.set_pwmservo(-1, 1000), MaxArmError::kNozzleRange, -1, 0);
  expect_refused(bench, bench.arm.set_pwmservo(180.1F, 1000), MaxArmError::kNozzleRange, 180.1F,
                 180);
  expect_refused(bench, bench.arm.set_pwmservo(std::numeric_limits<float>::infinity(), 1000),
                 MaxArmError::kNotANumber, 0, 0);
  expect_refused(bench, bench.arm.set_SuctionNozzle(0), MaxArmError::kSuctionRange, 0, 1);
  expect_refused(bench, bench.arm.set_SuctionNozzle(4), MaxArmError::kSuctionRange, 4, 3);
  expect_refused(bench, bench.arm.set_SuctionNozzle(-1), MaxArmError::kSuctionRange, -1, 1);
  expect_refused(bench, bench.arm.set_SuctionNozzle(257), MaxArmError::kSuctionRange, 257, 3);
}

TEST(ArduinoArm, unreachable_points_are_refused) {
  Bench bench;
  const std::int16_t high[3] = {0, -100, 240};
  const std::int16_t behind[3] = {100, 100, 100};
  const std::int16_t far[3] = {0, -400, 100};
  const std::int16_t close[3] = {0, -40, 100};
  expect_refused(bench, bench.arm.set_xyz(high, 1000), MaxArmError::kJointLimit, -17.06F, 0, 3);
  expect_refused(bench, bench.arm.set_xyz(behind, 1000), MaxArmError::kJointLimit, -15, 0, 1);
  expect_refused(bench, bench.arm.set_xyz(far, 1000), MaxArmError::kOutOfReach, 375.4F, 266.4F);
  expect_refused(bench, bench.arm.set_xyz(close, 1000), MaxArmError::kTooClose, 40, 50);
  expect_refused(bench, bench.arm.move_to(0, -100, 240, 1000), MaxArmError::kJointLimit, -17.06F, 0,
                 3);
}

TEST(ArduinoArm, point_whose_pulse_the_arm_would_cut_to_0_is_refused_by_set_xyz_only) {
  // The base at 0.01 deg: pulse 0.04, which the arm cuts to 0.
  Bench bench;
  const std::int16_t point[3] = {175, 101, 100};
  const MaxArmResult refused = bench.arm.set_xyz(point, 1000);
  expect_refused(bench, refused, MaxArmError::kJointLimit, refused.value, 0.24F, 1);
  EXPECT_LT(refused.value, 0.245);
  EXPECT_TRUE(bench.arm.move_to(175, 101, 100, 1000));
  EXPECT_EQ(bench.last()[4], 1);
}

TEST(ArduinoArm, arm_goes_to_every_kind_of_target) {
  Bench bench;
  const std::int16_t point[3] = {120, -180, 85};
  ASSERT_TRUE(bench.arm.set_xyz(point, 1000));
  bench.line.wait(2s);
  EXPECT_NEAR(bench.line.pulse(0), 359, 1);
  EXPECT_NEAR(bench.line.pulse(1), 317, 4);
  EXPECT_NEAR(bench.line.pulse(2), 674, 4);
  EXPECT_TRUE(bench.arm.at_target());
  ASSERT_TRUE(bench.arm.move_to(-120, -180, 85, 1000));
  bench.line.wait(2s);
  EXPECT_NEAR(bench.line.pulse(0), 640, 1);
  EXPECT_NEAR(bench.line.pulse(1), 318, 4);
  EXPECT_NEAR(bench.line.pulse(2), 675, 4);
  EXPECT_TRUE(bench.arm.at_target());
  const float angles[3] = {100, 96, 144};
  ASSERT_TRUE(bench.arm.set_angles(angles, 500));
  bench.line.wait(2s);
  EXPECT_NEAR(bench.line.pulse(0), 417, 1);
  EXPECT_NEAR(bench.line.pulse(1), 400, 4);
  EXPECT_NEAR(bench.line.pulse(2), 600, 4);
  EXPECT_TRUE(bench.arm.at_target());
  ASSERT_TRUE(bench.arm.set_pwmservo(135, 300));
  ASSERT_TRUE(bench.arm.set_SuctionNozzle(kSuctionOn));
  bench.line.wait(1s);
  EXPECT_NEAR(bench.line.machine().truth().tool, from_deg(135), 1e-9);
  EXPECT_TRUE(bench.line.machine().truth().suction);
  EXPECT_EQ(bench.line.machine().firmware().restarts(), 0U);
}

TEST(ArduinoArm, blocked_arm_has_missed_its_target) {
  Bench bench;
  bench.line.machine().disturb({sim::Disturbance::Kind::kBlock, 0, from_deg(130)});
  const std::int16_t pulses[3] = {700, 500, 500};
  ASSERT_TRUE(bench.arm.set_pulses(pulses, 500));
  bench.line.wait(1s);
  const MaxArmResult result = bench.arm.at_target();
  EXPECT_EQ(result.error, MaxArmError::kMissedTarget);
  EXPECT_EQ(result.joint, 1);
  EXPECT_NEAR(result.value, 130, 0.2);
  EXPECT_NEAR(result.limit, 168, 0.01);
}

TEST(ArduinoArm, any_lost_byte_of_a_target_is_found_by_reading_back) {
  for (std::size_t lost = 0; lost < 13; ++lost) {
    Bench bench;
    int writes = 0;
    bench.line.to_arm = [&](ArmLine::Chunk& chunk) {
      if (writes++ == 0) chunk.erase(chunk.begin() + static_cast<long>(lost));
    };
    ASSERT_TRUE(bench.arm.move_to(100, -180, 120, 500));
    bench.line.wait(1s);
    EXPECT_EQ(bench.arm.at_target().error, MaxArmError::kMissedTarget) << lost;
    ASSERT_TRUE(bench.arm.move_to(100, -180, 120, 500));
    bench.line.wait(1s);
    EXPECT_TRUE(bench.arm.at_target()) << lost;
  }
}

TEST(ArduinoArm, frames_are_20_ms_apart_behind_their_last_byte) {
  for (const bool blocking : {false, true}) {
    Bench bench;
    bench.line.blocking = blocking;
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE(bench.arm.move_to(0, -200, static_cast<float>(100 + i), 20));
      ASSERT_TRUE(bench.arm.set_SuctionNozzle(kSuctionOff));
    }
    for (std::size_t i = 1; i < bench.line.writes.size(); ++i) {
      const auto& before = bench.line.writes[i - 1];
      const Duration gap = bench.line.writes[i].at - before.at - before.bytes.size() * 1041667ns;
      EXPECT_GE(gap, 20ms);
      EXPECT_LE(gap, 24ms);
    }
    bench.line.wait(1s);
    EXPECT_EQ(bench.line.machine().firmware().requests_taken(), 40U);
  }
}

TEST(ArduinoArm, overflow_of_millis_neither_blocks_nor_shortens_gaps) {
  Bench bench;
  set_clock(now(), 0xFFFFFFFAU);
  const Instant before = now();
  std::int16_t pulses[3];
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(bench.arm.move_to(0, -200, 120, 1000));
    ASSERT_TRUE(bench.arm.read_pulses(pulses));
  }
  EXPECT_LT(now() - before, 2s);
  for (std::size_t i = 1; i < bench.line.writes.size(); ++i) {
    EXPECT_GE(bench.line.writes[i].at - bench.line.writes[i - 1].at, 25ms);
  }
  // 30 days without a call.
  set_clock(now(), static_cast<std::uint32_t>(millis() + 30UL * 24 * 3600 * 1000));
  const Instant later = now();
  ASSERT_TRUE(bench.arm.move_to(0, -200, 120, 1000));
  EXPECT_LT(now() - later, 50ms);
}

TEST(ArduinoArm, port_that_takes_too_little_is_a_failure) {
  struct Deaf : ArmLine {
    size_t write(const uint8_t*, size_t) override { return 3; }
  } line;
  SinewMaxArm arm(line);
  const MaxArmResult result = arm.move_to(0, -200, 120, 1000);
  EXPECT_EQ(result.error, MaxArmError::kWriteFailed);
  EXPECT_EQ(result.value, 3);
  EXPECT_EQ(result.limit, 13);
}

TEST(ArduinoArm, random_calls_send_only_frames_that_the_arm_may_get) {
  test::for_random_cases(300, [](test::Random& random) {
    Bench bench;
    const auto any = [&] { return static_cast<std::int16_t>(random.integer(-300, 1100)); };
    for (int i = 0; i < 20; ++i) {
      const std::int16_t three[3] = {any(), any(), any()};
      const auto time = static_cast<std::int32_t>(random.integer(-100, 31000));
      const auto written = bench.line.writes.size();
      const auto choice = random.integer(0, 4);
      const MaxArmResult result = choice == 0   ? bench.arm.set_angles(three, time)
                                  : choice == 1 ? bench.arm.set_pulses(three, time)
                                  : choice == 2 ? bench.arm.set_xyz(three, time)
                                  : choice == 3 ? bench.arm.set_pwmservo(three[0], time)
                                                : bench.arm.set_SuctionNozzle(three[0]);
      EXPECT_EQ(bench.line.writes.size(), written + (result ? 1 : 0));
    }
    maxarm::RequestDecoder decoder;
    for (const auto& write : bench.line.writes) {
      std::optional<maxarm::Request> request;
      for (const std::uint8_t byte : write.bytes) request = decoder.push(byte);
      ASSERT_TRUE(request);
      if (const auto* angle = std::get_if<maxarm::SetAngle>(&*request)) {
        for (const auto pulse : angle->pulses) EXPECT_TRUE(pulse >= 1 && pulse <= 1000);
        EXPECT_TRUE(angle->time_ms >= 20 && angle->time_ms <= 30000);
      } else if (const auto* pwm = std::get_if<maxarm::SetPwmServo>(&*request)) {
        EXPECT_TRUE(pwm->pulse_us >= 500 && pwm->pulse_us <= 2500);
        EXPECT_TRUE(pwm->time_ms >= 20 && pwm->time_ms <= 30000);
      } else if (const auto* suction = std::get_if<maxarm::SetSuction>(&*request)) {
        EXPECT_TRUE(suction->action >= 1 && suction->action <= 3);
      }
    }
    bench.line.wait(1s);
    EXPECT_EQ(bench.line.machine().firmware().restarts(), 0U);
  });
}

TEST(ArduinoArm, random_reachable_points_are_reached_on_both_programs) {
  test::for_random_cases(300, [](test::Random& random) {
    ArmLine line(random.chance(0.5) ? MaxArmChecksum::kSpec : MaxArmChecksum::kWithHeader,
                 random.chance(0.5) ? MaxArmVariant::kArduino : MaxArmVariant::kMicroPython,
                 random.bits());
    SinewMaxArm arm(line);
    line.blocking = random.chance(0.5);
    const auto x = static_cast<std::int16_t>(random.integer(-180, 180));
    const auto y = static_cast<std::int16_t>(random.integer(-220, -120));
    const auto z = static_cast<std::int16_t>(random.integer(60, 130));
    const std::int16_t point[3] = {x, y, z};
    const MaxArmResult sent =
        random.chance(0.5) ? arm.set_xyz(point, 500) : arm.move_to(x, y, z, 500);
    if (!sent) return random.discard();
    delay(1200);
    EXPECT_TRUE(arm.at_target()) << x << " " << y << " " << z;
    std::int16_t xyz[3];
    ASSERT_TRUE(arm.read_xyz(xyz));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(xyz[i], point[i], 6) << x << " " << y << " " << z;
  });
}

}  // namespace
}  // namespace sinew::arduino
