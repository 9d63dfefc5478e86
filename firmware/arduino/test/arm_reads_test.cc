#include <SinewMaxArm.h>
#include <gtest/gtest.h>

#include "arm_line.h"
#include "host/virtual_clock.h"
#include "sinew/core/units.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::arduino {
namespace {

using namespace std::chrono_literals;
using Chunk = ArmLine::Chunk;

constexpr Duration kReadMax = 4500ms;

struct Bench {
  explicit Bench(MaxArmChecksum checksum = MaxArmChecksum::kSpec,
                 MaxArmVariant variant = MaxArmVariant::kArduino)
      : line(checksum, variant) {}

  MaxArmResult read() {
    const Instant before = now();
    const MaxArmResult result = arm.read_pulses(pulses);
    took = now() - before;
    EXPECT_LE(took, kReadMax);
    return result;
  }
  /// The servos' pulses were read.
  void expect_actual() const {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(pulses[i], line.pulse(i), 0.6);
  }

  ArmLine line;
  SinewMaxArm arm{line};
  std::int16_t pulses[3] = {};
  Duration took{};
};

/// Bytes that arrive right before `chunk`.
void put_before(Chunk& chunk, const std::vector<std::uint8_t>& bytes) {
  const Instant due = chunk.front().due;
  Chunk all;
  for (const std::uint8_t byte : bytes) all.push_back({byte, due});
  all.insert(all.end(), chunk.begin(), chunk.end());
  chunk = all;
}

TEST(ArduinoReads, both_programs_with_both_checksums_are_read) {
  for (const auto variant : {MaxArmVariant::kArduino, MaxArmVariant::kMicroPython}) {
    for (const auto checksum : {MaxArmChecksum::kSpec, MaxArmChecksum::kWithHeader}) {
      for (const bool blocking : {false, true}) {
        Bench bench(checksum, variant);
        bench.line.blocking = blocking;
        const bool spec = checksum == MaxArmChecksum::kSpec;
        EXPECT_EQ(bench.arm.checksum(), ReplyChecksum::kUnknown);
        for (int i = 0; i < 10; ++i) {
          ASSERT_TRUE(bench.read());
          EXPECT_LE(bench.took, 700ms);
          bench.expect_actual();
        }
        EXPECT_EQ(bench.arm.checksum(), spec ? ReplyChecksum::kSpec : ReplyChecksum::kWithHeader);
        EXPECT_EQ(bench.arm.checksum_changes(), 0);
        std::int16_t xyz[3];
        ASSERT_TRUE(bench.arm.read_xyz(xyz));
        EXPECT_NEAR(xyz[0], 0, 1);
        EXPECT_NEAR(xyz[1], -162, 2);
        EXPECT_NEAR(xyz[2], 212, 2);
      }
    }
  }
}

TEST(ArduinoReads, angles_are_exact_as_float_and_rounded_as_whole_numbers) {
  Bench bench;
  bench.line.from_arm = [](Chunk& chunk) {
    const auto golden =
        maxarm::encode_reply(maxarm::Angles{{864, 410, 712}}, maxarm::Checksum::kSpec);
    for (std::size_t i = 0; i < golden.size(); ++i) chunk[i].byte = golden[i];
  };
  float exact[3];
  std::int16_t rounded[3];
  ASSERT_TRUE(bench.arm.read_angles(exact));
  ASSERT_TRUE(bench.arm.read_angles(rounded));
  EXPECT_NEAR(exact[0], 207.36, 1e-4);
  EXPECT_NEAR(exact[1], 98.4, 1e-4);
  EXPECT_NEAR(exact[2], 170.88, 1e-4);
  EXPECT_EQ(rounded[0], 207);
  EXPECT_EQ(rounded[1], 98);
  EXPECT_EQ(rounded[2], 171) << "the maker's code cuts it to 170";
}

TEST(ArduinoReads, changed_checksum_is_reported_and_the_read_succeeds) {
  Bench bench;
  ASSERT_TRUE(bench.read());
  ASSERT_TRUE(bench.read());
  bench.line.exchange(MaxArmChecksum::kWithHeader, MaxArmVariant::kArduino);
  ASSERT_TRUE(bench.read());
  EXPECT_EQ(bench.arm.checksum(), ReplyChecksum::kWithHeader);
  EXPECT_EQ(bench.arm.checksum_changes(), 1);
  ASSERT_TRUE(bench.read());
  EXPECT_LE(bench.took, 700ms);
  EXPECT_EQ(bench.arm.checksum_changes(), 1);
}

TEST(ArduinoReads, flipped_bit_that_looks_like_the_other_checksum_is_noise) {
  Bench bench;
  ASSERT_TRUE(bench.read());
  ASSERT_TRUE(bench.read());
  int replies = 0;
  bench.line.from_arm = [&](Chunk& chunk) {
    if (replies++ > 0) return;
    // One flipped bit: 500 becomes 501, and the sum that of AA 55 as well.
    EXPECT_EQ(chunk[4].byte, 0xF4);
    chunk[4].byte = 0xF5;
  };
  ASSERT_TRUE(bench.read());
  bench.expect_actual();
  EXPECT_EQ(bench.arm.checksum(), ReplyChecksum::kSpec);
  EXPECT_EQ(bench.arm.checksum_changes(), 0);
}

TEST(ArduinoReads, any_lost_byte_of_a_reply_costs_time_only) {
  for (std::size_t lost = 0; lost < 11; ++lost) {
    Bench bench;
    int replies = 0;
    bench.line.from_arm = [&](Chunk& chunk) {
      if (replies++ == 0) chunk.erase(chunk.begin() + static_cast<long>(lost));
    };
    ASSERT_TRUE(bench.read()) << lost;
    EXPECT_LE(bench.took, 2500ms);
    bench.expect_actual();
    bench.line.from_arm = nullptr;
    ASSERT_TRUE(bench.read());
    EXPECT_LE(bench.took, 700ms);
  }
}

TEST(ArduinoReads, any_lost_byte_of_a_question_costs_time_only) {
  for (const auto variant : {MaxArmVariant::kArduino, MaxArmVariant::kMicroPython}) {
    for (std::size_t lost = 0; lost < 5; ++lost) {
      Bench bench(MaxArmChecksum::kSpec, variant);
      int writes = 0;
      bench.line.to_arm = [&](Chunk& chunk) {
        if (writes++ == 0) chunk.erase(chunk.begin() + static_cast<long>(lost));
      };
      ASSERT_TRUE(bench.read()) << lost;
      bench.expect_actual();
    }
  }
}

TEST(ArduinoReads, noise_before_a_reply_loses_nothing) {
  const std::vector<std::string> noises{
      "AA",
      "AA AA",
      "AA 55",
      "AA 55 11",
      "AA 55 11 06",
      "AA 55 11 06 77 00 FF",
      "AA 55 11 05 AA 55 11 05 AA 55 11 05 AA 55 11 05 AA 55 11 05 AA 55 11 05 AA 55 11 06 77"};
  for (const std::string& noise : noises) {
    Bench bench;
    bench.line.from_arm = [&](Chunk& chunk) { put_before(chunk, test::from_hex(noise)); };
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(bench.read()) << noise;
      EXPECT_LE(bench.took, 700ms);
      bench.expect_actual();
    }
  }
}

