#include <gtest/gtest.h>

#include "sinew/devices/lsc/lsc_driver_units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_test_cell.h"

/// Servos that rest beside what they were told, under the arm's weight.
namespace sinew {
namespace {

using test::LscCell;
using test::LscPose;
using namespace std::chrono_literals;

/// Reached out, where the weight is felt most.
constexpr LscPose kOut{0.2, 1.0, 0.3, 0.2, 0};

TEST(LscSag, an_arm_that_sags_sinks_no_further_when_the_jaws_move) {
  LscCell cell(LscProfile::kBus);
  cell.start(kOut);
  const double sagged = cell.worst(kOut);
  ASSERT_GT(sagged, 0.008) << "else there is nothing to mend";
  // The jaws' frames name the arm's servos too.
  for (const double width : {0.02, 0.05, 0.03}) {
    ASSERT_TRUE(cell.driver.tool(JawsTo{width}, cell.now));
    cell.run_for(3s);
    EXPECT_LT(cell.worst(kOut), sagged + 2e-3) << width;
  }
}

TEST(LscSag, no_servo_is_told_beyond_its_limits_because_it_sags) {
  LscCell cell(LscProfile::kBus);
  const auto& settings = cell.model.device.settings.get<LscDevice>();
  const LscUnits units(settings, cell.model.joints,
                       std::get<SerialGeometry>(cell.model.geometry).gripper);
  for (std::size_t joint = 0; joint < 5; ++joint) {
    for (const double limit : {cell.model.joints[joint].lower, cell.model.joints[joint].upper}) {
      const auto at = *units.of_joint(joint, limit);
      const auto inside = *units.of_joint(joint, 0.9 * limit);
      for (const double more : {-40.0, 40.0}) {
        const double told = units.q_of(joint, units.beside(joint, at, more));
        EXPECT_GE(told, cell.model.joints[joint].lower - 1e-9);
        EXPECT_LE(told, cell.model.joints[joint].upper + 1e-9);
        EXPECT_EQ(units.beside(joint, inside, more / 10), inside + more / 10);
      }
    }
  }
}

}  // namespace
}  // namespace sinew
