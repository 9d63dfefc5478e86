#include "sinew/runtime/links/robot_variant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/devices/kinds.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/model/left_out.h"
#include "support/robot_promises.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

constexpr const char* kRobots[] = {"bigrobotarm", "hexapod", "learm", "maxarm", "robot-arm-2"};

TEST(RobotVariant, every_profile_on_every_wire_is_a_sound_robot_with_driver_and_machine) {
  int variants = 0;
  for (const char* id : kRobots) {
    const RobotModel& robot = test::robot(id);
    std::vector<std::optional<std::string>> wires{std::nullopt};
    for (const std::string& wire : robot.device.settings->wires()) wires.emplace_back(wire);
    for (const auto& wire : wires) {
      const auto on_wire = variant_of(robot, std::nullopt, wire);
      ASSERT_TRUE(on_wire) << id;
      std::vector<std::optional<std::string>> profiles{std::nullopt};
      for (const std::string& profile : on_wire->device.settings->profiles())
        profiles.emplace_back(profile);
      for (const auto& profile : profiles) {
        const auto variant = variant_of(robot, profile, wire);
        ASSERT_TRUE(variant) << id << " " << profile.value_or("-") << wire.value_or("-");
        EXPECT_EQ(test::broken_promise(*variant), "") << id << " " << profile.value_or("-");
        const RobotDriver driver = make_driver(*variant);
        EXPECT_TRUE(driver);
        EXPECT_EQ(driver.get().positions().size(), variant->joints.size());
        const auto machine = make_machine(*variant, {.profile = profile}, Instant{});
        ASSERT_TRUE(machine) << machine.error();
        EXPECT_EQ(static_cast<bool>(machine->spi), static_cast<bool>(driver.spi));
        EXPECT_EQ(machine->get().truth().joints.size(), variant->joints.size());
        ++variants;
      }
    }
  }
  EXPECT_GT(variants, 25);
}

TEST(RobotVariant, bus_servos_count_thousandths_of_240_degrees_the_same_way_round) {
  const RobotModel& robot = test::robot("learm");
  const auto variant = variant_of(robot, "bus", std::nullopt);
  ASSERT_TRUE(variant);
  const auto& pwm = robot.device.settings.get<LscDevice>();
  const auto& bus = variant->device.settings.get<LscDevice>();
  for (std::size_t i = 0; i < pwm.servos.size(); ++i) {
    EXPECT_EQ(std::signbit(bus.servos[i].units_per_rad), std::signbit(pwm.servos[i].units_per_rad));
    // 90 degrees are 375 units: an arm joint has 125 to 875.
    EXPECT_NEAR(std::abs(bus.servos[i].units_per_rad) * from_deg(90), 375, 1e-9);
    EXPECT_EQ(bus.servos[i].centre, 500);
    EXPECT_EQ(bus.servos[i].id, pwm.servos[i].id);
  }
  EXPECT_EQ(variant->device.capability.feedback, PositionFeedback::kMeasured);
}

TEST(RobotVariant, unknown_names_are_told_with_those_that_are_known) {
  const auto learm = variant_of(test::robot("learm"), "lsc7", std::nullopt);
  ASSERT_FALSE(learm);
  EXPECT_EQ(learm.error(), "--profile: 'lsc7' is none of lsc6, bus, esp32");
  const auto maxarm = variant_of(test::robot("maxarm"), std::nullopt, "usb");
  ASSERT_FALSE(maxarm);
  EXPECT_EQ(maxarm.error(), "--wire: 'usb' is unknown: maxarm has but one");
  const auto link = variant_of(test::robot("robot-arm-2"), "as-built", "link");
  EXPECT_FALSE(link) << "the first firmware never spoke the link";
}

TEST(RobotVariant, joints_are_left_out_by_name_or_number_on_both_wires) {
  const RobotModel arm = test::robot("robot-arm-2");
  for (const std::optional<std::string>& wire :
       {std::optional<std::string>("link"), std::optional<std::string>()}) {
    const std::vector<std::string> names{"J3", "flange_roll"};
    const auto variant = variant_of(arm, std::nullopt, wire, names);
    ASSERT_TRUE(variant);
    for (std::size_t j = 0; j < 6; ++j) {
      EXPECT_EQ(is_left_out(*variant, j), j == 2 || j == 5);
      EXPECT_FALSE(is_left_out(arm, j));
    }
  }
  const auto why = [&](const char* robot, const std::vector<std::string>& names) {
    return variant_of(test::robot(robot), std::nullopt, std::nullopt, names).error();
  };
  EXPECT_EQ(why("learm", {"J3"}),
            "--without: learm has one controller for all joints; no joint can be left out");
  EXPECT_EQ(why("robot-arm-2", {"J7"}),
            "--without: 'J7' is no joint of robot-arm-2; its joints: base, shoulder, elbow, "
            "forearm_roll, wrist_bend, flange_roll, or J1 to J6");
  EXPECT_EQ(why("robot-arm-2", {"J1", "J2", "J3", "J4", "J5", "J6"}),
            "--without: all joints are left out; at least one must stay");
}

TEST(RobotMachine, robot_that_its_device_does_not_fit_is_refused_in_words) {
  RobotModel robot = test::robot("learm");
  robot.device = test::robot("maxarm").device;
  const auto palletizer = make_machine(robot, {}, Instant{});
  ASSERT_FALSE(palletizer);
  EXPECT_EQ(palletizer.error(), "learm: its device is simulated for a palletizer only");
  RobotModel boards = test::robot("robot-arm-2");
  boards.dynamics.links.clear();
  const auto bare = make_machine(boards, {}, Instant{});
  ASSERT_FALSE(bare);
  EXPECT_NE(bare.error().find("[link.<joint>]"), std::string::npos);
}

}  // namespace
}  // namespace sinew::runtime
