#include "sinew/toml/toml_guard.h"

#include <gtest/gtest.h>

#include "sinew/toml/toml_tree.h"

namespace sinew {
namespace {

/// "line:column" of the complaint, "" where there is none.
std::string place(std::string_view text) {
  const auto complaint = unfit_for_parser(text);
  if (!complaint) return "";
  return std::to_string(complaint->line) + ":" + std::to_string(complaint->column);
}

TEST(TomlGuard, size_and_line_length_are_bounded) {
  EXPECT_EQ(place(std::string(kMaxTomlBytes, '\n')), "");
  EXPECT_EQ(place(std::string(kMaxTomlBytes + 1, '\n')), "1:1");
  const std::string longest = "#" + std::string(kMaxTomlLineBytes - 1, 'x');
  EXPECT_EQ(place("\n" + longest + "\n"), "");
  EXPECT_EQ(place("\n" + longest + "x\n"), "2:1");
  EXPECT_EQ(place(longest + "x"), "1:1") << "the last line needs no line feed";
}

TEST(TomlGuard, characters_beyond_ascii_live_in_strings_and_comments_only) {
  for (const char* text :
       {"a = 'ü'", "a = \"ü\"", "a = \"\\\"ü\"", "a = 1 # ü", "a = '''\nü'''", "a = '#' # ü",
        "a = \"\"\"\nü\\\"\"\" ü\"\"\"", "a = \"\"\"ü\"\"\"\"\" # ü", "\xEF\xBB\xBF\x61 = 1", ""}) {
    EXPECT_EQ(place(text), "") << text;
    EXPECT_TRUE(parse_toml(text).has_value()) << text;
  }
  EXPECT_EQ(place("a = ü"), "1:5");
  EXPECT_EQ(place("a = 1\nü = 1"), "2:1");
  EXPECT_EQ(place("a = 'ü' ü"), "1:9") << "columns count characters";
  EXPECT_EQ(place("a = ''ü"), "1:7");
  EXPECT_EQ(place("a = \"\\\\\"ü"), "1:9");
  EXPECT_EQ(place("a = '\\'ü"), "1:8") << "a literal string knows no escape";
  EXPECT_EQ(place("a = \"x\nü"), "2:1") << "a string on one line ends with it";
  EXPECT_EQ(place("a = '''x'''\nü"), "2:1");
  EXPECT_EQ(place("a = \"\"\"x\"\"\"\"\"ü"), "1:14");
  EXPECT_EQ(place("# x\nü"), "2:1");
  EXPECT_EQ(place("a =\xC2\xA0"
                  "1"),
            "1:4")
      << "a no-break space is no space";
}

}  // namespace
}  // namespace sinew
