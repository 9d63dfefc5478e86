#include "sinew/runtime/journal/journal_writer.h"

#include <gtest/gtest.h>

#include <thread>

#include "sinew/io/disk_folder.h"
#include "sinew/runtime/journal/journal_test_cell.h"
#include "support/allocation_guard.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

using sinew::test::AllocationCounter;
using sinew::test::ScratchFolder;

constexpr std::size_t kJoints = 6;

JournalRecord record_at(std::uint64_t sequence, std::uint32_t generation = 1) {
  JournalRecord record;
  record.kind = JournalKind::kRest;
  record.sequence = sequence;
  record.generation = generation;
  record.owner = test::settings_for(kJoints).owner;
  const auto q = static_cast<double>(sequence);
  for (std::size_t k = 0; k < kJoints; ++k) {
    record.positions.push_back({PositionQuality::kCommanded, q, q, q});
  }
  return record;
}

JournalRecovery look(Disk& disk) {
  JournalFiles files(disk, "positions");
  return recover(files.load()->files(), test::recovery_for(kJoints));
}

TEST(JournalPump, nothing_shows_before_the_disk_is_done) {
  sim::MemoryDisk disk;
  JournalFiles files(disk, "positions");
  JournalPump pump(files);
  EXPECT_FALSE(pump.work());
  EXPECT_TRUE(pump.offer(record_at(1)));
  EXPECT_TRUE(pump.offer(record_at(2)));
  EXPECT_EQ(pump.durable_sequence(), 0U);
  const std::uint64_t syncs = disk.syncs();
  EXPECT_TRUE(pump.work());
  EXPECT_EQ(pump.durable_sequence(), 0U);
  pump.publish();
  EXPECT_EQ(pump.durable_sequence(), 2U);
  EXPECT_FALSE(pump.failed());
  // One for the new file, one for what else was waiting.
  EXPECT_EQ(disk.syncs() - syncs, 2U);
}

TEST(JournalPump, full_queue_refuses_and_allocates_nothing) {
  sim::MemoryDisk disk;
  JournalFiles files(disk, "positions");
  JournalPump pump(files);
  const AllocationCounter allocations;
  std::uint64_t sequence = 1;
  while (pump.offer(record_at(sequence))) ++sequence;
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(sequence - 1, JournalPump::kQueue);
  EXPECT_TRUE(pump.work());
  EXPECT_TRUE(pump.offer(record_at(sequence)));
}

TEST(JournalPump, error_stays_and_is_told) {
  sim::MemoryDisk disk;
  JournalFiles files(disk, "positions");
  JournalPump pump(files);
  ASSERT_TRUE(pump.offer(record_at(1)));
  pump.work();
  pump.publish();
  disk.set_capacity(kJournalChunkSize + 100);
  // Until the file has to grow.
  for (std::uint64_t k = 2; k <= 8; ++k) ASSERT_TRUE(pump.offer(record_at(k)));
  pump.work();
  EXPECT_FALSE(pump.failure());
  pump.publish();
  EXPECT_TRUE(pump.failed());
  EXPECT_EQ(pump.failure()->code, DiskErrorCode::kFull);
  EXPECT_EQ(pump.durable_sequence(), 1U);
  // Room again is no reason to trust it: what it did meanwhile nobody knows.
  disk.set_capacity(1 << 20);
  ASSERT_TRUE(pump.offer(record_at(9)));
  pump.work();
  pump.publish();
  EXPECT_TRUE(pump.failed());
  EXPECT_EQ(pump.durable_sequence(), 1U);
  EXPECT_EQ(disk.bytes("positions.1")->size(), kJournalChunkSize + 100);
}

TEST(JournalWriter, writes_to_a_real_disk_what_recovery_finds) {
  const ScratchFolder scratch;
  auto disk = io::DiskFolder::open_folder(scratch.at("state"));
  ASSERT_TRUE(disk);
  constexpr std::uint64_t kRecords = 300;
  {
    JournalFiles files(*disk, "positions");
    ASSERT_TRUE(files.lock());
    JournalWriter writer(files);
    for (std::uint64_t k = 1; k <= kRecords; ++k) {
      const auto generation = static_cast<std::uint32_t>(1 + k / 100);
      while (!writer.offer(record_at(k, generation))) std::this_thread::yield();
      ASSERT_FALSE(writer.failed());
      ASSERT_LE(writer.durable_sequence(), k);
      if (k % 50 != 0) continue;
      while (writer.durable_sequence() < k) std::this_thread::yield();
      const JournalRecovery recovery = look(*disk);
      EXPECT_EQ(recovery.finding, JournalFinding::kEndedAtRest);
      EXPECT_EQ(recovery.positions[5].q, static_cast<double>(k));
    }
  }
  EXPECT_EQ(look(*disk).end.sequence, kRecords);
  EXPECT_EQ(look(*disk).end.generation, 4U);
  EXPECT_EQ(look(*disk).damaged_slots, 0U);
  EXPECT_EQ(*disk->list(),
            (std::vector<std::string>{"positions.0", "positions.1", "positions.lock"}));
}

TEST(JournalWriter, end_comes_after_what_was_offered) {
  for (std::uint64_t count = 0; count < 16; ++count) {
    sim::MemoryDisk disk;
    JournalFiles files(disk, "positions");
    {
      JournalWriter writer(files);
      for (std::uint64_t k = 1; k <= count; ++k) ASSERT_TRUE(writer.offer(record_at(k)));
    }
    EXPECT_EQ(files.durable_sequence(), count);
  }
}

TEST(JournalWriter, failure_comes_across) {
  sim::MemoryDisk disk;
  disk.fail_from_call(2, {DiskErrorCode::kDenied, 0});
  JournalFiles files(disk, "positions");
  JournalWriter writer(files);
  ASSERT_TRUE(writer.offer(record_at(1)));
  while (!writer.failed()) std::this_thread::yield();
  EXPECT_EQ(writer.failure(), (DiskError{DiskErrorCode::kDenied, 0}));
  EXPECT_EQ(writer.durable_sequence(), 0U);
}

}  // namespace
}  // namespace sinew::runtime
