#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sinew/devices/kinds.h"
#include "sinew/sim/link_fault.h"

namespace sinew::test {

/// What happened to a line so far.
struct LineCounts {
  std::uint64_t bytes = 0;   ///< both ways
  std::uint64_t trace = 0;   ///< FNV-1a of each of them and which way it went, as it was sent
  std::uint64_t faults = 0;  ///< bytes dropped, doubled, flipped, held back; and cuts
};

/// The wire between a driver and its machine in virtual time, as quick as the real one.
class FaultLine {
 public:
  virtual ~FaultLine() = default;

  /// Moves what is due at `now` on. @return  the time afterwards: a clocked exchange takes time.
  virtual Instant turn(Instant now) = 0;
  /// When the line has something to do next.
  virtual std::optional<Instant> next_event() const = 0;
  /// From now on; nothing of what is under way is lost. A clocked wire takes flips and cuts only.
  virtual void set_faults(const sim::LinkFaultSpec& spec, Instant now) = 0;
  /// The port goes away and comes back: what was under way is lost.
  virtual void clear(Instant now) = 0;
  /// One bit of the byte that goes this way behind `bytes_first` others.
  virtual void flip_once(sim::LinkDirection direction, std::uint64_t bytes_first, unsigned bit) = 0;
  virtual bool flip_pending() const = 0;
  virtual void cancel_flips() = 0;
  virtual LineCounts counts() const = 0;
  /// No byte is under way.
  bool quiet() const { return !next_event(); }

  /// What goes to the device, as it is handed to the wire: byte by byte, or an exchange at once;
  /// when its first clock begins and when its last one ends.
  std::function<void(std::span<const std::uint8_t>, Instant begins, Instant ends)> tap;
};

std::unique_ptr<FaultLine> byte_line(ByteDriver& driver, sim::ByteMachine& machine,
                                     Duration byte_time, Instant now);
std::unique_ptr<FaultLine> spi_line(SpiDriver& driver, sim::SpiMachine& machine, Instant now);

/// A robot's own driver and a machine, its simulated one or another, back to back. Time goes from
/// event to event.
class FaultCell {
 public:
  /// What everything that looks at a cell is called after.
  using Look = std::function<void(const std::optional<DriverEvent>&)>;

  /// @param robot  as variant_of() made it; outlives the cell. @param seed  of the machine
  FaultCell(const RobotModel& robot, const MachineVariant& options, Duration warm_up);
  /// @param machine  that answers as the robot's device does
  FaultCell(const RobotModel& robot, RobotMachine machine, Duration warm_up);

  Driver& driver() const { return driver_.get(); }
  sim::Machine& machine() const { return machine_.get(); }
  sim::SpiMachine* spi_machine() const { return machine_.spi.get(); }
  FaultLine& line() { return *line_; }
  const RobotModel& robot() const { return robot_; }
  Instant now() const { return now_; }

  /// A new host on the same machine: the old one is gone without a word.
  void replace_driver();

  /// From event to event, `longest` at most between two looks, until `end`, or until `done` says
  /// so. False where driver and machine keep each other awake without time passing.
  bool run_to(Instant end, Duration longest, const std::function<bool()>& done);

  /// Every event, and once after every turn with none. Where nobody looks the events stay with the
  /// driver, for a program that runs on it.
  Look look;

 private:
  void turn();

  const RobotModel& robot_;
  RobotDriver driver_;
  RobotMachine machine_;
  std::unique_ptr<FaultLine> line_;
  Instant now_;
};

}  // namespace sinew::test
