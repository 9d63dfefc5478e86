#include "sinew/vision/reused_memory.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sinew::vision {
namespace {

TEST(ReusedMemory, returns_a_block_of_exactly_the_same_size_to_the_same_thread) {
  constexpr std::size_t kBytes = 3 << 20;
  void* block = reused_block(kBytes);
  give_back_block(block, kBytes);
  void* other = reused_block(kBytes + 4);
  EXPECT_NE(other, block);
  std::thread([&] {
    void* there = reused_block(kBytes);
    EXPECT_NE(there, block);
    give_back_block(there, kBytes);
  }).join();
  EXPECT_EQ(reused_block(kBytes), block);
  give_back_block(block, kBytes);
  give_back_block(other, kBytes + 4);
}

TEST(ReusedMemory, keeps_at_most_48_MB_and_frees_the_oldest_first) {
  std::thread([] {  // which has none yet
    constexpr std::size_t kMega = 1U << 20U;
    std::vector<void*> blocks;
    for (const std::size_t size : {10U, 11U, 12U}) blocks.push_back(reused_block(size * kMega));
    for (const std::size_t i : {0U, 1U, 2U}) give_back_block(blocks[i], (10 + i) * kMega);
    EXPECT_EQ(bytes_kept(), 33 * kMega);
    // Taken and returned, the first one is the youngest.
    EXPECT_EQ(reused_block(10 * kMega), blocks[0]);
    EXPECT_EQ(bytes_kept(), 23 * kMega);
    give_back_block(blocks[0], 10 * kMega);
    give_back_block(reused_block(20 * kMega), 20 * kMega);
    EXPECT_EQ(bytes_kept(), 42 * kMega) << "the 11 MB are gone";
    EXPECT_EQ(reused_block(12 * kMega), blocks[2]);
    EXPECT_EQ(reused_block(10 * kMega), blocks[0]);
    EXPECT_EQ(bytes_kept(), 20 * kMega);
    give_back_block(blocks[0], 10 * kMega);
    give_back_block(blocks[2], 12 * kMega);
    give_back_block(reused_block(100 * kMega), 100 * kMega);
    EXPECT_EQ(bytes_kept(), 42 * kMega) << "too large to keep";
  })
      .join();
}

}  // namespace
}  // namespace sinew::vision
