#pragma once

#include <expected>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/devices/statements.h"
#include "sinew/driver/robot_driver.h"
#include "sinew/driver/wire_reader.h"
#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/robot_machine.h"
#include "sinew/wire/board_image.h"

namespace sinew {

class FactsView;
class TableReader;

/// A search for one joint's zero.
struct ZeroSearch {
  double longest = 0;  ///< s
  double end = 0;      ///< where the joint rests behind it, rad
};

/// One kind of device: what a robot's file says of it, and all that is made for a robot that has
/// one. `devices/KIND/KIND.cc` has it, and devices/kinds.cc the list. What may be nullptr says so.
struct DeviceKind {
  DeviceTable table;
  /// Reads what is the kind's own of [device], behind read_capability() of devices/table_file.h.
  void (*read)(TableReader& reader, RobotModel& model) = nullptr;
  /// Whether the rest of the file asks for nothing that this device cannot do; nullptr: no check.
  void (*check)(TableReader& root, const RobotModel& model) = nullptr;
  bool (*has)(const SomeSettings& settings) = nullptr;

  // For a robot whose device is of this kind:

  /// @param patience  a device whose time runs faster than ours is answered late; what the driver
  ///                  waits for answers is stretched by so much.
  RobotDriver (*driver)(const RobotModel& robot, double patience) = nullptr;
  /// @param robot  as variant_of() made it
  /// @error  a sentence: what the robot's file lacks, or has otherwise than this device needs it
  std::expected<RobotMachine, std::string> (*machine)(const RobotModel& robot,
                                                      const MachineVariant& variant,
                                                      Instant boot) = nullptr;
  /// @param facts  of the driver: which wire was found where the robot's file leaves that open
  std::unique_ptr<WireReader> (*listener)(const Device& device, const DeviceFacts& facts) = nullptr;
  /// What its driver keeps of its reports, as docs/api.md has it; nullptr: nothing.
  /// @param facts  of a driver that this kind has made, not empty
  nlohmann::ordered_json (*view)(const FactsView& view, const DeviceFacts& facts) = nullptr;

  /// Which image its board has said it runs; nullptr: it has one board that says none, or several
  /// boards, which DeviceActions::images asks.
  std::optional<BoardImage> (*image)(const DeviceFacts& facts) = nullptr;

  /// How its boards search for a joint's zero; nullptr: they do not, or its time is not known.
  ZeroSearch (*search)(const RobotModel& robot, std::size_t joint) = nullptr;

  // Words for people; nullptr: none. `driver` is one that this kind has made.

  /// What its driver can report beside positions and its supply.
  void (*state)(const Driver& driver, const RobotModel& robot,
                DeviceStatements& statements) = nullptr;
  /// What a driver that may still become ready suspects, and what to try; empty: nothing.
  std::string (*suspicion)(const Driver& driver) = nullptr;
  /// What to check where the device is silent, or answers what fits nothing. Begins with "; ".
  std::string (*silence_hint)(const RobotModel& robot, const Error& trouble,
                              const DriverHealth& health) = nullptr;
};

/// DeviceKind::has of a kind with such settings.
template <class Settings>
bool has_settings(const SomeSettings& settings) {
  return settings.is<Settings>();
}

/// The driver as what its kind has made.
template <class Made>
const Made& driver_as(const Driver& driver) {
  const auto* made = dynamic_cast<const Made*>(&driver);
  SINEW_ASSERT(made != nullptr);
  return *made;
}

inline Duration stretched(Duration duration, double patience) {
  return from_seconds(to_seconds(duration) * patience);
}

/// The silence hint of any device.
/// @param more, other  what its kind adds where it is silent, and where something else answers
inline std::string common_silence_hint(const RobotModel& robot, const DriverHealth& health,
                                       const std::string& more = {},
                                       const std::string& other = {}) {
  if (health.unexpected == 0) return "; is it switched on, and is this its port?" + more;
  return "; something answers there, but not as " + robot.id +
         " does: is another robot on this port?" + other;
}

/// DeviceKind::machine's sentence where it is simulated for a geometry of another kind.
/// @param geometry  "a palletizer"
inline std::unexpected<std::string> simulated_for(const RobotModel& robot,
                                                  std::string_view geometry) {
  return std::unexpected(robot.id + ": its device is simulated for " + std::string(geometry) +
                         " only");
}

}  // namespace sinew