TEST(ArduinoReads, late_reply_is_never_mistaken_for_a_new_one) {
  // The first reply comes 300 ms behind the deadline, and says where the arm was.
  Bench bench;
  std::int16_t before[3];
  ASSERT_TRUE(bench.arm.read_pulses(before));
  int replies = 0;
  bench.line.from_arm = [&](Chunk& chunk) {
    if (replies++ > 0) return;
    for (TimedByte& timed : chunk) timed.due += 900ms;
  };
  int writes = 0;
  bench.line.to_arm = [&](Chunk&) {
    if (++writes != 2) return;
    // The arm moves between the first question and the second.
    bench.line.machine().receive(maxarm::encode_request(maxarm::SetAngle{{300, 500, 500}, 20}),
                                 now());
  };
  ASSERT_TRUE(bench.read());
  EXPECT_NEAR(before[0], 500, 1);
  EXPECT_LT(bench.pulses[0], 490) << "the stale reply says 500";
}

TEST(ArduinoReads, reply_behind_the_last_deadline_is_ignored_by_the_next_call) {
  Bench bench;
  bool late = true;
  std::vector<TimedByte> kept;
  bench.line.from_arm = [&](Chunk& chunk) {
    if (!late) return;
    kept = chunk;
    chunk.clear();
  };
  EXPECT_EQ(bench.read().error, MaxArmError::kNoReply);
  late = false;
  const std::int16_t moved[3] = {300, 500, 500};
  ASSERT_TRUE(bench.arm.set_pulses(moved, 500));
  delay(1500);
  // It arrives together with the next reply.
  bool given = false;
  bench.line.from_arm = [&](Chunk& chunk) {
    if (given) return;
    given = true;
    std::vector<std::uint8_t> stale;
    for (const TimedByte& timed : kept) stale.push_back(timed.byte);
    put_before(chunk, stale);
  };
  ASSERT_TRUE(bench.read());
  EXPECT_NEAR(bench.pulses[0], 300, 2);
}

