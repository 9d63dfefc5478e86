#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "minimum_cases.h"

namespace sinew::house {

/// What one GoogleTest program did: tests that ran to their end, and of those that are properties
/// the random cases that asserted something.
struct ProgramResult {
  std::string program;
  std::size_t tests = 0;
  std::size_t skipped = 0;
  std::map<std::string, std::uint64_t> cases;  ///< by Suite.name
  std::set<std::string> varying;  ///< of these, where other cases were discarded: the seed's chance
};

/// Reads GoogleTest's JSON report.
/// @error  a sentence, where the text is not such a report.
std::expected<ProgramResult, std::string> parse_result(std::string_view program,
                                                       std::string_view json);

/// Whether every program was meant to run, or only those that left a result.
enum class Extent : std::uint8_t { kPartial, kFull };

/// Complaints where fewer tests or cases ran than the tables ask for. In a full run a program that
/// left no result and a result without a row are complaints too.
std::vector<std::string> hold_against(std::span<const ProgramResult> results,
                                      std::span<const MinimumTests> minimum_tests,
                                      std::span<const MinimumCases> minimum_cases, Extent extent);

/// The rows of minimum_cases.h that these results would just meet; half as many cases where how
/// many there are is the seed's chance.
std::string as_table(std::span<const ProgramResult> results);

/// The results below `folder`, sorted by program; of one that ran in shards NAME.1.json,
/// NAME.2.json and so on are added up. A result that is older than its program in `programs_folder`
/// belongs to an earlier build and is left out; an unreadable one is a complaint.
std::vector<ProgramResult> read_results(const std::filesystem::path& folder,
                                        const std::filesystem::path& programs_folder,
                                        std::vector<std::string>& complaints);

}  // namespace sinew::house
