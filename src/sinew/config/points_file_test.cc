#include "sinew/config/points_file.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew {
namespace {

std::vector<std::string> complaints(std::string_view text) {
  const auto points = read_points(text, "points.toml");
  std::vector<std::string> lines;
  if (points) return lines;
  for (const Complaint& complaint : points.error()) lines.push_back(to_text(complaint));
  return lines;
}

TEST(PointsFile, joints_legs_and_places_of_the_tool_are_read) {
  const auto points = read_points(
      "[points.home_side]\n"
      "robot = \"learm\"\n"
      "joints_deg = [20, 20.5, 40, 40, 0]\n"
      "source = \"by hand\"\n"
      "taught_at = \"2026-11-21T10:00:00Z\"\n"
      "[points.up]\nrobot = \"hexapod\"\nlegs_mm = [250, 250, 250, 250, 250, 251.5]\n"
      "[points.bin]\nrobot = \"learm\"\nx_mm = 200\ny_mm = -30\nz_mm = 80.25\n"
      "[points.turned]\nrobot = \"puma560\"\nx_mm = 1\ny_mm = 2\nz_mm = 3\n"
      "rx_deg = 180\nry_deg = 0\nrz_deg = 90\n"
      "[points.tilted]\nrobot = \"learm\"\nx_mm = 1\ny_mm = 2\nz_mm = 3\n"
      "pitch_deg = 170\nroll_deg = 5\n",
      "points.toml");
  ASSERT_TRUE(points) << to_text(points.error().front());
  ASSERT_EQ(points->size(), 5U);
  const auto& q = std::get<JointVector>((*points)[0].place);
  ASSERT_EQ(q.size(), 5U);
  EXPECT_DOUBLE_EQ(q[1], from_deg(20.5));
  EXPECT_EQ((*points)[0].source, "by hand");
  EXPECT_EQ((*points)[0].taught_at, "2026-11-21T10:00:00Z");
  EXPECT_EQ((*points)[1].lengths, 0b111111);
  EXPECT_DOUBLE_EQ(std::get<JointVector>((*points)[1].place)[5], 0.2515);
  const auto& bin = std::get<ToolPlace>((*points)[2].place);
  EXPECT_DOUBLE_EQ(bin.p_BT.z, 0.08025);
  EXPECT_FALSE(bin.R_BT || bin.pitch || bin.roll);
  EXPECT_NEAR(std::get<ToolPlace>((*points)[3].place).R_BT->x.y, 1, 1e-12);
  EXPECT_DOUBLE_EQ(*std::get<ToolPlace>((*points)[4].place).pitch, from_deg(170));
}

TEST(PointsFile, joints_of_both_kinds_have_a_unit_each) {
  const auto points = read_points(
      "[points.up]\nrobot = \"scara\"\njoints = [\"-90deg\", \"80.5mm\", \"0deg\"]\n", "p");
  ASSERT_TRUE(points) << to_text(points.error().front());
  EXPECT_EQ((*points)[0].lengths, 0b010);
  const auto& q = std::get<JointVector>((*points)[0].place);
  EXPECT_DOUBLE_EQ(q[0], from_deg(-90));
  EXPECT_DOUBLE_EQ(q[1], 0.0805);
  for (const char* joints : {"[\"90\"]", "[90]", "[\"90 degrees\"]", "[\"mm\"]", "[\"1e9mm\"]",
                             "[]", "[\"721deg\"]", "\"9deg\"", "[\"nandeg\"]"}) {
    EXPECT_EQ(complaints(std::string("[points.a]\nrobot=\"r\"\njoints = ") + joints + "\n").size(),
              1U)
        << joints;
  }
  EXPECT_EQ(complaints("[points.a]\nrobot=\"r\"\njoints = [\"1deg\"]\njoints_deg = [1]\n"),
            std::vector<std::string>{"points.toml:3:1: points.a.joints: joints_deg says that"});
}

TEST(PointsFile, every_fault_is_told_at_its_place) {
  const struct {
    const char* text;
    std::vector<std::string> lines;
  } kCases[] = {
      {"[point.a]\n", {"points.toml:1:2: point: a file of points has nothing but [points.NAME]"}},
      {"points = 3\n",
       {"points.toml:1:10: points: must be a table: write each point below its [points.NAME]"}},
      {"[points.\"a b\"]\nrobot=\"r\"\n",
       {"points.toml:1:9: points.a b: a name is a letter and then letters, digits, - and _, 40 at "
        "most"}},
      {"[points.a]\njoints_deg = [1]\n",
       {"points.toml:1:9: points.a.robot: is missing: which robot's point is it? as in robot = "
        "\"learm\""}},
      {"[points.a]\nrobot = \"r\"\n",
       {"points.toml:1:9: points.a: has no place: joints_deg, legs_mm, joints, or x_mm, y_mm and "
        "z_mm"}},
      {"[points.a]\nrobot = \"r\"\njoint_deg = [1]\n",
       {"points.toml:3:1: points.a.joint_deg: no point has this key; did you mean joints_deg?"}},
      {"[points.a]\nrobot = \"r\"\nx_mm = 1\ny_mm = 2\n",
       {"points.toml:4:1: points.a.y_mm: needs z_mm beside it"}},
      {"[points.a]\nrobot = \"r\"\nx_mm = 1\ny_mm = 2\nz_mm = nan\n",
       {"points.toml:5:8: points.a.z_mm: must be -100000 to 100000, not nan"}},
      {"[points.a]\nrobot = \"r\"\njoints_deg = [1, \"2\"]\n",
       {"points.toml:3:18: points.a.joints_deg: must be a number, not a string"}},
      {"[points.a]\nrobot = \"r\"\njoints_deg = [1, 1e9]\n",
       {"points.toml:3:18: points.a.joints_deg: must be -720 to 720, not 1e+09"}},
      {"[points.a]\nrobot = \"r\"\njoints_deg = [1,2,3,4,5,6,7,8,9]\n",
       {"points.toml:3:14: points.a.joints_deg: must be a list of 1 to 8 numbers"}},
      {"[points.a]\nrobot = \"r\"\njoints_deg = [1]\nz_mm = 2\n",
       {"points.toml:4:1: points.a.z_mm: joints_deg names the place already: a point is joints or "
        "the tool's, not both"}},
      {"[points.a]\nrobot = \"r\"\nx_mm = 1\ny_mm = 2\nz_mm = 3\nrx_deg = 1\nry_deg = 1\n"
       "rz_deg = 1\npitch_deg = 1\nroll_deg = 1\n",
       {"points.toml:9:1: points.a.pitch_deg: rx_deg, ry_deg and rz_deg say the orientation "
        "already"}},
  };
  for (const auto& c : kCases) EXPECT_EQ(complaints(c.text), c.lines) << c.text;
  EXPECT_EQ(complaints("[points.a]\nrobot = 3\nx_mm = true\nlegs_mm = 4\n").size(), 2U)
      << "all at once";
}

TEST(PointsFile, a_fault_in_one_point_leaves_the_others_usable) {
  const TaughtPoints points = usable_points(
      "[points.bad]\nrobot = \"learm\"\nx_mm = 1\n[points.good]\nrobot = \"learm\"\n"
      "joints_deg = [1, 2, 3, 4, 5]\n",
      "points.toml");
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].name, "bad");
  EXPECT_NE(points[0].wrong.find("points.toml:3"), std::string::npos) << points[0].wrong;
  EXPECT_NE(points[0].wrong.find("y_mm"), std::string::npos) << points[0].wrong;
  EXPECT_EQ(points[1].name, "good");
  EXPECT_EQ(points[1].wrong, "");
  const TaughtPoints none = usable_points("[points.bad\n", "points.toml");
  ASSERT_EQ(none.size(), 1U);
  EXPECT_EQ(none[0].name, "");
  EXPECT_NE(none[0].wrong, "");
}

