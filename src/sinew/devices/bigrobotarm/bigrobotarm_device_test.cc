#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace bigrobotarm;
using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

BigRobotArmDevice arm(BigRobotArmWire wire = BigRobotArmWire::kByte) {
  BigRobotArmDevice settings;
  constexpr std::array<double, kJoints> kStepsPerRev{3200, 400, 3200, 3200, 3200};
  for (std::size_t i = 0; i < kJoints; ++i) {
    settings.joints[i].steps_per_motor_rev = kStepsPerRev[i];
  }
  settings.joints[0].multiplier_boot = 200;
  settings.wire = wire;
  return settings;
}

/// A device and the time line it lives on.
struct Bench {
  explicit Bench(BigRobotArmWire wire = BigRobotArmWire::kByte) : firmware(arm(wire), Instant{}) {}

  void send(const Request& request) {
    const auto bytes = byte::encode_request(request);
    firmware.receive(bytes, now);
    firmware.receive(std::array{byte::kTerminator}, now);
  }
  void send(const std::string& lines) {
    firmware.receive({reinterpret_cast<const std::uint8_t*>(lines.data()), lines.size()}, now);
  }
  void run_to(Duration since_boot) {
    now = Instant{since_boot};
    firmware.advance(now);
  }
  void run_to_rest() {
    while (const auto event = firmware.next_event()) run_to(event->time_since_epoch());
  }
  std::vector<Reply> replies() {
    std::vector<Reply> all;
    for (const std::uint8_t byte : output()) {
      if (const auto reply = decoder.push(byte)) all.push_back(reply->value());
    }
    return all;
  }
  Bytes output() {
    Bytes bytes;
    std::array<std::uint8_t, 7> piece{};
    while (const std::size_t count = firmware.take_output(piece)) {
      bytes.insert(bytes.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
    return bytes;
  }
  std::string text() {
    const Bytes bytes = output();
    return {bytes.begin(), bytes.end()};
  }

  BigRobotArmFirmware firmware;
  byte::ReplyDecoder decoder;
  Instant now{};
};

const Words kDocumented{-2400, 600, -5000, 800, -1000};

TEST(BigRobotArmFirmware, status_at_boot_shows_the_measured_defaults) {
  Bench bench;
  bench.send(ReadStatus{});
  const Words boot{200, 100, 100, 100, 100};
  EXPECT_EQ(bench.replies(),
            (std::vector<Reply>{Status{Words{}, boot, boot, Gripper{true, 90}, false}}));
}

TEST(BigRobotArmFirmware, goto_answers_its_head_at_once_and_the_rest_after_the_motion) {
  Bench bench;
  bench.send(Goto{kDocumented});
  EXPECT_EQ(bench.output(), (Bytes{0x01, 0x0D, 0x0A}));
  // The elbow's 5000 steps at 3200 steps/s and 3200 steps/s^2.
  EXPECT_EQ(bench.firmware.next_event(), Instant{2'562'500us});
  bench.run_to(2'562'499us);
  EXPECT_TRUE(bench.output().empty());
  bench.run_to(2'562'500us);
  EXPECT_EQ(bench.output().size(), 25U);
  EXPECT_FALSE(bench.firmware.moving());
}

TEST(BigRobotArmFirmware, joints_run_their_own_ramps_and_the_truth_lags_the_report) {
  Bench bench;
  bench.send(Goto{kDocumented});
  bench.run_to(500ms);
  const auto steps = bench.firmware.rotor_steps(bench.now);
  EXPECT_DOUBLE_EQ(steps[0], -0.5 * 6400 * 0.25);
  EXPECT_DOUBLE_EQ(steps[1], 0.5 * 400 * 0.25);
  EXPECT_DOUBLE_EQ(steps[2], -0.5 * 3200 * 0.25);
  EXPECT_DOUBLE_EQ(steps[3], 400);  // half of its way: a triangle of 1 s
  bench.run_to(1s);
  EXPECT_DOUBLE_EQ(bench.firmware.rotor_steps(bench.now)[3], 800);
  bench.run_to_rest();
  const auto end = bench.firmware.rotor_steps(bench.now);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_EQ(end[i], kDocumented[i]);
}

TEST(BigRobotArmFirmware, sync_stretches_every_joint_to_the_slowest) {
  Bench bench;
  bench.send(SetSync{true});
  bench.send(Goto{kDocumented});
  bench.run_to(1'281'250us);
  const auto half = bench.firmware.rotor_steps(bench.now);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(half[i], kDocumented[i] / 2, 1e-6);
  bench.run_to(2'562'400us);
  const auto nearly = bench.firmware.rotor_steps(bench.now);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NE(nearly[i], kDocumented[i]);
}

TEST(BigRobotArmFirmware, bytes_queue_in_motion_up_to_63_and_the_rest_is_lost) {
  Bench bench;
  bench.send(Goto{{0, 0, 5000, 0, 0}});
  for (int i = 0; i < 80; ++i) bench.send(ReadStatus{});
  EXPECT_EQ(bench.firmware.bytes_lost(), 160U - 63U);
  std::vector<Reply> replies = bench.replies();
  EXPECT_EQ(replies, (std::vector<Reply>{MotionStarted{}}));
  bench.run_to(10s);
  replies = bench.replies();
  // 63 bytes are 31 requests with their 0D and a last 08, complete by its length.
  ASSERT_EQ(replies.size(), 1U + 32U);
  EXPECT_EQ(replies[0], (Reply{GotoDone{{0, 0, 5000, 0, 0}}}));
}

TEST(BigRobotArmFirmware, queued_motion_starts_where_the_one_before_ended) {
  Bench bench;
  bench.send(Goto{{0, 0, 5000, 0, 0}});
  bench.send(Home{});
  bench.run_to(5s);
  EXPECT_EQ(bench.firmware.next_event(), Instant{5'125'000us});
  bench.run_to(20s);
  const auto replies = bench.replies();
  ASSERT_EQ(replies.size(), 4U);
  EXPECT_EQ(replies[3], (Reply{HomeDone{}}));
}

TEST(BigRobotArmFirmware, echoes_know_no_limits) {
  Bench bench;
  const Words wild{0, -5, 3000, 330, 2'000'000'000};
  bench.send(SetSpeeds{wild});
  bench.send(SetAccelerations{wild});
  bench.send(SetGripper{true, 255});
  bench.send(SetGripper{false, 40});
  EXPECT_EQ(bench.replies(), (std::vector<Reply>{Speeds{wild}, Accelerations{wild},
                                                 Gripper{true, 255}, Gripper{false, 255}}));
}

TEST(BigRobotArmFirmware, acceleration_zero_is_echoed_and_the_old_one_kept) {
  Bench bench;
  bench.send(SetAccelerations{{0, -3, 0, 0, 0}});
  bench.send(Goto{{0, 0, 5000, 0, 0}});
  EXPECT_EQ(bench.firmware.next_event(), Instant{2'562'500us});
}

TEST(BigRobotArmFirmware, joint_without_speed_never_arrives_but_the_others_do) {
  Bench bench;
  bench.send(SetSpeeds{{0, 100, 100, 100, 100}});
  bench.send(Goto{{0, 400, 0, 0, 0}});
  EXPECT_TRUE(bench.firmware.next_event().has_value()) << "the base need not move";
  bench.run_to_rest();
  bench.send(Goto{{10, 0, 0, 0, 0}});
  EXPECT_FALSE(bench.firmware.next_event().has_value());
  bench.run_to(24h);
  EXPECT_TRUE(bench.firmware.moving());
  EXPECT_NEAR(bench.firmware.rotor_steps(bench.now)[0], 0, 1e-6);
  EXPECT_EQ(bench.firmware.rotor_steps(bench.now)[1], 0);
}

TEST(BigRobotArmFirmware, reset_moves_the_zero_and_not_the_arm) {
  Bench bench;
  bench.send(Goto{kDocumented});
  bench.run_to_rest();
  bench.send(Reset{});
  bench.send(ReadStatus{});
  const auto replies = bench.replies();
  EXPECT_EQ(replies[2], (Reply{ResetDone{}}));
  EXPECT_EQ(std::get<Status>(replies[3]).positions, Words{});
  EXPECT_EQ(bench.firmware.rotor_steps(bench.now)[2], -5000);
  bench.send(Goto{{0, 0, 100, 0, 0}});
  bench.run_to_rest();
  EXPECT_EQ(bench.firmware.rotor_steps(bench.now)[2], -4900);
}

TEST(BigRobotArmFirmware, text_echoes_before_the_motion_and_reports_after_it) {
  Bench bench(BigRobotArmWire::kText);
  bench.send("G0 E5000\r");  // by place: the first word is the base
  EXPECT_EQ(bench.text(), "Free mem: 5214\r\nProcess command: G0 E5000\r\n");
  bench.run_to_rest();
  EXPECT_EQ(bench.text(),
            "BigRobotArm::MOVING-TO\r\nBigRobotArm::POSITION: B5000 S0 E0 WR0 W0\r\n"
            "BigRobotArm::READY\r\n");
  bench.send("G00 X5\r");
  bench.run_to_rest();
  EXPECT_EQ(bench.text(),
            "Free mem: 5214\r\nProcess command: G00 X5\r\nBigRobotArm::MOVING-TO\r\n"
            "BigRobotArm::POSITION: B5 S0 E0 WR0 W0\r\nBigRobotArm::READY\r\n");
  bench.send("g0\r");
  EXPECT_EQ(bench.text(),
            "Free mem: 5214\r\nProcess command: g0\r\nBigRobotArm::INVALID-COMMAND\r\n"
            "BigRobotArm::READY\r\n");
}

TEST(BigRobotArmFirmware, text_home_opens_the_gripper_and_the_byte_home_does_not) {
  Bench text(BigRobotArmWire::kText);
  text.send("G28\r");
  EXPECT_EQ(text.firmware.gripper(), (Gripper{true, 40}));
  Bench byte;
  byte.send(Home{});
  EXPECT_EQ(byte.firmware.gripper(), (Gripper{true, 90}));
}

TEST(BigRobotArmFirmware, documented_sequence_runs_five_times) {
  Bench bench(BigRobotArmWire::kText);
  bench.send("BEGIN I5\r");
  bench.send("G0 B100 S200 E300 WR400 W300\r");
  bench.send("G0 B0 S50 E5000 WR1500 W0\r");
  const std::string recorded = bench.text();
  EXPECT_EQ(recorded.find("POSITION"), std::string::npos);
  bench.send("END\r");
  EXPECT_EQ(bench.text(), "Free mem: 5214\r\nProcess command: END\r\n");
  int motions = 0;
  while (const auto event = bench.firmware.next_event()) {
    ++motions;
    bench.run_to(event->time_since_epoch());
  }
  EXPECT_EQ(motions, 10);
  EXPECT_NE(bench.text().find("POSITION: B0 S50 E5000 WR1500 W0\r\n"), std::string::npos);
  // First the shoulder's 200 steps, a triangle; then nine times the elbow's 4700.
  EXPECT_NEAR(to_seconds(bench.now.time_since_epoch()), std::sqrt(2.0) + 9 * 2.46875, 1e-7);
}

TEST(BigRobotArmFirmware, sequence_holds_twenty_commands_and_eight_bits_of_rounds) {
  Bench bench(BigRobotArmWire::kText);
  bench.send("END\r");
  EXPECT_NE(bench.text().find("INVALID-COMMAND"), std::string::npos);
  bench.send("BEGIN I200\r");
  for (int i = 0; i < 20; ++i) bench.send("G0 B1000\r");
  EXPECT_EQ(bench.text().find("INVALID-COMMAND"), std::string::npos);
  bench.send("G0 B1000\r");
  EXPECT_NE(bench.text().find("INVALID-COMMAND"), std::string::npos);
  bench.send("END\r");
  EXPECT_FALSE(bench.firmware.moving()) << "I200 is -56 rounds";
  EXPECT_NE(bench.text().find("SYNC-MOTORS: 0\r\nBigRobotArm::READY"), std::string::npos);
}

TEST(BigRobotArmFirmware, host_that_does_not_read_loses_no_reply) {
  Bench bench;
  for (int i = 0; i < 80; ++i) bench.send(ReadStatus{});
  std::size_t replies = 0;
  for (int i = 0; i < 4; ++i) {
    replies += bench.replies().size();
    bench.run_to(1s * (i + 1));
  }
  // All that fitted into the output and the input buffer behind it.
  EXPECT_EQ(replies * 2 + bench.firmware.bytes_lost(), 160U + (bench.firmware.bytes_lost() & 1));
}

TEST(BigRobotArmFirmware, any_bytes_are_survived_without_an_allocation) {
  test::for_random_cases(2'000, [](test::Random& random) {
    const auto wire = random.chance(0.5) ? BigRobotArmWire::kByte : BigRobotArmWire::kText;
    BigRobotArmFirmware firmware(arm(wire), Instant{});
    std::array<std::uint8_t, 600> out{};
    std::array<std::uint8_t, 40> bytes{};
    constexpr std::string_view kAlphabet = "G0 28MS153-BEGINEDI\r\r";
    const test::AllocationCounter allocations;
    Instant now{};
    for (int step = 0; step < 50; ++step) {
      for (auto& byte : bytes) {
        const auto letter = static_cast<std::size_t>(random.integer(0, kAlphabet.size() - 1));
        byte = static_cast<std::uint8_t>(wire == BigRobotArmWire::kText ? kAlphabet[letter]
                                         : random.chance(0.5)           ? random.integer(0, 14)
                                                                        : random.integer(0, 255));
      }
      firmware.receive(bytes, now);
      now += Duration{random.integer(0, 20'000'000'000)};
      firmware.advance(now);
      (void)firmware.take_output(out);
    }
    EXPECT_EQ(allocations.count(), 0U);
  });
}

TEST(BigRobotArm, gripper_gets_the_pulses_that_were_measured) {
  Bench bench;
  EXPECT_EQ(bench.firmware.gripper_pulse_us(), 1473) << "at boot, 90";
  const std::vector<std::array<int, 2>> rows{{40, 957}, {0, 545}, {90, 1473}, {255, 2401}};
  for (const auto& [position, pulse] : rows) {
    bench.send(SetGripper{true, static_cast<std::uint8_t>(position)});
    EXPECT_EQ(bench.firmware.gripper_pulse_us(), pulse) << position;
  }
  bench.send(SetGripper{true, 40});
  bench.send(SetGripper{false, 90});
  EXPECT_EQ(bench.firmware.gripper_pulse_us(), 957) << "a disabled one takes no position";
}

}  // namespace
}  // namespace sinew
