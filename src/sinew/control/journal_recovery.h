#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "sinew/control/journal_record.h"
#include "sinew/control/position_journal.h"
#include "sinew/core/disk.h"

namespace sinew {

/// What the journal of the run before looks like, worst first where several things are true.
enum class JournalFinding : std::uint8_t {
  kNothing,        ///< there is no journal
  kNewer,          ///< written by a later version of this program
  kOtherRobot,     ///< of another robot
  kOtherModel,     ///< of this robot with other zeros, gears or geometry
  kEdited,         ///< its records do not follow one another: edited by hand
  kOlderCopy,      ///< the newer of its two files is missing, or is an older copy
  kCopied,         ///< its file is a copy, or was changed by somebody else after the last record
  kCut,            ///< its file is shorter than its records say
  kUnreadable,     ///< more damage than what a crash leaves
  kDamagedTail,    ///< the last write did not come through whole
  kEndedInMotion,  ///< the last record is an intent
  kEndedInLook,  ///< the device had been asked what it forgets by telling, and nobody wrote it down
  kEndedAtRest,  ///< the run died while nothing moved
  kCleanEnd,     ///< the run ended in order
};

/// What gets the user from there to positions that may be planned with.
enum class WayOut : std::uint8_t {
  kNothing,   ///< all joints are known
  kVerify,    ///< look whether the machine stands where `last_said` says, and confirm or correct it
  kHome,      ///< find the zeros anew
  kRecovery,  ///< move it joint by joint to a place that is known, and declare that
};

/// One of the two files; empty bytes where it is not there.
struct JournalFile {
  std::span<const std::uint8_t> bytes;
  DiskStamp stamp;
};

struct RecoverySettings {
  JournalOwner owner;
  std::size_t joints = 0;
  /// What each joint may have moved by when the device lost its power and got it again: two full
  /// steps of an open-loop stepper's motor; infinite for what falls or is pushed by hand.
  JointVector power_up_way = {};
  /// What each joint may have done that only an answer told which the device has forgotten since:
  /// counts where the last record is a kLook, or was to be written behind it.
  JointVector forgotten_way = {};
  /// False only where the device itself shows that it kept its power.
  bool power_may_have_failed = true;
  bool can_home = false;
  /// By more than so much a file may not have been changed after its last record, nor be older
  /// than its first one.
  Duration stamp_tolerance = std::chrono::seconds(60);
};

struct JournalRecovery {
  JournalFinding finding = JournalFinding::kNothing;
  WayOut way_out = WayOut::kRecovery;
  /// What may be planned with: kCommanded, kUncertain or kLost; the truth is in [lower, upper].
  JournalPositions positions;
  /// What the last readable record says, for people to compare with; never to plan with. Lost
  /// where none can be read.
  JournalPositions last_said;
  JournalTime last_time;
  bool power_up_added = false;          ///< intervals are wider by power_up_way
  DriverMemory memory;                  ///< what else of the device its last record says
  std::size_t damaged_slots = 0;        ///< in both files, also those that did no harm
  std::optional<JournalRecord> last{};  ///< whole, and what `positions` come from; else nothing
  JournalEnd end;                       ///< for the PositionJournal and the files of the next run
};

/// What is known of each joint, from the bytes of both generations. Bounded by their size.
JournalRecovery recover(std::span<const JournalFile, 2> files, const RecoverySettings& settings);

/// As above where the device can tell: measured joints are that, whatever the journal says.
void take_measured(JournalRecovery& recovery, std::span<const JointPosition> positions,
                   const RecoverySettings& settings);

/// The one table of words for these two.
std::string_view sentence(JournalFinding finding);
std::string_view sentence(WayOut way_out);

}  // namespace sinew
