#include "sinew/cli/output/device_argument.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sinew/core/error_code.h"
#include "sinew/devices/kinds.h"

namespace sinew::cli {

std::string silence_hint(const RobotModel& model, const Error& trouble,
                         const DriverHealth& health) {
  using enum ErrorCode;
  const bool latched = trouble.code == kEmergencyStop || trouble.code == kStopLatched;
  if (latched && !boards_of(model.device).empty()) {
    return "; sinew device " + model.id + " release, with the same --port, releases it";
  }
  constexpr std::array kOfTheLine{kDeviceSilent, kUnexpectedReply, kUnaskedReply, kDeviceRefused,
                                  kDeviceKilled, kOtherBoard,      kChecksum,     kReplyMismatch};
  if (std::ranges::find(kOfTheLine, trouble.code) == kOfTheLine.end()) return {};
  const DeviceKind& kind = kind_of(model.device);
  return kind.silence_hint != nullptr ? kind.silence_hint(model, trouble, health)
                                      : common_silence_hint(model, health);
}

bool is_on_spi(const RobotModel& model) {
  return !boards_of(model.device).empty();
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
