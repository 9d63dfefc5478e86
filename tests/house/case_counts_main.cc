// Runs after all other tests and holds what they report against tests/minimum_cases.h.
//   case_counts           checks the programs that left a result; with SINEW_FULL_RUN=1 all of them
//   case_counts --table   prints what ran as rows of that file
// Exit: 0 all well, 1 complaints, 77 nothing ran that could be checked.

#include <cstdlib>
#include <iostream>
#include <string_view>

#include "house/case_counts.h"

namespace {

constexpr int kNothingToCheck = 77;

int run(bool table, sinew::house::Extent extent) {
  using namespace sinew::house;
  std::vector<std::string> complaints;
  const auto results = read_results(SINEW_RESULTS_FOLDER, SINEW_PROGRAMS_FOLDER, complaints);
  if (table) {
    std::cout << as_table(results);
    return EXIT_SUCCESS;
  }
  if (results.empty() && extent == Extent::kPartial) {
    std::cout << "no test program has run since it was built: nothing to check\n";
    return kNothingToCheck;
  }
  const auto lacking = hold_against(results, kMinimumTests, kMinimumCases, extent);
  complaints.insert(complaints.end(), lacking.begin(), lacking.end());
  for (const std::string& complaint : complaints) std::cout << complaint << '\n';

  std::size_t tests = 0;
  std::size_t skipped = 0;
  std::uint64_t cases = 0;
  for (const ProgramResult& result : results) {
    tests += result.tests;
    skipped += result.skipped;
    for (const auto& [name, ran] : result.cases) cases += ran;
  }
  std::cout << tests << " tests and " << cases << " random cases in " << results.size()
            << " programs, " << skipped << " skipped"
            << (extent == Extent::kFull ? "" : " (partial run: absent programs were not asked for)")
            << '\n';
  return complaints.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  const char* full = std::getenv("SINEW_FULL_RUN");
  const bool is_full = full != nullptr && std::string_view(full) == "1";
  const bool table = argc == 2 && std::string_view(argv[1]) == "--table";
  return run(table, is_full ? sinew::house::Extent::kFull : sinew::house::Extent::kPartial);
}
