#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/control/journal_record.h"

namespace sinew {

/// How far ahead of the motion a joint's steps are reserved; rad, or m of a leg.
struct JournalJoint {
  /// A reservation reaches block + lead beyond what is sent next; where less than lead is left of
  /// it, the next is written. Motion does not wait where lead is the way of the longest sync, and
  /// in constant motion there is one sync a block.
  double block = 0;
  double lead = 0;
  /// What noise on the wire may move it by without being asked, and what a sensor jitters by. Each
  /// reservation and each measured position is wider by so much on either side.
  double slack = 0;
  double lower = -1e9;  ///< no block is laid beyond these limits
  double upper = 1e9;
};

struct JournalSettings {
  JournalOwner owner;
  FixedVector<JournalJoint, kMaxJoints> joints;
  /// A new generation is begun at rest behind so many records, and in motion behind twice as many.
  std::uint32_t generation_records = 1024;
};

/// Where the journal of the run before ends; recovery says so.
struct JournalEnd {
  std::uint64_t sequence = 0;
  std::uint32_t generation = 0;  ///< 0: there is none
  std::uint32_t checksum = 0;    ///< of its last record
  std::uint64_t next = 0;        ///< bytes of its file in front of where the next record goes
  std::uint64_t length = 0;      ///< bytes that its file has; 0 where it only grows (version 2)
};

/// What is about to be sent, one entry a joint. Entries of lost joints are not looked at.
struct JournalMotion {
  /// As the driver says it before anything more is sent.
  std::span<const JointPosition> now;
  /// Where each joint may be from now on once the next is sent: all that was sent before and is
  /// not known to be done, the next, and the way to rest from there.
  std::span<const JointInterval> next;
  /// All that this motion can still want; no block is laid beyond it. Empty: nobody knows.
  std::span<const JointInterval> whole = {};
};

/// What is written before bytes leave, and which bytes may leave. Pure: records come out and
/// somebody writes them, in order, and says how far they are safe on disk.
///
/// The one promise that everything rests on: the truth lies in the last record that is safe and in
/// each one written after it. So whichever of them a crash leaves as the last, it is right.
///
///   what happens                         | record        | motion meanwhile
///   -------------------------------------+---------------+--------------------------------------
///   the run begins                       | kOpened       | none
///   motion begins, or leaves its block   | kIntent       | where old and new reservation agree
///   less than `lead` of the block left   | kIntent       | goes on
///   a look at a device that forgets      | kLook         | none, and no look before it is safe
///   arrived, stopped                     | kRest         | none
///   declared, homed, measured at rest    | kDeclared, .. | none
///   position gone                        | kLost         | none with known joints
///   the run ends                         | kClosed       | none
///
/// Each of them is to be synced at once: at a motion's start and stop, and before a reserved block
/// is used up. Nothing waits for a clock, so nothing is ever older on disk than one sync takes.
/// All members are @rt.
class PositionJournal {
 public:
  /// Records that may be on their way to the disk. Whoever writes them keeps no more unsynced, and
  /// recovery takes no more than that for the remains of a crash.
  static constexpr std::size_t kUnsyncedMax = 8;

  PositionJournal(const JournalSettings& settings, const JournalEnd& end);

  /// The first record of this run, and of a new generation. Once, before anything else.
  JournalRecord open(std::span<const JointPosition> positions, const JournalTime& time);

  /// Up to where the records are safe on disk; each cycle, before the others.
  void durable(std::uint64_t sequence);

  /// Before each sending: what has to be written for it, if anything. Nothing also where the disk
  /// is so slow that kUnsyncedMax records wait for it: may_send() holds the motion then.
  std::optional<JournalRecord> reserve(const JournalMotion& motion, const JournalTime& time);

  /// The next may leave: it, and where the machine may be until then, lies in the last safe record
  /// and in all behind it, and one of these is an intent that is safe.
  bool may_send(std::span<const JointInterval> next) const;

  /// The driver is about to ask its device what that forgets by telling (Driver::looks). Each cycle
  /// until it has: what it has found out so far is recorded. Nothing: as with reserve().
  std::optional<JournalRecord> look(std::span<const JointPosition> positions,
                                    const JournalTime& time);
  /// It may: whichever record a crash leaves as the last says so.
  bool may_look() const;

  /// The machine stands, nothing that was sent is still to be carried out, and the driver has
  /// looked at how it ended (kDone, kStopped). To be asked each cycle at rest: nothing where the
  /// last record says it already, and where too many wait.
  std::optional<JournalRecord> at_rest(std::span<const JointPosition> positions,
                                       const JournalTime& time);
  /// At rest, somebody or something said where it stands. Nothing where too many
  /// records wait: to be said again in the next cycle.
  /// @param kind  kDeclared, kHomed or kMeasured
  std::optional<JournalRecord> told(JournalKind kind, std::span<const JointPosition> positions,
                                    const JournalTime& time);
  /// Some joints are lost; the others are as they are said to be. Nothing: as with told().
  std::optional<JournalRecord> lost(std::span<const JointPosition> positions, JournalCause cause,
                                    const JournalTime& time);
  /// What each record says besides (DriverMemory); at_rest() writes one where it has changed.
  void device_says(bool held_by_stop, std::uint8_t counted) {
    held_ = held_by_stop;
    counted_ = counted;
  }
  /// The run ends, at rest. The last record. Nothing: as with told().
  std::optional<JournalRecord> close(std::span<const JointPosition> positions,
                                     const JournalTime& time);

  /// Of the last record that was handed out.
  std::uint64_t sequence() const { return sequence_; }
  /// All that was handed out is safe.
  bool settled() const { return durable_ >= sequence_; }
  /// The oldest record that is not safe was written more than 100 ms ago: the disk is slow, or
  /// nobody writes. Motion holds by itself where it reaches the end of what is reserved.
  bool overdue(Instant now) const;

  static constexpr Duration kOverdue = std::chrono::milliseconds(100);

 private:
  /// A record that a crash may leave as the last.
  struct Claim {
    std::uint64_t sequence = 0;
    JournalKind kind = JournalKind::kOpened;
    bool held = false;
    std::uint8_t counted = 0;
    Instant written{};
    JournalPositions positions;
  };

  JournalRecord hand_out(JournalKind kind, JournalCause cause, const JournalPositions& positions,
                         const JournalTime& time);
  std::optional<JournalRecord> stand(JournalKind kind, JournalCause cause,
                                     std::span<const JointPosition> positions,
                                     const JournalTime& time);
  JournalPositions standing(std::span<const JointPosition> positions) const;
  JointPosition reserved(std::size_t joint, const JournalMotion& motion) const;
  bool runs_out(std::size_t joint, const JournalMotion& motion) const;

  JournalSettings settings_;
  std::uint64_t sequence_ = 0;
  std::uint64_t durable_ = 0;
  std::uint32_t generation_ = 0;
  std::uint32_t records_ = 0;  ///< of this generation
  bool open_ = false;
  bool held_ = false;
  std::uint8_t counted_ = 0;
  JournalPositions rest_;  ///< as last said while it stood
  /// Oldest first: the last one that is safe, and those behind it.
  FixedVector<Claim, kUnsyncedMax> claims_;
};

}  // namespace sinew
