#include "sinew/devices/bigrobotarm/bigrobotarm_driver_probe.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_test_cell.h"

namespace sinew {
namespace {

using namespace bigrobotarm;
using namespace std::chrono_literals;

struct Line {
  BigRobotArmWire wire;
  BigRobotArmDialect dialect;
  BigRobotArmProfile profile;
};

const std::vector<Line>& lines() {
  static const std::vector<Line> all = [] {
    std::vector<Line> made;
    for (const auto profile : {BigRobotArmProfile::kDocument, BigRobotArmProfile::kAsBuilt}) {
      made.push_back({BigRobotArmWire::kByte, BigRobotArmDialect::k2021, profile});
      made.push_back({BigRobotArmWire::kText, BigRobotArmDialect::k2021, profile});
      made.push_back({BigRobotArmWire::kText, BigRobotArmDialect::k2026, profile});
    }
    return made;
  }();
  return all;
}

/// A probe and a firmware, back to back.
struct Bench {
  explicit Bench(const Line& line)
      : firmware(
            test::big_robot_arm(line.wire, line.dialect).device.settings.get<BigRobotArmDevice>(),
            Instant{}, line.profile) {}

  void send(const std::string& bytes) {
    firmware.receive({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, now);
  }
  std::size_t drop_answers() {
    std::array<std::uint8_t, 64> piece{};
    std::size_t all = 0;
    while (const std::size_t count = firmware.take_output(piece)) all += count;
    return all;
  }
  void run(Duration duration) {
    const Instant end = now + duration;
    std::array<std::uint8_t, 64> piece{};
    for (int round = 0; round < 20'000; ++round) {
      while (const std::size_t count = probe.take_output(piece)) {
        asked.insert(asked.end(), piece.begin(), piece.begin() + static_cast<long>(count));
        firmware.receive(std::span(piece.data(), count), now);
      }
      while (const std::size_t count = firmware.take_output(piece)) {
        probe.receive(std::span(piece.data(), count), now);
      }
      if (now >= end) return;
      Instant next = end;
      if (const auto due = probe.next_deadline()) next = std::min(next, *due);
      if (const auto due = firmware.next_event()) next = std::min(next, *due);
      now = std::max(now, next);
      firmware.advance(now);
      probe.poll(now);
    }
    FAIL() << "they keep each other awake";
  }
  Words steps() const {
    Words words{};
    const auto rotor = firmware.rotor_steps(now);
    for (std::size_t i = 0; i < kJoints; ++i) {
      words[i] = static_cast<std::int32_t>(std::lround(rotor[i]));
    }
    return words;
  }

  BigRobotArmFirmware firmware;
  BigRobotArmProbe probe;
  Instant now{};
  std::vector<std::uint8_t> asked;
};

std::string as_bytes(const Request& request, const Line& line) {
  if (line.wire == BigRobotArmWire::kText) {
    const auto words = text::encode_line({request});
    return std::string(text::view(words)) + '\r';
  }
  const auto bytes = byte::encode_request(request);
  return std::string(bytes.begin(), bytes.end()) + '\r';
}

/// What may have happened to a device before somebody asks who it is. True: it will answer in the
/// ordinary way.
using Past = std::function<void(Bench&, const Line&)>;

const std::vector<std::pair<std::string, Past>>& pasts() {
  static const std::vector<std::pair<std::string, Past>> all{
      {"fresh", [](Bench&, const Line&) {}},
      {"moved",
       [](Bench& bench, const Line& line) {
         bench.send(as_bytes(Goto{{100, 200, 300, 400, 500}}, line));
         bench.run(20s);
       }},
      {"in motion",
       [](Bench& bench, const Line& line) {
         bench.send(as_bytes(Goto{{100, 200, 5000, 400, 500}}, line));
         bench.run(300ms);
       }},
      {"answers unread",
       [](Bench& bench, const Line& line) {
         bench.send(as_bytes(ReadStatus{}, line) + as_bytes(SetGripper{true, 40}, line));
       }},
      {"in sync mode",
       [](Bench& bench, const Line& line) {
         bench.send(as_bytes(SetSync{true}, line) + as_bytes(Goto{{50, 50, 50, 50, 50}}, line));
         bench.run(20s);
       }},
      {"other values",
       [](Bench& bench, const Line& line) {
         bench.send(as_bytes(SetSpeeds{{1, 2, 3, 4, 5}}, line) +
                    as_bytes(SetGripper{false, 200}, line));
         bench.run(1s);
       }},
      {"with an unknown command behind it",
       [](Bench& bench, const Line&) {
         bench.send("\x7F\x55 nonsense\r");
         bench.run(1s);
       }},
  };
  return all;
}

TEST(BigRobotArmProbe, every_device_is_recognised_in_every_state_and_none_moves) {
  for (const Line& line : lines()) {
    for (const auto& [name, past] : pasts()) {
      Bench bench(line);
      past(bench, line);
      (void)bench.drop_answers();
      const bool moving = bench.firmware.moving();
      const Words targets = bench.firmware.targets();
      const Words steps = bench.steps();
      bench.probe.open(bench.now);
      bench.run(60s);
      ASSERT_TRUE(bench.probe.found()) << name;
      EXPECT_EQ(bench.probe.found()->wire, line.wire) << name;
      if (line.wire == BigRobotArmWire::kText) {
        EXPECT_EQ(bench.probe.found()->dialect, line.dialect) << name;
      }
      EXPECT_EQ(bench.firmware.targets(), targets) << name;
      EXPECT_EQ(bench.steps(), moving ? targets : steps) << name;
      EXPECT_FALSE(bench.probe.next_deadline()) << "it has nothing more to ask";
    }
  }
}

TEST(BigRobotArmProbe, device_that_records_a_sequence_is_recognised_and_keeps_recording) {
  for (const auto dialect : {BigRobotArmDialect::k2021, BigRobotArmDialect::k2026}) {
    Bench bench({BigRobotArmWire::kText, dialect, BigRobotArmProfile::kAsBuilt});
    bench.send("BEGIN I2\rG0 B500\r");
    (void)bench.drop_answers();
    bench.probe.open(bench.now);
    bench.run(20s);
    ASSERT_TRUE(bench.probe.found());
    EXPECT_EQ(*bench.probe.found(), (BigRobotArmFound{BigRobotArmWire::kText, dialect}));
    EXPECT_EQ(bench.steps(), Words{});
    bench.send("END\r");
    bench.run(20s);
    EXPECT_EQ(bench.steps()[0], 500) << "the probe's line was not kept";
  }
}

TEST(BigRobotArmProbe, no_damaged_bit_or_byte_of_the_question_moves_anything) {
  constexpr std::array<std::uint8_t, 2> kQuestion{8, 13};
  std::vector<std::vector<std::uint8_t>> damaged;
  for (std::size_t place = 0; place < 2; ++place) {
    for (int bit = 0; bit < 8; ++bit) {
      auto bytes = kQuestion;
      bytes[place] ^= static_cast<std::uint8_t>(1 << bit);
      damaged.push_back({bytes[0], bytes[1]});
    }
    damaged.push_back({kQuestion[1 - place]});
    auto doubled = std::vector<std::uint8_t>{8, 13};
    doubled.insert(doubled.begin() + static_cast<long>(place), kQuestion[place]);
    damaged.push_back(doubled);
  }
  for (const Line& line : lines()) {
    for (const auto& bytes : damaged) {
      Bench bench(line);
      bench.send(as_bytes(Goto{{100, 200, 300, 400, 500}}, line));
      bench.run(20s);
      const Words steps = bench.steps();
      bench.firmware.receive(bytes, bench.now);
      bench.probe.open(bench.now);
      bench.run(20s);
      ASSERT_TRUE(bench.probe.found());
      EXPECT_EQ(bench.probe.found()->wire, line.wire);
      EXPECT_EQ(bench.steps(), steps);
      EXPECT_FALSE(bench.firmware.moving());
    }
  }
}

TEST(BigRobotArmProbe, silent_line_is_asked_ever_more_slowly) {
  BigRobotArmProbe probe;
  Instant now{};
  probe.open(now);
  std::vector<Instant> asked;
  std::array<std::uint8_t, 4> out{};
  for (; now < Instant{30s}; now += 1ms) {
    probe.poll(now);
    if (probe.take_output(out) > 0) asked.push_back(now);
  }
  ASSERT_GT(asked.size(), 10U);
  EXPECT_EQ(asked[0], Instant{100ms});
  EXPECT_EQ(asked[1] - asked[0], 700ms);
  EXPECT_EQ(asked[2] - asked[1], 900ms);
  EXPECT_EQ(asked.back() - asked[asked.size() - 2], 1300ms);
  EXPECT_FALSE(probe.found());
}

TEST(BigRobotArmProbe, driver_that_is_told_the_wrong_wire_finds_the_right_one) {
  for (const Line& line : lines()) {
    RobotModel robot = test::big_robot_arm(line.wire, line.dialect);
    test::BigRobotArmCell cell(robot, line.profile);
    auto wrong = robot.device.settings.get<BigRobotArmDevice>();
    wrong.wire =
        line.wire == BigRobotArmWire::kByte ? BigRobotArmWire::kText : BigRobotArmWire::kByte;
    wrong.probe_wire = true;
    cell.driver = BigRobotArmDriver(wrong, robot.joints);
    cell.make_ready();
    EXPECT_EQ(cell.driver.wire().wire, line.wire);
    ASSERT_TRUE(cell.driver.move(cell.move_to({0.3, 0.1, 0.2, 0.1, 0}), cell.now));
    cell.run_until(DriverState::kReady);
    EXPECT_EQ(cell.count(DriverEvent::Kind::kDone), 1);
    EXPECT_EQ(cell.liar(), -1);
  }
}

}  // namespace
}  // namespace sinew