TEST(PointsFile, a_point_is_added_or_replaced_and_the_rest_stays_as_it_was) {
  const std::string text =
      "# all of them by Ann\n\n[points.a] # the first\nrobot = \"learm\"\n"
      "joints_deg = [0, 20, 40, 40, 0]\n\n# not nearer than this\n[points.b]\n"
      "robot = \"learm\"\nx_mm = 200\ny_mm = 0\nz_mm = 150\n";
  TaughtPoint point{.name = "a",
                    .robot = "learm",
                    .place = JointVector{},
                    .lengths = 0,
                    .source = "taught",
                    .taught_at = ""};
  for (int i = 0; i < 5; ++i) std::get<JointVector>(point.place).push_back(from_deg(10.0 * i));
  const auto replaced = with_point(text, "p.toml", point);
  ASSERT_TRUE(replaced);
  EXPECT_EQ(*replaced,
            "# all of them by Ann\n\n[points.a]\nrobot = \"learm\"\n"
            "joints_deg = [0, 10, 20, 30, 40]\nsource = \"taught\"\n\n"
            "# not nearer than this\n[points.b]\n"
            "robot = \"learm\"\nx_mm = 200\ny_mm = 0\nz_mm = 150\n");
  point.name = "c";
  const auto added = with_point(*replaced, "p.toml", point);
  ASSERT_TRUE(added);
  EXPECT_TRUE(added->starts_with(*replaced));
  const auto points = read_points(*added, "p.toml");
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 3U);
  EXPECT_EQ((*points)[2].name, "c");
  EXPECT_EQ(with_point("", "p.toml", point), points_text({point}));
  EXPECT_FALSE(with_point("[points.x]\nrobot = 3\n", "p.toml", point)) << "never over a wrong file";
  point.name = "d";
  const auto inline_table =
      with_point("points.d = {robot = \"maxarm\", joints_deg = [0, 0, 0]}\n", "p.toml", point);
  ASSERT_FALSE(inline_table);
  EXPECT_NE(inline_table.error()[0].message.find("by hand"), std::string::npos);
}

