#include "sinew/toml/toml_tree.h"

#include <gtest/gtest.h>

#include "sinew/toml/toml_guard.h"

namespace sinew {
namespace {

TEST(TomlTree, keys_and_values_know_their_line_and_column) {
  const auto tree =
      parse_toml("a = 1\n[t]\n  b = [1.5, 'ü',  true]\n\n[[r]]\nc = {d = 2}\n[[r]]\n");
  ASSERT_TRUE(tree.has_value());
  ASSERT_EQ(tree->size(), 3U);
  EXPECT_EQ((*tree)[0].key, "a");
  EXPECT_EQ((*tree)[0].place, (Place{1, 1}));
  EXPECT_EQ((*tree)[0].node.place, (Place{1, 5}));
  const TomlEntry& t = (*tree)[1];
  EXPECT_EQ(t.node.place, (Place{2, 1}));
  const TomlEntry& b = std::get<TomlTable>(t.node.value)[0];
  EXPECT_EQ(b.place, (Place{3, 3}));
  const auto& items = std::get<TomlArray>(b.node.value);
  ASSERT_EQ(items.size(), 3U);
  EXPECT_EQ(items[1].place, (Place{3, 13}));
  EXPECT_EQ(items[2].place, (Place{3, 19})) << "columns count characters, not bytes";
  EXPECT_TRUE(std::get<bool>(items[2].value));
  const auto& r = std::get<TomlArray>((*tree)[2].node.value);
  ASSERT_EQ(r.size(), 2U);
  EXPECT_EQ(r[1].place, (Place{7, 1}));
}

TEST(TomlTree, entries_stand_in_the_order_of_the_file) {
  const auto tree = parse_toml("z = 1\na = 2\nm = 3\n");
  ASSERT_TRUE(tree.has_value());
  EXPECT_EQ((*tree)[0].key, "z");
  EXPECT_EQ((*tree)[1].key, "a");
  EXPECT_EQ((*tree)[2].key, "m");
}

TEST(TomlTree, syntax_errors_say_where_the_parser_gave_up) {
  const auto tree = parse_toml("a = 1\nb = = 2\n");
  ASSERT_FALSE(tree.has_value());
  EXPECT_EQ(tree.error().line, 2);
  EXPECT_EQ(tree.error().column, 5);
  EXPECT_FALSE(tree.error().message.empty());
  const auto twice = parse_toml("a = 1\na = 2\n");
  ASSERT_FALSE(twice.has_value());
  EXPECT_EQ(twice.error().line, 2);
}

/// The library's own assertions end the program here.
TEST(TomlTree, header_that_begins_with_a_dot_is_an_error_with_a_place) {
  for (const char* text : {"[.a]", "[[.a]]", "[ =]", "[+]", "[[#]]", "[,"}) {
    const auto tree = parse_toml("\n" + std::string(text) + "\n");
    ASSERT_FALSE(tree.has_value()) << text;
    EXPECT_EQ(tree.error().line, 2) << text;
  }
}

TEST(TomlTree, every_kind_of_value_has_a_name_for_people) {
  const auto tree = parse_toml("a=1979-05-27\nb=true\nc=1\nd=1.0\ne=''\nf=[]\ng={}\n");
  ASSERT_TRUE(tree.has_value());
  std::string names;
  for (const TomlEntry& entry : *tree) names += std::string(type_name(entry.node)) + "; ";
  EXPECT_EQ(names,
            "a date or time; true or false; a whole number; a real number; a string; a list; "
            "a table; ");
}

TEST(TomlTree, depth_is_bounded) {
  EXPECT_TRUE(parse_toml("a = [[[[1]]]]").has_value());
  EXPECT_FALSE(parse_toml("a = " + std::string(100, '[') + std::string(100, ']')).has_value());
}

/// As deep as the bounds let a file go: dots fill each line and tables stand in lists in tables.
TEST(TomlTree, deepest_file_that_is_let_in_does_not_exhaust_the_stack) {
  std::string dots = "a";
  while (dots.size() + 10 < kMaxTomlLineBytes) dots += ".a";
  std::string text = "[" + dots + "]\n";
  std::string end = "1";
  for (int i = 0; i < 3; ++i) {
    text += dots + " = [{\n";
    end += "}]";
  }
  // TOML lets no line end inside an inline table; a list in between is the way around.
  EXPECT_FALSE(parse_toml(text + "b = " + end).has_value());
  std::string lists = "[" + dots + "]\n" + dots + " = [";
  for (int i = 0; i < 3; ++i) lists += "\n{" + dots + " = [";
  const auto tree = parse_toml(lists + "\n1]}]}]}]\n");
  ASSERT_TRUE(tree.has_value()) << tree.error().message;
  const TomlTable* table = &*tree;
  std::size_t depth = 0;
  while (table != nullptr) {
    ++depth;
    const TomlNode* node = &table->front().node;
    if (const auto* list = std::get_if<TomlArray>(&node->value)) node = &list->front();
    table = std::get_if<TomlTable>(&node->value);
  }
  EXPECT_GT(depth, 900U);
}

TEST(TomlTree, megabyte_of_one_pattern_is_read_or_refused) {
  constexpr struct {
    const char* piece;
    bool valid;
  } kCases[] = {{"[[a]]\n", true},      {"# x\n", true}, {"[a.b]\n", false}, {"a.b.c = [\n", false},
                {"\"\" = ''\n", false}, {"{\n", false},  {"'''\n", false},   {"\xff\n", false}};
  for (const auto& c : kCases) {
    std::string text;
    while (text.size() + 20 < kMaxTomlBytes) text += c.piece;
    EXPECT_EQ(parse_toml(text).has_value(), c.valid) << c.piece;
  }
}

}  // namespace
}  // namespace sinew
