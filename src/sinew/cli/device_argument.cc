#include "sinew/cli/device_argument.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"

namespace sinew::cli {

namespace {

/// No kind of LSC board answers all the questions of another one.
std::string lsc_hint(const LscDevice& device, const Error& trouble, const DriverHealth& health) {
  if (trouble.code == ErrorCode::kOtherBoard) {
    return "; only one with servos on a bus does so: name it with --profile bus";
  }
  if (device.profile == LscProfile::kBus && health.supply_volts) {
    return "; it tells its supply and nothing else, as a classic board does: try --profile lsc6";
  }
  const std::string where = health.unexpected > 0
                                ? "; something answers there, but not as this board does. Is it"
                                : "; is it switched on, and is this its port? Or is it";
  return where + " another kind of board (--profile lsc6, bus or esp32)?";
}

}  // namespace

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
  const auto& settings = model.device.settings;
  if (const auto* lsc = settings.as<LscDevice>()) return lsc_hint(*lsc, trouble, health);
  const auto* bigrobotarm = settings.as<BigRobotArmDevice>();
  const bool wire_in_doubt = bigrobotarm != nullptr && !bigrobotarm->probe_wire;
  if (health.unexpected > 0) {
    return "; something answers there, but not as " + model.id +
           " does: is another robot on this port?" +
           (wire_in_doubt ? " Or does it speak another wire (--wire probe finds out)?" : "");
  }
  const std::string common = "; is it switched on, and is this its port?";
  if (settings.is<IcpDevice>()) {
    return common +
           " Try once more: on a busy computer a reply may come too late. A controller that was "
           "told to shut down, or was idle for long, replies only after it was switched off and on";
  }
  if (settings.is<MaxArmDevice>()) {
    return common +
           " The arm's stock firmware does not speak this wire: the vendor's slave program "
           "has to be installed. Its MicroPython program sleeps and homes for 14 s after it was "
           "switched on (--profile micropython waits for that)";
  }
  if (wire_in_doubt) {
    return common + " Does it speak this wire (--wire probe finds out)?";
  }
  return common;
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
