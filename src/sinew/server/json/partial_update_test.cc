#include "sinew/server/json/partial_update.h"

#include <gtest/gtest.h>

namespace sinew::server {
namespace {

TEST(PartialUpdate, holds_what_differs_and_what_is_gone) {
  const Json before{{"state", "ready"}, {"feed", 1}, {"fault", {{"cause", "x"}}}};
  const Json now{{"state", "moving"}, {"feed", 1}, {"lease", 3}};
  const Json update = partial_update(before, now);
  EXPECT_EQ(update, (Json{{"state", "moving"}, {"lease", 3}, {"fault", nullptr}}));
  EXPECT_TRUE(partial_update(now, now).empty());
  Json known = before;
  apply_update(known, update);
  EXPECT_TRUE(partial_update(known, now).empty());
}

TEST(PartialUpdate, of_nothing_is_all_of_it) {
  const Json now{{"state", "ready"}};
  EXPECT_EQ(partial_update(Json::object(), now), now);
}

}  // namespace
}  // namespace sinew::server
