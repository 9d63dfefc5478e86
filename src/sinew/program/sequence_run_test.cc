#include "sinew/program/sequence_run.h"

#include <gtest/gtest.h>

#include "sinew/program/sequence_test_cell.h"
#include "support/property.h"

namespace sinew::sequence {
namespace {

using namespace std::chrono_literals;
using Phase = Run::Phase;

constexpr std::string_view kDocumented =
    "BEGIN I5\nG0 B100 S200 E300 WR400 W300\nG0 B0 S50 E5000 WR1500 W0\nEND\n";

class EitherWire : public ::testing::TestWithParam<BigRobotArmWire> {};
INSTANTIATE_TEST_SUITE_P(Wires, EitherWire,
                         ::testing::Values(BigRobotArmWire::kByte, BigRobotArmWire::kText),
                         [](const auto& parameter) {
                           return parameter.param == BigRobotArmWire::kByte ? "byte" : "text";
                         });

/// Every motion took what the plan said, and ended where it was sent.
void expect_as_planned(const Run& run) {
  for (const Record& record : run.records()) {
    const auto* move = std::get_if<MoveOrder>(&record.order->what);
    if (move == nullptr) continue;
    EXPECT_NEAR(to_seconds(record.done - record.started), move->duration, 1e-8);
    EXPECT_LT(apart(record.q_reported, move->q), 1e-9);
    EXPECT_GE(record.started, record.asked);
  }
}

TEST_P(EitherWire, each_record_takes_the_predicted_time) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  ASSERT_EQ(cell.run.records().size(), 10U);
  expect_as_planned(cell.run);
  EXPECT_TRUE(cell.run.looked_like_boot());
  EXPECT_FALSE(cell.run.failure());
  EXPECT_LT(apart(cell.truth(), angles_of(cell.model, {0, 50, 5000, 1500, 0})), 1e-9);
  const auto records = cell.run.records();
  EXPECT_NEAR(to_seconds(records.back().done - records.front().asked), cell.run.plan().duration,
              1e-6);
}

/// What the device says of itself once the run is over.
std::optional<bigrobotarm::Status> status_of(Cell& cell) {
  EXPECT_EQ(cell.driver.read_status(cell.now), Expected<void>());
  std::array<std::uint8_t, 128> bytes{};
  const std::size_t asked = cell.driver.take_output(bytes);
  cell.firmware.receive(std::span(bytes.data(), asked), cell.now);
  while (const std::size_t size = cell.firmware.take_output(bytes)) {
    cell.driver.receive(std::span(bytes.data(), size), cell.now);
  }
  const auto event = cell.driver.take_event();
  const auto* read = event ? std::get_if<BigRobotArmDriver::StatusRead>(&*event) : nullptr;
  return read != nullptr ? std::optional(read->status) : std::nullopt;
}

TEST_P(EitherWire, every_command_arrives_at_the_device) {
  Cell cell(
      "M203 B150 S90 E80 WR70 W60\nM201 B50\nG1 E1 P40\nG0 B100 S200 E300 WR400 W300\nG92\n"
      "S1\nG0 B500 S-100\nS0\nG28\nG1 E0 P0\n",
      arm(GetParam()));
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  expect_as_planned(cell.run);
  EXPECT_LT(apart(cell.truth(), angles_of(cell.model, {100, 200, 300, 400, 300})), 1e-9);
  EXPECT_FALSE(cell.firmware.gripper().enabled);
  EXPECT_EQ(cell.firmware.gripper().position, 40);
  EXPECT_EQ(cell.firmware.bytes_lost(), 0U);

  // Whoever comes next finds the program's own speeds, not those of the synchronised move.
  const auto status = status_of(cell);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->speeds, (Words{150, 90, 80, 70, 60}));
  EXPECT_EQ(status->accelerations, (Words{50, 100, 100, 100, 100}));
}

