#include "sinew/model/left_out.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_test_cell.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_test_cell.h"

// Boards that are left out by choice: nothing is ever sent to them, and the others do everything.

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::LinkCell;
using test::RegisterCell;
using Kind = DriverEvent::Kind;
using Quality = PositionQuality;

AxisRegistersDevice boards_without(std::size_t joint) {
  AxisRegistersDevice device = test::six_boards();
  device.boards[joint].homing_place = kLeftOut;
  return device;
}

TEST(LeftOut, register_boards_home_move_stop_and_are_cleared_without_it) {
  for (const std::size_t gone : {std::size_t{0}, std::size_t{2}, std::size_t{5}}) {
    RegisterCell cell(AxisRegisterProfile::kDocument, boards_without(gone));
    std::uint8_t selected = 0;
    cell.watch = [&](const spi::Transfer& transfer) {
      selected = static_cast<std::uint8_t>(selected | transfer.select);
    };
    cell.axes[gone].place(from_deg(33));
    cell.driver->open(cell.now);
    ASSERT_TRUE(cell.run_until([&] { return cell.saw(Kind::kReady); }, 60)) << gone;
    cell.events.clear();
    ASSERT_TRUE(cell.driver->home(cell.now));
    EXPECT_EQ(cell.finish(3600).kind, Kind::kDone);
    std::vector<double> to{10, 10, 10, 10, 10, 10};
    JointMove move = cell.to(to);
    ASSERT_TRUE(cell.driver->move(move, cell.now));
    EXPECT_EQ(cell.finish().kind, Kind::kDone);
    for (std::size_t i = 0; i < 6; ++i) {
      const bool out = i == gone;
      EXPECT_EQ(cell.driver->positions()[i].quality, out ? Quality::kLost : Quality::kCommanded);
      EXPECT_NEAR(to_deg(cell.axes[i].q()), out ? 33 : 10, 0.1) << i;
    }
    cell.driver->stop(cell.now);
    EXPECT_EQ(cell.finish().kind, Kind::kStopped);
    ASSERT_TRUE(cell.driver->clear_fault(cell.now));
    EXPECT_EQ(cell.finish().kind, Kind::kDone);
    cell.driver->declare_positions(std::vector<JointPosition>(6, {Quality::kCommanded, 0, 0, 0}));
    EXPECT_EQ(cell.driver->positions()[gone].quality, Quality::kLost) << "whoever says otherwise";
    cell.run_for(10s);
    EXPECT_EQ(selected, 0x3F & ~(1U << gone)) << "it was never selected";
    EXPECT_FALSE(cell.driver->axis_fault(gone));
  }
}

TEST(LeftOut, register_boards_that_are_all_silent_besides_are_told_as_one_silence) {
  RegisterCell cell(AxisRegisterProfile::kDocument, boards_without(0));
  cell.line = [](const spi::Transfer&, int) { return test::LineFault{.deaf = 0x3F}; };
  cell.driver->open(cell.now);
  const DriverEvent end = cell.finish();
  EXPECT_EQ(end.kind, Kind::kFailed);
  EXPECT_EQ(end.error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(end.error.index, -1);
}

TEST(LeftOut, linked_axes_home_move_and_stop_without_it) {
  for (const std::size_t gone : {std::size_t{0}, std::size_t{2}, std::size_t{5}}) {
    LinkCell cell;
    cell.device.boards[gone].homing_place = kLeftOut;
    cell.driver = std::make_unique<AxisLinkDriver>(cell.device, cell.joints);
    std::uint8_t selected = 0;
    cell.disturb = [&](const spi::Transfer& transfer) {
      selected = static_cast<std::uint8_t>(selected | transfer.select);
      return test::LinkFault{};
    };
    for (auto& axis : cell.axes) axis->place(0.1);
    cell.driver->open(cell.now);
    cell.run_for(20ms);
    ASSERT_EQ(cell.driver->state(), DriverState::kReady) << gone;
    cell.events.clear();
    ASSERT_TRUE(cell.driver->home(cell.now));
    ASSERT_TRUE(cell.run_to_event(Kind::kDone, 3600s));
    cell.events.clear();
    const double from = cell.axes[gone]->q();
    JointMove move = cell.move_to(0, 60s);
    for (std::size_t i = 0; i < 6; ++i) {
      if (i != gone) move.q[i] = cell.driver->positions()[i].q + 0.05;
    }
    const auto taken = cell.driver->move(move, cell.now);
    ASSERT_TRUE(taken) << static_cast<int>(taken.error().code) << " " << int{taken.error().index};
    ASSERT_TRUE(cell.run_to_event(Kind::kDone, 100s));
    for (std::size_t i = 0; i < 6; ++i) {
      const bool out = i == gone;
      EXPECT_EQ(cell.driver->positions()[i].quality, out ? Quality::kLost : Quality::kMeasured);
      EXPECT_NEAR(cell.axes[i]->q(), out ? from : move.q[i], 0.01) << i;
    }
    cell.events.clear();
    cell.driver->stop(cell.now);
    EXPECT_TRUE(cell.run_to_event(Kind::kStopped, 10s));
    EXPECT_EQ(selected, 0x3F & ~(1U << gone)) << "it was never selected";
  }
}

}  // namespace
}  // namespace sinew
