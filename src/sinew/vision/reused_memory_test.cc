#include "sinew/vision/reused_memory.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sinew::vision {
namespace {

TEST(ReusedMemory, a_block_comes_back_where_its_size_fits_exactly_and_is_of_one_thread) {
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

TEST(ReusedMemory, what_is_kept_is_bounded_and_the_oldest_goes_first) {
  void* first = reused_block(30 << 20);
  give_back_block(first, 30 << 20);
  void* second = reused_block(20 << 20);
  give_back_block(second, 20 << 20);  // 50 MB are too many
  EXPECT_EQ(reused_block(20 << 20), second);
  give_back_block(second, 20 << 20);
  void* large = reused_block(100 << 20);
  give_back_block(large, 100 << 20);  // never kept
  EXPECT_EQ(reused_block(20 << 20), second);
  give_back_block(second, 20 << 20);
}

}  // namespace
}  // namespace sinew::vision
