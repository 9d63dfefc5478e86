#include "sinew/control/position_journal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"

namespace sinew {
namespace {

using std::chrono::milliseconds;
using Positions = std::vector<JointPosition>;
using Intervals = std::vector<JointInterval>;

JointPosition exact(double q) {
  return {PositionQuality::kCommanded, q, q, q};
}

JournalTime at(Duration since_start) {
  return {Instant{since_start}, 0};
}

JournalSettings two_joints() {
  JournalSettings settings;
  settings.joints = {{.block = 1, .lead = 0.25, .slack = 0, .lower = -10, .upper = 10},
                     {.block = 1, .lead = 0.25, .slack = 0, .lower = -10, .upper = 10}};
  return settings;
}

/// A journal whose records are all safe at once, at rest in 0.
class AtRest {
 public:
  explicit AtRest(const JournalSettings& settings = two_joints(), Positions positions = {})
      : journal(settings, {}) {
    positions.resize(settings.joints.size(), exact(0));
    journal.open(positions, at({}));
    sync();
  }
  void sync() { journal.durable(journal.sequence()); }
  std::optional<JournalRecord> reserve(const Positions& now, const Intervals& next) {
    return journal.reserve({now, next}, at({}));
  }
  PositionJournal journal;
};

TEST(PositionJournal, first_step_waits_until_its_intent_is_safe) {
  AtRest cell;
  const Positions now{exact(0), exact(0)};
  const Intervals next{{0, 0.1}, {0, 0}};
  EXPECT_FALSE(cell.journal.may_send(next));
  const auto record = cell.reserve(now, next);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->kind, JournalKind::kIntent);
  EXPECT_EQ(record->positions[0].quality, PositionQuality::kUncertain);
  EXPECT_EQ(record->positions[0].lower, 0);
  EXPECT_EQ(record->positions[0].upper, 0.1 + 1.25);
  // What stands keeps its number.
  EXPECT_EQ(record->positions[1].quality, PositionQuality::kCommanded);
  EXPECT_FALSE(cell.journal.may_send(next));
  cell.journal.durable(record->sequence - 1);
  EXPECT_FALSE(cell.journal.may_send(next));
  cell.journal.durable(record->sequence);
  EXPECT_TRUE(cell.journal.may_send(next));
  EXPECT_FALSE(cell.journal.may_send(Intervals{{0, 1.36}, {0, 0}}));
  EXPECT_FALSE(cell.journal.may_send(Intervals{{0, 0.1}, {0, 1e-9}}));
  EXPECT_FALSE(cell.reserve(now, next));
}

TEST(PositionJournal, next_block_is_asked_for_before_this_one_is_used_up) {
  AtRest cell;
  cell.reserve({exact(0), exact(0)}, {{0, 0.1}, {0, 0}});
  cell.sync();
  // 1.35 is reserved; with 0.25 left the next one is due, and motion goes on meanwhile.
  EXPECT_FALSE(cell.reserve({exact(1), exact(0)}, {{1, 1.1}, {0, 0}}));
  const Intervals next{{1.1, 1.2}, {0, 0}};
  const auto record = cell.reserve({exact(1.1), exact(0)}, next);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->positions[0].lower, 1.1);
  EXPECT_TRUE(cell.journal.may_send(next));
  // But not back to where the pending record says that it cannot be.
  EXPECT_FALSE(cell.journal.may_send(Intervals{{1.0, 1.1}, {0, 0}}));
  // And not beyond what is safe.
  EXPECT_FALSE(cell.journal.may_send(Intervals{{1.2, 1.4}, {0, 0}}));
  cell.sync();
  EXPECT_TRUE(cell.journal.may_send(Intervals{{1.2, 1.4}, {0, 0}}));
}

TEST(PositionJournal, turning_round_inside_the_block_needs_no_record) {
  AtRest cell;
  cell.reserve({exact(0), exact(0)}, {{-0.1, 0.1}, {0, 0}});
  cell.sync();
  EXPECT_FALSE(cell.reserve({exact(0.5), exact(0)}, {{0.4, 0.5}, {0, 0}}));
  EXPECT_TRUE(cell.journal.may_send(Intervals{{0.4, 0.5}, {0, 0}}));
}

TEST(PositionJournal, nothing_moves_while_a_rest_waits_for_the_disk) {
  AtRest cell;
  const Intervals next{{0, 0.1}, {0, 0}};
  cell.reserve({exact(0), exact(0)}, next);
  cell.sync();
  ASSERT_TRUE(cell.journal.at_rest(Positions{exact(0.1), exact(0)}, at({})));
  EXPECT_FALSE(cell.journal.may_send(Intervals{{0.1, 0.2}, {0, 0}}));
  ASSERT_TRUE(cell.reserve({exact(0.1), exact(0)}, {{0.1, 0.2}, {0, 0}}));
  EXPECT_FALSE(cell.journal.may_send(Intervals{{0.1, 0.2}, {0, 0}}));
  cell.sync();
  EXPECT_TRUE(cell.journal.may_send(Intervals{{0.1, 0.2}, {0, 0}}));
}

