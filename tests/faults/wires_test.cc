#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <iostream>

#include "faults/campaign.h"
#include "sinew/core/units.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/how_many.h"
#include "support/robots.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// Faults that each wire gets: SINEW_FAULTS where it is set, times what one of this wire is worth.
std::uint64_t faults_wanted(const WireRules& rules, std::uint64_t usual) {
  const auto wanted = number_of("SINEW_FAULTS");
  if (!wanted) return usual;
  return static_cast<std::uint64_t>(static_cast<double>(*wanted) * rules.faults_each);
}

/// SINEW_FAULT_CASE: that one only.
std::optional<std::uint64_t> only_case() {
  return number_of("SINEW_FAULT_CASE");
}

/// How many faults there shall be decides where a case ends.
std::string replay_of(std::uint64_t number) {
  const char* faults = std::getenv("SINEW_FAULTS");
  return "SINEW_SEED=" + std::to_string(seed()) +
         (faults != nullptr ? " SINEW_FAULTS=" + std::string(faults) : "") +
         " SINEW_FAULT_CASE=" + std::to_string(number);
}

void print(const CampaignSums& sums, double seconds) {
  std::cout << "  " << sums.faults << " faults in " << sums.episodes << " episodes, "
            << to_seconds(sums.virtual_time) / 3600 << " h in " << seconds
            << " s of the processor; done " << sums.done << ", failed " << sums.failed
            << ", stopped " << sums.stopped << ", refused " << sums.refused << "\n  worst recovery "
            << to_seconds(sums.worst_recovery) << " s; off the way " << sums.wrong_motions
            << " times, by " << sums.worst_excess << " and for " << to_seconds(sums.worst_stray)
            << " s at most; rested elsewhere than claimed " << sums.wrong_rests << " times, by "
            << sums.worst_error << " at most; power cuts " << sums.power_cuts << ", runaways "
            << sums.runaways << ", slips " << sums.slips << ", homings " << sums.homings
            << ", second tries " << sums.second_tries << '\n';
  for (const auto& [name, count] : sums.device_faults) {
    std::cout << "    fault " << name << ": " << count << '\n';
  }
}