TEST_P(EitherWire, stop_in_a_synchronised_part_puts_the_speeds_back) {
  Cell cell("M203 B150\nS1\nG0 B20 S0 E9000\nG0 B2000\n", arm(GetParam()));
  cell.go_to_line(3);
  cell.run.stop();
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kStopped);
  EXPECT_LT(apart(cell.truth(), angles_of(cell.model, {20, 0, 9000, 0, 0})), 1e-9);
  const auto status = status_of(cell);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->speeds, (Words{150, 100, 100, 100, 100}));
  EXPECT_EQ(status->accelerations, (Words{200, 100, 100, 100, 100}));
}

TEST_P(EitherWire, device_with_its_own_sync_on_is_not_moved) {
  Cell cell("G0 B100\n", arm(GetParam()));
  const auto on = GetParam() == BigRobotArmWire::kByte ? std::string("\x07\x01\r") : "S1\r";
  cell.firmware.receive(std::span(reinterpret_cast<const std::uint8_t*>(on.data()), on.size()),
                        cell.now);
  std::array<std::uint8_t, 128> bytes{};
  while (cell.firmware.take_output(bytes) > 0) {
  }
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kDeviceSync);
  EXPECT_EQ(apart(cell.truth(), {}), 0);
}

TEST_P(EitherWire, stop_finishes_the_motion_under_way_and_sends_nothing_more) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.go_to_line(2);
  const std::size_t sent = cell.to_device.size();
  cell.run.stop();
  EXPECT_EQ(cell.run.phase(), Phase::kStopping);
  cell.go_on();
  EXPECT_EQ(cell.run.phase(), Phase::kStopped);
  EXPECT_EQ(cell.run.records().size(), 1U);
  EXPECT_EQ(cell.to_device.size(), sent);
  EXPECT_LT(apart(cell.truth(), angles_of(cell.model, {100, 200, 300, 400, 300})), 1e-9);
}

TEST_P(EitherWire, device_that_never_answers_fails_before_the_first_order) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.cut = true;
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 0);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.run.failure()->error.limit, 6);
  EXPECT_GT(cell.now, Instant{Run::kOpeningLimit});
  EXPECT_LE(cell.now, Instant{Run::kOpeningLimit + 1s});
  EXPECT_TRUE(cell.run.records().empty());
}

TEST_P(EitherWire, device_that_goes_silent_in_a_motion_is_told_with_its_line) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.go_to_line(3);
  const Instant asked = cell.run.under_way()->asked;
  cell.cut = true;
  const std::size_t sent = cell.to_device.size();
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 3);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.run.records().size(), 1U);
  EXPECT_EQ(cell.to_device.size(), sent);
  // Half as long again as predicted, and 2 s.
  EXPECT_NEAR(to_seconds(cell.now - asked), 1.5 * (4700.0 / 3200 + 1) + 2, 0.01);
}

TEST_P(EitherWire, garbage_in_a_motion_fails_and_no_order_follows) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.go_to_line(3);
  const std::size_t sent = cell.to_device.size();
  const std::array<std::uint8_t, 4> noise{0x55, 0x0D, 0x0A, 0x99};
  cell.driver.receive(noise, cell.now);
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 3);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kUnexpectedReply);
  EXPECT_EQ(cell.run.records().size(), 1U);
  EXPECT_EQ(cell.to_device.size(), sent);
}

TEST_P(EitherWire, port_that_closes_in_a_motion_fails_with_its_line) {
  Cell cell(kDocumented, arm(GetParam()));
  cell.go_to_line(2);
  cell.driver.close();
  cell.run.poll(cell.now);
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 2);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kPortClosed);
  EXPECT_FALSE(cell.run.under_way());
}

/// A board that was reset by the opening of its port listens when its boot loader is done.
TEST(SequenceRun, device_that_answers_late_is_waited_for) {
  Cell cell("G0 B100", arm());
  cell.cut = true;
  cell.go_on(Instant{3s});
  EXPECT_EQ(cell.run.phase(), Phase::kOpening);
  cell.cut = false;
  cell.go_on();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
}