TEST(ArduinoReads, unsolicited_reply_is_dropped) {
  Bench bench;
  for (const char* stale : {"AA 55 11 06 60 03 9A 01 C9 02 1F", "AA 55 11 06 60 03 9A"}) {
    bench.line.put_unsolicited(test::from_hex(stale));
    ASSERT_TRUE(bench.read());
    bench.expect_actual();
  }
}

TEST(ArduinoReads, silence_noise_and_an_endless_line_end_in_time_with_a_reason) {
  Bench silent;
  silent.line.from_arm = [](Chunk& chunk) { chunk.clear(); };
  EXPECT_EQ(silent.read().error, MaxArmError::kNoReply);
  EXPECT_GE(silent.took, 2s) << "three tries";
  Bench noisy;
  noisy.line.from_arm = [](Chunk& chunk) {
    for (TimedByte& timed : chunk) timed.byte ^= 0x15U;
  };
  EXPECT_EQ(noisy.read().error, MaxArmError::kBadReply);
  for (const int byte : {0x00, 0x55, 0xAA, 0xFF}) {
    Bench babbling;
    babbling.line.babble = static_cast<std::uint8_t>(byte);
    EXPECT_EQ(babbling.arm.read_pulses(babbling.pulses).error, MaxArmError::kBadReply);
    EXPECT_LE(now() - (Instant{} + 20s), 6s);
  }
}

TEST(ArduinoReads, deaf_micropython_program_is_woken) {
  // A frame that is cut by the program's look at its port makes it deaf to questions.
  Bench bench(MaxArmChecksum::kWithHeader, MaxArmVariant::kMicroPython);
  const auto part = test::from_hex("AA 55 01 08 C8 00 F4");
  bench.line.write(part.data(), part.size());
  bench.line.wait(250ms);
  ASSERT_TRUE(bench.read());
  bench.expect_actual();
}

TEST(ArduinoReads, dead_servo_is_named) {
  Bench bench;
  bench.line.machine().disturb({sim::Disturbance::Kind::kMagnet, 1, 0});
  const MaxArmResult result = bench.read();
  EXPECT_EQ(result.error, MaxArmError::kServoFault);
  EXPECT_EQ(result.joint, 2);
  EXPECT_EQ(result.value, -1);
  EXPECT_LE(bench.took, 1500ms);
}

TEST(ArduinoReads, reply_that_waits_for_the_nozzle_is_awaited) {
  Bench bench;
  ASSERT_TRUE(bench.arm.set_pwmservo(45, 2000));
  const Instant before = now();
  ASSERT_TRUE(bench.arm.read_pulses(bench.pulses));
  EXPECT_GE(now() - before, 1900ms);
  EXPECT_LE(now() - before, 2500ms);
  EXPECT_EQ(bench.line.writes.size(), 2U) << "one question";
  Bench python(MaxArmChecksum::kSpec, MaxArmVariant::kMicroPython);
  ASSERT_TRUE(python.arm.set_pwmservo(45, 2000));
  ASSERT_TRUE(python.read());
  EXPECT_LE(python.took, 700ms) << "this program replies during the turn";
}

