#include "sinew/cli/device_argument.h"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<void, Outcome> check_has_device(const RobotModel& model) {
  if (!std::holds_alternative<NoDriver>(model.device.settings)) return {};
  return std::unexpected(could_not(model.id + " has no device: it is a model only"));
}

std::span<const AxisBoard> boards_of(const RobotModel& model) {
  const auto& settings = model.device.settings;
  if (const auto* registers = std::get_if<AxisRegistersDevice>(&settings)) {
    return {registers->boards.data(), registers->boards.size()};
  }
  if (const auto* link = std::get_if<AxisLinkDevice>(&settings)) {
    return {link->boards.data(), link->boards.size()};
  }
  return {};
}

bool is_on_spi(const RobotModel& model) {
  return !boards_of(model).empty();
}

std::expected<void, Outcome> check_time_scale(double scale) {
  constexpr double kMin = 0.01;
  constexpr double kMax = 100;
  if (scale >= kMin && scale <= kMax) return {};
  return std::unexpected(
      bad_input(fmt::format("--time-scale: {} is outside {}..{}", scale, kMin, kMax)));
}

}  // namespace sinew::cli
