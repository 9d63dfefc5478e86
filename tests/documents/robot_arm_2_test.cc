#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis_registers/axis_registers_test_cell.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/devices/encoder/encoder_wire.h"
#include "sinew/mcu/encoder_node.h"
#include "sinew/wire/spi.h"
#include "support/robots.h"

// Robot Arm 2's document: its numbers and its words, typed as they stand there. Its frames and
// checksums are in tests/golden/axis_registers.txt and encoder_link.txt, each row in which its
// first firmware differs in devices/axis_registers, a bus that is opened six times in
// sim/simwire_server_test.cc, its torque table in planning/studies/torque_study_test.cc.

namespace sinew {
namespace {

/// One transaction of the register protocol: seven transfers, each with its select and its pause.
double transaction_s(std::size_t size, bool last_pause = true) {
  using namespace axis_registers;
  Duration time{};
  const std::array<std::size_t, 7> sizes{1, 1, 1, kHeaderSize, 1, size + kCrcSize, kCommitSize};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    spi::Transfer transfer;
    transfer.clock_hz = 500'000;
    transfer.mosi.resize(sizes[i]);
    time += kSelectSetup + spi::wire_time(transfer);
    if (i == 4) time += kValidationPause;
    if (i != 4 && (last_pause || i + 1 < sizes.size())) time += kStepPause;
  }
  return to_seconds(time);
}

TEST(RobotArm2Document, register_transactions_cost_what_the_document_adds_up) {
  EXPECT_NEAR(transaction_s(1), 81.832e-3, 1e-9);
  EXPECT_NEAR(transaction_s(4), 81.880e-3, 1e-9);
  EXPECT_NEAR(transaction_s(4, false), 71.88e-3, 1e-9);
  struct Row {
    double transactions, one_hz, six_hz;
  };
  for (const Row& row : {Row{1, 12.21, 2.035}, Row{2, 6.11, 1.018}, Row{3, 4.07, 0.678}}) {
    const double time = row.transactions * transaction_s(4);
    EXPECT_NEAR(1 / time, row.one_hz, 0.006);
    EXPECT_NEAR(1 / (6 * time), row.six_hz, 0.0006);
  }
  EXPECT_NEAR(6 * transaction_s(4), 0.4913, 5e-5) << "an emergency stop to six, one by one";
}

TEST(RobotArm2Document, one_frame_a_cycle_reaches_the_rates_of_the_documents_table) {
  struct Row {
    std::size_t bytes;
    int overhead_us;
    std::array<std::array<int, 3>, 3> at;  ///< us, Hz of six in a row, Hz of six at once
  };
  constexpr std::array<std::uint32_t, 3> kClocks{500'000, 4'000'000, 18'000'000};
  const std::array rows{Row{12, 200, {{{392, 425, 2551}, {224, 744, 4464}, {205, 812, 4870}}}},
                        Row{12, 50, {{{242, 689, 4132}, {74, 2252, 13514}, {55, 3012, 18072}}}},
                        Row{16, 200, {{{456, 365, 2193}, {232, 718, 4310}, {207, 805, 4828}}}},
                        Row{16, 50, {{{306, 545, 3268}, {82, 2032, 12195}, {57, 2918, 17510}}}},
                        Row{24, 50, {{{434, 384, 2304}, {98, 1701, 10204}, {61, 2747, 16484}}}}};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < kClocks.size(); ++i) {
      spi::Transfer transfer;
      transfer.clock_hz = kClocks[i];
      transfer.setup = std::chrono::microseconds(row.overhead_us);
      transfer.mosi.resize(row.bytes);
      const double time = to_seconds(transfer.setup + spi::wire_time(transfer));
      EXPECT_NEAR(time * 1e6, row.at[i][0], 0.5) << row.bytes << " at " << kClocks[i];
      EXPECT_NEAR(1 / (6 * time), row.at[i][1], 0.6) << row.bytes << " at " << kClocks[i];
      EXPECT_NEAR(1 / time, row.at[i][2], 1) << row.bytes << " at " << kClocks[i];
    }
  }
}

