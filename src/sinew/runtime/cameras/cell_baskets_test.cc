#include "sinew/runtime/cameras/cell_baskets.h"

#include <gtest/gtest.h>

#include "sinew/core/rotation.h"
#include "sinew/io/file.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

std::vector<CellBasket> two() {
  return {{.name = "reds", .X_WK = {Rotation{}, {0.1, 0.2, 0}}},
          {.name = "blues", .X_WK = {Rotation{}, {0.1, -0.2, 0}}}};
}

TEST(CellBaskets, a_move_is_kept_and_counts_in_the_next_life) {
  const sinew::test::ScratchFolder folder;
  const std::string file = folder.at("cell.baskets.json");
  {
    CellBaskets baskets(two());
    ASSERT_TRUE(baskets.keep_in(file));
    baskets.move(1, {rotation_z(0.5), {0.3, -0.1, 0}});
    EXPECT_EQ(baskets.revision(), 1U);
    ASSERT_TRUE(baskets.keep());
  }
  CellBaskets again(two());
  ASSERT_TRUE(again.keep_in(file));
  EXPECT_EQ(again.all()[0].X_WK.p, (Vec3{0.1, 0.2, 0}));
  EXPECT_EQ(again.all()[1].X_WK.p, (Vec3{0.3, -0.1, 0}));
  EXPECT_NEAR(fixed_xyz(again.all()[1].X_WK.R).z, 0.5, 1e-12);
  EXPECT_EQ(again.find("blues"), 1U);
  EXPECT_FALSE(again.find("greens"));
}

TEST(CellBaskets, a_cell_s_file_that_has_changed_since_counts_more) {
  const sinew::test::ScratchFolder folder;
  const std::string file = folder.at("cell.baskets.json");
  CellBaskets baskets(two());
  ASSERT_TRUE(baskets.keep_in(file));
  baskets.move(0, {Rotation{}, {0.3, 0.3, 0}});
  ASSERT_TRUE(baskets.keep());
  auto changed = two();
  changed[0].X_WK.p.x = 0.15;
  CellBaskets again(changed);
  ASSERT_TRUE(again.keep_in(file));
  EXPECT_EQ(again.all()[0].X_WK.p, (Vec3{0.15, 0.2, 0}));
}

TEST(CellBaskets, what_is_no_such_file_is_named) {
  const sinew::test::ScratchFolder folder;
  const std::string file = folder.at("cell.baskets.json");
  for (const char* text : {"[]", "{\"sinew_baskets\": 1}", "{", "{\"sinew_baskets\": 2}"}) {
    ASSERT_TRUE(io::replace_file(file, text));
    CellBaskets baskets(two());
    const auto kept = baskets.keep_in(file);
    ASSERT_FALSE(kept) << text;
    EXPECT_NE(kept.error().sentence.find(file), std::string::npos);
  }
}

}  // namespace
}  // namespace sinew::runtime