TEST(PositionJournal, a_look_at_a_forgetful_device_waits_until_its_record_is_safe) {
  AtRest cell;
  const Positions now{exact(0), exact(1)};
  EXPECT_FALSE(cell.journal.may_look());
  const auto record = cell.journal.look(now, at({}));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->kind, JournalKind::kLook);
  EXPECT_EQ(record->positions[1].q, 1);
  EXPECT_EQ(record->positions[1].quality, PositionQuality::kCommanded);
  EXPECT_FALSE(cell.journal.may_look());
  cell.sync();
  EXPECT_TRUE(cell.journal.may_look());
  EXPECT_FALSE(cell.journal.look(now, at({}))) << "said already";
  // What it finds out counts at once, and no motion begins on it.
  const Positions wider{exact(0), {PositionQuality::kUncertain, 1, 0.5, 1.5}};
  const auto more = cell.journal.look(wider, at({}));
  ASSERT_TRUE(more);
  EXPECT_EQ(more->positions[1].upper, 1.5);
  cell.sync();
  EXPECT_FALSE(cell.journal.may_send(Intervals{{0, 0}, {0.5, 1.5}}));
  const auto rest = cell.journal.at_rest(wider, at({}));
  ASSERT_TRUE(rest) << "the look is over, and that is said although nothing else is new";
  EXPECT_EQ(rest->kind, JournalKind::kRest);
  EXPECT_FALSE(cell.journal.may_look());
}

TEST(PositionJournal, a_look_under_way_keeps_the_block_and_motion_goes_on_behind_a_new_intent) {
  AtRest cell;
  const Intervals next{{0, 0.1}, {0, 0}};
  const auto intent = cell.reserve({exact(0), exact(0)}, next);
  cell.sync();
  const auto look = cell.journal.look(Positions{exact(0.1), exact(0)}, at({}));
  ASSERT_TRUE(look);
  EXPECT_EQ(look->positions[0].upper, intent->positions[0].upper);
  EXPECT_EQ(look->positions[0].quality, PositionQuality::kUncertain);
  EXPECT_FALSE(cell.journal.may_send(next));
  EXPECT_FALSE(cell.journal.may_look()) << "a crash may leave the intent, which says nothing of it";
  cell.sync();
  EXPECT_TRUE(cell.journal.may_look());
  ASSERT_TRUE(cell.reserve({exact(0.1), exact(0)}, {{0.1, 0.2}, {0, 0}}));
  EXPECT_FALSE(cell.journal.may_look());
  cell.sync();
  EXPECT_TRUE(cell.journal.may_send(Intervals{{0.1, 0.2}, {0, 0}}));
}

TEST(PositionJournal, rest_is_written_once) {
  AtRest cell;
  const Positions rest{exact(0), exact(0)};
  EXPECT_FALSE(cell.journal.at_rest(rest, at({})));
  cell.reserve(rest, {{0, 0.1}, {0, 0}});
  EXPECT_TRUE(cell.journal.at_rest(rest, at({})));
  EXPECT_FALSE(cell.journal.at_rest(rest, at({})));
  // What widens at rest is a new truth.
  EXPECT_TRUE(cell.journal.at_rest(Positions{{PositionQuality::kUncertain, 0, -0.1, 0.1}, exact(0)},
                                   at({})));
}

TEST(PositionJournal, sensor_that_jitters_at_rest_writes_nothing) {
  JournalSettings settings = two_joints();
  settings.joints[0].slack = 0.01;
  const auto measured = [](double q) {
    return Positions{{PositionQuality::kMeasured, q, q - 0.001, q + 0.001}, exact(0)};
  };
  AtRest cell(settings, measured(1));
  for (const double q : {1.005, 0.995, 1.01, 0.99}) {
    EXPECT_FALSE(cell.journal.at_rest(measured(q), at({}))) << q;
  }
  const auto record = cell.journal.at_rest(measured(1.011), at({}));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->positions[0].q, 1.011);
  EXPECT_EQ(record->positions[0].lower, 1.011 - 0.001 - 0.01);
  // Nor does it begin a reservation where another joint moves.
  cell.sync();
  const Positions now{measured(1.012)[0], exact(0)};
  const Intervals next{{now[0].lower, now[0].upper}, {0, 0.5}};
  EXPECT_EQ(cell.reserve(now, next)->positions[0].quality, PositionQuality::kMeasured);
}