TEST(RobotArm2Document, fifty_ms_lie_behind_an_error_code_before_the_next_syn) {
  using namespace axis_registers;
  AxisRegisterLink link(test::six_boards(), {});
  AxisRegisterRequest request;
  request.select = 1;
  request.operation = Operation::kWrite;
  request.address = 4;
  request.data.push_back(1);
  request.tries = 2;
  Instant now{};
  link.start(request, now);
  spi::Bytes before;
  std::optional<Instant> refused;  // when the error code had come
  std::optional<Instant> again;    // the next SYN
  Instant last_end{};              // of the transfer before that one
  while (link.busy() && !again) {
    now = std::max(now, link.next_deadline().value_or(now));
    const auto transfer = link.take_transfer(now);
    ASSERT_TRUE(transfer);
    if (refused && transfer->mosi == spi::Bytes{kSyn}) again = now;
    if (!again) last_end = now + transfer->setup + spi::wire_time(*transfer);
    now += transfer->setup + spi::wire_time(*transfer);
    spi::Bytes miso;
    miso.resize(transfer->mosi.size());
    if (before == spi::Bytes{kSyn}) miso[0] = kSynAck;
    if (before.size() == kHeaderSize) {
      miso[0] = static_cast<std::uint8_t>(Verdict::kCrc);
      refused = now;
    }
    before = transfer->mosi;
    link.exchanged({miso.data(), miso.size()}, now);
  }
  ASSERT_TRUE(refused && again);
  // The document waits 50 ms behind the code. Between the code and the next SYN stand our four
  // bursts that free a board from any state, so the 50 ms count from the last of them.
  EXPECT_GE(to_seconds(*again - last_end), 0.050);
  EXPECT_LT(to_seconds(*again - last_end), 0.051);
}

TEST(RobotArm2Document, a_joint_turns_in_54400_steps_by_its_gears) {
  const auto& drives = test::robot("robot-arm-2").dynamics.drives;
  for (const auto& drive : drives) {
    EXPECT_NEAR(drive.steps_per_turn * drive.microsteps * drive.gear_ratio, 54400, 1e-6)
        << "200 steps, 16 microsteps, 17:1";
  }
  EXPECT_NEAR(54400 / 360.0, 151.11, 0.005) << "steps a degree";
  EXPECT_NEAR(5000 / (54400 / 360.0), 33.1, 0.05) << "deg/s at 5000 steps/s: 100 is out of reach";
}

TEST(RobotArm2Document, a_sensor_has_4096_ticks_and_what_fits_int16_does) {
  EXPECT_EQ(encoder_link::kTurn, 4096);
  const auto ticks = [](double degrees) { return degrees / 360 * encoder_link::kTurn; };
  // On the motor shaft 100 deg/s fits and 200 deg/s^2 does not: saturated, never wrapped.
  EXPECT_EQ(std::llround(ticks(17 * 100)), 19342);
  EXPECT_EQ(std::llround(ticks(17 * 200)), 38684);
  // As the node says it: 2^-20 ticks a ms, and a ms^2.
  const ShaftFilter filter{
      .angle = 0,
      .speed = static_cast<std::int32_t>(std::llround(19342e-3 * 0x1p20)),
      .acceleration = static_cast<std::int32_t>(std::llround(38684e-6 * 0x1p20))};
  EXPECT_EQ(shaft_filter_speed(&filter), 19342);
  EXPECT_EQ(shaft_filter_acceleration(&filter), 32767);
  EXPECT_EQ(std::llround(ticks(100)), 1138);
  EXPECT_EQ(std::llround(ticks(200)), 2276);
}

TEST(RobotArm2Document, ready_may_stay_high_as_on_the_boards_of_its_log) {
  const RobotModel& robot = test::robot("robot-arm-2");
  sim::StepperArm::Settings settings;
  settings.wire = sim::AxisWire::kRegistersAsBuilt;
  EXPECT_FALSE(sim::StepperArm(robot, settings, Instant{}).ready_pin(0)) << "low, as it is coded";
  settings.ready_high = true;
  const sim::StepperArm logged(robot, settings, Instant{});
  for (std::size_t axis = 0; axis < 6; ++axis) EXPECT_TRUE(logged.ready_pin(axis));
}

}  // namespace
}  // namespace sinew
