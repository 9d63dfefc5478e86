#include "sinew/runtime/homing_time.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device_test_cell.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/kinds.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;

/// robot-arm-2 with joints that turn little: the whole search takes minutes even here.
RobotModel small_arm(const char* wire) {
  RobotModel model = test::robot("robot-arm-2");
  auto& device = model.device.settings.get<AxisRegistersDevice>();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    model.joints[i].lower = from_deg(-6);
    model.joints[i].upper = from_deg(6);
    device.boards[i].zero = from_deg(-6);
  }
  return *variant_of(model, std::nullopt, wire);
}

TEST(HomingTime, only_axis_boards_have_one) {
  for (const char* robot : {"learm", "maxarm", "bigrobotarm", "hexapod"}) {
    EXPECT_TRUE(homing_of(test::robot(robot)).times.empty()) << robot;
  }
  EXPECT_EQ(homing_of(test::robot("robot-arm-2")).times.size(), 6U);
}

/// The longest search that there is: from the far end, the whole range at 3 deg/s.
TEST(HomingTime, bound_holds_for_an_axis_that_stands_at_its_far_end) {
  const RobotModel& model = test::robot("robot-arm-2");
  test::AxisCell cell(model.joints[0].upper, axis_settings(model, 0));
  const Instant begin = cell.now;
  ASSERT_TRUE(cell.home());
  const double took = to_seconds(cell.now - begin);
  const double bound = homing_of(model).times[0];
  RecordProperty("took_s", static_cast<int>(took));
  RecordProperty("bound_s", static_cast<int>(bound));
  EXPECT_LT(took, bound);
  EXPECT_GT(took, 0.75 * bound) << "a bound that is of some use";
}

class BothBoardWires : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Wires, BothBoardWires, ::testing::Values("registers", "link"));

TEST_P(BothBoardWires, every_axis_is_named_while_its_zero_is_searched_for) {
  const RobotModel model = small_arm(GetParam());
  const bool link = model.device.settings.is<AxisLinkDevice>();
  sim::StepperArm arm(
      model, {.wire = link ? sim::AxisWire::kLink : sim::AxisWire::kRegisters, .start = {}},
      Instant{});
  const RobotDriver driver = make_driver(model);
  const auto program = program::parse("home\n", "p", model);
  ASSERT_TRUE(program);
  ControlLoop loop(model, *driver.spi, {.gap = 1h, .lease_life = 1h}, {}, nullptr);
  program::Run run(*program, loop.machine());
  run.expect_homing(homing_of(model));
  Instant now{};
  run.start(now);
  std::vector<std::size_t> named;
  while (!run.finished() && now < Instant{} + 20min) {
    loop.step(now, [&] { run.poll(now); });
    const auto joint = driver.spi->homing_joint();
    if (joint && (named.empty() || named.back() != *joint)) named.push_back(*joint);
    driver.spi->poll(now);
    const auto transfer = driver.spi->take_transfer(now);
    if (!transfer) {
      const auto next = driver.spi->next_deadline();
      now = next ? std::max(now + 100us, *next) : now + 10ms;
      continue;
    }
    const auto miso = arm.exchange(*transfer, now);
    now += transfer->setup + spi::wire_time(*transfer);
    driver.spi->exchanged({miso.data(), miso.size()}, now);
  }
  ASSERT_EQ(run.phase(), program::Run::Phase::kDone);
  EXPECT_EQ(named, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_FALSE(driver.spi->homing_joint());
  const program::Record& home = run.records()[0];
  EXPECT_LT(to_seconds(home.done - home.asked), home.duration);
  EXPECT_EQ(home.duration, run.plan().homing_max);
}

}  // namespace
}  // namespace sinew::runtime