TEST(PositionJournal, reservation_ends_where_the_motion_or_the_joint_does) {
  AtRest cell;
  const Positions now{exact(0), exact(9.5)};
  const Intervals next{{0, 0.1}, {9.5, 9.6}};
  const Intervals whole{{0, 0.3}, {9.5, 20}};
  const auto record = cell.journal.reserve({now, next, whole}, at({}));
  EXPECT_EQ(record->positions[0].upper, 0.3);
  EXPECT_EQ(record->positions[1].upper, 10);
  cell.sync();
  const Positions later{exact(0.2), exact(9.9)};
  const Intervals last{{0.2, 0.3}, {9.9, 10}};
  EXPECT_FALSE(cell.journal.reserve({later, last, whole}, at({})));
  EXPECT_TRUE(cell.journal.may_send(last));
}

TEST(PositionJournal, a_way_to_rest_that_leads_out_of_the_motion_has_a_whole_block) {
  AtRest cell;
  const Positions now{exact(0), exact(0)};
  const Intervals whole{{0, 0.3}, {0, 0}};
  // The next pieces lead farther out, and none of them waits for a record of its own.
  ASSERT_TRUE(cell.journal.reserve({now, Intervals{{0, 0.35}, {0, 0}}, whole}, at({})));
  cell.sync();
  const Intervals farther{{0, 0.4}, {0, 0}};
  EXPECT_FALSE(cell.journal.reserve({now, farther, whole}, at({})));
  EXPECT_TRUE(cell.journal.may_send(farther));
}

TEST(PositionJournal, noise_that_moves_a_joint_has_its_room) {
  JournalSettings settings = two_joints();
  settings.joints[0].slack = 0.01;
  AtRest cell(settings);
  const auto record = cell.reserve({exact(0), exact(0)}, {{0, 0.1}, {0, 0}});
  EXPECT_EQ(record->positions[0].lower, -0.01);
  EXPECT_EQ(record->positions[0].upper, 0.1 + 1.25 + 0.01);
}

TEST(PositionJournal, lost_joint_moves_under_a_safe_intent_only_and_stays_lost) {
  AtRest cell;
  const Positions now{{}, exact(0)};
  ASSERT_TRUE(cell.journal.lost(now, JournalCause::kDevice, at({})));
  cell.sync();
  const Intervals next{{}, {0, 0}};
  EXPECT_FALSE(cell.journal.may_send(next));
  const auto record = cell.reserve(now, next);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->positions[0].quality, PositionQuality::kLost);
  cell.sync();
  EXPECT_TRUE(cell.journal.may_send(next));
  // It gets lost, or found, under way: that is said before anything else is sent.
  EXPECT_TRUE(cell.reserve({exact(1), exact(0)}, {{1, 1}, {0, 0}}));
  EXPECT_TRUE(cell.reserve({{}, exact(0)}, next));
}

TEST(PositionJournal, what_is_no_position_is_lost) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  PositionJournal journal(two_joints(), {7, 3, 1});
  const JournalRecord record =
      journal.open(Positions{{PositionQuality::kCommanded, nan, 0, 0},
                             {PositionQuality::kUncertain, 0, -infinity, 1}},
                   at({}));
  EXPECT_TRUE(is_valid(record));
  EXPECT_EQ(record.sequence, 8U);
  EXPECT_EQ(record.generation, 4U);
  EXPECT_EQ(record.cause, JournalCause::kRecovery);
  for (const JointPosition& joint : record.positions) {
    EXPECT_EQ(joint.quality, PositionQuality::kLost);
  }
  // A guess outside its interval is put inside.
  journal.durable(8);
  const auto said = journal.told(
      JournalKind::kDeclared, Positions{{PositionQuality::kUncertain, 5, 1, 2}, exact(0)}, at({}));
  EXPECT_EQ(said->positions[0].q, 2);
}

TEST(PositionJournal, generation_ends_at_rest_or_where_it_is_twice_as_long_under_way) {
  JournalSettings settings = two_joints();
  settings.generation_records = 4;
  AtRest cell(settings);
  std::vector<std::uint32_t> generations;
  double q = 0;
  for (int k = 0; k < 10; ++k, q += 2) {
    const auto record = cell.reserve({exact(q), exact(0)}, {{q, q + 2}, {0, 0}});
    generations.push_back(record->generation);
    cell.sync();
  }
  EXPECT_EQ(generations, (std::vector<std::uint32_t>{1, 1, 1, 1, 1, 1, 1, 2, 2, 2}));
  for (int k = 0; k < 3; ++k) {
    const auto record =
        cell.journal.told(JournalKind::kDeclared, Positions{exact(q), exact(0)}, at({}));
    generations.push_back(record->generation);
    cell.sync();
  }
  EXPECT_EQ(generations[10], 2U);
  EXPECT_EQ(generations[11], 3U);
  EXPECT_EQ(generations[12], 3U);
}

