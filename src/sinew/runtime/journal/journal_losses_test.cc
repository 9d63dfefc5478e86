#include <gtest/gtest.h>

#include <iostream>

#include "sinew/runtime/journal/journal_test_cell.h"
#include "support/how_many.h"

namespace sinew::runtime {
namespace {

using test::Cell;
using test::FindingCounts;
using test::Random;

/// The end of a life, one way or another.
void crash(Cell& cell, Random& random) {
  if (cell.disk.power_is_cut() || random.chance(0.6)) {
    cell.lose_power();
  } else {
    cell.kill();
  }
}

TEST(JournalLosses, what_is_recovered_always_contains_the_truth) {
  FindingCounts findings{};
  std::uint64_t sends = 0;
  std::uint64_t records = 0;
  const std::uint64_t losses = sinew::test::how_many("SINEW_POWER_LOSSES", 2000);
  sinew::test::for_random_cases(losses, [&](Random& random) {
    Cell cell(random);
    const std::int64_t lives = random.integer(1, 5);
    for (std::int64_t life = 0; life < lives && !::testing::Test::HasFailure(); ++life) {
      if (random.chance(0.8)) {
        const auto calls = static_cast<std::uint64_t>(random.integer(1, 40));
        cell.disk.cut_power_at_call(cell.disk.calls() + calls);
      }
      cell.live();
      crash(cell, random);
    }
    findings[static_cast<std::size_t>(cell.look().finding)] += 1;
    for (std::size_t k = 0; k < findings.size(); ++k) findings[k] += cell.findings[k];
    sends += cell.sends;
    records += cell.records;
  });
  for (std::size_t k = 0; k < findings.size(); ++k) {
    if (findings[k] == 0) continue;
    std::cout << "  " << findings[k] << " " << sentence(static_cast<JournalFinding>(k)) << "\n";
  }
  std::cout << "  " << sends << " sendings, " << records << " records\n";
  // A journal that always says "lost" would be right too.
  const auto times = [&](JournalFinding finding) {
    return findings[static_cast<std::size_t>(finding)];
  };
  EXPECT_GT(times(JournalFinding::kEndedInMotion), losses / 4);
  EXPECT_GT(times(JournalFinding::kEndedAtRest), losses / 4);
  EXPECT_GT(times(JournalFinding::kCleanEnd), losses / 100);
  EXPECT_GT(sends, 50 * losses);
  // Crashes never look like somebody's hand.
  for (const auto finding :
       {JournalFinding::kEdited, JournalFinding::kOlderCopy, JournalFinding::kCopied,
        JournalFinding::kCut, JournalFinding::kUnreadable, JournalFinding::kOtherModel,
        JournalFinding::kOtherRobot}) {
    EXPECT_EQ(times(finding), 0U) << sentence(finding);
  }
}

/// The same life again and again, its power cut at its first call to the disk, its second, ...
TEST(JournalLosses, power_that_goes_at_each_call_in_turn_never_leaves_a_lie) {
  std::uint64_t cuts = 0;
  for (std::uint64_t life = 0; life < 60; ++life) {
    for (std::uint64_t call = 1; !::testing::Test::HasFailure(); ++call) {
      Random random(sinew::test::seed() + life);
      Cell cell(random);
      cell.disk.cut_power_at_call(cell.disk.calls() + call);
      cell.live({.cycles_max = 400});
      if (!cell.disk.power_is_cut()) break;  // it had no more calls than that
      cell.lose_power();
      cell.look();
      ++cuts;
    }
  }
  std::cout << "  " << cuts << " cuts\n";
  EXPECT_GT(cuts, 500U);
}

TEST(JournalLosses, full_disk_at_any_write_starts_no_motion_and_holds_within_100_ms) {
  Duration longest{};
  std::uint64_t failed = 0;
  sinew::test::for_random_cases(1500, [&](Random& random) {
    Cell cell(random);
    cell.live();
    cell.kill();
    if (random.chance(0.5)) {
      cell.disk.fail_from_call(
          cell.disk.calls() + static_cast<std::uint64_t>(random.integer(1, 40)),
          {DiskErrorCode::kFull, 0});
    } else {
      // Room for some records more, to the byte.
      std::size_t used = 0;
      for (const char* name : {"positions.0", "positions.1"}) {
        used += cell.disk.bytes(name).value_or(std::vector<std::uint8_t>{}).size();
      }
      cell.disk.set_capacity(used + static_cast<std::size_t>(random.integer(0, 12'000)));
    }
    cell.live();
    longest = std::max(longest, cell.longest_to_hold);
    failed += cell.longest_to_hold > Duration{} ? 1 : 0;
    // What stood there before can be read, and is right; with power or without.
    crash(cell, random);
    const JournalRecovery recovery = cell.look();
    EXPECT_NE(recovery.finding, JournalFinding::kUnreadable);
    EXPECT_NE(recovery.finding, JournalFinding::kCut);
  });
  std::cout << "  " << failed << " times full; longest until held " << to_seconds(longest)
            << " s\n";
  EXPECT_GT(failed, 300U);
  EXPECT_LE(longest, std::chrono::milliseconds(100));
}

TEST(JournalLosses, journal_alone_ends_motion_where_nobody_hears_that_the_disk_failed) {
  std::uint64_t sends = 0;
  sinew::test::for_random_cases(500, [&](Random& random) {
    Cell cell(random);
    cell.live({.cycles_max = 300});
    cell.kill();
    cell.disk.fail_from_call(cell.disk.calls() + static_cast<std::uint64_t>(random.integer(1, 20)),
                             {DiskErrorCode::kFailed, 5});
    const std::uint64_t before = cell.motions;
    cell.live({.cycles_max = 3000, .hold_on_failure = false});
    // No more than the block that was safe already, each way, of each change of mind inside it.
    EXPECT_LE(cell.sends_after_failure, 4 * (64 + 48 + 4) * (cell.motions - before + 1));
    sends += cell.sends_after_failure;
    crash(cell, random);
    cell.look();
  });
  EXPECT_GT(sends, 0U);
}

TEST(JournalLosses, slow_disk_makes_motion_wait_and_never_lie) {
  sinew::test::for_random_cases(100, [](Random& random) {
    Cell cell(random);
    cell.disk.set_sync_time(std::chrono::milliseconds(200), std::chrono::milliseconds(900), 1);
    cell.live({.cycles_max = 4000});
    crash(cell, random);
    cell.look();
  });
}

}  // namespace
}  // namespace sinew::runtime