TEST(SequenceRun, device_that_talks_nonsense_while_it_opens_is_told_as_that) {
  Cell cell("G0 B100", arm());
  cell.cut = true;
  for (int i = 0; i < 700 && !cell.run.finished(); ++i) {
    cell.go_on(cell.now + 10ms);
    cell.driver.receive(std::array<std::uint8_t, 1>{0x55}, cell.now);
  }
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 0);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kUnaskedReply);
}

TEST(SequenceRun, port_that_closes_while_it_opens_fails_at_once) {
  Cell cell("G0 B100", arm());
  cell.go_on(Instant{50ms});
  cell.driver.close();
  cell.run.poll(cell.now);
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kPortClosed);
}

TEST(SequenceRun, stop_before_the_device_answered_orders_nothing) {
  Cell cell(kDocumented, arm());
  cell.go_on(Instant{50ms});
  cell.run.stop();
  EXPECT_EQ(cell.run.phase(), Phase::kStopped);
  cell.go_on();
  EXPECT_TRUE(cell.run.records().empty());
  EXPECT_TRUE(cell.to_device.empty());
}

TEST(SequenceRun, stop_after_the_end_changes_nothing) {
  Cell cell("G0 B100", arm());
  cell.go_on();
  cell.run.stop();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
}

TEST(SequenceRun, plan_is_made_for_where_the_device_really_is) {
  Cell cell("G92\nG0 B6400", arm());
  // Somebody moved the arm before: its base is 200 steps away, and 6600 are too far.
  cell.firmware.receive(std::array<std::uint8_t, 22>{1, 200, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                     0, 0,   0, 0, 0, 0, 0, 0, 0, 0, 0x0D},
                        Instant{});
  cell.firmware.advance(Instant{5s});
  std::array<std::uint8_t, 128> ignored{};
  while (cell.firmware.take_output(ignored) > 0) {
  }
  cell.now = Instant{5s};
  cell.go_on();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->line, 2);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kJointLimit);
  EXPECT_FALSE(cell.run.looked_like_boot());
  // Only the status was asked for.
  EXPECT_EQ(cell.to_device, (std::vector<std::uint8_t>{8, 0x0D}));
}

TEST(SequenceRun, progress_grows_with_the_time_to_the_plans_whole_duration) {
  Cell cell(kDocumented, arm());
  double last = 0;
  while (!cell.run.finished()) {
    cell.go_on(cell.now + 37ms);
    const double progress = cell.run.progress(cell.now);
    ASSERT_GE(progress, last - 1e-9);
    ASSERT_LE(progress, last + 0.038);
    last = progress;
  }
  EXPECT_NEAR(last, cell.run.plan().duration, 1e-9);
}

TEST(SequenceRun, program_without_orders_is_done_when_the_device_answered) {
  Cell cell("S1\nS0\n", arm());
  cell.go_on();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_TRUE(cell.run.records().empty());
}

TEST(SequenceRun, any_noise_in_any_motion_ends_in_a_run_that_is_over) {
  test::for_random_cases(500, [](test::Random& random) {
    const auto wire = random.chance(0.5) ? BigRobotArmWire::kByte : BigRobotArmWire::kText;
    Cell cell(kDocumented, arm(wire));
    cell.go_on(Instant{from_seconds(random.uniform(0, 20))});
    const std::size_t records = cell.run.records().size();
    std::vector<std::uint8_t> noise(static_cast<std::size_t>(random.integer(1, 80)));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.bits());
    cell.driver.receive(noise, cell.now);
    cell.go_on();
    // Noise while the driver waits for quiet, or that is cut off as an echo, costs nothing; what is
    // done stays done, and what failed has its place.
    ASSERT_TRUE(cell.run.finished());
    EXPECT_GE(cell.run.records().size(), records);
    if (cell.run.phase() == Phase::kFailed) {
      EXPECT_TRUE(cell.run.failure());
    } else {
      expect_as_planned(cell.run);
      EXPECT_EQ(cell.run.records().size(), 10U);
    }
  });
}

}  // namespace
}  // namespace sinew::sequence
