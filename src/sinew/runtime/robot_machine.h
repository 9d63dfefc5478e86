#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>

#include "sinew/sim/machine.h"

namespace sinew::runtime {

class SimulatedTable;

/// How a simulated machine shall be, beyond what its model says.
struct MachineOptions {
  std::optional<std::string> profile;  ///< one of DeviceSettings::profiles()
  std::uint64_t seed = 1;
  std::size_t boards = kMaxJoints;  ///< SPI: how many of the axis boards are there
  bool soft_select = false;         ///< SPI: boards listen whether selected or not
  bool ready_high = false;          ///< SPI: READY never falls, as on the boards of the log
  /// What its hand works on; nothing: an empty table. Outlives the machine.
  SimulatedTable* table = nullptr;
  std::size_t place = 0;  ///< which of the table's robots it is
};

/// A simulated machine: one of the two is there.
struct RobotMachine {
  std::unique_ptr<sim::ByteMachine> byte;
  std::unique_ptr<sim::SpiMachine> spi;

  explicit operator bool() const { return byte || spi; }
  sim::Machine& get() const { return byte ? static_cast<sim::Machine&>(*byte) : *spi; }
};

/// @param robot  as variant_of() made it
/// @error  a sentence: what the robot's file lacks, or has otherwise than this device needs it
std::expected<RobotMachine, std::string> make_machine(const RobotModel& robot,
                                                      const MachineOptions& options, Instant boot);

}  // namespace sinew::runtime