TEST(PointsFile, a_point_is_removed_or_renamed_and_the_rest_stays_as_it_was) {
  const std::string text =
      "# of the kitchen\n[points.a]\nrobot = \"learm\"\njoints_deg = [1]\n\n# b is low\n"
      "[points.b]  # really\nrobot = \"learm\"\njoints_deg = [2]\n";
  EXPECT_EQ(without_point(text, "p", "a"),
            "# of the kitchen\n# b is low\n[points.b]  # really\nrobot = \"learm\"\n"
            "joints_deg = [2]\n");
  EXPECT_EQ(without_point(text, "p", "b"),
            "# of the kitchen\n[points.a]\nrobot = \"learm\"\njoints_deg = [1]\n\n# b is low\n");
  EXPECT_EQ(with_point_renamed(text, "p", "b", "c-2"),
            "# of the kitchen\n[points.a]\nrobot = \"learm\"\njoints_deg = [1]\n\n# b is low\n"
            "[points.c-2]  # really\nrobot = \"learm\"\njoints_deg = [2]\n");
  EXPECT_EQ(without_point(text, "p", "c").error()[0].message, "there is no point 'c'");
  EXPECT_EQ(with_point_renamed(text, "p", "c", "d").error()[0].message, "there is no point 'c'");
  EXPECT_EQ(with_point_renamed(text, "p", "a", "b").error()[0].message,
            "there is a point 'b' already");
  EXPECT_FALSE(without_point("[points", "p", "a"));
}

