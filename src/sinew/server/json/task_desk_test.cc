#include "sinew/server/json/task_desk.h"

#include <gtest/gtest.h>

#include <latch>

namespace sinew::server {
namespace {

TEST(TaskDesk, one_client_leaves_room_for_the_others) {
  std::latch go(1);
  TaskDesk desk;
  std::latch begun(1);
  ASSERT_TRUE(desk.ask({1, 0, true}, [&] {
    begun.count_down();
    go.wait();
    return "first";
  }));
  begun.wait();
  const auto quick = [] { return "quick"; };
  for (std::size_t i = 0; i < TaskDesk::kOfOneMax; ++i) {
    EXPECT_TRUE(desk.ask({1, i, true}, quick)) << i;
  }
  EXPECT_FALSE(desk.ask({1, 99, true}, quick));
  EXPECT_TRUE(desk.ask({2, 0, true}, quick));
  // What the server itself keeps is bounded by all alone.
  std::size_t own = 0;
  while (desk.ask({0, nullptr, false}, quick)) ++own;
  EXPECT_EQ(own, TaskDesk::kWaitingMax - TaskDesk::kOfOneMax - 1);
  EXPECT_FALSE(desk.ask({3, 0, true}, quick));
  go.count_down();
  std::vector<Answered> done;
  while (done.size() < TaskDesk::kWaitingMax + 1) {
    if (auto one = desk.take()) done.push_back(std::move(*one));
  }
  EXPECT_EQ(*done.front().result, "first");
  EXPECT_EQ(done[1].ticket.id, 0);
  EXPECT_EQ(done[TaskDesk::kOfOneMax + 1].ticket.client, 2U);
}

}  // namespace
}  // namespace sinew::server
