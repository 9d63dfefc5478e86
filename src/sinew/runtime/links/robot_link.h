#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sinew/driver/driver.h"
#include "sinew/io/spi_bus.h"
#include "sinew/runtime/links/driver_line.h"
#include "sinew/runtime/links/machine_server.h"
#include "sinew/sim/robot_machine.h"

namespace sinew::runtime {

class SimulatedTable;

/// A simulated machine and where it stands.
struct SimulatedMachine {
  MachineVariant variant{};
  /// What its hand works on; nothing: an empty table. Outlives the machine.
  SimulatedTable* table = nullptr;
  std::size_t place = 0;  ///< which of the table's robots it is
};

/// A robot's driver on a wire to its device: over a port, over simwire, or in simulated time to a
/// machine that is simulated in this process.
class RobotLink {
 public:
  /// Its port is still closed: connect() opens it.
  /// @param robot, clock, log  outlive the link
  /// @param port  "/dev/ttyUSB0" or "tcp:HOST:PORT" for robots on a serial port; for those on SPI
  ///              "spidev", "simwire:unix:PATH" or "simwire:tcp:HOST:PORT".
  /// @error  a port of the wrong kind
  static io::IoResult<RobotLink> prepare(const RobotModel& robot, const std::string& port,
                                         const io::Clock& clock, ByteLog& log);
  /// @param clock  a simulated one; clock and log outlive the link
  static io::IoResult<RobotLink> simulate(const RobotModel& robot,
                                          const SimulatedMachine& simulated, const io::Clock& clock,
                                          ByteLog& log);

  RobotLink(RobotLink&&) noexcept;
  RobotLink& operator=(RobotLink&&) = delete;
  ~RobotLink();

  /// Opens the port, also again after it was lost.
  /// @error  it cannot be opened; a sentence that says why, and what helps
  io::IoResult<void> connect();
  /// Closes the port; other processes can open it then.
  void disconnect();

  Driver& driver() const;
  /// Of a port that is open, or was.
  DriverLine& line() const;
  /// What people know it by: the port's path, "simwire:..", "spidev".
  const std::string& name() const;
  bool simulated() const;
  /// Where a simulated machine stands; nothing where it is real. In the thread of the line.
  std::optional<sim::Truth> truth() const;

 private:
  struct Parts;
  explicit RobotLink(std::unique_ptr<Parts> parts);
  static std::unique_ptr<Parts> parts_for(const RobotModel& robot, const io::Clock& clock,
                                          ByteLog& log);
  std::unique_ptr<Parts> parts_;
};

/// The bus of a robot's boards on SPI, for whoever talks to them below their driver.
/// @param port  "spidev", "simwire:unix:PATH" or "simwire:tcp:HOST:PORT"; outlived by `clock`
/// @error  it cannot be opened; a sentence that says why, and what helps
io::IoResult<std::unique_ptr<io::SpiBus>> open_spi(const RobotModel& robot, const std::string& port,
                                                   const io::Clock& clock);

/// A port of the wrong kind: boards on SPI have no serial port, and the others nothing else. A
/// sentence that says what this robot's port is; nothing where the name may be right.
std::optional<std::string> wrong_port(const RobotModel& robot, const std::string& port);

/// The clock of a robot's wire: simulated for a device of this process (no port) and for boards
/// behind simwire, whose time goes by what their host says; real, or scaled, for all others.
io::Clock clock_for(const std::optional<std::string>& port, double scale);

/// Whether no real device is meant: no port, a pseudo-terminal, or simwire. The other end of those
/// may keep a time of its own; what is found out there says nothing of the robot on the bench.
bool may_be_simulated(const std::optional<std::string>& port);

}  // namespace sinew::runtime