TEST(PointsFile, what_is_written_is_read_again) {
  test::for_random_cases(2'000, [](test::Random& random) {
    TaughtPoints points;
    for (auto count = random.integer(0, 5); count > 0; --count) {
      TaughtPoint point;
      point.name = "p" + std::to_string(points.size());
      point.robot = random.chance(0.5) ? "learm" : "odd \"name\" \\";
      if (random.chance(0.5)) point.source = "taught \\ \"here\" \xC3\xA4";
      if (random.chance(0.5)) point.taught_at = "now";
      if (random.chance(0.5)) {
        JointVector q;
        for (auto joints = random.integer(1, 8); joints > 0; --joints) {
          q.push_back(random.uniform(-6, 6));
        }
        const unsigned all = (1U << q.size()) - 1;
        const unsigned some =
            random.chance(0.3) ? all : static_cast<unsigned>(random.integer(0, 255));
        if (random.chance(0.7)) point.lengths = static_cast<std::uint8_t>(some & all);
        point.place = q;
      } else {
        const auto any = [&] { return random.uniform(-3, 3); };
        ToolPlace place{{any(), any(), any()}, {}, {}, {}};
        if (random.chance(0.3)) place.R_BT = rotation_from_fixed_xyz({any(), any() / 2, any()});
        if (!place.R_BT && random.chance(0.5)) {
          place.pitch = any();
          place.roll = any();
        }
        point.place = place;
      }
      points.push_back(point);
    }
    const std::string text = points_text(points);
    const auto again = read_points(text, "p");
    ASSERT_TRUE(again) << to_text(again.error().front()) << "\n" << text;
    ASSERT_EQ(again->size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const TaughtPoint& a = points[i];
      const TaughtPoint& b = (*again)[i];
      ASSERT_EQ(a.name, b.name);
      ASSERT_EQ(a.robot, b.robot);
      ASSERT_EQ(a.source, b.source);
      ASSERT_EQ(a.taught_at, b.taught_at);
      ASSERT_EQ(a.place.index(), b.place.index());
      if (const auto* q = std::get_if<JointVector>(&a.place)) {
        const auto& other = std::get<JointVector>(b.place);
        ASSERT_EQ(q->size(), other.size());
        ASSERT_EQ(a.lengths, b.lengths);
        for (std::size_t j = 0; j < q->size(); ++j) ASSERT_NEAR((*q)[j], other[j], 2e-11);
        continue;
      }
      const auto& x = std::get<ToolPlace>(a.place);
      const auto& y = std::get<ToolPlace>(b.place);
      ASSERT_NEAR(norm(x.p_BT - y.p_BT), 0, 1e-11);
      ASSERT_EQ(x.R_BT.has_value(), y.R_BT.has_value());
      if (x.R_BT) {
        ASSERT_NEAR(angle_between(*x.R_BT, *y.R_BT), 0, 1e-7);
      }
      ASSERT_EQ(x.pitch.has_value(), y.pitch.has_value());
      if (x.pitch) {
        ASSERT_NEAR(*x.pitch, *y.pitch, 1e-10);
      }
    }
    ASSERT_EQ(points_text(*again).size(), text.size());
  });
}

TEST(PointsFile, hostile_bytes_are_refused_or_read_and_never_more) {
  const char* const kParts[] = {"[points.a]\n",
                                "robot = \"r\"\n",
                                "joints_deg = [1,2]\n",
                                "x_mm = 1\n",
                                "y_mm = 1e308\n",
                                "z_mm = -0\n",
                                "[points]\n",
                                "a = {x_mm=1}\n",
                                "[[points.b]]\n",
                                "legs_mm=[[1]]\n",
                                "\"\"=1\n",
                                "taught_at = 2026-01-01\n",
                                "rx_deg=inf\n",
                                "\0",
                                "[points.a.b]\n",
                                "robot = \"\\u0007\"\n"};
  int refused = 0, read = 0;
  test::for_random_cases(5'000, [&](test::Random& random) {
    std::string text;
    for (auto i = random.integer(0, 9); i > 0; --i) {
      text += kParts[random.integer(0, std::ssize(kParts) - 1)];
      if (random.chance(0.05)) text += '\0';
    }
    const auto points = read_points(text, "p");
    ++(points ? read : refused);
    if (points) return random.discard();
    for (const Complaint& complaint : points.error()) {
      ASSERT_GE(complaint.line, 1);
      ASSERT_FALSE(complaint.message.empty());
    }
  });
  EXPECT_GT(refused, 1000);
  EXPECT_GT(read, 50);
}

}  // namespace
}  // namespace sinew
