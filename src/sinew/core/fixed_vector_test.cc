#include "sinew/core/fixed_vector.h"

#include <gtest/gtest.h>

#include <numeric>

namespace sinew {
namespace {

FixedVector<int, 8> counted(int count) {
  FixedVector<int, 8> items;
  items.resize(static_cast<std::size_t>(count));
  std::iota(items.begin(), items.end(), 1);
  return items;
}

TEST(FixedVector, GivesItsFirstOnesAsFarAsThereIsRoom) {
  auto items = counted(5);
  std::array<int, 3> room{};
  EXPECT_EQ(items.take_front(room), 3u);
  EXPECT_EQ(room, (std::array{1, 2, 3}));
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0], 4);
  EXPECT_EQ(items.take_front(room), 2u);
  EXPECT_EQ(room, (std::array{4, 5, 3}));
  EXPECT_TRUE(items.empty());
  EXPECT_EQ(items.take_front(room), 0u);
}

TEST(FixedVector, GivesOneAfterTheOtherInOrder) {
  auto items = counted(8);
  for (int expected = 1; expected <= 8; ++expected) EXPECT_EQ(items.take_front(), expected);
  EXPECT_EQ(items.take_front(), std::nullopt);
}

TEST(FixedVector, DropsItsFirstOnes) {
  auto items = counted(6);
  items.drop_front(0);
  EXPECT_EQ(items.size(), 6u);
  items.drop_front(4);
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[1], 6);
}

}  // namespace
}  // namespace sinew