CampaignSums run_campaign(const WireRules& rules, std::uint64_t usual) {
  const std::clock_t began = std::clock();
  CampaignSums sums;
  const auto robot = runtime::variant_of(test::robot(rules.robot), rules.profile, rules.wire);
  if (!robot) {
    ADD_FAILURE() << robot.error();
    return sums;
  }
  const std::uint64_t wanted = faults_wanted(rules, usual);
  for (std::uint64_t k = only_case().value_or(0); sums.faults < wanted; ++k) {
    FaultCase fault_case(*robot, rules, seed() ^ (k * 0xD1342543DE82EF95ULL), sums);
    bool fine = fault_case.begin();
    for (int i = 0; fine && i < rules.episodes && sums.faults < wanted; ++i) {
      fine = fault_case.episode();
    }
    fault_case.add_counts();
    if (!fine) {
      ADD_FAILURE() << fault_case.complaint() << "\nreplay with " << replay_of(k);
      break;
    }
    if (only_case()) break;
  }
  print(sums, static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  ::testing::Test::RecordProperty("cases", std::to_string(sums.faults));
  return sums;
}

// What stands in docs/wires/*.md, as numbers.

WireRules lsc(const std::string& profile) {
  WireRules rules;
  rules.robot = "learm";
  rules.profile = profile;
  rules.regain = Regain::kSlowMove;
  rules.trusted = false;
  // What was commanded is claimed with its sag, what was measured as it was read.
  rules.tolerance = profile == "bus" ? 0.08 : 0.02;
  rules.overshoot = 0.1;
  // The ESP32 swallows up to 255 bytes behind a damaged length, and the host asks slowly.
  rules.recovery = profile == "esp32" ? 60s : 5s;
  rules.rest = 500ms;
  rules.phase = 25s;
  return rules;
}

/// Between two frames and their repeats.
WireRules lsc_single_flips(const std::string& profile) {
  WireRules rules = lsc(profile);
  rules.single_flips = 400ms;
  rules.true_at_rest = true;
  // What was said wrongly last stays until somebody opens it again.
  rules.closes = false;
  // In a motion the next segment mends it, at rest the next sign of life; a bit of an id gives a
  // servo another one's target.
  rules.excess_max = 3.6;
  // A bus arm is measured, says so, and waits for a slow move where it stands outside its limits.
  if (profile == "lsc6") {
    // Up to 1.1 s until it hears its targets again, and 0.9 s on the way.
    rules.rest = 2500ms;
    // Where a second flip makes the position lost, until the slow move that finds it again.
    rules.stray_max = 20s;
  }
  return rules;
}

TEST(Faults, lsc6_single_flips_are_mended_by_the_next_frame) {
  run_campaign(lsc_single_flips("lsc6"), 500);
}
TEST(Faults, lsc_bus_single_flips_are_mended_by_the_next_frame) {
  run_campaign(lsc_single_flips("bus"), 500);
}
TEST(Faults, lsc6) {
  run_campaign(lsc("lsc6"), 2000);
}
TEST(Faults, lsc_bus) {
  run_campaign(lsc("bus"), 2000);
}
TEST(Faults, lsc_esp32) {
  run_campaign(lsc("esp32"), 2000);
}

WireRules maxarm(const std::string& profile) {
  WireRules rules;
  rules.robot = "maxarm";
  rules.profile = profile;
  rules.trusted = false;
  rules.tolerance = from_deg(1);
  rules.overshoot = from_deg(2);
  rules.recovery = 30s;
  rules.rest = 2s;
  rules.longest_motion = 66s;
  rules.phase = 25s;
  return rules;
}

TEST(Faults, maxarm_arduino) {
  run_campaign(maxarm("arduino"), 1000);
}
TEST(Faults, maxarm_micropython) {
  WireRules rules = maxarm("micropython");
  // It holds pulses at p2 <= 700 and p3 >= 470, and the driver tells that the target is missed.
  rules.lower[1] = from_deg(210 - 0.24 * 690);
  rules.lower[2] = from_deg(0.24 * 480 - 120);
  run_campaign(rules, 1000);
}

WireRules bigrobotarm(const std::string& profile, const std::string& wire) {
  WireRules rules;
  rules.robot = "bigrobotarm";
  rules.profile = profile;
  rules.wire = wire;
  rules.regain = Regain::kDeclare;
  rules.trusted = false;
  rules.runs_away = true;
  // What is claimed holds what a rotor trails its field by.
  rules.tolerance = 1e-6;
  rules.overshoot = from_deg(0.5);
  rules.recovery = 20s;
  rules.rest = 1s;
  rules.phase = 25s;
  rules.way = 0.05;
  return rules;
}

TEST(Faults, maxarm_single_flips_make_no_wrong_motion) {
  WireRules rules = maxarm("arduino");
  rules.trusted = true;
  rules.single_flips = 3s;
  rules.faults_each = 0.1;  // as many would take hours
  run_campaign(rules, 100);
}

TEST(Faults, bigrobotarm_byte) {
  run_campaign(bigrobotarm("document", "byte"), 1000);
}
TEST(Faults, bigrobotarm_byte_as_built) {
  run_campaign(bigrobotarm("as-built", "byte"), 1000);
}
TEST(Faults, bigrobotarm_text) {
  run_campaign(bigrobotarm("as-built", "text"), 1000);
}
TEST(Faults, bigrobotarm_text2026) {
  run_campaign(bigrobotarm("as-built", "text2026"), 1000);
}

/// The same arm with our own firmware.
WireRules arm_link() {
  WireRules rules = bigrobotarm("sinew", "framed");
  rules.trusted = true;
  rules.runs_away = false;
  return rules;
}

TEST(Faults, arm_link) {
  run_campaign(arm_link(), 1000);
}
TEST(Faults, arm_link_single_flips_make_no_wrong_motion) {
  WireRules rules = arm_link();
  rules.single_flips = 0ms;
  run_campaign(rules, 1000);
}

WireRules icp(const std::string& profile = "table1") {
  WireRules rules;
  rules.robot = "hexapod";
  rules.profile = profile;
  rules.regain = Regain::kDeclare;
  rules.trusted = false;
  rules.by_field = true;
  rules.tolerance = 0.6 * 218.75e-9;
  rules.overshoot = 1.1 * 218.75e-9;
  rules.recovery = 8s;
  rules.rest = 500ms;
  rules.phase = 25s;
  rules.way = 0.0005;
  return rules;
}

TEST(Faults, icp) {
  run_campaign(icp(), 1000);
}
TEST(Faults, icp_section4) {
  run_campaign(icp("section4"), 1000);
}
TEST(Faults, icp_fffe) {
  run_campaign(icp("fffe"), 1000);
}

TEST(Faults, icp_single_flips_make_no_wrong_step) {
  WireRules rules = icp();
  rules.trusted = true;
  rules.single_flips = 600ms;
  run_campaign(rules, 200);
}

WireRules axis(const std::string& profile, const std::string& wire) {
  WireRules rules;
  rules.robot = "robot-arm-2";
  rules.profile = profile.empty() ? std::nullopt : std::optional(profile);
  rules.wire = wire;
  rules.regain = Regain::kHome;
  rules.tolerance = from_deg(0.5);
  rules.overshoot = from_deg(1);
  rules.recovery = 8s;
  rules.rest = 1s;
  rules.phase = 5s;
  rules.way = 0.01;
  rules.chance_max = 0.8;
  rules.moves_uncertain = wire == "registers";
  rules.episodes = 100;
  return rules;
}

TEST(Faults, axis_registers) {
  run_campaign(axis("document", "registers"), 1000);
}
/// The first firmware stores what it is told, has no status and moves nothing.
WireRules axis_as_built() {
  WireRules rules = axis("as-built", "registers");
  rules.regain = Regain::kDeclare;
  rules.stores_only = true;
  // Its board holds the place at which it came on, by single microsteps of 0.01 deg.
  rules.overshoot = from_deg(0.1);
  return rules;
}

TEST(Faults, axis_registers_as_built) {
  run_campaign(axis_as_built(), 1000);
}
TEST(Faults, axis_link) {
  WireRules rules = axis("", "link");
  rules.faults_each = 40;  // it has thousands in a second
  run_campaign(rules, 10000);
}

TEST(WholeCell, every_robot_moves_its_own_machine_as_it_was_asked) {
  const std::array rules{lsc("lsc6"),
                         lsc("bus"),
                         lsc("esp32"),
                         maxarm("arduino"),
                         maxarm("arduino-with-header"),
                         bigrobotarm("document", "byte"),
                         bigrobotarm("as-built", "text"),
                         bigrobotarm("as-built", "text2026"),
                         bigrobotarm("document", "probe"),
                         arm_link(),
                         icp(),
                         icp("section4"),
                         icp("fffe"),
                         axis("document", "registers"),
                         axis("", "link")};
  for (const WireRules& rule : rules) {
    const auto robot = runtime::variant_of(test::robot(rule.robot), rule.profile, rule.wire);
    ASSERT_TRUE(robot) << robot.error();
    CampaignSums sums;
    FaultCase fault_case(*robot, rule, seed(), sums);
    EXPECT_TRUE(fault_case.begin() && fault_case.clean_motions(4))
        << rule.robot << ' ' << rule.profile.value_or("") << ' ' << rule.wire.value_or("") << ": "
        << fault_case.complaint();
  }
}

TEST(Faults, axis_link_single_flips_make_no_wrong_motion) {
  WireRules rules = axis("", "link");
  rules.single_flips = 0ms;
  const CampaignSums sums = run_campaign(rules, 2000);
  EXPECT_EQ(sums.wrong_motions, 0U);
}

}  // namespace
}  // namespace sinew::test
