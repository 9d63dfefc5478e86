#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace bigrobotarm;
using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

BigRobotArmDevice arm(BigRobotArmWire wire, BigRobotArmDialect dialect) {
  BigRobotArmDevice settings;
  constexpr std::array<double, kJoints> kStepsPerRev{3200, 400, 3200, 3200, 3200};
  for (std::size_t i = 0; i < kJoints; ++i) {
    settings.joints[i].steps_per_motor_rev = kStepsPerRev[i];
  }
  settings.joints[0].multiplier_boot = 200;
  settings.wire = wire;
  settings.dialect = dialect;
  return settings;
}

/// The device as the firmware was seen to behave.
struct Bench {
  explicit Bench(BigRobotArmWire wire = BigRobotArmWire::kByte,
                 BigRobotArmDialect dialect = BigRobotArmDialect::k2021)
      : firmware(arm(wire, dialect), Instant{}, BigRobotArmProfile::kAsBuilt) {}

  void send(const Request& request) {
    const auto bytes = byte::encode_request(request);
    firmware.receive(bytes, now);
    firmware.receive(std::array{byte::kTerminator}, now);
  }
  void send(const Bytes& bytes) { firmware.receive(bytes, now); }
  void send(const std::string& lines) {
    firmware.receive({reinterpret_cast<const std::uint8_t*>(lines.data()), lines.size()}, now);
  }
  void run_to(Duration since_boot) {
    now = Instant{since_boot};
    firmware.advance(now);
  }
  void run_to_rest() {
    for (int i = 0; i < 100 && firmware.next_event(); ++i) {
      run_to(firmware.next_event()->time_since_epoch());
    }
  }
  Words steps() const {
    Words words{};
    const auto rotor = firmware.rotor_steps(now);
    for (std::size_t i = 0; i < kJoints; ++i) {
      words[i] = static_cast<std::int32_t>(std::lround(rotor[i]));
    }
    return words;
  }
  std::string text() {
    std::string all;
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = firmware.take_output(piece)) {
      all.append(piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
    return all;
  }
  std::vector<Reply> replies() {
    std::vector<Reply> all;
    for (const char character : text()) {
      const auto reply = decoder.push(static_cast<std::uint8_t>(character));
      if (reply) all.push_back(reply->value());
    }
    return all;
  }
  double seconds() const { return to_seconds(now.time_since_epoch()); }

  BigRobotArmFirmware firmware;
  byte::ReplyDecoder decoder;
  Instant now{};
};

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(BigRobotArmAsBuilt, byte_0d_inside_a_goto_cuts_it_and_the_tail_is_answered_too) {
  Bench bench;
  bench.send(Goto{{13, 0, 0, 0, 0}});
  bench.run_to_rest();
  EXPECT_EQ(bench.replies(), (std::vector<Reply>{MotionStarted{}, GotoDone{}, Invalid{}}));
  bench.send(Goto{{3400, 0, 0, 0, 0}});  // 48 0d 00 00
  bench.run_to_rest();
  EXPECT_EQ(bench.steps()[0], 72);
}

TEST(BigRobotArmAsBuilt, value_269_starts_a_second_goto_far_out_of_reach) {
  Bench bench;
  bench.send(Goto{{100, 10, 269, 50, 50}});
  bench.run_to(3s);
  // The first one, cut, is over; the tail 01 00 00 32 .. is a goto of its own.
  EXPECT_TRUE(bench.firmware.moving());
  EXPECT_EQ(bench.firmware.targets(), (Words{3276800, 3276800, 0, 0, 0}));
  bench.run_to(300s);
  EXPECT_GT(bench.steps()[0], 500'000);
}

TEST(BigRobotArmAsBuilt, speed_269_sets_all_to_zero_and_hangs_in_its_tail) {
  Bench bench;
  bench.send(SetSpeeds{{269, 100, 100, 100, 100}});
  bench.run_to(1h);
  EXPECT_TRUE(bench.firmware.moving());
  EXPECT_FALSE(bench.firmware.next_event().has_value());
  bench.send(ReadStatus{});
  bench.run_to(2h);
  EXPECT_EQ(bench.replies(), (std::vector<Reply>{Speeds{}, MotionStarted{}}));
  bench.firmware.reset(bench.now);
  bench.decoder.reset();
  bench.send(ReadStatus{});
  EXPECT_EQ(bench.replies().size(), 1U) << "only a reset helps";
}

TEST(BigRobotArmAsBuilt, short_goto_goes_to_zeros) {
  Bench bench;
  bench.send(Goto{{0, 0, 5000, 0, 0}});
  bench.run_to_rest();
  bench.send(Bytes{0x01, 0x0D});
  bench.run_to_rest();
  EXPECT_EQ(bench.steps(), Words{});
  bench.send(Bytes{0x01, 0x64, 0x0D});
  bench.run_to_rest();
  EXPECT_EQ(bench.steps()[0], 100);
}

TEST(BigRobotArmAsBuilt, surplus_is_ignored_and_a_line_feed_is_data) {
  Bench bench;
  bench.send(Bytes{0x07, 0x00, 0x55, 0x0D, 0x07, 0x00, 0x0D, 0x0A, 0x08, 0x0D});
  EXPECT_EQ(bench.replies(), (std::vector<Reply>{Sync{}, Sync{}, Invalid{}}));
}

TEST(BigRobotArmAsBuilt, sync_and_async_motions_add_and_only_one_is_reported) {
  Bench bench;
  bench.send(SetSync{true});
  bench.send(Goto{{2000, 0, 0, 0, 0}});
  bench.run_to_rest();
  bench.send(SetSync{false});
  bench.send(Goto{{1000, 0, 0, 0, 0}});
  bench.run_to_rest();
  const auto replies = bench.replies();
  EXPECT_EQ(replies[2], Reply{GotoDone{}}) << "a sync goto tells the old targets";
  EXPECT_EQ(replies[5], (Reply{GotoDone{{1000, 0, 0, 0, 0}}}));
  EXPECT_EQ(bench.steps()[0], 3000);
  bench.send(Reset{});
  bench.send(SetSync{true});
  bench.send(Goto{{2000, 0, 0, 0, 0}});
  EXPECT_FALSE(bench.firmware.moving()) << "reset knows nothing of the other frame";
}

TEST(BigRobotArmAsBuilt, reported_word_has_only_the_sign_in_its_top_byte) {
  Bench bench;
  bench.send(SetAccelerations{{20'000'000, -20'000'000, 5, -5, 100}});
  EXPECT_EQ(
      bench.replies()[0],
      (Reply{Accelerations{{0x00312D00, static_cast<std::int32_t>(0xFFCED300U), 5, -5, 100}}}));
}

TEST(BigRobotArmAsBuilt, echo_is_one_less_for_the_measured_multipliers_and_right_for_the_others) {
  std::vector<std::int32_t> cut;
  const auto echo = [](std::int32_t value) {
    Bench bench;
    bench.send(SetSpeeds{{value, value, value, value, value}});
    return std::get<Speeds>(bench.replies()[0]).speeds;
  };
  for (std::int32_t value = 1; value <= 520; value += value < 40 ? 1 : 7) {
    if (!byte::sendable(value)) continue;
    const Words echoed = echo(value);
    if (echoed[0] != value) cut.push_back(value);
    for (const std::int32_t word : echoed) EXPECT_EQ(word, value - (echoed[0] == value ? 0 : 1));
  }
  // Swept as on the firmware; 499 was seen beside it.
  EXPECT_EQ(cut, (std::vector<std::int32_t>{117, 236, 418, 474, 495}));
  EXPECT_EQ(echo(499)[2], 498);
}

TEST(BigRobotArmAsBuilt, documented_goto_takes_the_time_that_was_measured) {
  Bench bench;
  const Words target{-2400, 600, -5000, 800, -1000};
  bench.send(Goto{target});
  std::array<double, kJoints> arrived{};
  for (int tick = 0; bench.firmware.moving(); ++tick) {
    bench.run_to(tick * 5ms);
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (arrived[i] == 0 && bench.steps()[i] == target[i]) arrived[i] = bench.seconds();
    }
  }
  constexpr std::array<double, kJoints> kMeasured{2.12, 2.60, 3.405, 1.19, 1.39};  // s
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(arrived[i], kMeasured[i], 0.065 * kMeasured[i]) << i;
  }
}

