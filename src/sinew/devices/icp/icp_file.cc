#include "sinew/devices/icp/icp_file.h"

#include <algorithm>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

constexpr Named<bool> kYesNo[] = {{"yes", true}, {"no", false}};

/// [device.simulated]: how the simulated controller reads the document.
void read_firmware(TableReader& reader, IcpFirmware& firmware) {
  constexpr Named<bool> kMinusOnes[] = {{"FFFF", false}, {"FFFE", true}};
  std::optional<TableReader> table = reader.table("simulated", Presence::kOptional);
  if (!table) return;
  const auto time = [&](std::string_view key, std::int64_t unit_ms, std::int64_t max,
                        Duration& out) {
    std::int64_t value = 0;
    if (!table->integer(key, 0, max, value)) return;
    out = std::chrono::milliseconds(value * unit_ms);
  };
  table->choice("knows_wake", kYesNo, firmware.knows_wake);
  table->choice("checks_selector", kYesNo, firmware.checks_selector);
  table->choice("bit_one_is_plus", kYesNo, firmware.bit_one_is_plus);
  table->choice("minus_one", kMinusOnes, firmware.minus_one_is_fffe);
  table->choice("silent_without_motor", kYesNo, firmware.silent_without_motor);
  table->choice("ack_without_module", kYesNo, firmware.ack_without_module);
  time("processing_ms", 1, 1000, firmware.processing);
  time("boot_ms", 1, 60'000, firmware.boot);
  time("idle_shutdown_s", 1000, 86'400, firmware.idle_shutdown);
  table->finish();
}

}  // namespace

void read_icp(TableReader& reader, RobotModel& model) {
  auto& device = model.device.settings.emplace<IcpDevice>();
  double travel = 0;
  double units = 0;
  const bool pitch = reader.quantity("travel_per_turn_*", kLength, above_zero_to(0.1), travel);
  const bool steps = reader.number("microsteps_per_rev", between(1, 1e6), units);
  if (pitch && steps) {
    device.units_per_m = units / travel;
    // One unit of one leg is an exchange of four bytes, each ten bits long.
    constexpr double kBitsPerUnit = 4 * 10;
    const double carried = model.device.baud / kBitsPerUnit / device.units_per_m;
    model.device.capability.shared_velocity = carried;
    // Six legs each round to whole units at every segment's end, and what a segment then takes
    // longer is not made up for. Measured: 1.8 % in all, where six go at once.
    model.device.capability.limits_share = 0.975;
    // Nobody can ask a leg for more than that, whatever its motor could.
    for (Joint& leg : model.joints) leg.velocity_max = std::min(leg.velocity_max, carried);
  }
  reader.number("units_per_down", between(1, 2), device.units_per_down);
  constexpr double kNudgeMax = 1e-3;  // m; the driver's own bound
  reader.quantity("nudge_*_max", kLength, above_zero_to(kNudgeMax),
                  model.device.capability.nudge_max);
  std::int64_t timeout_ms = 50;
  reader.integer("reply_timeout_ms", 5, 5000, timeout_ms);
  device.reply_timeout = std::chrono::milliseconds(timeout_ms);
  reader.integer("tries", 1, 20, device.tries);
  read_firmware(reader, device.firmware);
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    table.choice("invert", kYesNo, device.legs[i].invert);
    table.integer("i2c_address", 0x60, 0x7F, device.legs[i].address);
  });
}

}  // namespace sinew
