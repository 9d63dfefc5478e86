#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "faults/fault_cell.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/journal/journal_files.h"
#include "sinew/sim/memory_disk.h"
#include "support/property.h"
#include "support/trace_hash.h"

namespace sinew::test {

/// How often things happened, of all seeds; a run in which nothing happens proves nothing.
struct SystemCounts {
  std::uint64_t commands = 0;
  std::uint64_t motions_done = 0;
  std::uint64_t faults = 0;  ///< of wires, supplies, disks and hosts
  std::uint64_t kills = 0;
  std::uint64_t power_losses = 0;
  std::uint64_t sunk_supplies = 0;
  std::uint64_t disks_failed = 0;
  std::uint64_t latched = 0;
  std::uint64_t records = 0;
  std::uint64_t looks = 0;
  std::uint64_t back = 0;  ///< stations that were ready again at the end
};

struct Misfortune {
  std::uint64_t number = 0;
  std::string text;  ///< when, to whom, what
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
  /// Supplies sink as well, from now on.
  void let_supplies_sink() { supplies_sink_ = true; }
  /// Misfortunes of these numbers are drawn, and do not happen. @param first  number of this
  /// station's first one
  void spare(const std::set<std::uint64_t>& numbers, std::uint64_t first) {
    spared_ = numbers;
    next_misfortune_ = first;
  }
  /// Those that happened.
  const std::vector<Misfortune>& misfortunes() const { return happened_; }
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
    control::LeaseToken last_lease;  ///< that was given
    std::optional<Instant> disk_failed_at;
    std::uint64_t begun_by_then = 0;  ///< motions
    std::uint64_t begun = 0;          ///< motions, as its events tell
    bool asked_for_lease = false;
  };

  /// A misfortune with all its chance drawn: whether it happens changes no other draw.
  struct Blow {
    std::int64_t dice = 0;
    std::uint64_t seed = 0;
    bool recovers = false;  ///< of a wire: its bytes come as they should again
    Duration delay{};       ///< of its bytes
    Duration cut{};
    Duration sync_max{};     ///< of a slow disk
    bool power_too = false;  ///< of a host that dies
    Duration away{};         ///< until it is started again
    double volts = 0;        ///< of a supply that sinks, as a share of what it should be
  };
  Blow draw_blow();
  std::string strike(const Blow& blow);
  std::string sink_supply(const Blow& blow);
  void look_at_supply();
  void start_anew_where_disk_failed();
  void switch_off_and_on();

  void begin_life();
  void kill(bool power_too, Duration away, std::uint64_t seed);
  void look();
  void write();
  void act();
  void misfortune();
  void command();
  void ask_to_move();
  void declare_truth();
  void look_at_records();
  void look_at_states();
  void look_at_limits();
  void look_at_disk();
  void look_at_lease(const control::LeaseToken& lease);
  void say(const control::Outputs& outputs);
  double resolution(std::size_t joint, JournalKind kind = JournalKind::kRest) const;
  bool guarded() const;

  const RobotModel& robot_;
  Random random_;
  SystemCounts& counts_;
  TraceHash& hash_;
  FaultCell cell_;
  sim::MemoryDisk disk_;
  std::unique_ptr<Host> host_;
  std::optional<Instant> host_returns_;
  std::uint32_t been_inside_ = 0;  ///< joints, as bits
  bool supplies_sink_ = false;
  std::optional<Instant> supply_returns_;
  /// Its modules may have lost their power, and nobody has found out yet.
  bool browned_out_ = false;  ///< and nobody has read it yet
  Instant next_switching_{};
  bool misfortunes_ = true;
  std::set<std::uint64_t> spared_;
  std::uint64_t next_misfortune_ = 0;
  std::vector<Misfortune> happened_;
};

}  // namespace sinew::test