TEST(BigRobotArmAsBuilt, step_rates_end_where_the_processor_does) {
  const auto rate = [](std::size_t motors) {
    Bench bench;
    Words speeds{300, 2000, 300, 300, 300};
    Words target{};
    for (std::size_t i = 0; i < motors; ++i) target[i] = 20'000;
    bench.send(SetSpeeds{speeds});
    bench.send(SetAccelerations{{3000, 3000, 3000, 3000, 3000}});
    bench.send(Goto{target});
    bench.run_to(2s);
    const double before = bench.steps()[0];
    bench.run_to(4s);
    return (bench.steps()[0] - before) / 2;
  };
  EXPECT_NEAR(rate(1), 3450, 0.065 * 3450);
  EXPECT_NEAR(rate(4), 1300, 0.065 * 1300);
  EXPECT_NEAR(rate(5), 1010, 0.065 * 1010);
}

TEST(BigRobotArmAsBuilt, sync_motion_of_five_takes_3_18_s_instead_of_2) {
  Bench bench;
  bench.send(SetSync{true});
  bench.send(Goto{{12800, 800, 6400, 6400, 6400}});
  bench.run_to_rest();
  EXPECT_NEAR(bench.seconds(), 3.18, 0.01 * 3.18);
  bench.send(Goto{{12800 + 6400, 800, 6400, 6400, 6400}});
  const double start = bench.seconds();
  bench.run_to_rest();
  EXPECT_NEAR(6400 / (bench.seconds() - start), 5600, 0.01 * 5600) << "one motor alone";
}