TEST(PositionJournal, slow_disk_gets_no_more_than_it_can_take_and_is_told_of) {
  AtRest cell;
  std::size_t records = 0;
  double q = 0;
  for (int k = 0; k < 50; ++k, q += 2) {
    const auto record = cell.journal.reserve(
        {Positions{exact(q), exact(0)}, Intervals{{q, q + 2}, {0, 0}}}, at(milliseconds(k)));
    records += record ? 1 : 0;
    EXPECT_FALSE(cell.journal.may_send(Intervals{{q, q + 2}, {0, 0}}));
  }
  EXPECT_EQ(records, PositionJournal::kUnsyncedMax - 1);
  EXPECT_FALSE(cell.journal.at_rest(Positions{exact(q), exact(0)}, at(milliseconds(50))));
  EXPECT_FALSE(cell.journal.settled());
  EXPECT_FALSE(cell.journal.overdue(Instant{milliseconds(100)}));
  EXPECT_TRUE(cell.journal.overdue(Instant{milliseconds(101)}));
  cell.sync();
  EXPECT_FALSE(cell.journal.overdue(Instant{milliseconds(999)}));
  EXPECT_TRUE(cell.journal.settled());
  EXPECT_TRUE(cell.journal.at_rest(Positions{exact(q), exact(0)}, at(milliseconds(51))));
}

/// One joint at constant speed for a minute, sent each `cycle`; a sync takes 50 ms.
struct Drive {
  double speed = 0;
  double step = 0;  ///< that is sent at once
  std::size_t joints = 1;
  std::size_t records = 0;
  std::size_t waits = 0;  ///< cycles in which nothing could be sent, behind the first record

  void run(const JournalSettings& settings) {
    AtRest cell(settings);
    Instant done = Instant::max();
    double q = 0;
    const auto cycle = from_seconds(step / speed);
    for (Instant now{}; now < Instant{std::chrono::minutes(1)}; now += cycle) {
      if (now >= done) cell.sync(), done = Instant::max();
      Positions positions(joints, exact(q));
      const Intervals next(joints, {q, q + step});
      if (cell.journal.reserve({positions, next}, {now, 0})) {
        ++records;
        done = now + milliseconds(50);
      }
      if (cell.journal.may_send(next)) {
        q += step;
      } else if (records > 1) {
        ++waits;
      }
    }
  }
};

TEST(PositionJournal, hexapod_syncs_less_than_four_times_a_second_and_never_waits) {
  // hexapod: 240 units/s of 218.75 nm; 64 of them are a block, 16 take 67 ms.
  constexpr double kUnit = 218.75e-9;
  JournalSettings settings;
  for (int k = 0; k < 6; ++k) {
    settings.joints.push_back({.block = 64 * kUnit, .lead = 16 * kUnit, .slack = kUnit});
  }
  Drive one{.speed = 240 * kUnit, .step = kUnit};
  JournalSettings single = settings;
  single.joints.resize(1);
  one.run(single);
  EXPECT_EQ(one.waits, 0U);
  EXPECT_LE(one.records, 4 * 60U);
  EXPECT_GT(one.records, 3 * 60U);
  Drive six{.speed = 40 * kUnit, .step = kUnit, .joints = 6};
  six.run(settings);
  EXPECT_EQ(six.waits, 0U);
  EXPECT_LE(six.records, 60U);
}

TEST(PositionJournal, arm_at_full_speed_syncs_less_than_five_times_a_second_and_never_waits) {
  // robot-arm-2: 29.5 deg/s, a cycle of 10 ms; a block is 250 ms of that, the lead 80 ms.
  const double speed = from_deg(29.5);
  JournalSettings settings;
  for (int k = 0; k < 6; ++k) {
    settings.joints.push_back({.block = 0.25 * speed, .lead = 0.08 * speed});
  }
  Drive arm{.speed = speed, .step = speed * 0.01, .joints = 6};
  arm.run(settings);
  EXPECT_EQ(arm.waits, 0U);
  EXPECT_LE(arm.records, 5 * 60U);
}

TEST(PositionJournal, its_calls_allocate_nothing) {
  PositionJournal journal(two_joints(), {});
  const std::array<JointPosition, 2> now{exact(0), exact(0)};
  const std::array<JointInterval, 2> next{JointInterval{0, 1}, JointInterval{0, 0}};
  const test::AllocationCounter allocations;
  journal.open(now, at({}));
  EXPECT_TRUE(journal.reserve({now, next}, at({})));
  journal.durable(2);
  EXPECT_TRUE(journal.may_send(next));
  EXPECT_TRUE(journal.at_rest(now, at({})));
  EXPECT_TRUE(journal.lost(now, JournalCause::kUser, at({})));
  EXPECT_TRUE(journal.close(now, at({})));
  EXPECT_FALSE(journal.overdue(Instant{}));
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew
