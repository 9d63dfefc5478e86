#include "sinew/runtime/journal/position_record.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <variant>
#include <vector>

#include "sinew/control/machine_identity.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/io/clock.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

TEST(PositionRecord, what_another_program_wrote_down_is_an_interval_that_somebody_has_to_verify) {
  const sinew::test::ScratchFolder folder;
  const RobotModel& hexapod = sinew::test::robot("hexapod");
  std::vector<JointPosition> legs;
  for (const Joint& leg : hexapod.joints) {
    legs.push_back({PositionQuality::kUncertain, 0.27, leg.lower, leg.upper});
  }
  {
    const auto record = PositionRecord::open(folder.at("positions"), "old", hexapod);
    ASSERT_TRUE(record) << record.error().sentence;
    EXPECT_EQ((*record)->recovery().finding, JournalFinding::kNothing);
    const auto said = (*record)->import(hexapod, legs, {Instant{}, io::wall_time_ns()});
    ASSERT_TRUE(said) << said.error().sentence;
  }
  const auto again = PositionRecord::open(folder.at("positions"), "old", hexapod);
  ASSERT_TRUE(again) << again.error().sentence;
  const JournalRecovery& found = (*again)->recovery();
  EXPECT_EQ(found.way_out, WayOut::kVerify) << sentence(found.finding);
  ASSERT_EQ(found.positions.size(), legs.size());
  for (std::size_t leg = 0; leg < legs.size(); ++leg) {
    EXPECT_EQ(found.positions[leg].quality, PositionQuality::kUncertain);
    EXPECT_LE(found.positions[leg].lower, legs[leg].lower);
    EXPECT_GE(found.positions[leg].upper, legs[leg].upper);
    EXPECT_EQ(found.last_said[leg].q, 0.27);
  }
}

/// Journals of one folder, whose machines hang on ports that are known by their names.
class OneFolder : public ::testing::Test {
 protected:
  /// Opens the journal `name` for `port`, and leaves it with a record of this kind.
  JournalRecovery live(const std::string& name, const std::string& port, JournalKind kind, double q,
                       const RobotModel& robot = arm()) {
    const auto record = PositionRecord::open(folder_.at("p"), name, robot, port);
    EXPECT_TRUE(record) << record.error().sentence;
    if (!record) return {};
    found_ = (*record)->found();
    const JournalRecovery before = (*record)->recovery();
    PositionJournal journal(control::journal_settings(robot), before.end);
    std::vector<JointPosition> at(robot.joints.size(), {PositionQuality::kCommanded, q, q, q});
    const JournalTime now{Instant{}, io::wall_time_ns()};
    EXPECT_TRUE((*record)->pump().offer(journal.open(at, now)));
    if (kind == JournalKind::kIntent) {
      std::vector<JointInterval> next(at.size(), JointInterval{q, q + 0.1});
      EXPECT_TRUE((*record)->pump().offer(*journal.reserve({at, next}, now)));
    }
    return before;
  }
  static const RobotModel& arm() { return sinew::test::robot("bigrobotarm"); }

  sinew::test::ScratchFolder folder_;
  std::string found_;
};

TEST_F(OneFolder, another_journal_of_the_machine_is_taken_over_as_it_ends) {
  live("a", "x", JournalKind::kOpened, 0.5);
  live("b", "x", JournalKind::kIntent, 0.5);
  live("a", "x", JournalKind::kOpened, 0.7);
  EXPECT_NE(found_.find("'b' followed the machine on x last; 'a' continues from it; the last run "
                        "ended while the machine was moving"),
            std::string::npos)
      << found_;
  const JournalRecovery b = live("b", "x", JournalKind::kOpened, 0);
  EXPECT_EQ(b.finding, JournalFinding::kEndedAtRest);
  EXPECT_EQ(b.positions[0].q, 0.7);
  // The same journal again, and another machine.
  EXPECT_EQ(live("b", "x", JournalKind::kOpened, 0).positions[0].q, 0);
  EXPECT_EQ(found_, sentence(JournalFinding::kEndedAtRest));
  EXPECT_EQ(live("c", "y", JournalKind::kOpened, 0).finding, JournalFinding::kNothing);
}

TEST_F(OneFolder, what_is_taken_over_is_as_old_as_it_was) {
  live("a", "x", JournalKind::kIntent, 0.5);
  io::Clock().pause(std::chrono::milliseconds(50));
  const auto b = PositionRecord::open(folder_.at("p"), "b", arm(), "x");
  ASSERT_TRUE(b);
  EXPECT_GE((*b)->start().memory.since, std::chrono::milliseconds(50));
}

