#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "faults/fault_cell.h"
#include "sinew/control/motion_source.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/journal/journal_files.h"
#include "sinew/runtime/journal/journal_writer.h"
#include "sinew/sim/memory_disk.h"
#include "support/property.h"
#include "system/stop_ear.h"

namespace sinew::test {

/// One stop in the middle of a motion.
struct StopShot {
  /// From the request to the first byte of the first frame that stops; nothing where none was said.
  std::optional<Duration> first_byte = {};
  /// From the end of what the wire was carrying when the request was taken, or from then.
  Duration behind_wire{};
  /// From the end of whatever the wire carried last before it.
  Duration behind_last{};
  /// Frames that moved the machine on, begun behind the request was taken.
  int moved_on = 0;
  Duration standstill{};  ///< from the request
  /// From the request until the driver says that it may go on, the latest that it said.
  std::optional<Duration> goes_on = {};
  /// By which a joint stands beside where its motion would have led; rad or m, the largest.
  double short_of_target = 0;
};

/// A controller on its driver, its wire and its machine, in virtual time, that is told to stop in
/// the middle of one motion after the other.
///
/// The control cycle is as far apart as it may be (2 ms while anything moves): who asks in between
/// waits for the next one. Standstill is the last moment at which a joint was farther than 0.1 deg
/// (0.1 um of a leg) from where it then stays.
class StopRange {
 public:
  static constexpr Duration kCycle = std::chrono::milliseconds(2);

  enum class Journal : std::uint8_t { kNone, kKept };

  /// @param robot    as variant_of() made it; outlives this
  /// @param journal  kKept: records() and events() as well, on a disk that takes no time
  StopRange(const RobotModel& robot, const std::optional<std::string>& profile, std::uint64_t seed,
            Journal journal = Journal::kNone);

  /// Enabled, and where it stands is known.
  void prepare();
  /// A motion from where it stands, and a stop of it at a moment that chance has chosen.
  StopShot shoot();

  /// A motion from where it stands, up to where its driver moves.
  void begin_motion();
  void cycle();
  /// Cycles until it is so. False: it took longer.
  bool wait(const std::function<bool()>& condition, Duration longest);
  control::LocalMachine& machine() { return loop_.machine(); }
  const control::Controller& controller() const { return loop_.controller(); }
  sim::Machine& simulated() { return cell_.machine(); }
  const std::vector<JournalRecord>& records() const { return records_; }
  const std::vector<control::ControlEvent>& events() const { return events_; }
  /// Of the heap, in the controller's steps so far.
  std::uint64_t allocations() const { return allocations_; }

 private:
  struct Look {
    Instant at{};
    JointVector q;
  };

  /// A journal on a disk in memory.
  struct Recorder {
    Recorder();
    sim::MemoryDisk disk;
    runtime::JournalFiles files;
    runtime::JournalPump pump;
  };

  void cycles_until(Instant end);
  void run_to(Instant end);
  void look();
  void declare_truth();
  Duration standstill_since(Instant asked) const;

  const RobotModel& robot_;
  Random random_;
  FaultCell cell_;
  std::unique_ptr<Recorder> recorder_;
  std::vector<JournalRecord> records_;
  std::vector<control::ControlEvent> events_;
  runtime::ControlLoop loop_;
  std::unique_ptr<StopEar> ear_;
  std::unique_ptr<control::MotionSource> motion_;
  JointVector target_;
  Duration planned_{};  ///< how long the motion takes, where nobody stops it
  Instant next_cycle_{};
  Instant wire_free_{};
  std::vector<Instant> ends_;  ///< of what the wire carries, since a stop was asked for
  bool armed_ = false;
  std::optional<Instant> first_stop_;
  int moved_on_ = 0;
  std::vector<Look> looks_;  ///< since a stop was asked for
  bool looking_ = false;
  std::uint64_t allocations_ = 0;
};

}  // namespace sinew::test
