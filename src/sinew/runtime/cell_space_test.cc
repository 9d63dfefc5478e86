#include "sinew/runtime/cell_space.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using planning::CellWay;
using planning::JointArray;

/// Two learms 0.5 m apart that look at each other, both upright.
class TwoArms : public testing::Test {
 public:
  explicit TwoArms(const std::vector<CellObject>& objects = {}) {
    Cell cell;
    cell.robots.resize(2);
    cell.robots[0].name = "left";
    cell.robots[1].name = "right";
    cell.robots[1].X_WB.p.x = 0.5;
    cell.robots[1].X_WB.R = rotation_z(kPi);
    cell.objects = objects;
    const std::vector<RobotModel> models{test::robot("learm"), test::robot("learm")};
    space_ = std::make_unique<CellSpace>(cell, models);
    for (const std::size_t i : {0U, 1U}) space_->stands(i, at(upright()));
  }

  static JointArray upright() { return {}; }
  static JointArray out(double base_deg) {
    return {from_deg(base_deg), from_deg(20), from_deg(40), from_deg(40), 0};
  }
  static CellStand at(const JointArray& q) {
    return {.joints = {q, {}}, .known = true, .sure = true};
  }
  static CellStand moving(const JointArray& q) {
    CellStand stand = at(q);
    stand.rests = false;
    return stand;
  }
  static planning::JointPath line(const JointArray& from, const JointArray& to) {
    planning::JointPath path(5, 1);
    EXPECT_TRUE(path.append_line({from.data(), 5}, {to.data(), 5}, 1));
    return path;
  }
  Expected<void> ask(std::size_t robot, std::uint32_t command, const JointArray& from,
                     const JointArray& to) {
    const CellWay way(line(from, to));
    return space_->ask(robot, command, &way);
  }

 protected:
  std::unique_ptr<CellSpace> space_;
};

TEST_F(TwoArms, the_second_of_two_is_refused_until_the_first_has_ended_and_rests_elsewhere) {
  ASSERT_TRUE(ask(0, 1, upright(), out(0)));
  EXPECT_EQ(ask(1, 2, upright(), out(0)).error().code, ErrorCode::kCellTaken);
  EXPECT_TRUE(space_->refusal(1)->moving);
  EXPECT_EQ(space_->refusal(1)->other, "left");
  // On its way, at its end but not at rest yet, at rest but not ended: it is still its own.
  space_->stands(0, moving(out(45)));
  EXPECT_FALSE(ask(1, 3, upright(), out(0)));
  space_->ended(0, 1);
  EXPECT_FALSE(ask(1, 4, upright(), out(0)));
  space_->stands(0, at(out(80)));
  EXPECT_TRUE(ask(1, 5, upright(), out(0)));
}

TEST_F(TwoArms, a_command_that_never_began_gives_back_what_it_was_granted) {
  ASSERT_TRUE(ask(0, 1, upright(), out(0)));
  space_->stands(0, at(upright()));
  EXPECT_FALSE(ask(1, 2, upright(), out(0))) << "it may still begin";
  space_->ended(0, 7);
  space_->stands(0, at(upright()));
  EXPECT_FALSE(ask(1, 3, upright(), out(0))) << "another one ended";
  space_->ended(0, 1);
  space_->stands(0, at(upright()));
  EXPECT_TRUE(ask(1, 4, upright(), out(0)));
}

TEST_F(TwoArms, who_rests_in_the_way_is_refused_for_good_and_who_works_is_not_planned_against) {
  space_->stands(0, at(out(0)));
  EXPECT_EQ(ask(1, 1, upright(), out(0)).error().code, ErrorCode::kCellContact);
  const CellWay way(line(upright(), out(0)));
  EXPECT_FALSE(space_->look(1, way));
  space_->works(0, true);
  EXPECT_TRUE(space_->look(1, way));
  EXPECT_FALSE(ask(1, 2, upright(), out(0))) << "it is still there";
}

TEST_F(TwoArms, a_fault_that_loses_the_position_leaves_the_whole_reach) {
  ASSERT_TRUE(ask(0, 1, upright(), out(0)));
  space_->ended(0, 1);
  CellStand lost = at(out(0));
  lost.known = lost.sure = false;
  space_->stands(0, lost);
  EXPECT_FALSE(ask(1, 2, upright(), out(0)));
  EXPECT_TRUE(space_->refusal(1)->unknown);
  EXPECT_NE(space_->refusal(1)->sentence().find("nobody knows"), std::string::npos);
  // It cannot be homed either while the other one is in its reach.
  space_->stands(1, at(out(0)));
  EXPECT_EQ(space_->ask(0, 3, nullptr).error().code, ErrorCode::kCellContact);
  EXPECT_TRUE(space_->refusal(0)->asker_unknown);
}

