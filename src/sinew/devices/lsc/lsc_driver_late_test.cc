#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "sinew/core/error_code.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_test_cell.h"
#include "support/property.h"

/// A LeArm whose host comes late: stopped for a while, swapped out, busy elsewhere.
namespace sinew {
namespace {

using namespace test;
using Kind = DriverEvent::Kind;
using Quality = PositionQuality;

/// A motion's next segment that comes when its time is over and the driver says the last one again.
LscCell underrun() {
  LscCell cell(LscProfile::kLsc6);
  cell.start(kLscHere);
  LscPose at = kLscHere;
  for (int k = 0; k < 4; ++k) {
    at[0] += 0.1;
    while (!cell.driver.wants_move(cell.now)) cell.run_for(1ms);
    EXPECT_TRUE(cell.driver.move(cell.to(at, 80ms, 1), cell.now));
    cell.take(64);
  }
  cell.planned = at;
  cell.planned[0] += 0.1;
  cell.be_late_by(90ms);
  cell.driver.poll(cell.now);  // takes the last one over
  cell.take(64);
  cell.be_late_by(120ms);
  return cell;
}

TEST(LscDriverLateHost,
     a_segment_that_is_late_by_one_takes_the_place_of_what_has_not_begun_to_leave) {
  for (const std::size_t begun : {0U, 1U, 21U}) {
    LscCell cell = underrun();
    const std::size_t before = cell.to_board.history.size();
    cell.driver.poll(cell.now);  // says the last one again
    cell.take(begun);
    EXPECT_EQ(cell.to_board.history.size(), before + begun);
    EXPECT_FALSE(cell.driver.wants_move(cell.now));
    ASSERT_TRUE(cell.driver.move(cell.to(cell.planned, 80ms), cell.now));
    EXPECT_EQ(cell.driver.state(), DriverState::kMoving);
    cell.take(64);
    EXPECT_EQ(cell.to_board.history.size(), before + 22);
    cell.run_for(1s);
    EXPECT_EQ(cell.ends(), 5U);
    EXPECT_EQ(cell.count(Kind::kDone), 5U);
    EXPECT_LT(cell.worst(cell.planned), kLscSag);
  }
}

TEST(LscDriverLateHost, a_command_waits_for_a_question_that_is_leaving_and_a_stop_takes_it_back) {
  for (const std::size_t begun : {0U, 1U}) {
    for (const bool stopped : {false, true}) {
      LscCell cell(LscProfile::kLsc6);
      cell.start(kLscHere);
      cell.run_for(1s);
      const std::size_t before = cell.to_board.history.size();
      cell.be_late_by(1100ms);
      cell.driver.poll(cell.now);
      cell.take(begun);
      LscPose there = kLscHere;
      there[0] += 0.1;
      ASSERT_TRUE(cell.driver.move(cell.to(there, 100ms), cell.now));
      EXPECT_FALSE(cell.driver.wants_move(cell.now));
      EXPECT_EQ(refusal(cell.driver.move(cell.to(there, 100ms), cell.now)), ErrorCode::kBusy);
      if (stopped) cell.driver.stop(cell.now);
      cell.take(64);
      EXPECT_EQ(cell.to_board.history.size(), before + 4);
      cell.run_for(1s);
      EXPECT_EQ(cell.ends(), 1U);
      EXPECT_EQ(cell.count(stopped ? Kind::kStopped : Kind::kDone), 1U);
      EXPECT_LT(cell.worst(stopped ? kLscHere : there), kLscSag);
    }
  }
}

/// A host that polls, moves, takes and gives when it likes.
class LateHost {
 public:
  LateHost(LscCell& cell, Random& random) : cell_(cell), random_(random) {}

  void act() {
    cell_.be_late_by(1ms * random_.integer(0, random_.chance(0.1) ? 250 : 40));
    if (random_.chance(0.8)) cell_.driver.poll(cell_.now);
    if (random_.chance(0.7)) cell_.take(static_cast<std::size_t>(random_.integer(0, 30)));
    if (random_.chance(0.2)) cell_.run_for(1ms * random_.integer(0, 60));
    if (cell_.driver.wants_move(cell_.now) || random_.chance(0.2)) move();
    if (random_.chance(0.03)) count(cell_.driver.tool(JawsTo{random_.uniform(0, 0.06)}, cell_.now));
    if (random_.chance(0.03)) stop();
    cell_.take_events();
  }
  std::size_t expected() const { return commands_ + idle_stops_; }
  std::size_t commands() const { return commands_; }

 private:
  void count(const Expected<void>& taken) { commands_ += taken ? 1 : 0; }
  void move() {
    LscPose at = at_;
    for (double& q : at) q = std::clamp(q + random_.uniform(-0.15, 0.15), -0.8, 0.8);
    const double speed = random_.chance(0.8) ? 1 : 0;
    auto taken = cell_.driver.move(cell_.to(at, 80ms, speed), cell_.now);
    if (refusal(taken) == ErrorCode::kPositionUnknown) {
      taken = cell_.driver.move(cell_.to(at, 2s), cell_.now);
    }
    count(taken);
    if (taken) at_ = at;
  }
  void stop() {
    cell_.driver.poll(cell_.now);
    cell_.take_events();
    if (cell_.ends() == expected()) ++idle_stops_;
    cell_.driver.stop(cell_.now);
  }

  LscCell& cell_;
  Random& random_;
  LscPose at_ = kLscHere;
  std::size_t commands_ = 0;
  std::size_t idle_stops_ = 0;
};

TEST(LscDriverLateHost, it_ends_every_command_once_and_claims_nothing_wrong) {
  std::size_t commands = 0;
  int claims = 0;
  for_random_cases(200, [&](Random& random) {
    LscCell cell(kLscProfiles[static_cast<std::size_t>(random.integer(0, 2))], random.bits());
    cell.start(kLscHere);
    LateHost host(cell, random);
    for (int i = 0; i < 150; ++i) host.act();
    cell.run_for(10s);
    EXPECT_EQ(cell.ends(), host.expected());
    EXPECT_EQ(cell.driver.state(), DriverState::kReady);
    commands += host.commands();
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      if (joint.quality == Quality::kLost) continue;
      ++claims;
      // What a bus servo measured, it was a moment ago.
      const double sag = joint.quality == Quality::kMeasured ? kLscSag : 0;
      EXPECT_GE(cell.machine.truth().joints[i].q, joint.lower - sag) << i;
      EXPECT_LE(cell.machine.truth().joints[i].q, joint.upper + sag) << i;
    }
  });
  std::cout << "  " << commands << " commands, " << claims << " of 1000 joints claimed a place\n";
  EXPECT_GT(commands, 2000U);
  EXPECT_GT(claims, 500);
}

}  // namespace
}  // namespace sinew
