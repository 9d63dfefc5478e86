#include "sinew/sim/memory_disk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace sinew::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes block(std::uint8_t value, std::size_t size = 512) {
  return Bytes(size, value);
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// What stands in "a" behind a power loss, for each of many seeds.
std::set<Bytes> losses(const MemoryDisk& disk) {
  std::set<Bytes> results;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    MemoryDisk copy = disk;
    copy.lose_power(seed);
    if (const auto bytes = copy.bytes("a")) results.insert(*bytes);
  }
  return results;
}

TEST(MemoryDisk, keeps_what_was_synced_through_every_power_loss) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1)));
  ASSERT_TRUE(disk.sync(file));
  ASSERT_TRUE(disk.sync_folder());
  EXPECT_EQ(losses(disk), std::set{block(1)});
}

TEST(MemoryDisk, spoils_what_was_not_in_every_way) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1)));
  ASSERT_TRUE(disk.sync(file));
  ASSERT_TRUE(disk.sync_folder());
  ASSERT_TRUE(disk.append(file, block(2)));
  ASSERT_TRUE(disk.append(file, block(3)));
  const std::set<Bytes> seen = losses(disk);
  EXPECT_TRUE(std::ranges::all_of(seen, [](const Bytes& bytes) {
    return std::ranges::equal(std::span(bytes).first(512), block(1));
  }));
  EXPECT_TRUE(seen.contains(block(1)));                        // lost
  EXPECT_TRUE(seen.contains(block(1) + block(2) + block(3)));  // kept
  EXPECT_TRUE(seen.contains(block(1) + block(0) + block(3)));  // the later one came first
  EXPECT_TRUE(seen.contains(block(1) + block(2) + block(0)));  // its length came first
  std::set<std::size_t> lengths;
  std::size_t flipped = 0;
  for (const Bytes& bytes : seen) {
    lengths.insert(bytes.size());
    flipped += bytes.size() == 1536 && std::ranges::count(bytes, 1) == 512 &&
                       std::ranges::count(bytes, 2) >= 511 && std::ranges::count(bytes, 3) == 511
                   ? 1
                   : 0;
  }
  EXPECT_GT(lengths.size(), 300U);  // torn at any byte
  EXPECT_GT(flipped, 0U);
}

TEST(MemoryDisk, spoils_what_was_written_over_in_every_way_and_nothing_else) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1, 2048)));
  ASSERT_TRUE(disk.sync(file));
  ASSERT_TRUE(disk.sync_folder());
  ASSERT_TRUE(disk.write(file, 512, block(2)));
  ASSERT_TRUE(disk.write(file, 1024, block(3)));
  const std::set<Bytes> seen = losses(disk);
  EXPECT_TRUE(std::ranges::all_of(seen, [](const Bytes& bytes) {
    return bytes.size() == 2048 && std::ranges::equal(std::span(bytes).first(512), block(1)) &&
           std::ranges::equal(std::span(bytes).last(512), block(1));
  }));
  EXPECT_TRUE(seen.contains(block(1, 2048)));                             // both lost
  EXPECT_TRUE(seen.contains(block(1) + block(2) + block(3) + block(1)));  // both kept
  EXPECT_TRUE(seen.contains(block(1, 1024) + block(3) + block(1)));       // the later one alone
  EXPECT_TRUE(seen.contains(block(1) + block(0) + block(3) + block(1)));
  std::size_t torn = 0;
  for (const Bytes& bytes : seen) {
    const auto twos = std::ranges::count(bytes, 2);
    torn += twos > 0 && twos < 512 && std::ranges::count(bytes, 1) == 1536 - twos ? 1 : 0;
  }
  EXPECT_GT(torn, 100U);  // old and new, divided at any byte
}

TEST(MemoryDisk, full_disk_takes_what_is_written_over_other_bytes) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1)));
  disk.set_capacity(522);
  EXPECT_TRUE(disk.write(file, 100, block(2, 412)));
  EXPECT_EQ(disk.write(file, 500, block(3, 30)).error().code, DiskErrorCode::kFull);
  EXPECT_EQ(disk.bytes("a"), block(1, 100) + block(2, 400) + block(3, 22));
  EXPECT_FALSE(disk.write(file, 600, block(4, 1)));
}

