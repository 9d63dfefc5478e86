#include "sinew/cli/device_argument.h"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<BigRobotArmDevice, Outcome> big_robot_arm(const RobotModel& model) {
  if (const auto* device = std::get_if<BigRobotArmDevice>(&model.device.settings)) return *device;
  if (model.device.protocol == "none") {
    return std::unexpected(could_not(model.id + " has no device: it is a model only"));
  }
  return std::unexpected(could_not(
      fmt::format("{}: this version has no driver for the wire '{}' yet; bigrobotarm has one",
                  model.id, model.device.protocol)));
}

std::expected<void, Outcome> check_time_scale(double scale) {
  constexpr double kMin = 0.01;
  constexpr double kMax = 100;
  if (scale >= kMin && scale <= kMax) return {};
  return std::unexpected(
      bad_input(fmt::format("--time-scale: {} is outside {}..{}", scale, kMin, kMax)));
}

}  // namespace sinew::cli
