#include "sinew/toml/table_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace sinew {
namespace {

/// Reads `text` as one table and returns what was complained about, as text.
std::vector<std::string> complaints(const std::string& text,
                                    const std::function<void(TableReader&)>& read) {
  const auto tree = parse_toml(text);
  if (!tree) return {to_text(tree.error())};
  Findings findings("f");
  TableReader reader(*tree, Place{}, "t", findings);
  read(reader);
  reader.finish();
  std::vector<std::string> texts;
  for (const Complaint& complaint : findings.take_complaints()) {
    texts.push_back(to_text(complaint));
  }
  return texts;
}

using Lines = std::vector<std::string>;

TEST(TableReader, every_unit_arrives_in_si) {
  constexpr struct {
    const char* text;
    double metres;
  } kCases[] = {{"d_mm = 95", 0.095}, {"d_m = 0.095", 0.095}, {"d_in = 2", 0.0508}};
  for (const auto& c : kCases) {
    double d = 0;
    EXPECT_EQ(complaints(std::string(c.text) + "\nsource = 's'",
                         [&](TableReader& reader) {
                           EXPECT_TRUE(reader.quantity("d_*", kLength, between(-1, 1), d));
                         }),
              Lines{});
    EXPECT_DOUBLE_EQ(d, c.metres) << c.text;
  }
  double v = 0;
  EXPECT_EQ(complaints("v_deg_s_max = 180\nsource = 's'",
                       [&](TableReader& reader) {
                         reader.quantity("v_*_max", kAngleRate, above_zero_to(10), v);
                       }),
            Lines{});
  EXPECT_DOUBLE_EQ(v, kPi);
  double steps = 0;
  EXPECT_EQ(complaints("steps_per_turn = -10000\nsource = 's'",
                       [&](TableReader& reader) {
                         reader.quantity("steps_per_*", kPerAngle, between(-1e6, 1e6), steps);
                       }),
            Lines{});
  EXPECT_DOUBLE_EQ(steps * 2 * kPi, -10000);
}

TEST(TableReader, bounds_of_a_range_belong_to_it_and_excluded_zero_does_not) {
  const auto read = [](const char* text, const Range& range) {
    return complaints(std::string(text) + "\nsource = 's'", [&](TableReader& reader) {
      double a = 0;
      reader.quantity("a_*", kAngle, range, a);
    });
  };
  const Range closed = between(from_deg(-90), from_deg(90));
  EXPECT_EQ(read("a_deg = 90", closed), Lines{});
  EXPECT_EQ(read("a_deg = -90.0", closed), Lines{});
  EXPECT_EQ(read("a_deg = 90.01", closed),
            Lines{"f:1:9: t.a_deg: must be -90 to 90 deg, not 90.01"});
  EXPECT_EQ(read("a_rad = -2", closed),
            Lines{"f:1:9: t.a_rad: must be -1.5708 to 1.5708 rad, not -2"});
  EXPECT_EQ(read("a_deg = 0", above_zero_to(kPi)),
            Lines{"f:1:9: t.a_deg: must be above 0 and at most 180 deg, not 0"});
  EXPECT_EQ(read("a_deg = 1e-9", above_zero_to(kPi)), Lines{});
  EXPECT_EQ(read("a_deg = nan", closed), Lines{"f:1:9: t.a_deg: must be -90 to 90 deg, not nan"});
  EXPECT_EQ(read("a_deg = -inf", closed), Lines{"f:1:9: t.a_deg: must be -90 to 90 deg, not -inf"});
  EXPECT_EQ(read("a_deg = '90'", closed), Lines{"f:1:9: t.a_deg: must be a number, not a string"});
}

TEST(TableReader, key_without_its_unit_is_told_the_units) {
  const auto read = [](TableReader& reader) {
    double x = 0;
    reader.quantity("d_*", kLength, between(-1, 1), x);
    reader.quantity("velocity_*_max", kAngleRate, above_zero_to(1), x);
  };
  EXPECT_EQ(complaints("d = 95\nvelocity_max = 3\nsource = 's'", read),
            (Lines{"f:1:1: t.d: missing unit: write `d_mm`, `d_m` or `d_in`",
                   "f:2:1: t.velocity_max: missing unit: write `velocity_deg_s_max` or "
                   "`velocity_rad_s_max`"}));
  EXPECT_EQ(complaints("d_mm = 95\nsource = 's'", read),
            Lines{"f:1:1: t.velocity_max: missing: write `velocity_deg_s_max` or "
                  "`velocity_rad_s_max`"});
}

TEST(TableReader, one_quantity_in_two_units_is_refused_at_the_second) {
  const auto read = [](TableReader& reader) {
    double x = 0;
    reader.quantity("d_*", kLength, between(-1, 1), x);
  };
  EXPECT_EQ(complaints("d_in = 1\nd_mm = 25.4\nsource = 's'", read),
            Lines{"f:2:1: t.d_mm: the same quantity stands in `d_in` already; keep one"});
  EXPECT_EQ(complaints("d_m = 0.5\nd_mm = 25.4\nd_in=1\nsource = 's'", read),
            (Lines{"f:2:1: t.d_mm: the same quantity stands in `d_m` already; keep one",
                   "f:3:1: t.d_in: the same quantity stands in `d_m` already; keep one"}));
}

TEST(TableReader, misspelt_key_gets_a_proposal_and_no_second_complaint_as_missing) {
  const auto read = [](TableReader& reader) {
    double x = 0;
    reader.quantity("upper_*", kAngle, between(-1, 1), x);
  };
  EXPECT_EQ(complaints("  uper_deg = 1\nsource = 's'", read),
            Lines{"f:1:3: t.uper_deg: unknown key; did you mean `upper_deg`?"});
  EXPECT_EQ(complaints("upper_deg = 1\ncolour = 1\nsource = 's'", read),
            Lines{"f:2:1: t.colour: unknown key; known here are `source`, `upper_deg` or "
                  "`upper_rad`"});
  EXPECT_EQ(complaints("upper_deg = 1\nsuorce = 's'", read),
            Lines{"f:2:1: t.suorce: unknown key; did you mean `source`?"});
}

TEST(TableReader, keys_that_are_no_names_are_shown_safely) {
  EXPECT_EQ(complaints("\"a\\nb\" = 1", [](TableReader&) {}),
            Lines{"f:1:1: t.a\\x0ab: unknown key; known here are `source`"});
}

TEST(TableReader, whole_numbers_are_whole_and_in_range) {
  const auto read = [](TableReader& reader) {
    std::uint32_t baud = 0;
    const bool was_read = reader.integer("baud", 300, 4000000, baud);
    EXPECT_EQ(baud, was_read ? 9600U : 0U);
  };
  EXPECT_EQ(complaints("baud = 9600\nsource = 's'", read), Lines{});
  EXPECT_EQ(complaints("baud = 9600.0\nsource = 's'", read),
            Lines{"f:1:8: t.baud: must be a whole number, not a real number"});
  EXPECT_EQ(complaints("baud = -1\nsource = 's'", read),
            Lines{"f:1:8: t.baud: must be 300 to 4000000, not -1"});
  EXPECT_EQ(complaints("source = 's'", read), Lines{"f:1:1: t.baud: missing: write `baud`"});
}

TEST(TableReader, vectors_have_three_numbers_and_complain_at_the_wrong_one) {
  Vec3 p;
  const auto read = [&](TableReader& reader) {
    reader.vector("xyz_*", kLength, between(-10, 10), p);
  };
  EXPECT_EQ(complaints("xyz_mm = [1, 2.5, -3]\nsource = 's'", read), Lines{});
  EXPECT_DOUBLE_EQ(p.x, 0.001);
  EXPECT_DOUBLE_EQ(p.y, 0.0025);
  EXPECT_DOUBLE_EQ(p.z, -0.003);
  EXPECT_EQ(complaints("xyz_mm = [1, 2]\nsource = 's'", read),
            Lines{"f:1:10: t.xyz_mm: must have three numbers, not 2"});
  EXPECT_EQ(complaints("xyz_mm = [1, nan, 'x']\nsource = 's'", read),
            (Lines{"f:1:14: t.xyz_mm[2]: must be -10000 to 10000 mm, not nan",
                   "f:1:19: t.xyz_mm[3]: must be a number, not a string"}));
  EXPECT_EQ(complaints("xyz_mm = 1\nsource = 's'", read),
            Lines{"f:1:10: t.xyz_mm: must be a list of three numbers, not a whole number"});
}

TEST(TableReader, directions_are_normalised_and_zero_has_none) {
  Vec3 axis;
  const auto read = [&](TableReader& reader) { reader.direction("axis", axis); };
  EXPECT_EQ(complaints("axis = [3, 0, -4]\nsource = 's'", read), Lines{});
  EXPECT_DOUBLE_EQ(axis.x, 0.6);
  EXPECT_DOUBLE_EQ(axis.z, -0.8);
  EXPECT_EQ(complaints("axis = [0, 0, 0.0]\nsource = 's'", read),
            Lines{"f:1:8: t.axis: must point somewhere: its length is below 0.001"});
}

TEST(TableReader, words_come_from_their_list) {
  constexpr Named<int> kWords[] = {{"stream", 1}, {"point_to_point", 2}};
  int word = 0;
  const auto read = [&](TableReader& reader) { reader.choice("motion", kWords, word); };
  EXPECT_EQ(complaints("motion = 'point_to_point'", read), Lines{});
  EXPECT_EQ(word, 2);
  EXPECT_EQ(complaints("motion = 'steam'", read),
            Lines{"f:1:10: t.motion: must be `stream` or `point_to_point`, not `steam`; did you "
                  "mean `stream`?"});
  EXPECT_EQ(complaints("motion = 3", read),
            Lines{"f:1:10: t.motion: must be a string, not a whole number"});
}

TEST(TableReader, text_is_neither_blank_nor_long_nor_full_of_control_characters) {
  const auto read = [](TableReader& reader) {
    std::string title;
    reader.text("title", 10, title);
  };
  const std::string sentence =
      "f:1:9: t.title: must be 1 to 10 bytes of text, not blank, without control characters";
  EXPECT_EQ(complaints("title = 'ten bytes.'", read), Lines{});
  EXPECT_EQ(complaints("title = ''", read), Lines{sentence});
  EXPECT_EQ(complaints("title = '  '", read), Lines{sentence});
  EXPECT_EQ(complaints("title = 'eleven byte'", read), Lines{sentence});
  EXPECT_EQ(complaints("title = \"a\\u0000b\"", read), Lines{sentence});
  EXPECT_EQ(complaints("title = \"a\\u001bb\"", read), Lines{sentence});
}

TEST(TableReader, numbers_need_a_source_and_words_do_not) {
  const auto read = [](TableReader& reader) {
    double x = 0;
    reader.quantity("d_*", kLength, between(-1, 1), x);
    reader.quantity("a_*", kLength, between(-1, 1), x);
  };
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2", read),
            Lines{"f:1:1: t.source: missing: write where these numbers come from, or \"assumed\""});
  const std::string blank =
      "f:3:10: t.source: must be a string that says where these numbers come from, or a table "
      "with one string per key";
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = ''", read), Lines{blank});
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = 7", read), Lines{blank});
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = {d_mm = 'x'}", read),
            Lines{"f:3:10: t.source: says nothing of `a_mm`; name it or add `rest`"});
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = {d_mm = 'x', a_m = 'y', rest = 'z'}", read),
            Lines{"f:3:23: t.source.a_m: no such number in this table; did you mean `a_mm`?"});
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = {d_mm = ' ', rest = 'z'}", read),
            Lines{"f:3:18: t.source.d_mm: must be a string that says where the number comes from"});
  EXPECT_EQ(complaints("d_mm = 1\na_mm = 2\nsource = {d_mm = 'x', rest = 'z'}", read), Lines{});
  EXPECT_EQ(complaints("name = 'x'",
                       [](TableReader& reader) {
                         std::string name;
                         reader.text("name", 10, name);
                       }),
            Lines{});
}

