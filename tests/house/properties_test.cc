#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <regex>

#include "house/source_tree.h"
#include "support/property.h"

/// Properties: what they counted is what they asserted.
namespace sinew::house {
namespace {

/// Places in a file where the body of a property leaves before it has asserted anything, and does
/// not say so.
std::vector<std::size_t> silent_exits(const std::string& text) {
  constexpr std::string_view kCall = "for_random_cases(";
  static const std::regex kAsserts("EXPECT_|ASSERT_|expect_|FAIL\\(|HasF");
  static const std::regex kExit(R"(\breturn;)");
  std::vector<std::size_t> lines;
  for (auto at = text.find(kCall); at != text.npos; at = text.find(kCall, at + 1)) {
    std::size_t end = at + kCall.size();
    for (int depth = 1; depth > 0 && end < text.size(); ++end) {
      depth += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
    }
    const std::string body = text.substr(at, end - at);
    for (std::sregex_iterator exit(body.begin(), body.end(), kExit), none; exit != none; ++exit) {
      if (std::regex_search(body.begin(), body.begin() + exit->position(), kAsserts)) continue;
      const auto place = text.begin() + static_cast<std::ptrdiff_t>(at) + exit->position();
      lines.push_back(static_cast<std::size_t>(std::count(text.begin(), place, '\n')) + 1);
    }
  }
  return lines;
}

TEST(Properties, no_case_ends_before_its_first_assertion_without_being_discarded) {
  for (const SourceFile& file :
       read_tree(SINEW_SOURCE_DIR, std::array<std::string_view, 2>{"src", "tests"})) {
    for (const std::size_t line : silent_exits(code_only(file.text))) {
      ADD_FAILURE() << file.path << ":" << line << ": return random.discard();";
    }
  }
}

TEST(Properties, a_silent_exit_is_found_and_others_are_not) {
  const auto exits = [](const std::string& body) {
    return silent_exits("test::for_random_cases(5, [&](Random& random) {\n" + body + "});\n")
        .size();
  };
  EXPECT_EQ(exits("if (x) return;\nEXPECT_TRUE(y);\n"), 1U);
  EXPECT_EQ(exits("if (x) return random.discard();\nEXPECT_TRUE(y);\n"), 0U);
  EXPECT_EQ(exits("EXPECT_TRUE(y);\nif (x) return;\nEXPECT_TRUE(z);\n"), 0U);
}

TEST(Properties, discarded_cases_do_not_count_and_nothing_but_them_is_a_failure) {
  test::for_random_cases(100, [](test::Random& random) {
    if (random.integer(0, 3) == 0) return random.discard();
    EXPECT_GE(random.uniform(0, 1), 0);
  });
  const test::CaseCounts some = test::case_counts();
  EXPECT_GT(some.discarded, 0U);
  EXPECT_EQ(some.asserted, 100U) << "others take their place";
  EXPECT_NONFATAL_FAILURE(
      test::for_random_cases(10, [](test::Random& random) { random.discard(); }),
      "all 40 cases were discarded");
  EXPECT_EQ(test::case_counts().asserted, some.asserted);
}

}  // namespace
}  // namespace sinew::house
