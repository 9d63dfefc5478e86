#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "sinew/control/controller.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/property.h"
#include "support/robots.h"
#include "system/stop_range.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using control::MachineState;

struct Robot {
  const char* id;
  const char* wire;  ///< null: its default
  bool jogs;
  bool nudges;
};

constexpr Robot kRobots[] = {
    {"robot-arm-2", "registers", false, false},
    {"robot-arm-2", "link", true, false},
    {"learm", nullptr, true, false},
    {"bigrobotarm", nullptr, false, true},
    {"bigrobotarm", "framed", true, true},
    {"maxarm", nullptr, false, false},
    {"hexapod", nullptr, true, true},
};

void PrintTo(const Robot& robot, std::ostream* out) {
  *out << robot.id;
}

class StepAllocations : public testing::TestWithParam<Robot> {
 protected:
  void SetUp() override {
    const Robot& one = GetParam();
    const auto wire = one.wire == nullptr ? std::optional<std::string>() : one.wire;
    robot_ = runtime::variant_of(test::robot(one.id), {}, wire).value();
    robot_->collision = {};
    range_.emplace(*robot_, std::nullopt, seed());
    range_->prepare();
  }
  void move_and_hold();
  void jog();
  void nudge();

  void cycles(int count) {
    for (int k = 0; k < count; ++k) range_->cycle();
  }
  bool comes_to(MachineState state) {
    return range_->wait([&] { return range_->controller().state() == state; }, 60s);
  }

  std::optional<RobotModel> robot_;
  std::optional<StopRange> range_;
};

/// A motion that is slowed down, held and resumed.
void StepAllocations::move_and_hold() {
  range_->begin_motion();
  range_->machine().give(control::SetFeed{0.5});
  cycles(20);
  range_->machine().give(control::Hold{});
  cycles(5);
  // Whole moves cannot be held in the middle.
  ASSERT_TRUE(range_->wait(
      [&] {
        return range_->controller().state() == MachineState::kHeld ||
               range_->controller().state() == MachineState::kReady;
      },
      60s));
  range_->machine().give(control::Resume{});
  range_->machine().give(control::SetFeed{1});
  EXPECT_TRUE(comes_to(MachineState::kReady));
}

void StepAllocations::jog() {
  control::JogAt jog;
  const double share = 0.2;
  for (const Joint& joint : robot_->joints) {
    jog.velocity.velocity.push_back(share * joint.velocity_max);
  }
  range_->machine().give(jog);
  cycles(2);
  EXPECT_EQ(range_->controller().jogs(), GetParam().jogs);
  for (int k = 0; k < 40; ++k) {
    range_->machine().give(jog);
    cycles(3);
  }
  EXPECT_TRUE(comes_to(MachineState::kReady));
}

void StepAllocations::nudge() {
  const double way = robot_->joints[0].kind == JointKind::kPrismatic ? 2e-6 : 0.01;
  range_->machine().give(control::Nudge{0, way});
  cycles(2);
  EXPECT_EQ(range_->controller().state() == MachineState::kRecovering, GetParam().nudges);
  EXPECT_TRUE(comes_to(MachineState::kReady));
}

TEST_P(StepAllocations, none_in_motions_holds_jogs_small_steps_and_stops) {
  EXPECT_EQ(range_->allocations(), 0U) << "enabling, homing";
  move_and_hold();
  EXPECT_EQ(range_->allocations(), 0U) << "a motion, a hold";
  jog();
  EXPECT_EQ(range_->allocations(), 0U) << "a jog";
  range_->shoot();
  EXPECT_EQ(range_->allocations(), 0U) << "a stop";
  nudge();
  EXPECT_EQ(range_->allocations(), 0U) << "a small step";
}

INSTANTIATE_TEST_SUITE_P(EachRobot, StepAllocations, testing::ValuesIn(kRobots),
                         [](const auto& robot) {
                           std::string name = robot.param.id;
                           if (robot.param.wire != nullptr) {
                             name += std::string("_") + robot.param.wire;
                           }
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace sinew::test
