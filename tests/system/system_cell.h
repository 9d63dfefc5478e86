#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "faults/fault_cell.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/journal_files.h"
#include "sinew/sim/memory_disk.h"
#include "support/property.h"

namespace sinew::test {

/// FNV-1a of everything that happens: what went over the wires, states, events, records. Not of
/// doubles.
class TraceHash {
 public:
  void add(std::uint64_t value) {
    for (int k = 0; k < 8; ++k) hash_ = (hash_ ^ (value >> 8 * k & 0xFF)) * 0x100000001B3ULL;
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

/// How often things happened, of all seeds; a run in which nothing happens proves nothing.
struct SystemCounts {
  std::uint64_t commands = 0;
  std::uint64_t motions_done = 0;
  std::uint64_t faults = 0;  ///< of wires, supplies, disks and hosts
  std::uint64_t kills = 0;
  std::uint64_t power_losses = 0;
  std::uint64_t latched = 0;
  std::uint64_t records = 0;
  std::uint64_t looks = 0;
  std::uint64_t back = 0;  ///< stations that were ready again at the end
};

/// One robot: its machine lives on, its host (driver, controller, journal, clients) may die.
class Station {
 public:
  /// @param robot  as variant_of() made it; outlives this
  Station(const RobotModel& robot, const std::optional<std::string>& profile, std::uint64_t seed,
          SystemCounts& counts, TraceHash& hash);

  /// Time goes on by a slice; clients and misfortunes act at its beginning.
  void slice(Duration time);
  /// No more misfortunes: what is wrong is put right, as a person would.
  void heal();
  bool ready() const;
  std::string where() const;
  const RobotModel& robot() const { return robot_; }

 private:
  /// A host's life.
  struct Host {
    Host(const RobotModel& robot, Driver& driver, Disk& disk);
    bool opened = false;
    runtime::JournalFiles files;
    JournalRecovery recovery;
    std::unique_ptr<runtime::JournalPump> pump;
    std::unique_ptr<runtime::ControlLoop> loop;
    /// A controller that dies must not leave motions behind that it still uses.
    std::vector<std::unique_ptr<control::MotionSource>> motions;
    Instant busy_until{};
    std::vector<JournalRecord> claims;  ///< the last one that is safe, and those behind it
    control::LeaseToken stranger{.client = 2};
    bool asked_for_lease = false;
  };

  void begin_life();
  void kill(bool power_too);
  void look();
  void write();
  void act();
  void misfortune();
  void command();
  void ask_to_move();
  void declare_truth();
  void look_at_records();
  void look_at_states();
  void say(const control::Outputs& outputs);
  double resolution(std::size_t joint) const;

  const RobotModel& robot_;
  Random random_;
  SystemCounts& counts_;
  TraceHash& hash_;
  FaultCell cell_;
  sim::MemoryDisk disk_;
  std::unique_ptr<Host> host_;
  std::optional<Instant> host_returns_;
  bool misfortunes_ = true;
};

}  // namespace sinew::test