TEST_F(OneFolder, what_cannot_be_taken_over_is_lost_and_both_journals_are_named) {
  live("a", "x", JournalKind::kOpened, 0.5);
  RobotModel other = arm();
  other.device.settings.get<BigRobotArmDevice>().joints[0].steps_per_rad *= 2;
  live("b", "x", JournalKind::kOpened, 0.5, other);
  EXPECT_NE(found_.find("'a' followed the machine on x last; 'b' cannot continue from it: the "
                        "position journal is of this robot with other zeros"),
            std::string::npos)
      << found_;
  const JournalRecovery a = live("a", "x", JournalKind::kOpened, 0.5);
  EXPECT_EQ(a.positions[0].quality, PositionQuality::kLost);
  // Cut short.
  live("b", "x", JournalKind::kOpened, 0.5);
  for (const char* file : {"p/b.0", "p/b.1"}) {
    std::filesystem::resize_file(folder_.at(file), kJournalSlotSize);
  }
  EXPECT_EQ(live("a", "x", JournalKind::kOpened, 0.5).positions[0].quality, PositionQuality::kLost);
  EXPECT_NE(found_.find("truncated"), std::string::npos) << found_;
}

TEST_F(OneFolder, run_without_a_journal_is_remembered_where_one_follows_the_machine) {
  ASSERT_TRUE(forget_port(folder_.at("p"), "x", arm()));
  live("a", "x", JournalKind::kOpened, 0.5);
  EXPECT_EQ(found_, sentence(JournalFinding::kNothing));
  ASSERT_TRUE(forget_port(folder_.at("p"), "y", arm()));
  EXPECT_EQ(live("a", "x", JournalKind::kOpened, 0.5).positions[0].q, 0.5);
  ASSERT_TRUE(forget_port(folder_.at("p"), "x", arm()));
  EXPECT_EQ(live("a", "x", JournalKind::kOpened, 0.5).positions[0].quality, PositionQuality::kLost);
  EXPECT_NE(found_.find("without --journal"), std::string::npos) << found_;
  EXPECT_EQ(live("a", "x", JournalKind::kOpened, 0.5).positions[0].q, 0.5);
}

TEST_F(OneFolder, machine_that_is_plugged_in_later_is_known_where_this_journal_followed_it) {
  live("b", "x", JournalKind::kOpened, 0.5);
  {
    const auto a = PositionRecord::open(folder_.at("p"), "a", arm(), "y");
    ASSERT_TRUE(a);
    EXPECT_TRUE((*a)->follow_port(arm(), "y"));
    EXPECT_TRUE((*a)->follow_port(arm(), "z"));
    // Another machine than before; where the one on y was left it no longer knows.
    const auto left = (*a)->follow_port(arm(), "y");
    ASSERT_FALSE(left);
    EXPECT_NE(left.error().sentence.find("has followed another one since"), std::string::npos)
        << left.error().sentence;
    const auto theirs = (*a)->follow_port(arm(), "x");
    ASSERT_FALSE(theirs);
    EXPECT_EQ(theirs.error().sentence,
              "x: the position journal 'b' followed the machine that is there now, and 'a' does "
              "not know where it stands; end this program and start it again");
    ASSERT_TRUE(forget_port(folder_.at("p"), "z", arm()));
    const auto nobodys = (*a)->follow_port(arm(), "z");
    ASSERT_FALSE(nobodys);
    EXPECT_NE(nobodys.error().sentence.find("a run without --journal moved the machine"),
              std::string::npos)
        << nobodys.error().sentence;
    EXPECT_TRUE((*a)->follow_port(arm(), "v"));
  }
  live("b", "v", JournalKind::kOpened, 0.5);
  EXPECT_NE(found_.find("'a' followed the machine on v last"), std::string::npos) << found_;
}

TEST_F(OneFolder, journal_that_somebody_else_writes_is_not_taken_over) {
  const auto held = PositionRecord::open(folder_.at("p"), "a", arm(), "x");
  ASSERT_TRUE(held);
  const auto refused = PositionRecord::open(folder_.at("p"), "b", arm(), "x");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().sentence.find("'a' followed the machine on x last"), std::string::npos);
  EXPECT_NE(refused.error().sentence.find("is writing it"), std::string::npos);
}

}  // namespace
}  // namespace sinew::runtime
