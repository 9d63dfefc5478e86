// What a supply that sinks under way leaves: controller, driver, wire, device and journal together.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "sinew/control/controller.h"
#include "sinew/core/error_code.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/property.h"
#include "support/robots.h"
#include "system/stop_range.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using control::MachineState;
using control::StopCause;

class Supply : public testing::Test {
 protected:
  void begin(const char* id, const std::optional<std::string>& profile) {
    robot_ = runtime::variant_of(test::robot(id), profile, {}).value();
    range_.emplace(*robot_, profile, seed(), StopRange::Journal::kKept);
    range_->prepare();
    // Long enough for a board to be asked twice what its battery says.
    range_->machine().give(control::SetFeed{0.05});
    range_->begin_motion();
  }
  void set_volts(double volts) {
    range_->simulated().disturb({sim::Disturbance::Kind::kSupply, -1, volts});
  }
  bool comes_to_fault() {
    return range_->wait([&] { return range_->controller().state() == MachineState::kFault; }, 60s);
  }
  /// The truth is in the last record; a lost joint says nothing.
  /// @param room  that the joint may stand beside what its motor was told
  void expect_truth_in_last_record(double room) {
    range_->wait([] { return false; }, 100ms);
    ASSERT_FALSE(range_->records().empty());
    const JournalRecord& last = range_->records().back();
    EXPECT_NE(last.kind, JournalKind::kIntent) << "it stands";
    const sim::Truth truth = range_->simulated().truth();
    for (std::size_t j = 0; j < truth.joints.size(); ++j) {
      const JointPosition& said = last.positions[j];
      if (said.quality == PositionQuality::kLost) continue;
      EXPECT_GE(truth.joints[j].q, said.lower - room) << j;
      EXPECT_LE(truth.joints[j].q, said.upper + room) << j;
    }
  }
  PositionQuality worst_recorded() const {
    PositionQuality worst = PositionQuality::kMeasured;
    for (const JointPosition& joint : range_->records().back().positions) {
      worst = std::min(worst, joint.quality);
    }
    return worst;
  }
  const control::Latched& latched() const { return *range_->controller().latched(); }
  bool command_failed_or_stopped() const {
    for (const control::ControlEvent& event : range_->events()) {
      const bool ended = event.kind == control::ControlEvent::Kind::kFailed ||
                         event.kind == control::ControlEvent::Kind::kStopped;
      if (ended && event.command != 0) return true;
    }
    return false;
  }

  std::optional<RobotModel> robot_;
  std::optional<StopRange> range_;
};

TEST_F(Supply, a_low_battery_is_told_and_the_motion_goes_on) {
  begin("learm", "lsc6");
  set_volts(6.2);
  range_->wait([] { return false; }, 5s);
  EXPECT_FALSE(range_->controller().latched());
  EXPECT_FALSE(command_failed_or_stopped());
  EXPECT_EQ(std::ranges::count_if(range_->events(),
                                  [](const control::ControlEvent& event) {
                                    return event.kind == control::ControlEvent::Kind::kNotice &&
                                           event.error.code == ErrorCode::kSupplyLow;
                                  }),
            1);
  EXPECT_EQ(worst_recorded(), PositionQuality::kCommanded);
}

TEST_F(Supply, an_empty_battery_is_a_fault_that_stays_and_the_position_is_lost) {
  begin("learm", "lsc6");
  set_volts(4.5);
  ASSERT_TRUE(comes_to_fault());
  EXPECT_EQ(latched().cause, StopCause::kDevice);
  EXPECT_EQ(latched().error.code, ErrorCode::kSupplyLow);
  EXPECT_TRUE(command_failed_or_stopped());
  expect_truth_in_last_record(0.02);
  EXPECT_EQ(worst_recorded(), PositionQuality::kLost);
  // The cause is there still.
  range_->machine().give(control::Acknowledge{});
  range_->cycle();
  EXPECT_EQ(range_->controller().state(), MachineState::kFault);
}

/// Below what the modules need, not below what the controller needs.
TEST_F(Supply, a_brown_out_of_the_hexapods_modules_is_a_fault_and_an_honest_interval) {
  for (const double volts : {4.5, 7.2}) {
    begin("hexapod", {});
    range_->wait([] { return false; }, 500ms);
    set_volts(volts);
    range_->wait([] { return false; }, 20ms);
    set_volts(12);
    ASSERT_TRUE(comes_to_fault()) << volts;
    EXPECT_EQ(latched().cause, StopCause::kDevice);
    EXPECT_TRUE(command_failed_or_stopped());
    expect_truth_in_last_record(0);
    EXPECT_EQ(worst_recorded(), PositionQuality::kUncertain) << volts;
    EXPECT_EQ(range_->controller().reference(), std::nullopt) << "nothing is planned from there";
  }
}

}  // namespace
}  // namespace sinew::test
