#include "sinew/control/journal_recovery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sinew/core/assert.h"

namespace sinew {
namespace {

using enum JournalFinding;

/// One file, read slot by slot.
struct Generation {
  std::optional<SealedRecord> first;
  std::optional<SealedRecord> last;      ///< of its own generation
  std::optional<SealedRecord> succeeds;  ///< the first record of the next one, as its last word
  std::size_t damaged = 0;               ///< slots, or pieces of one
  std::size_t damaged_behind = 0;        ///< slots behind the last good one that are not empty
  std::uint64_t next = 0;                ///< as JournalEnd has them
  std::uint64_t length = 0;
  bool cut = false;
  bool broken_chain = false;
  bool newer = false;
  bool any_bytes = false;
};

std::optional<SealedRecord> read_slot(std::span<const std::uint8_t> slot, Generation& generation) {
  const auto first = slot.first(std::min(kJournalRecordSize, slot.size()));
  const auto second = slot.subspan(first.size());
  const auto record = decode_journal_record(first);
  if (record && std::ranges::equal(first, second)) return record;
  if (record) {
    ++generation.damaged;
    // Two whole records in one slot: somebody put them there.
    generation.broken_chain |= decode_journal_record(second).has_value();
    return record;
  }
  // Of an empty one with a bit turned over too.
  generation.damaged +=
      std::ranges::all_of(slot, [](std::uint8_t byte) { return byte == kJournalEmpty; }) ? 0 : 1;
  generation.newer |= is_newer_journal_record(first) || is_newer_journal_record(second);
  return decode_journal_record(second);
}

/// Whether `next` may stand `slots` slots behind `before`.
bool follows(const SealedRecord& before, const SealedRecord& next, std::size_t slots) {
  const std::uint64_t steps = next.record.sequence - before.record.sequence;
  // The run behind a crash does not count what the crash spoiled.
  const bool in_place =
      next.record.generation == before.record.generation ? steps == slots : steps <= slots;
  return in_place && steps > 0 && (steps > 1 || next.seal.previous == before.checksum);
}

std::span<const std::uint8_t> slot_at(std::span<const std::uint8_t> bytes, std::size_t slot) {
  const std::size_t at = slot * kJournalSlotSize;
  return bytes.subspan(at, std::min(kJournalSlotSize, bytes.size() - at));
}

/// What stands behind the last good record, which is in slot `last` of `slots`.
void read_tail(std::span<const std::uint8_t> bytes, std::size_t last, std::size_t slots,
               Generation& generation) {
  constexpr std::size_t kChunk = kJournalChunkSize / kJournalSlotSize;
  std::size_t used = last + 1;
  std::size_t length = 0;
  if (generation.first->version < 3) {
    used = slots;
  } else {
    // Only where the last slot of a chunk is used was the next chunk safe; else it may be anything.
    do {
      const std::size_t from = used;
      length = (from / kChunk + 1) * kChunk;
      for (std::size_t k = from; k < std::min(length, slots); ++k) {
        if (!is_empty_journal_slot(slot_at(bytes, k))) used = k + 1;
      }
    } while (used == length);
  }
  generation.damaged_behind = used - last - 1;
  generation.next = used * kJournalSlotSize;
  generation.length = length * kJournalSlotSize;
  generation.cut = bytes.size() < generation.length;
}

Generation read_generation(std::span<const std::uint8_t> bytes) {
  Generation generation;
  generation.any_bytes = !bytes.empty();
  std::optional<SealedRecord> before;
  std::size_t last = 0;
  const std::size_t slots = (bytes.size() + kJournalSlotSize - 1) / kJournalSlotSize;
  for (std::size_t k = 0; k < slots; ++k) {
    const auto sealed = read_slot(slot_at(bytes, k), generation);
    if (!sealed) continue;
    // Behind a record that names the next generation nothing is written.
    if (generation.succeeds) generation.broken_chain = true;
    if (before && !follows(*before, *sealed, k - last)) generation.broken_chain = true;
    if (!generation.first) generation.first = sealed;
    const std::uint32_t own = generation.first->record.generation;
    if (sealed->record.generation == own) {
      generation.last = sealed;
    } else if (sealed->record.generation == own + 1) {
      generation.succeeds = sealed;
    } else {
      generation.broken_chain = true;
    }
    before = sealed;
    last = k;
  }
  if (before) read_tail(bytes, last, slots, generation);
  return generation;
}

/// Why what the two files say together cannot be trusted; nothing where it can.
std::optional<JournalFinding> distrust(const Generation& newest, const Generation& other,
                                       const JournalFile& file, const RecoverySettings& settings) {
  const JournalRecord& last = newest.last->record;
  if (last.owner.robot != settings.owner.robot) return kOtherRobot;
  if (last.owner.model != settings.owner.model) return kOtherModel;
  if (last.positions.size() != settings.joints) return kOtherModel;
  if (newest.broken_chain || other.broken_chain) return kEdited;
  // The last word of a file is that another one goes on; then that has to be there.
  if (newest.succeeds) return kOlderCopy;
  if (other.first) {
    if (other.first->record.generation + 1 != last.generation) return kOlderCopy;
    if (other.last->record.sequence >= newest.first->record.sequence) return kEdited;
  }
  if (other.succeeds) {
    const std::uint64_t begins = other.succeeds->record.sequence;
    if (begins > newest.first->record.sequence) return kOlderCopy;
    if (begins == newest.first->record.sequence &&
        other.succeeds->checksum != newest.first->checksum) {
      return kEdited;
    }
  }
  const std::uint64_t identity = newest.first->seal.file;
  if (identity != 0 && file.stamp.identity != 0 && identity != file.stamp.identity) return kCopied;
  // Records are written over what stands there: a crash may keep one and not the time of its write.
  const Duration late{file.stamp.changed_ns - last.time.wall_ns};
  // A clock that was set back meanwhile leaves the first record alone behind it.
  const std::int64_t oldest = std::min(newest.first->record.time.wall_ns, last.time.wall_ns);
  const Duration early{oldest - file.stamp.changed_ns};
  if (file.stamp.changed_ns != 0 && last.time.wall_ns != 0 &&
      (late > settings.stamp_tolerance || early > settings.stamp_tolerance)) {
    return kCopied;
  }
  if (newest.cut) return kCut;
  return std::nullopt;
}

JournalFinding finding_of(JournalKind kind) {
  switch (kind) {
    case JournalKind::kIntent:
      return kEndedInMotion;
    case JournalKind::kLook:
      return kEndedInLook;
    case JournalKind::kClosed:
      return kCleanEnd;
    case JournalKind::kOpened:
    case JournalKind::kDeclared:
    case JournalKind::kHomed:
    case JournalKind::kMeasured:
    case JournalKind::kRest:
    case JournalKind::kLost:
      break;
  }
  return kEndedAtRest;
}

/// What remains of a joint that was said to stand there. Where the last write is spoiled, a joint
/// that was known is lost: that write may have been the one that let it move. An interval stays,
/// for a crash spoils only what was not safe yet, and nothing moves by that.
JointPosition remembered(const JointPosition& said, bool spoiled, double way) {
  if (said.quality == PositionQuality::kLost || !std::isfinite(way)) {
    return {.count_zero = said.count_zero};
  }
  if (spoiled && said.quality != PositionQuality::kUncertain) return {};
  JointPosition joint = said;
  joint.lower -= way;
  joint.upper += way;
  // Nobody measures now what was measured then.
  if (joint.quality == PositionQuality::kMeasured) joint.quality = PositionQuality::kCommanded;
  if (way > 0) joint.quality = PositionQuality::kUncertain;
  return joint;
}

WayOut way_out_of(const JournalRecovery& recovery, bool can_home) {
  const auto known = [](const JointPosition& joint) {
    return joint.quality >= PositionQuality::kCommanded;
  };
  const auto said = [](const JointPosition& joint) {
    return joint.quality != PositionQuality::kLost;
  };
  if (!recovery.positions.empty() && std::ranges::all_of(recovery.positions, known)) {
    return WayOut::kNothing;
  }
  if (can_home) return WayOut::kHome;
  const bool comparable =
      !recovery.last_said.empty() && std::ranges::all_of(recovery.last_said, said);
  return comparable ? WayOut::kVerify : WayOut::kRecovery;
}

JournalFinding finding_without_records(const Generation& a, const Generation& b) {
  if (a.newer || b.newer) return kNewer;
  return a.any_bytes || b.any_bytes ? kUnreadable : kNothing;
}

void take_positions(JournalRecovery& recovery, const Generation& newest,
                    const RecoverySettings& settings) {
  const JournalRecord& last = newest.last->record;
  recovery.finding = finding_of(last.kind);
  const bool spoiled = newest.damaged_behind > 0;
  recovery.memory = {last.kind == JournalKind::kIntent && !spoiled,
                     last.cause == JournalCause::kHeld, last.counted};
  if (spoiled) recovery.finding = kDamagedTail;
  if (!spoiled) recovery.last = last;
  // What is spoiled behind it may have been one.
  const bool forgotten = last.kind == JournalKind::kLook || spoiled;
  for (std::size_t k = 0; k < settings.joints; ++k) {
    double way = 0;
    if (settings.power_may_have_failed && !settings.power_up_way.empty()) {
      way = settings.power_up_way[k];
    }
    recovery.power_up_added |= way > 0;
    if (forgotten && !settings.forgotten_way.empty()) way += settings.forgotten_way[k];
    recovery.positions[k] = remembered(last.positions[k], spoiled, way);
  }
}

}  // namespace

JournalRecovery recover(std::span<const JournalFile, 2> files, const RecoverySettings& settings) {
  SINEW_ASSERT(settings.joints > 0 && settings.joints <= kMaxJoints);
  SINEW_ASSERT(settings.power_up_way.empty() || settings.power_up_way.size() == settings.joints);
  SINEW_ASSERT(settings.forgotten_way.empty() || settings.forgotten_way.size() == settings.joints);
  JournalRecovery recovery;
  recovery.positions.resize(settings.joints);
  recovery.last_said.resize(settings.joints);
  const std::array generations{read_generation(files[0].bytes), read_generation(files[1].bytes)};
  recovery.damaged_slots = generations[0].damaged + generations[1].damaged;

  const auto sequence = [&](std::size_t k) {
    return generations[k].last ? generations[k].last->record.sequence : 0;
  };
  const std::size_t at = sequence(1) > sequence(0) ? 1 : 0;
  const Generation& newest = generations[at];
  const Generation& other = generations[1 - at];
  if (!newest.last) {
    recovery.finding = finding_without_records(newest, other);
    recovery.way_out = way_out_of(recovery, settings.can_home);
    return recovery;
  }

  const SealedRecord& end = newest.succeeds ? *newest.succeeds : *newest.last;
  recovery.end = {end.record.sequence, end.record.generation, end.checksum};
  // Of a file that names its successor nothing is known there.
  if (!newest.succeeds) recovery.end.next = newest.next, recovery.end.length = newest.length;
  recovery.last_time = newest.last->record.time;
  const auto reason = distrust(newest, other, files[at], settings);
  if (reason != kOtherRobot && newest.last->record.positions.size() == settings.joints) {
    recovery.last_said = newest.last->record.positions;
  }
  if (newest.newer || other.newer) {
    recovery.finding = kNewer;
  } else if (reason) {
    recovery.finding = *reason;
  } else if (newest.damaged_behind > PositionJournal::kUnsyncedMax ||
             (other.any_bytes && !other.first)) {
    // Files appear under their names only when they are whole; a crash leaves no such thing.
    recovery.finding = kUnreadable;
  } else {
    take_positions(recovery, newest, settings);
  }
  recovery.way_out = way_out_of(recovery, settings.can_home);
  return recovery;
}

void take_measured(JournalRecovery& recovery, std::span<const JointPosition> positions,
                   const RecoverySettings& settings) {
  SINEW_ASSERT(positions.size() == recovery.positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    if (positions[k].quality == PositionQuality::kMeasured) recovery.positions[k] = positions[k];
  }
  recovery.way_out = way_out_of(recovery, settings.can_home);
}

std::string_view sentence(JournalFinding finding) {
  static constexpr std::array kSentences = std::to_array<std::string_view>({
      "there is no position journal yet",
      "the position journal was written by a later version of this program",
      "the position journal is of another robot",
      "the position journal is of this robot with other zeros, gears or geometry",
      "the position journal was edited: its records do not follow one another",
      "the newer file of the position journal is missing, or an older copy was put in its place",
      "the position journal was copied here, or changed by something else than this program",
      "the position journal is truncated: the end of its newer file is missing",
      "the position journal is damaged beyond what a crash leaves",
      "the last write to the position journal did not come through whole",
      "the last run ended while the machine was moving",
      "the last run ended while it asked the machine whether its supply had held, which forgets "
      "that "
      "by telling",
      "the last run ended unexpectedly, with no motion to a target under way",
      "the last run ended in order",
  });
  static_assert(kSentences.size() == static_cast<std::size_t>(kCleanEnd) + 1);
  return kSentences[static_cast<std::size_t>(finding)];
}

std::string_view sentence(WayOut way_out) {
  static constexpr std::array kSentences = std::to_array<std::string_view>({
      "every joint is known",
      "look whether the machine stands where it is shown, and confirm or correct it",
      "home it",
      "move it joint by joint to a place that is known, and declare that place",
  });
  return kSentences[static_cast<std::size_t>(way_out)];
}

}  // namespace sinew