TEST(MemoryDisk, takes_names_back_whose_folder_was_not_synced) {
  MemoryDisk disk;
  DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1)));
  ASSERT_TRUE(disk.sync(file));
  ASSERT_TRUE(disk.sync_folder());
  file = *disk.create("a.new");
  ASSERT_TRUE(disk.append(file, block(2)));
  ASSERT_TRUE(disk.sync(file));
  ASSERT_TRUE(disk.rename("a.new", "a"));
  EXPECT_EQ(losses(disk), (std::set{block(1), block(2)}));
  ASSERT_TRUE(disk.sync_folder());
  EXPECT_EQ(losses(disk), std::set{block(2)});
}

TEST(MemoryDisk, process_that_dies_leaves_the_page_cache_and_no_lock) {
  MemoryDisk disk;
  ASSERT_TRUE(disk.lock("lock"));
  EXPECT_EQ(disk.lock("lock").error().code, DiskErrorCode::kLocked);
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.append(file, block(1)));
  disk.kill_process();
  EXPECT_EQ(disk.bytes("a"), block(1));
  EXPECT_FALSE(disk.append(file, block(2)));
  EXPECT_TRUE(disk.lock("lock"));
}

TEST(MemoryDisk, full_disk_takes_what_fits) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  disk.set_capacity(700);
  EXPECT_TRUE(disk.append(file, block(1)));
  EXPECT_EQ(disk.append(file, block(2)).error().code, DiskErrorCode::kFull);
  EXPECT_EQ(disk.bytes("a"), block(1) + block(2, 188));
}

TEST(MemoryDisk, fails_from_the_call_on_that_was_said) {
  MemoryDisk disk;
  disk.fail_from_call(3, {DiskErrorCode::kDenied, 0});
  const DiskFile file = *disk.create("a");
  EXPECT_TRUE(disk.append(file, block(1)));
  EXPECT_EQ(disk.sync(file).error().code, DiskErrorCode::kDenied);
  EXPECT_FALSE(disk.append(file, block(1)));
  Bytes out(1000);
  EXPECT_EQ(disk.read("a", out), 512U);
}

TEST(MemoryDisk, power_that_is_cut_in_a_call_leaves_it_half_done) {
  MemoryDisk disk;
  const DiskFile file = *disk.create("a");
  ASSERT_TRUE(disk.sync_folder());
  ASSERT_TRUE(disk.append(file, block(1)));
  disk.cut_power_at_call(disk.calls() + 1);
  EXPECT_FALSE(disk.sync(file));
  EXPECT_TRUE(disk.power_is_cut());
  EXPECT_FALSE(disk.append(file, block(2)));
  const std::set<Bytes> seen = losses(disk);
  EXPECT_TRUE(seen.contains(Bytes{}));
  EXPECT_TRUE(seen.contains(block(1)));
  disk.lose_power(1);
  EXPECT_FALSE(disk.power_is_cut());
}

TEST(MemoryDisk, tells_sizes_times_and_names) {
  MemoryDisk disk;
  disk.set_wall(5);
  DiskFile file = *disk.create("b");
  ASSERT_TRUE(disk.create("a"));
  disk.set_wall(7);
  ASSERT_TRUE(disk.append(file, block(1)));
  const DiskStamp stamp = *disk.stamp("b");
  EXPECT_EQ(stamp.size, 512U);
  EXPECT_EQ(stamp.changed_ns, 7);
  EXPECT_NE(stamp.identity, disk.stamp("a")->identity);
  EXPECT_EQ(disk.list(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(disk.stamp("c").error().code, DiskErrorCode::kMissing);
  EXPECT_EQ(disk.open("c").error().code, DiskErrorCode::kMissing);
  Bytes small(511);
  EXPECT_EQ(disk.read("b", small).error().code, DiskErrorCode::kTooLarge);
  disk.set_sync_time(std::chrono::milliseconds(20), std::chrono::milliseconds(50), 1);
  ASSERT_TRUE(disk.sync(file));
  const Duration time = disk.take_time();
  EXPECT_GE(time, std::chrono::milliseconds(20));
  EXPECT_LE(time, std::chrono::milliseconds(50));
  EXPECT_EQ(disk.take_time(), Duration{});
  EXPECT_TRUE(disk.remove("a"));
  EXPECT_FALSE(disk.remove("a"));
}

}  // namespace
}  // namespace sinew::sim