TEST(ArduinoReads, questions_are_125_ms_apart_however_fast_the_arm_replies) {
  Bench bench;
  bench.line.from_arm = [](Chunk& chunk) { chunk.clear(); };
  bench.line.to_arm = [&](Chunk&) {
    bench.line.put_unsolicited(test::from_hex("AA 55 11 06 F4 01 F4 01 F4 01 09"));
  };
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(bench.read());
  for (std::size_t i = 1; i < bench.line.writes.size(); ++i) {
    EXPECT_GE(bench.line.writes[i].at - bench.line.writes[i - 1].at, 124ms);
  }
}

TEST(ArduinoReads, halt_stops_the_arm_where_it_is) {
  for (const auto variant : {MaxArmVariant::kArduino, MaxArmVariant::kMicroPython}) {
    Bench bench(MaxArmChecksum::kSpec, variant);
    ASSERT_TRUE(bench.arm.move_to(150, -150, 120, 1000));
    delay(1500);
    ASSERT_TRUE(bench.arm.move_to(-150, -150, 120, 5000));
    delay(1000);
    const Instant before = now();
    ASSERT_TRUE(bench.arm.halt());
    EXPECT_LE(now() - before, 700ms);
    bench.line.wait(500ms);
    const double at = bench.line.pulse(0);
    EXPECT_GT(at, 330) << "it had left 312";
    EXPECT_LT(at, 500) << "the target was 687";
    EXPECT_FALSE(bench.line.machine().truth().moving);
    bench.line.wait(5s);
    EXPECT_NEAR(bench.line.pulse(0), at, 0.5);
    EXPECT_TRUE(bench.arm.at_target());
  }
}

TEST(ArduinoReads, halt_never_sends_pulse_0) {
  Bench bench;
  bench.line.from_arm = [](Chunk& chunk) {
    const auto reply =
        maxarm::encode_reply(maxarm::Angles{{0, 1000, 499}}, maxarm::Checksum::kSpec);
    for (std::size_t i = 0; i < reply.size(); ++i) chunk[i].byte = reply[i];
  };
  ASSERT_TRUE(bench.arm.halt());
  const auto sent = maxarm::encode_request(maxarm::SetAngle{{1, 1000, 499}, 100});
  EXPECT_EQ(bench.line.writes.back().bytes, std::vector<std::uint8_t>(sent.begin(), sent.end()));
}

TEST(ArduinoReads, halt_fails_where_the_arm_does_not_reply) {
  Bench bench;
  bench.line.from_arm = [](Chunk& chunk) { chunk.clear(); };
  EXPECT_EQ(bench.arm.halt().error, MaxArmError::kNoReply);
}

TEST(ArduinoReads, random_faults_never_give_a_wrong_position) {
  int succeeded = 0;
  test::for_random_cases(400, [&](test::Random& random) {
    Bench bench(random.chance(0.5) ? MaxArmChecksum::kSpec : MaxArmChecksum::kWithHeader,
                random.chance(0.5) ? MaxArmVariant::kArduino : MaxArmVariant::kMicroPython);
    bench.line.blocking = random.chance(0.5);
    ASSERT_TRUE(bench.read());
    ASSERT_TRUE(bench.read());
    const double loss = random.uniform(0, 0.03);
    const auto lose = [&](Chunk& chunk) {
      std::erase_if(chunk, [&](const TimedByte&) { return random.chance(loss); });
      if (random.chance(0.1) && !chunk.empty()) chunk[random.bits() % chunk.size()].byte ^= 4U;
    };
    bench.line.from_arm = lose;
    bench.line.to_arm = lose;
    for (int i = 0; i < 5; ++i) {
      if (!bench.read()) continue;
      bench.expect_actual();
      ++succeeded;
    }
  });
  EXPECT_GT(succeeded, 1500);
}

}  // namespace
}  // namespace sinew::arduino