TEST(TableReader, tables_are_tables_and_optional_ones_may_be_left_out) {
  const auto read = [](TableReader& reader) {
    if (auto tool = reader.table("tool")) tool->finish();
    if (auto gripper = reader.table("gripper", Presence::kOptional)) gripper->finish();
    for (TableReader& row : reader.tables("dh")) row.finish();
  };
  EXPECT_EQ(complaints("tool = {}\n[[dh]]\n[[dh]]\n", read), Lines{});
  EXPECT_EQ(complaints("tool = 1\ngripper = 2\ndh = 3\n", read),
            (Lines{"f:1:8: t.tool: must be a table, not a whole number",
                   "f:2:11: t.gripper: must be a table, not a whole number",
                   "f:3:6: t.dh: must be a list of tables, each under [[t.dh]], not a whole "
                   "number"}));
  EXPECT_EQ(complaints("tool = {x = 1}\ndh = [{}, 4]\n", read),
            (Lines{"f:1:9: t.tool.x: unknown key; known here are `source`",
                   "f:2:11: t.dh[2]: must be a table, not a whole number"}));
}

TEST(Findings, complaints_stop_at_their_bound) {
  Findings findings("f");
  for (int i = 0; i < 1000; ++i) findings.complain({1000 - i, 1}, "k", "m");
  const std::vector<Complaint> all = findings.take_complaints();
  ASSERT_EQ(all.size(), Findings::kMaxComplaints);
  EXPECT_TRUE(std::ranges::is_sorted(all, {}, &Complaint::line));
  EXPECT_EQ(all.front().message, "too many complaints; mend these first");
}

}  // namespace
}  // namespace sinew
