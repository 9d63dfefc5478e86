#include "sinew/cli/device_argument.h"

#include <fmt/format.h>

#include "sinew/runtime/robot_variant.h"

namespace sinew::cli {

std::expected<void, Outcome> check_has_device(const RobotModel& model) {
  if (!std::holds_alternative<NoDriver>(model.device.settings)) return {};
  return std::unexpected(could_not(model.id + " has no device: it is a model only"));
}

std::string silence_hint(const RobotModel& model, const DriverHealth& health) {
  const auto& settings = model.device.settings;
  const bool is_bigrobotarm = std::holds_alternative<BigRobotArmDevice>(settings);
  if (health.unexpected > 0) {
    return "; something answers there, but not as " + model.id +
           " does: is another robot on this port?" +
           (is_bigrobotarm ? " Or does it speak another wire (--wire probe finds out)?" : "");
  }
  const std::string common = "; is it switched on, and is this its port?";
  if (std::holds_alternative<IcpDevice>(settings)) {
    return common +
           " If so, cut its power: its controller shuts down when it was told to, and "
           "after a long idle time";
  }
  if (std::holds_alternative<MaxArmDevice>(settings)) {
    return common +
           " The arm's stock firmware does not speak this wire: the vendor's slave program "
           "has to be installed. Its MicroPython program sleeps and homes for 14 s after it was "
           "switched on (--profile micropython waits for that)";
  }
  if (is_bigrobotarm) {
    return common + " Does it speak this wire (--wire probe finds out)?";
  }
  return common;
}

bool is_on_spi(const RobotModel& model) {
  return !runtime::boards_of(model).empty();
}

std::expected<void, Outcome> check_seed(std::int64_t seed) {
  if (seed >= 0) return {};
  return std::unexpected(bad_input(fmt::format("--seed: {} is negative; any number from 0", seed)));
}

std::expected<void, Outcome> check_time_scale(double scale) {
  constexpr double kMin = 0.01;
  constexpr double kMax = 100;
  if (scale >= kMin && scale <= kMax) return {};
  return std::unexpected(
      bad_input(fmt::format("--time-scale: {} is outside {}..{}", scale, kMin, kMax)));
}

}  // namespace sinew::cli