TEST_F(TwoArms, of_two_threads_that_ask_at_once_exactly_one_is_granted_it) {
  for (std::uint32_t round = 1; round < 200; ++round) {
    std::atomic<int> ready = 0, granted = 0;
    const auto go = [&](std::size_t robot) {
      const CellWay way(line(upright(), out(0)));
      ++ready;
      while (ready < 2) std::this_thread::yield();
      if (space_->ask(robot, round, &way)) ++granted;
    };
    std::thread first(go, 0), second(go, 1);
    first.join();
    second.join();
    ASSERT_EQ(granted, 1);
    for (const std::size_t i : {0U, 1U}) {
      space_->ended(i, round);
      space_->stands(i, at(upright()));
    }
  }
}

TEST_F(TwoArms, a_jog_sees_what_is_near_and_is_seen_with_its_way_to_rest) {
  CellStand jog = at(out(0));
  jog.jogs = true;
  jog.rests = false;
  space_->stands(1, at(upright()));
  const auto near = space_->jogs(0, jog);
  ASSERT_TRUE(near);
  EXPECT_GT(near->size(), 0U) << "the other arm's stand is 0.12 m away";
  EXPECT_TRUE(ask(1, 1, upright(), out(88))) << "a jog that stands leaves room";
  space_->ended(1, 1);
  space_->stands(1, at(out(60)));
  jog.joints.q = out(-25);
  ASSERT_TRUE(space_->jogs(0, jog));
  EXPECT_TRUE(ask(1, 2, out(60), out(58)));
  space_->ended(1, 2);
  space_->stands(1, at(out(60)));
  jog.speeds[0] = -1.5;
  ASSERT_TRUE(space_->jogs(0, jog));
  EXPECT_EQ(ask(1, 3, out(60), out(45)).error().code, ErrorCode::kCellTaken) << "it comes there";
}

TEST_F(TwoArms, a_jog_that_asks_for_a_motion_is_still_seen_where_it_jogs) {
  CellStand jog = at(out(0));
  jog.jogs = true;
  jog.rests = false;
  ASSERT_TRUE(space_->jogs(0, jog));
  ASSERT_TRUE(ask(0, 1, out(80), out(88))) << "from elsewhere: its controller will refuse it";
  EXPECT_EQ(ask(1, 2, upright(), out(0)).error().code, ErrorCode::kCellTaken);
}

/// Each wants to go where the other one rests.
TEST_F(TwoArms, two_that_are_in_each_others_way_are_both_refused_and_neither_waits) {
  space_->stands(0, at(out(0)));
  space_->stands(1, at(out(40)));
  space_->works(0, true);
  space_->works(1, true);
  EXPECT_EQ(ask(1, 1, out(40), out(0)).error().code, ErrorCode::kCellContact);
  EXPECT_EQ(ask(0, 2, out(0), out(-40)).error().code, ErrorCode::kCellContact);
  EXPECT_FALSE(space_->refusal(0)->moving);
  EXPECT_FALSE(space_->refusal(1)->moving);
}

CellObject post() {
  CellObject post{.name = "post", .X_WX = {}, .half = {0.02, 0.02, 0.11}};
  post.X_WX.p = {0, 0.25, 0.11};
  return post;
}

class ArmsWithAPost : public TwoArms {
 public:
  ArmsWithAPost() : TwoArms({post()}) {}
};

TEST_F(ArmsWithAPost, an_object_is_in_the_way_and_says_where_and_what_would_do) {
  const CellWay way(line(out(45), out(90)));
  space_->stands(0, at(out(45)));
  EXPECT_EQ(space_->ask(0, 1, &way).error().code, ErrorCode::kCellContact);
  const auto refusal = space_->refusal(0);
  EXPECT_EQ(refusal->other, "post");
  EXPECT_GT(refusal->share, 0.2);
  EXPECT_GT(refusal->way, 0.02);
  EXPECT_NE(refusal->sentence().find("another way"), std::string::npos) << refusal->sentence();
}

}  // namespace
}  // namespace sinew::runtime
