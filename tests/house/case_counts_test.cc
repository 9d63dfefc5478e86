#include "house/case_counts.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "support/scratch_folder.h"

namespace sinew::house {
namespace {

using Complaints = std::vector<std::string>;

constexpr std::array kTests = std::to_array<MinimumTests>({{"wire_test", 2}});
constexpr std::array kCases = std::to_array<MinimumCases>({{"wire_test", "Crc.finds_it", 500}});

std::string report(const std::string& cases) {
  return R"({"testsuites": [{"name": "Crc", "testsuite": [
    {"name": "finds_it", "status": "RUN", "result": "COMPLETED", "cases": ")" +
         cases + R"("},
    {"name": "table", "status": "RUN", "result": "COMPLETED"},
    {"name": "off", "status": "NOTRUN", "result": "SUPPRESSED"},
    {"name": "later", "status": "RUN", "result": "SKIPPED"}]}]})";
}

Complaints judged(const std::string& json, Extent extent) {
  const auto result = parse_result("wire_test", json);
  if (!result.has_value()) return {result.error()};
  return hold_against(std::array{*result}, kTests, kCases, extent);
}

TEST(CaseCounts, pass_where_enough_ran) {
  EXPECT_EQ(judged(report("500"), Extent::kFull), Complaints{});
}

TEST(CaseCounts, name_the_test_that_ran_too_few_cases) {
  const Complaints expected{"Crc.finds_it ran 499 random cases, minimum 500"};
  EXPECT_EQ(judged(report("499"), Extent::kFull), expected);
  EXPECT_EQ(judged(report("499"), Extent::kPartial), expected);
}

TEST(CaseCounts, do_not_count_skipped_and_disabled_tests) {
  const auto result = parse_result("wire_test", report("500"));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->tests, 2U);
  EXPECT_EQ(result->skipped, 1U);
  constexpr std::array kThree = std::to_array<MinimumTests>({{"wire_test", 3}});
  EXPECT_EQ(hold_against(std::array{*result}, kThree, {}, Extent::kPartial),
            (Complaints{"wire_test ran 2 tests, minimum 3"}));
}

TEST(CaseCounts, a_property_that_vanished_ran_no_cases) {
  EXPECT_EQ(judged(R"({"testsuites": [{"name": "Crc", "testsuite": [
      {"name": "a", "status": "RUN", "result": "COMPLETED"},
      {"name": "b", "status": "RUN", "result": "COMPLETED"}]}]})",
                   Extent::kPartial),
            (Complaints{"Crc.finds_it ran 0 random cases, minimum 500"}));
}

TEST(CaseCounts, a_program_without_a_result_fails_the_full_run_only) {
  EXPECT_EQ(hold_against({}, kTests, kCases, Extent::kPartial), Complaints{});
  EXPECT_EQ(hold_against({}, kTests, kCases, Extent::kFull),
            (Complaints{"wire_test left no result of this run"}));
}

TEST(CaseCounts, a_result_without_a_row_fails_the_full_run_only) {
  const auto result = parse_result("new_test", report("500"));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(hold_against(std::array{*result}, {}, {}, Extent::kPartial), Complaints{});
  EXPECT_EQ(hold_against(std::array{*result}, {}, {}, Extent::kFull),
            (Complaints{"new_test has no row in tests/minimum_cases.h",
                        "Crc.finds_it of new_test has no row in tests/minimum_cases.h"}));
}

TEST(CaseCounts, where_chance_discards_some_half_of_the_others_is_the_minimum) {
  const auto result = parse_result("wire_test", R"({"testsuites": [
      {"name": "Crc", "testsuite": [
      {"name": "a", "status": "RUN", "result": "COMPLETED", "cases": "500", "discarded": "0"},
      {"name": "b", "status": "RUN", "result": "COMPLETED", "cases": "500",
       "discarded": "9"}]}]})");
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(as_table(std::array{*result}),
            "    {\"wire_test\", 2},\n\n    {\"wire_test\", \"Crc.a\", 500},\n"
            "    {\"wire_test\", \"Crc.b\", 250},\n");
}

TEST(CaseCounts, are_printed_as_the_rows_of_the_table) {
  std::vector<ProgramResult> results{{"a_test", 1, 0, {{"A.a", 999}, {"A.b", 1000}}, {}},
                                     {"b_test", 2, 0, {{"B.c", 12345678}}, {}}};
  EXPECT_EQ(as_table(results),
            "    {\"a_test\", 1},\n    {\"b_test\", 2},\n\n    {\"a_test\", \"A.a\", 999},\n"
            "    {\"a_test\", \"A.b\", 1'000},\n    {\"b_test\", \"B.c\", 12'345'678},\n");
}

TEST(CaseCounts, an_unreadable_result_is_a_complaint) {
  for (const char* json : {"", "{", "[]", R"({"testsuites": [{"name": 3}]})"}) {
    const Complaints complaints = judged(json, Extent::kPartial);
    ASSERT_EQ(complaints.size(), 1U) << json;
    EXPECT_TRUE(complaints[0].starts_with("wire_test left no readable result: ")) << complaints[0];
  }
  EXPECT_EQ(judged(report("many"), Extent::kPartial).size(), 1U);
}

TEST(CaseCounts, shards_of_one_program_are_added_up) {
  const test::ScratchFolder folder;
  const std::filesystem::path programs = folder.at("programs");
  const std::filesystem::path results = folder.at("results");
  std::filesystem::create_directories(programs);
  std::filesystem::create_directories(results);
  std::ofstream(programs / "wire_test") << "x";
  std::ofstream(results / "wire_test.1.json") << report("200");
  std::ofstream(results / "wire_test.2.json") << R"({"testsuites": [{"name": "Lsc", "testsuite": [
        {"name": "flips", "status": "RUN", "result": "COMPLETED", "cases": "7"}]}]})";
  Complaints complaints;
  const auto all = read_results(results, programs, complaints);
  EXPECT_TRUE(complaints.empty());
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].program, "wire_test");
  EXPECT_EQ(all[0].tests, 3U);
  EXPECT_EQ(all[0].skipped, 1U);
  EXPECT_EQ(all[0].cases.at("Crc.finds_it"), 200U);
  EXPECT_EQ(all[0].cases.at("Lsc.flips"), 7U);
}

}  // namespace
}  // namespace sinew::house