TEST(BigRobotArmAsBuilt, speed_zero_makes_one_step_and_hangs) {
  Bench bench;
  bench.send(SetSpeeds{{0, 100, 100, 100, 100}});
  bench.send(Goto{{500, 0, 0, 0, 0}});
  bench.run_to(1h);
  EXPECT_EQ(bench.steps()[0], 1);
  EXPECT_TRUE(bench.firmware.moving());
}

TEST(BigRobotArmAsBuilt, end_without_begin_kills_2021_and_is_invalid_in_2026) {
  Bench old(BigRobotArmWire::kText);
  old.send("END\r");
  (void)old.text();
  old.send("M503\r");
  old.run_to(1h);
  EXPECT_EQ(old.text(), "");
  Bench young(BigRobotArmWire::kText, BigRobotArmDialect::k2026);
  young.send("END\rM503\r");
  EXPECT_EQ(count_of(young.text(), "BigRobotArm::READY\r\n"), 2U);
}

TEST(BigRobotArmAsBuilt, dialect_of_2026_clamps_multipliers_and_echoes_no_unknown_line) {
  Bench bench(BigRobotArmWire::kText, BigRobotArmDialect::k2026);
  bench.send("M203 B0 S-3 E501 WR500 W3000\r");
  EXPECT_NE(bench.text().find("SPEED: B1 S1 E500 WR500 W500"), std::string::npos);
  bench.send("nonsense\r");
  EXPECT_EQ(bench.text(), "BigRobotArm::INVALID-COMMAND\r\nBigRobotArm::READY\r\n");
  Bench old(BigRobotArmWire::kText);
  old.send("M203 B0 S-3 E501 WR500 W3000\r");
  EXPECT_NE(old.text().find("SPEED: B0 S-3 E501 WR500 W3000"), std::string::npos);
  old.send("Q0 B100\r");
  EXPECT_NE(old.text().find("INVALID-COMMAND"), std::string::npos) << "no queue before 2026";
}

TEST(BigRobotArmAsBuilt, queue_takes_four_behind_the_running_one_and_still_listens) {
  Bench bench(BigRobotArmWire::kText, BigRobotArmDialect::k2026);
  for (int i = 1; i <= 6; ++i) bench.send("Q0 B" + std::to_string(1000 * i) + "\r");
  const std::string told = bench.text();
  EXPECT_EQ(count_of(told, "QUEUED-TO"), 5U);
  EXPECT_EQ(count_of(told, "QUEUE-FULL"), 1U);
  EXPECT_NE(told.find("QUEUED-TO\r\nBigRobotArm::POSITION: B5000 S0 E0 WR0 W0"), std::string::npos);
  bench.send("QFLUSH\r");
  EXPECT_EQ(count_of(bench.text(), "READY"), 0U);
  bench.run_to_rest();
  EXPECT_EQ(bench.steps()[0], 5000);
  EXPECT_EQ(count_of(bench.text(), "QUEUE-DRAINED\r\nBigRobotArm::READY"), 1U);
}

