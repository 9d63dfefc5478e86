#include "sinew/runtime/journal/journal_files.h"

#include <gtest/gtest.h>

#include <map>

#include "sinew/core/dispatch.h"
#include "sinew/runtime/journal/journal_test_cell.h"
#include "sinew/wire/crc32c.h"

namespace sinew::runtime {
namespace {

using test::kEpoch;
using test::kUnit;
using enum JournalFinding;

constexpr std::size_t kJoints = 2;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::array<const char*, 2> kNames{"positions.0", "positions.1"};

/// A run of so many records, and where the truth may be at its end.
class Story {
 public:
  Story(std::size_t records, JournalKind last, std::uint32_t generation_records = 25) {
    JournalSettings settings = test::settings_for(kJoints);
    settings.generation_records = generation_records;
    go(settings, {}, records, last);
  }

  JournalRecovery look() { return look(test::recovery_for(kJoints)); }
  JournalRecovery look(const RecoverySettings& settings) {
    JournalFiles files(disk, "positions");
    return recover(files.load()->files(), settings);
  }
  /// Another run behind it.
  void go_on(std::size_t records, JournalKind last, std::uint32_t generation_records = 1024) {
    const JournalEnd end = look().end;
    disk.kill_process();
    JournalSettings settings = test::settings_for(kJoints);
    settings.generation_records = generation_records;
    go(settings, end, records, last);
  }
  std::array<std::vector<std::uint8_t>, 2> bytes() const {
    return {disk.bytes(kNames[0]).value_or(std::vector<std::uint8_t>{}),
            disk.bytes(kNames[1]).value_or(std::vector<std::uint8_t>{})};
  }
  /// Which of the two files is the newer one.
  std::size_t newer() { return look().end.generation % 2; }

  /// No joint is said to be where it cannot be.
  void expect_never_wrong(const JournalRecovery& recovery) const {
    for (std::size_t k = 0; k < kJoints; ++k) {
      const JointPosition& said = recovery.positions[k];
      if (said.quality == PositionQuality::kLost) continue;
      EXPECT_TRUE(covers({said.lower, said.upper}, truth[k]));
    }
  }

  sim::MemoryDisk disk;
  std::array<JointInterval, kJoints> truth;

 private:
  void tick() {
    wall_ += kSecond / 10;
    disk.set_wall(wall_);
  }
  JournalTime time() const { return {Instant{Duration{wall_ - kEpoch}}, wall_}; }

  void go(const JournalSettings& settings, const JournalEnd& end, std::size_t records,
          JournalKind last) {
    JournalFiles files(disk, "positions");
    ASSERT_TRUE(files.lock());
    files.continue_after(end);
    PositionJournal journal(settings, end);
    const auto write = [&](const JournalRecord& record) {
      tick();
      ASSERT_TRUE(files.write(record));
      ASSERT_TRUE(files.sync());
      journal.durable(files.durable_sequence());
    };
    std::array<JointPosition, kJoints> at;
    for (JointPosition& joint : at) joint = {PositionQuality::kCommanded, 0, 0, 0};
    write(journal.open(at, time()));
    for (std::size_t k = 2; k <= records; ++k) {
      const JournalKind kind =
          k < records ? k % 2 == 0 ? JournalKind::kIntent : JournalKind::kRest : last;
      const double to = static_cast<double>(k) * 1000 * kUnit;
      if (kind == JournalKind::kIntent) {
        std::array<JointInterval, kJoints> next;
        for (std::size_t j = 0; j < kJoints; ++j) next[j] = {at[j].q, to};
        write(*journal.reserve({at, next}, time()));
        truth = next;
        continue;
      }
      for (JointPosition& joint : at) joint = {PositionQuality::kCommanded, to, to, to};
      if (kind == JournalKind::kClosed) write(*journal.close(at, time()));
      if (kind == JournalKind::kRest) write(*journal.at_rest(at, time()));
      if (kind == JournalKind::kLook) write(*journal.look(at, time()));
      truth.fill({to, to});
    }
  }

