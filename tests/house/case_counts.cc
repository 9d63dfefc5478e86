#include "house/case_counts.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace sinew::house {
namespace {

using Json = nlohmann::json;

void add_test(ProgramResult& result, const std::string& suite, const Json& test) {
  if (test.at("result") == "SKIPPED") ++result.skipped;
  if (test.at("status") != "RUN" || test.at("result") != "COMPLETED") return;
  if (test.contains("failures")) return;  // repeated, with a result of its own
  ++result.tests;
  if (!test.contains("cases")) return;
  const std::string name = suite + "." + test.at("name").get<std::string>();
  result.cases[name] = std::stoull(test.at("cases").get<std::string>());
  if (test.value("discarded", "0") != "0") result.varying.insert(name);
}

const ProgramResult* find(std::span<const ProgramResult> results, std::string_view program) {
  const auto found = std::ranges::find(results, program, &ProgramResult::program);
  return found == results.end() ? nullptr : &*found;
}

/// 100000 -> "100'000", as C++ reads it.
std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, 1, '\'');
  return digits;
}

std::string fewer(const std::string& who, std::uint64_t ran, std::uint64_t minimum,
                  const char* what) {
  return who + " ran " + std::to_string(ran) + " " + what + ", minimum " + std::to_string(minimum);
}

/// To what another shard of the same program has left.
void add_result(ProgramResult&& result, std::vector<ProgramResult>& results) {
  const auto found = std::ranges::find(results, result.program, &ProgramResult::program);
  if (found == results.end()) {
    results.push_back(std::move(result));
    return;
  }
  found->tests += result.tests;
  found->skipped += result.skipped;
  found->cases.merge(result.cases);
  found->varying.merge(result.varying);
}

void complain_of_missing_rows(const ProgramResult& result,
                              std::span<const MinimumTests> minimum_tests,
                              std::span<const MinimumCases> minimum_cases,
                              std::vector<std::string>& complaints) {
  const auto complain = [&](std::string who) {
    complaints.push_back(who.append(" has no row in tests/minimum_cases.h"));
  };
  const auto same_program = [&](const auto& row) { return row.program == result.program; };
  if (std::ranges::none_of(minimum_tests, same_program)) {
    complain(result.program);
  }
  for (const auto& [name, cases] : result.cases) {
    const auto same_test = [&](const auto& row) { return same_program(row) && row.test == name; };
    if (std::ranges::none_of(minimum_cases, same_test)) {
      complain(std::string(name).append(" of ").append(result.program));
    }
  }
}

}  // namespace

std::expected<ProgramResult, std::string> parse_result(std::string_view program,
                                                       std::string_view json) {
  ProgramResult result;
  result.program = program;
  try {
    const Json report = Json::parse(json);
    for (const Json& suite : report.at("testsuites")) {
      const auto suite_name = suite.at("name").get<std::string>();
      for (const Json& test : suite.at("testsuite")) add_test(result, suite_name, test);
    }
  } catch (const std::exception& failure) {
    return std::unexpected(result.program + " left no readable result: " + failure.what());
  }
  return result;
}

std::vector<std::string> hold_against(std::span<const ProgramResult> results,
                                      std::span<const MinimumTests> minimum_tests,
                                      std::span<const MinimumCases> minimum_cases, Extent extent) {
  std::vector<std::string> complaints;
  for (const MinimumTests& row : minimum_tests) {
    const ProgramResult* result = find(results, row.program);
    if (result != nullptr && result->tests < row.tests) {
      complaints.push_back(fewer(result->program, result->tests, row.tests, "tests"));
    }
    if (result == nullptr && extent == Extent::kFull) {
      complaints.push_back(std::string(row.program) + " left no result of this run");
    }
  }
  for (const MinimumCases& row : minimum_cases) {
    const ProgramResult* result = find(results, row.program);
    if (result == nullptr) continue;  // said above, once for the program
    const auto ran = result->cases.find(std::string(row.test));
    const std::uint64_t cases = ran == result->cases.end() ? 0 : ran->second;
    if (cases < row.cases) {
      complaints.push_back(fewer(std::string(row.test), cases, row.cases, "random cases"));
    }
  }
  if (extent == Extent::kPartial) return complaints;
  for (const ProgramResult& result : results) {
    complain_of_missing_rows(result, minimum_tests, minimum_cases, complaints);
  }
  return complaints;
}

std::string as_table(std::span<const ProgramResult> results) {
  std::string tests;
  std::string cases;
  for (const ProgramResult& result : results) {
    const std::string program = "    {\"" + result.program + "\", ";
    tests.append(program).append(std::to_string(result.tests)).append("},\n");
    for (const auto& [name, ran] : result.cases) {
      cases.append(program).append("\"").append(name).append("\", ");
      cases.append(grouped(result.varying.contains(name) ? ran / 2 : ran));
      cases.append("},\n");
    }
  }
  return tests + "\n" + cases;
}

std::vector<ProgramResult> read_results(const std::filesystem::path& folder,
                                        const std::filesystem::path& programs_folder,
                                        std::vector<std::string>& complaints) {
  namespace fs = std::filesystem;
  std::vector<ProgramResult> results;
  if (!fs::exists(folder)) return results;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    // Shards of one program are NAME.1.json, NAME.2.json, ...
    const std::string stem = entry.path().stem().string();
    const std::string name = stem.substr(0, stem.find('.'));
    const fs::path program = programs_folder / name;
    if (!fs::exists(program)) continue;
    if (fs::last_write_time(program) > entry.last_write_time()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    auto result = parse_result(name, text);
    if (result.has_value()) {
      add_result(std::move(*result), results);
    } else {
      complaints.push_back(result.error());
    }
  }
  std::ranges::sort(results, {}, &ProgramResult::program);
  return results;
}

}  // namespace sinew::house