TEST(BigRobotArmAsBuilt, clearing_the_queue_does_not_stop_the_running_motion) {
  Bench bench(BigRobotArmWire::kText, BigRobotArmDialect::k2026);
  bench.send("Q0 B1000\rQ0 B2000\rQCLEAR\rG0 B1000 S100\r");
  const std::string told = bench.text();
  EXPECT_EQ(count_of(told, "QUEUE-CLEARED\r\nBigRobotArm::READY"), 1U);
  EXPECT_EQ(count_of(told, "MOVING-TO"), 0U) << "a goto waits for the queue";
  bench.run_to_rest();
  EXPECT_EQ(bench.steps(), (Words{1000, 100, 0, 0, 0}));
  EXPECT_EQ(count_of(bench.text(), "MOVING-TO"), 1U);
}

TEST(BigRobotArmAsBuilt, ramped_motion_behind_a_level_one_runs_on_first_in_2026) {
  Bench bench(BigRobotArmWire::kText, BigRobotArmDialect::k2026);
  bench.send("S1\rG0 B50 S100 E150 WR200 W150\r");
  bench.run_to_rest();
  EXPECT_EQ(bench.steps(), (Words{50, 100, 150, 200, 150}));
  bench.send("S0\rG0 B0 S0 E0 WR0 W0\r");
  Words most{};
  while (bench.firmware.moving()) {
    bench.run_to(bench.now.time_since_epoch() + 5ms);
    for (std::size_t i = 0; i < kJoints; ++i) most[i] = std::max(most[i], bench.steps()[i]);
  }
  EXPECT_EQ(bench.steps(), Words{});
  // Seen on the firmware: 300 each.
  EXPECT_NEAR(most[1], 300, 4);
  EXPECT_NEAR(most[3], 300, 4);
  Bench old(BigRobotArmWire::kText);
  old.send("S1\rG0 B50 S100 E150 WR200 W150\r");
  old.run_to_rest();
  old.send("S0\rG0 B0 S0 E0 WR0 W0\r");
  EXPECT_FALSE(old.firmware.moving()) << "2021: its own frame never left zero";
}

TEST(BigRobotArmAsBuilt, reset_stops_where_it_is_and_counts_from_there) {
  Bench bench;
  bench.send(Goto{{0, 0, 5000, 0, 0}});
  bench.run_to(1s);
  const Words here = bench.steps();
  EXPECT_GT(here[2], 500);
  bench.firmware.reset(bench.now, 1s);
  bench.send(ReadStatus{});
  bench.run_to(3s);
  EXPECT_EQ(bench.firmware.bytes_lost(), 2U) << "its boot loader listened";
  (void)bench.text();
  bench.send(ReadStatus{});
  EXPECT_EQ(std::get<Status>(bench.replies()[0]).positions, Words{});
  EXPECT_EQ(bench.steps(), here);
}

TEST(BigRobotArmAsBuilt, any_bytes_are_survived_without_an_allocation) {
  test::for_random_cases(500, [](test::Random& random) {
    const auto wire = random.chance(0.5) ? BigRobotArmWire::kByte : BigRobotArmWire::kText;
    const auto dialect = random.chance(0.5) ? BigRobotArmDialect::k2021 : BigRobotArmDialect::k2026;
    BigRobotArmFirmware firmware(arm(wire, dialect), Instant{}, BigRobotArmProfile::kAsBuilt);
    std::array<std::uint8_t, 600> out{};
    std::array<std::uint8_t, 40> bytes{};
    constexpr std::string_view kAlphabet = "GQ0 28MS153-BEGINEDIFLUSH\r\r";
    const test::AllocationCounter allocations;
    Instant now{};
    for (int step = 0; step < 40; ++step) {
      for (auto& byte : bytes) {
        const auto letter = static_cast<std::size_t>(random.integer(0, kAlphabet.size() - 1));
        byte = static_cast<std::uint8_t>(random.integer(0, random.chance(0.7) ? 14 : 255));
        if (wire == BigRobotArmWire::kText) byte = static_cast<std::uint8_t>(kAlphabet[letter]);
      }
      firmware.receive(bytes, now);
      now += Duration{random.integer(0, 20'000'000'000)};
      firmware.advance(now);
      for (const double steps : firmware.rotor_steps(now)) ASSERT_TRUE(std::isfinite(steps));
      (void)firmware.take_output(out);
    }
    EXPECT_EQ(allocations.count(), 0U);
  });
}

}  // namespace
}  // namespace sinew
