#include "sinew/devices/grbl/grbl_driver_settings.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/grbl/grbl_test_cell.h"

namespace sinew {
namespace {

using grbl::Firmware;

class GrblSettings : public ::testing::Test {
 protected:
  /// All of a board that fits, but for one.
  void list_without(std::uint16_t number) {
    check.begin();
    const auto take = [&](int setting, double value) {
      if (setting != number) check.take({static_cast<std::uint16_t>(setting), value});
    };
    take(grbl::kIdleSetting, 255);
    for (int i = 0; i < 3; ++i) {
      take(grbl::kStepsSetting + i, 32'000.0 / 360);
      take(grbl::kRateSetting + i, 90 * 60);
      take(grbl::kAccelerationSetting + i, 400);
    }
  }
  std::optional<ErrorCode> with(std::uint16_t number, double value,
                                Firmware firmware = Firmware::kGrbl) {
    list_without(number);
    check.take({number, value});
    const auto error = check.misfit(firmware);
    return error ? std::optional(error->code) : std::nullopt;
  }

  RobotModel robot = test::grbl_robot();
  GrblSettingsCheck check{robot.device.settings.get<GrblDevice>(), robot.joints};
};

TEST_F(GrblSettings, those_that_fit_or_are_more_than_needed_do) {
  EXPECT_FALSE(with(grbl::kRateSetting, 1e5));
  EXPECT_FALSE(with(grbl::kRateSetting, 5399.9));
  EXPECT_FALSE(with(grbl::kStepsSetting + 1, 88.889));
  EXPECT_EQ(check.report_scale(), 1);
}

TEST_F(GrblSettings, those_that_do_not_are_named) {
  EXPECT_EQ(with(grbl::kIdleSetting, 25), ErrorCode::kBoardRests);
  EXPECT_EQ(with(grbl::kRateSetting + 2, 5000), ErrorCode::kBoardVelocity);
  EXPECT_EQ(with(grbl::kAccelerationSetting, 10), ErrorCode::kBoardAcceleration);
  EXPECT_EQ(with(grbl::kStepsSetting, 250), ErrorCode::kBoardSteps);
}

TEST_F(GrblSettings, what_is_not_listed_does_not_fit) {
  for (const int number : {grbl::kIdleSetting + 0, grbl::kStepsSetting + 1, grbl::kRateSetting + 2,
                           grbl::kAccelerationSetting + 0}) {
    list_without(static_cast<std::uint16_t>(number));
    EXPECT_FALSE(check.complete(Firmware::kGrbl));
    EXPECT_EQ(check.misfit(Firmware::kGrbl)->code, ErrorCode::kModelMismatch) << number;
  }
  list_without(grbl::kIdleSetting);
  EXPECT_FALSE(check.misfit(Firmware::kFluidNc));
}

TEST_F(GrblSettings, inches_are_told_apart) {
  list_without(0);
  check.take({grbl::kInchSetting, 1});
  EXPECT_EQ(check.report_scale(), 25.4);
  check.begin();
  EXPECT_EQ(check.report_scale(), 1);
}

}  // namespace
}  // namespace sinew