  std::int64_t wall_ = kEpoch;
};

/// Up to the first empty one.
std::size_t used_slots(std::span<const std::uint8_t> bytes) {
  std::size_t used = 0;
  while (used * kJournalSlotSize < bytes.size() &&
         !is_empty_journal_slot(bytes.subspan(used * kJournalSlotSize, kJournalSlotSize))) {
    ++used;
  }
  return used;
}

bool is_seen(const JournalRecovery& recovery) {
  return recovery.way_out != WayOut::kNothing &&
         std::ranges::all_of(recovery.positions, [](const JointPosition& joint) {
           return joint.quality == PositionQuality::kLost;
         });
}

/// What the version before wrote: no empty slots, and another number in each record.
std::array<std::vector<std::uint8_t>, 2> as_version_2(
    std::array<std::vector<std::uint8_t>, 2> files, std::size_t newer) {
  std::map<std::uint32_t, std::uint32_t> sums{{0, 0}};
  const auto put = [](std::span<std::uint8_t> to, std::uint32_t value) {
    for (std::size_t k = 0; k < 4; ++k) to[k] = static_cast<std::uint8_t>(value >> (8 * k));
  };
  for (const std::size_t file : {1 - newer, newer}) {
    std::vector<std::uint8_t>& bytes = files[file];
    bytes.resize(used_slots(bytes) * kJournalSlotSize);
    for (std::size_t at = 0; at < bytes.size(); at += kJournalSlotSize) {
      const auto record = std::span(bytes).subspan(at, kJournalRecordSize);
      const SealedRecord sealed = *decode_journal_record(record);
      record[4] = 2;
      put(record.subspan(248, 4), sums.at(sealed.seal.previous));
      const std::uint32_t sum = crc32c(record.first(252));
      put(record.subspan(252, 4), sum);
      sums[sealed.checksum] = sum;
      std::ranges::copy(record, record.data() + kJournalRecordSize);
    }
  }
  return files;
}

TEST(JournalFiles, what_was_written_comes_back) {
  Story at_rest(39, JournalKind::kRest);
  const JournalRecovery recovery = at_rest.look();
  EXPECT_EQ(recovery.finding, kEndedAtRest);
  EXPECT_EQ(recovery.way_out, WayOut::kNothing);
  EXPECT_EQ(recovery.positions[1].quality, PositionQuality::kCommanded);
  EXPECT_EQ(recovery.positions[1].q, 39'000 * kUnit);
  EXPECT_EQ(recovery.end.sequence, 39U);
  EXPECT_EQ(recovery.end.generation, 2U);
  EXPECT_EQ(recovery.damaged_slots, 0U);

  Story closed(40, JournalKind::kClosed);
  EXPECT_EQ(closed.look().finding, kCleanEnd);

  Story in_motion(40, JournalKind::kIntent);
  const JournalRecovery moving = in_motion.look();
  EXPECT_EQ(moving.finding, kEndedInMotion);
  EXPECT_EQ(moving.way_out, WayOut::kVerify);
  EXPECT_EQ(moving.positions[0].quality, PositionQuality::kUncertain);
  EXPECT_EQ(moving.positions[0].lower, (39'000 - 2) * kUnit);
  EXPECT_EQ(moving.positions[0].upper, (40'000 + 64 + 48 + 2) * kUnit);
}

// The sanitizers take two minutes for all bits, and find in some of them what they find in all.
#ifdef SINEW_SANITIZED
constexpr std::size_t kBitStride = 37;
#else
constexpr std::size_t kBitStride = 1;
#endif

TEST(JournalFiles, every_flipped_bit_of_forty_records_is_seen_and_harmless) {
  std::size_t flips = 0;
  for (const JournalKind last : {JournalKind::kRest, JournalKind::kIntent}) {
    Story run(last == JournalKind::kRest ? 39 : 40, last);
    const JournalRecovery expected = run.look();
    const auto bytes = run.bytes();
    JournalFiles files(run.disk, "positions");
    JournalBytes journal = *files.load();
    for (std::size_t file = 0; file < 2; ++file) {
      // The last record of all, whose loss would matter most, in both runs; the rest in one.
      const std::size_t first = last == JournalKind::kRest && file == expected.end.generation % 2
                                    ? (used_slots(bytes[file]) - 2) * kJournalSlotSize
                                    : 0;
      const std::size_t empty = 8 * kJournalSlotSize * used_slots(bytes[file]);
      // Empty slots are all alike.
      for (std::size_t bit = 8 * first; bit < 8 * bytes[file].size();
           bit += bit < empty ? kBitStride : 61 * kBitStride) {
        std::uint8_t& byte = journal.bytes[file][bit / 8];
        byte = static_cast<std::uint8_t>(byte ^ 1U << (bit % 8));
        const JournalRecovery recovery = recover(journal.files(), test::recovery_for(kJoints));
        byte = static_cast<std::uint8_t>(byte ^ 1U << (bit % 8));
        ASSERT_EQ(recovery.damaged_slots, 1U) << "bit " << bit;
        ASSERT_EQ(recovery.finding, expected.finding) << "bit " << bit;
        for (std::size_t k = 0; k < kJoints; ++k) {
          ASSERT_EQ(recovery.positions[k].lower, expected.positions[k].lower);
          ASSERT_EQ(recovery.positions[k].upper, expected.positions[k].upper);
          ASSERT_EQ(recovery.positions[k].quality, expected.positions[k].quality);
        }
        ++flips;
      }
    }
  }
  EXPECT_GT(flips, 40 * 8 * kJournalSlotSize / kBitStride);
}

TEST(JournalFiles, spoiled_slots_never_leave_an_exact_position_that_is_wrong) {
  for (const JournalKind last : {JournalKind::kRest, JournalKind::kIntent}) {
    Story run(last == JournalKind::kRest ? 39 : 40, last);
    const std::size_t newer = run.newer();
    const auto whole = run.bytes()[newer];
    const std::size_t slots = used_slots(whole);
    for (std::size_t spoiled = 1; spoiled <= slots; ++spoiled) {
      auto bytes = whole;
      // A medium's two ways to say that there is nothing.
      std::fill_n(bytes.begin() + static_cast<long>((slots - spoiled) * kJournalSlotSize),
                  spoiled * kJournalSlotSize,
                  spoiled % 2 == 0 ? std::uint8_t{0xFF} : std::uint8_t{0});
      run.disk.rot(kNames[newer], bytes);
      const JournalRecovery recovery = run.look();
      const bool as_a_crash = spoiled <= PositionJournal::kUnsyncedMax && spoiled < slots;
      EXPECT_EQ(recovery.finding, as_a_crash        ? kDamagedTail
                                  : spoiled < slots ? kUnreadable
                                                    : kOlderCopy);
      EXPECT_NE(recovery.way_out, WayOut::kNothing);
      for (const JointPosition& joint : recovery.positions) {
        EXPECT_LE(joint.quality, PositionQuality::kUncertain);
        EXPECT_TRUE(as_a_crash || joint.quality == PositionQuality::kLost);
      }
    }
  }
}

TEST(JournalFiles, spoiled_slot_in_the_middle_does_no_harm) {
  Story run(39, JournalKind::kRest);
  for (std::size_t file = 0; file < 2; ++file) {
    const auto whole = run.bytes()[file];
    const bool newer = file == run.newer();
    const std::size_t end = used_slots(whole) * kJournalSlotSize;
    for (std::size_t at = newer ? kJournalSlotSize : 0; at + kJournalSlotSize < end;
         at += kJournalSlotSize) {
      auto bytes = whole;
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), kJournalSlotSize,
                  std::uint8_t{0});
      run.disk.rot(kNames[file], bytes);
      const JournalRecovery recovery = run.look();
      EXPECT_EQ(recovery.finding, kEndedAtRest) << "file " << file << " at " << at;
      EXPECT_EQ(recovery.damaged_slots, 1U);
      run.expect_never_wrong(recovery);
    }
    run.disk.rot(kNames[file], whole);
  }
}

TEST(JournalFiles, file_cut_off_anywhere_by_hand_is_seen) {
  Story run(40, JournalKind::kIntent);
  const std::size_t newer = run.newer();
  const auto whole = run.bytes()[newer];
  run.disk.set_wall(kEpoch + 7200 * kSecond);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    run.disk.overwrite(kNames[newer], {whole.begin(), whole.begin() + static_cast<long>(size)});
    const JournalRecovery recovery = run.look();
    for (const JointPosition& joint : recovery.positions) {
      ASSERT_EQ(joint.quality, PositionQuality::kLost) << size;
    }
    ASSERT_NE(recovery.way_out, WayOut::kNothing);
    ASSERT_TRUE(recovery.finding == kCopied || recovery.finding == kOlderCopy ||
                recovery.finding == kUnreadable)
        << sentence(recovery.finding);
  }
}

TEST(JournalFiles, file_cut_at_any_byte_is_seen_where_more_than_empty_slots_is_gone) {
  Story run(40, JournalKind::kIntent);
  const std::size_t newer = run.newer();
  const auto whole = run.bytes()[newer];
  const std::size_t records = used_slots(whole) * kJournalSlotSize;
  const JournalRecovery expected = run.look();
  std::size_t believed = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // Its stamp is as if nobody had touched it.
    run.disk.rot(kNames[newer], {whole.begin(), whole.begin() + static_cast<long>(size)});
    const JournalRecovery recovery = run.look();
    if (size >= records && recovery.finding == kEndedInMotion) {
      ++believed;
      ASSERT_EQ(recovery.positions[1].upper, expected.positions[1].upper);
      continue;
    }
    ASSERT_TRUE(is_seen(recovery)) << size << ": " << sentence(recovery.finding);
    ASSERT_EQ(recovery.finding, size < kJournalRecordSize ? kOlderCopy : kCut) << size;
    ASSERT_NE(recovery.last_said[0].quality, PositionQuality::kLost);
  }
  EXPECT_LE(believed, kJournalChunkSize);
}

TEST(JournalFiles, file_of_any_length_cut_at_any_border_of_a_slot_is_seen) {
  std::size_t cuts = 0;
  for (std::size_t count = 1; count <= 70; ++count) {
    Story run(count, JournalKind::kRest, 100);
    run.go_on(count, count % 2 == 0 ? JournalKind::kIntent : JournalKind::kClosed, 100);
    const std::size_t newer = run.newer();
    const auto whole = run.bytes()[newer];
    const std::size_t records = used_slots(whole);
    ASSERT_EQ(records, count);
    ASSERT_EQ(whole.size() % kJournalChunkSize, 0U);
    ASSERT_GT(whole.size(), records * kJournalSlotSize);
    for (std::size_t slots = 0; slots < records; ++slots, ++cuts) {
      const auto end = whole.begin() + static_cast<long>(slots * kJournalSlotSize);
      run.disk.overwrite(kNames[newer], {whole.begin(), end});
      ASSERT_TRUE(is_seen(run.look())) << slots << " of " << count;
      // Nor does it help to make it as long as it was.
      std::vector<std::uint8_t> filled(whole.begin(), end);
      filled.resize(whole.size());
      run.disk.overwrite(kNames[newer], filled);
      const JournalRecovery recovery = run.look();
      for (const JointPosition& joint : recovery.positions) {
        ASSERT_LE(joint.quality, PositionQuality::kUncertain) << slots << " of " << count;
      }
    }
    if (count == 1) continue;  // of that file nothing is left to go on from
    // The run behind a cut is believed again.
    run.go_on(3, JournalKind::kRest);
    ASSERT_EQ(run.look().finding, kEndedAtRest) << count;
  }
  EXPECT_EQ(cuts, 70U * 71 / 2);
}

TEST(JournalFiles, last_word_of_a_file_goes_behind_its_last_record_at_any_place) {
  for (std::size_t count = 1; count <= 40; ++count) {
    for (const bool torn : {false, true}) {
      Story run(count, JournalKind::kRest, 100);
      auto bytes = run.bytes()[run.newer()];
      // A crash may have left anything of a record, and of a chunk that was being added.
      const std::size_t used = used_slots(bytes);
      if (torn) std::fill_n(bytes.begin() + static_cast<long>(used * kJournalSlotSize), 99, 'x');
      bytes.resize((used + (torn ? 2 : 1) + 15) / 16 * kJournalChunkSize);
      if (used % 2 == 0) bytes.insert(bytes.end(), 1234, 'y');
      const std::size_t old = run.newer();
      run.disk.rot(kNames[old], bytes);
      ASSERT_EQ(run.look().finding, torn ? kDamagedTail : kEndedAtRest) << count;
      run.go_on(3, JournalKind::kRest);
      ASSERT_EQ(run.look().finding, kEndedAtRest) << count;
      // It is whole again, and contradicts whoever takes the newer one away.
      ASSERT_TRUE(run.disk.remove(kNames[run.newer()]));
      ASSERT_EQ(run.look().finding, kOlderCopy) << count;
    }
  }
}

TEST(JournalFiles, crash_that_keeps_a_record_but_not_the_time_of_its_write_is_no_copy) {
  Story run(20, JournalKind::kIntent);
  JournalFiles files(run.disk, "positions");
  JournalBytes journal = *files.load();
  DiskStamp& stamp = journal.stamps[run.newer()];
  stamp.changed_ns = kEpoch + kSecond;
  EXPECT_EQ(recover(journal.files(), test::recovery_for(kJoints)).finding, kEndedInMotion);
  stamp.changed_ns = kEpoch - 61 * kSecond;
  EXPECT_EQ(recover(journal.files(), test::recovery_for(kJoints)).finding, kCopied);
}

TEST(JournalFiles, files_of_the_version_before_are_read_as_ever) {
  for (const JournalKind last : {JournalKind::kClosed, JournalKind::kIntent}) {
    Story run(40, last);
    const JournalRecovery expected = run.look();
    const std::size_t newer = run.newer();
    const auto old = as_version_2(run.bytes(), newer);
    for (std::size_t k = 0; k < 2; ++k) run.disk.rot(kNames[k], old[k]);
    const JournalRecovery recovery = run.look();
    EXPECT_EQ(recovery.finding, expected.finding);
    EXPECT_EQ(recovery.positions[1].upper, expected.positions[1].upper);
    EXPECT_EQ(recovery.damaged_slots, 0U);
    auto torn = old[newer];
    torn.insert(torn.end(), 100, std::uint8_t{0});
    run.disk.rot(kNames[newer], torn);
    EXPECT_EQ(run.look().finding, kDamagedTail);
    run.disk.rot(kNames[newer], old[newer]);
    run.go_on(3, JournalKind::kRest);
    EXPECT_EQ(run.look().finding, kEndedAtRest);
    EXPECT_EQ(run.look().damaged_slots, 0U);
    ASSERT_TRUE(run.disk.remove(kNames[run.newer()]));
    EXPECT_EQ(run.look().finding, kOlderCopy);
  }
}

TEST(JournalFiles, older_copy_of_one_file_contradicts_the_other) {
  Story run(10, JournalKind::kRest);
  const auto old = run.bytes();
  const std::size_t old_newer = run.newer();
  run.go_on(10, JournalKind::kRest);  // generation 2
  run.go_on(10, JournalKind::kRest);  // generation 3, in the place of 1
  ASSERT_EQ(run.look().finding, kEndedAtRest);
  ASSERT_EQ(run.newer(), old_newer);
  const auto kept = run.bytes();
  // Nothing else than its bytes is looked at here: stamps are as if nobody had touched it.
  run.disk.rot(kNames[old_newer], old[old_newer]);
  EXPECT_EQ(run.look().finding, kOlderCopy);
  EXPECT_EQ(run.look().way_out, WayOut::kVerify);
  EXPECT_EQ(run.look().positions[0].quality, PositionQuality::kLost);
  // The newer one is missing.
  ASSERT_TRUE(run.disk.remove(kNames[old_newer]));
  EXPECT_EQ(run.look().finding, kOlderCopy);
  // The older one is missing, or comes twice: the newer stands by itself, the other does not.
  Story again(10, JournalKind::kRest);
  again.go_on(10, JournalKind::kRest);
  const std::size_t newer = again.newer();
  const auto bytes = again.bytes();
  again.disk.rot(kNames[1 - newer], bytes[newer]);
  EXPECT_EQ(again.look().finding, kOlderCopy);
  ASSERT_TRUE(again.disk.remove(kNames[1 - newer]));
  EXPECT_EQ(again.look().finding, kEndedAtRest);
}

TEST(JournalFiles, older_copies_of_both_files_are_seen_by_their_stamps_and_else_not) {
  Story run(10, JournalKind::kRest);
  run.go_on(10, JournalKind::kRest);
  const auto old = run.bytes();
  run.go_on(10, JournalKind::kRest);
  for (std::size_t k = 0; k < 2; ++k) run.disk.replace(kNames[k], old[k]);
  EXPECT_EQ(run.look().finding, kCopied);
  EXPECT_EQ(run.look().positions[0].quality, PositionQuality::kLost);
  EXPECT_EQ(run.look().last_said[0].q, 10'000 * kUnit);

  Story other(10, JournalKind::kRest);
  const auto once = other.bytes()[1];
  other.go_on(10, JournalKind::kRest);
  other.go_on(10, JournalKind::kRest);
  ASSERT_TRUE(other.disk.remove(kNames[0]));
  other.disk.set_wall(kEpoch + 3600 * kSecond);
  other.disk.overwrite(kNames[1], once);
  EXPECT_EQ(other.look().finding, kCopied);
  // A whole disk that is put back brings its stamps along: nobody can tell. docs/journal.md.
  Story image(10, JournalKind::kRest);
  image.go_on(10, JournalKind::kRest);
  sim::MemoryDisk backup = image.disk;
  image.go_on(20, JournalKind::kRest);
  image.disk = backup;
  EXPECT_EQ(image.look().finding, kEndedAtRest);
}

TEST(JournalFiles, who_died_while_a_device_told_what_it_forgets_leaves_room_for_it) {
  RecoverySettings settings = test::recovery_for(kJoints);
  for (std::size_t k = 0; k < kJoints; ++k) settings.forgotten_way.push_back(0.5);
  for (const JournalKind last : {JournalKind::kRest, JournalKind::kIntent, JournalKind::kClosed}) {
    Story run(20, last);
    EXPECT_EQ(run.look(settings).positions[1].lower, run.look().positions[1].lower);
    EXPECT_EQ(run.look(settings).positions[1].quality, run.look().positions[1].quality);
  }
  Story run(21, JournalKind::kLook);
  EXPECT_EQ(run.look(settings).finding, kEndedInLook);
  EXPECT_EQ(run.look(settings).way_out, WayOut::kVerify);
  EXPECT_FALSE(run.look(settings).power_up_added);
  const JointPosition joint = run.look(settings).positions[1];
  EXPECT_EQ(joint.quality, PositionQuality::kUncertain);
  EXPECT_EQ(joint.q, 21'000 * kUnit);
  EXPECT_EQ(joint.lower, 21'000 * kUnit - 0.5);
  EXPECT_EQ(joint.upper, 21'000 * kUnit + 0.5);
  // Of a device that forgets nothing it says what a rest says.
  EXPECT_EQ(run.look().way_out, WayOut::kNothing);
  // A last write that did not come through may have been one.
  Story torn(20, JournalKind::kIntent);
  auto bytes = torn.bytes()[torn.newer()];
  const double lower = torn.look(settings).positions[1].lower;
  std::fill_n(bytes.begin() + static_cast<long>(used_slots(bytes) * kJournalSlotSize),
              kJournalSlotSize, std::uint8_t{0});
  torn.disk.rot(kNames[torn.newer()], bytes);
  EXPECT_EQ(torn.look(settings).finding, kDamagedTail);
  EXPECT_EQ(torn.look(settings).positions[1].lower, lower - 0.5);
}

TEST(JournalFiles, records_that_do_not_follow_one_another_are_no_journal) {
  Story run(39, JournalKind::kRest);
  const std::size_t newer = run.newer();
  const auto whole = run.bytes()[newer];
  const auto slot = [&](std::size_t k) {
    return std::span(whole).subspan(k * kJournalSlotSize, kJournalSlotSize);
  };
  const std::size_t slots = used_slots(whole);
  // One taken out, two exchanged, one repeated, one of another run put in.
  for (std::size_t k = 0; k + 1 < slots; ++k) {
    auto without = whole;
    const auto at = without.begin() + static_cast<std::ptrdiff_t>(k * kJournalSlotSize);
    without.erase(at, at + kJournalSlotSize);
    run.disk.rot(kNames[newer], without);
    EXPECT_TRUE(run.look().finding == kEdited || (k == 0 && run.look().finding == kEndedAtRest))
        << k;
    auto exchanged = whole;
    std::ranges::copy(slot(k), exchanged.begin() + static_cast<long>((k + 1) * kJournalSlotSize));
    std::ranges::copy(slot(k + 1), exchanged.begin() + static_cast<long>(k * kJournalSlotSize));
    run.disk.rot(kNames[newer], exchanged);
    EXPECT_EQ(run.look().finding, kEdited);
    auto repeated = whole;
    std::ranges::copy(slot(k), repeated.begin() + static_cast<long>(slots * kJournalSlotSize));
    run.disk.rot(kNames[newer], repeated);
    EXPECT_EQ(run.look().finding, kEdited);
  }
  Story other(39, JournalKind::kRest, 24);
  auto mixed = whole;
  const auto foreign = other.bytes()[other.newer()];
  std::copy_n(foreign.begin() + static_cast<long>((used_slots(foreign) - 1) * kJournalSlotSize),
              kJournalSlotSize, mixed.begin() + static_cast<long>((slots - 1) * kJournalSlotSize));
  run.disk.rot(kNames[newer], mixed);
  EXPECT_EQ(run.look().finding, kEdited);
}

TEST(JournalFiles, another_robot_or_model_is_not_this_one) {
  Story run(9, JournalKind::kClosed);
  RecoverySettings settings = test::recovery_for(kJoints);
  settings.owner.model ^= 1;
  EXPECT_EQ(run.look(settings).finding, kOtherModel);
  // Its positions may still be good for a look.
  EXPECT_EQ(run.look(settings).last_said[0].q, 9'000 * kUnit);
  EXPECT_EQ(run.look(settings).way_out, WayOut::kVerify);
  settings.owner.robot ^= 1;
  EXPECT_EQ(run.look(settings).finding, kOtherRobot);
  EXPECT_EQ(run.look(settings).way_out, WayOut::kRecovery);
  settings.can_home = true;
  EXPECT_EQ(run.look(settings).way_out, WayOut::kHome);
  EXPECT_EQ(run.look(test::recovery_for(3)).finding, kOtherModel);
  EXPECT_EQ(run.look(test::recovery_for(3)).positions.size(), 3U);
}

TEST(JournalFiles, power_up_way_makes_intervals_honest) {
  Story run(9, JournalKind::kClosed);
  RecoverySettings settings = test::recovery_for(kJoints);
  settings.power_up_way = {32 * kUnit, std::numeric_limits<double>::infinity()};
  const JournalRecovery recovery = run.look(settings);
  EXPECT_TRUE(recovery.power_up_added);
  EXPECT_EQ(recovery.finding, kCleanEnd);
  EXPECT_EQ(recovery.positions[0].quality, PositionQuality::kUncertain);
  EXPECT_EQ(recovery.positions[0].lower, (9'000 - 32) * kUnit);
  EXPECT_EQ(recovery.positions[0].upper, (9'000 + 32) * kUnit);
  EXPECT_EQ(recovery.positions[1].quality, PositionQuality::kLost);
  settings.power_may_have_failed = false;
  EXPECT_EQ(run.look(settings).positions[0].quality, PositionQuality::kCommanded);
  EXPECT_FALSE(run.look(settings).power_up_added);
}

TEST(JournalFiles, measured_joints_are_measured_whatever_the_journal_says) {
  Story run(40, JournalKind::kIntent);
  const RecoverySettings settings = test::recovery_for(kJoints);
  JournalRecovery recovery = run.look(settings);
  std::array<JointPosition, kJoints> told{JointPosition{PositionQuality::kMeasured, 1, 0.9, 1.1},
                                          JointPosition{}};
  take_measured(recovery, told, settings);
  EXPECT_EQ(recovery.positions[0].quality, PositionQuality::kMeasured);
  EXPECT_EQ(recovery.positions[1].quality, PositionQuality::kUncertain);
  EXPECT_EQ(recovery.way_out, WayOut::kVerify);
  told[1] = told[0];
  take_measured(recovery, told, settings);
  EXPECT_EQ(recovery.way_out, WayOut::kNothing);
}

TEST(JournalFiles, second_writer_is_refused) {
  sim::MemoryDisk disk;
  JournalFiles first(disk, "positions");
  JournalFiles second(disk, "positions");
  EXPECT_TRUE(first.lock());
  const auto refused = second.lock();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, DiskErrorCode::kLocked);
}

TEST(JournalFiles, no_journal_is_told_and_foreign_bytes_are_none) {
  sim::MemoryDisk disk;
  JournalFiles files(disk, "positions");
  EXPECT_EQ(recover(files.load()->files(), test::recovery_for(1)).finding, kNothing);
  disk.replace("positions.0", {'x', '=', '1', '\n'});
  EXPECT_EQ(recover(files.load()->files(), test::recovery_for(1)).finding, kUnreadable);
  EXPECT_EQ(recover(files.load()->files(), test::recovery_for(1)).way_out, WayOut::kRecovery);
  disk.replace("positions.0", std::vector<std::uint8_t>(JournalFiles::kFileMax + 1));
  EXPECT_EQ(files.load().error().code, DiskErrorCode::kTooLarge);
}

}  // namespace
}  // namespace sinew::runtime
