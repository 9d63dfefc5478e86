#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sinew/sim/machine.h"

namespace sinew {

/// A simulated machine: one of the two is there.
struct RobotMachine {
  std::unique_ptr<sim::ByteMachine> byte;
  std::unique_ptr<sim::SpiMachine> spi;

  explicit operator bool() const { return byte || spi; }
  sim::Machine& get() const { return byte ? static_cast<sim::Machine&>(*byte) : *spi; }
};

/// How a simulated machine shall be, beyond what its model says.
struct MachineVariant {
  std::optional<std::string> profile;  ///< one of DeviceSettings::profiles()
  std::uint64_t seed = 1;
  std::size_t boards = kMaxJoints;  ///< SPI: how many of the axis boards are there
  bool soft_select = false;         ///< SPI: boards listen whether selected or not
  bool ready_high = false;          ///< SPI: READY never falls, as on the boards of the log
};

}  // namespace sinew
