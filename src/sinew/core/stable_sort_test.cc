#include "sinew/core/stable_sort.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/property.h"

namespace sinew {
namespace {

struct Item {
  int key = 0;
  int number = 0;
};

TEST(StableSort, keys_rise_and_equals_keep_their_order) {
  int equals = 0;
  test::for_random_cases(500, [&](test::Random& random) {
    std::vector<Item> items(static_cast<std::size_t>(random.integer(0, 40)));
    std::vector<int> left(10);
    for (std::size_t i = 0; i < items.size(); ++i) {
      items[i] = {static_cast<int>(random.integer(0, 9)), static_cast<int>(i)};
      ++left[static_cast<std::size_t>(items[i].key)];
    }
    stable_sort_by(items, &Item::key);
    for (std::size_t i = 0; i < items.size(); ++i) {
      --left[static_cast<std::size_t>(items[i].key)];
      if (i == 0) continue;
      ASSERT_LE(items[i - 1].key, items[i].key);
      if (items[i - 1].key != items[i].key) continue;
      ASSERT_LT(items[i - 1].number, items[i].number);
      ++equals;
    }
    ASSERT_EQ(left, std::vector<int>(10)) << "none is lost, none is made";
  });
  EXPECT_GT(equals, 1000);
}

}  // namespace
}  // namespace sinew
