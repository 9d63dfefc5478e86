#include "sinew/config/cell_file.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/config/builtin_robots.h"
#include "sinew/core/units.h"
#include "sinew/vision/color_names.h"
#include "support/property.h"

namespace sinew {
namespace {

std::string complaints_of(std::string_view text) {
  const auto cell = read_cell(text, "cell.toml");
  if (cell) return "no complaint";
  std::string all;
  for (const Complaint& complaint : cell.error()) all += to_text(complaint) + "\n";
  return all;
}

constexpr std::string_view kTwo = R"(
title = "Two"
[[robot]]
name = "left"
robot = "learm"
profile = "bus"
port = "/dev/ttyUSB0"
x_mm = -300
rz_deg = 90
[[robot]]
name = "right"
robot = "mine.toml"
settings = "found/right.json"
seed = 7
[[object]]
name = "box"
length_mm = 100
width_mm = 200
height_mm = 50
z_mm = 25
[[camera]]
name = "top"
device = "/dev/video0"
)";

TEST(CellFile, says_which_robots_stand_where_and_hang_on_what) {
  const auto cell = read_cell(kTwo, "cell.toml");
  ASSERT_TRUE(cell) << complaints_of(kTwo);
  ASSERT_EQ(cell->robots.size(), 2U);
  const CellRobot& left = cell->robots[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.port, "/dev/ttyUSB0");
  EXPECT_EQ(left.profile, "bus");
  EXPECT_DOUBLE_EQ(left.X_WB.p.x, -0.3);
  EXPECT_NEAR(left.X_WB.R.x.y, 1, 1e-15);
  const CellRobot& right = cell->robots[1];
  EXPECT_FALSE(right.port);
  EXPECT_EQ(right.seed, 7U);
  EXPECT_EQ(right.settings, "found/right.json");
  EXPECT_FALSE(left.settings);
  ASSERT_EQ(cell->objects.size(), 1U);
  EXPECT_DOUBLE_EQ(cell->objects[0].half.y, 0.1);
  EXPECT_DOUBLE_EQ(cell->objects[0].X_WX.p.z, 0.025);
  ASSERT_EQ(cell->cameras.size(), 1U);
  EXPECT_EQ(cell->cameras[0].device, "/dev/video0");
}

/// More about the camera may follow.
const std::string kOneCamera = R"(
title = "one"
[[robot]]
name = "arm"
robot = "learm"
[[camera]]
name = "top"
)";

TEST(CellFile, a_calibrated_camera_says_where_its_table_is) {
  const std::string camera = kOneCamera + R"(device = "table.jpg"
calibration = "camera.toml"
cube_mm = 30
x_mm = 180
rz_deg = 90
)";
  const auto cell = read_cell(camera, "cell.toml");
  ASSERT_TRUE(cell) << complaints_of(camera);
  const CellCamera& top = cell->cameras[0];
  EXPECT_EQ(top.calibration, "camera.toml");
  EXPECT_DOUBLE_EQ(top.cube, 0.03);
  EXPECT_DOUBLE_EQ(top.X_WT.p.x, 0.18);
  EXPECT_NEAR((top.X_WT.R * Vec3{1, 0, 0}).y, 1, 1e-12);
}

TEST(CellFile, a_camera_on_an_arm_names_its_file_and_its_robot) {
  const std::string camera = kOneCamera + R"(device = "table.jpg"
calibration = "camera.toml"
hand_eye = "hand_eye.toml"
robot = "arm"
)";
  const auto cell = read_cell(camera, "cell.toml");
  ASSERT_TRUE(cell) << complaints_of(camera);
  EXPECT_EQ(cell->cameras[0].hand_eye, "hand_eye.toml");
  EXPECT_EQ(cell->cameras[0].robot, "arm");
  const auto without = [&](const std::string& line) {
    std::string text = camera;
    text.erase(text.find(line), line.size());
    return complaints_of(text);
  };
  EXPECT_NE(without("hand_eye = \"hand_eye.toml\"\n").find("stand together"), std::string::npos);
  EXPECT_NE(without("calibration = \"camera.toml\"\n").find("needs calibration"),
            std::string::npos);
  std::string other = camera;
  other.replace(other.rfind("\"arm\""), 5, "\"leg\"");
  EXPECT_NE(complaints_of(other).find("robot is 'leg', and this cell has no robot of that name"),
            std::string::npos)
      << complaints_of(other);
}

TEST(CellFile, several_baskets_have_names_of_their_own) {
  std::string text = kOneCamera + "device = \"simulated\"\n";
  for (const char* name : {"red", "blue"}) {
    text += std::string("[[basket]]\nname = \"") + name +
            "\"\nlength_mm = 100\nwidth_mm = 100\nheight_mm = 40\n";
  }
  const auto cell = read_cell(text, "cell.toml");
  ASSERT_TRUE(cell) << complaints_of(text);
  ASSERT_EQ(cell->baskets.size(), 2U);
  EXPECT_EQ(cell->baskets[1].name, "blue");
  std::string twice(text);
  twice.replace(twice.find("\"blue\""), 6, "\"red\"");
  EXPECT_NE(complaints_of(twice).find("name"), std::string::npos) << complaints_of(twice);
  std::string many(text);
  for (int i = 0; i < 8; ++i) {
    many += "[[basket]]\nname = \"b" + std::to_string(i) +
            "\"\nlength_mm = 100\nwidth_mm = 100\nheight_mm = 40\n";
  }
  EXPECT_NE(complaints_of(many).find("at most 8 baskets"), std::string::npos);
}

TEST(CellFile, a_simulated_camera_has_cubes_and_a_basket) {
  const std::string text = kOneCamera + R"(device = "simulated"
[basket]
name = "tray"
length_mm = 120
width_mm = 100
height_mm = 40
y_mm = 200
rz_deg = 90
[[cube]]
color = "blue"
x_mm = 180
y_mm = -30
rz_deg = 20
)";
  const auto cell = read_cell(text, "cell.toml");
  ASSERT_TRUE(cell) << complaints_of(text);
  ASSERT_EQ(cell->baskets.size(), 1U);
  EXPECT_EQ(cell->baskets[0].size, (Vec3{0.12, 0.1, 0.04}));
  EXPECT_NEAR((cell->baskets[0].X_WK * Vec3{0.1, 0, 0}).y, 0.3, 1e-12);
  ASSERT_EQ(cell->cubes.size(), 1U);
  EXPECT_EQ(cell->cubes[0].color, static_cast<int>(vision::ColorName::kBlue));
  EXPECT_EQ(cell->cubes[0].p_W, (Vec3{0.18, -0.03, 0}));
  std::string real(text);
  real.replace(real.find("simulated"), 9, "table.jpg");
  EXPECT_NE(complaints_of(real).find("there is none"), std::string::npos) << complaints_of(real);
  std::string painted(text);
  painted.replace(painted.find("blue"), 4, "teal");
  EXPECT_NE(complaints_of(painted).find("has to be red, orange"), std::string::npos)
      << complaints_of(painted);
}

TEST(CellFile, the_cell_that_every_build_carries_has_all_robots_with_a_device) {
  const auto cell = read_cell(builtin_cell(), "cells/five.toml");
  ASSERT_TRUE(cell) << complaints_of(builtin_cell());
  EXPECT_EQ(cell->robots.size(), 5U);
  for (const CellRobot& robot : cell->robots) {
    EXPECT_FALSE(robot.port) << robot.name;
    const auto robots = builtin_robots();
    EXPECT_TRUE(std::ranges::any_of(robots, [&](const BuiltinRobot& one) {
      return one.id == robot.robot;
    })) << robot.robot;
  }
}

TEST(CellFile, complains_with_line_and_key) {
  struct Case {
    std::string_view text;
    std::string_view says;
  };
  constexpr Case kCases[] = {
      {"title = \"x\"\n", "cell.toml:1:1: robot: missing"},
      {"title = \"x\"\n[[robot]]\nname = \"A b\"\nrobot = \"learm\"\n",
       "robot[1].name: must be lower-case letters"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\n[[robot]]\nname = \"a\"\nrobot = "
       "\"r\"\n",
       "there is another one of this name"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\nprot = \"/dev/x\"\n",
       "did you mean `port`?"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\nx = 3\n", "missing unit"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\nx_mm = nan\n", "must be -100000"},
      {"title = \"x\"\ntime_scale = 10\n[[robot]]\nname = \"a\"\nrobot = \"r\"\nport = \"p\"\n",
       "a robot on a real port keeps real time"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\nport = \"p\"\ntime_scale = 2\n",
       "time_scale: a robot on a real port keeps real time"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\ntime_scale = 2000\n",
       "time_scale: must be"},
      {"title = \"x\"\ntime_scale = 0\n[[robot]]\nname = \"a\"\nrobot = \"r\"\n",
       "time_scale: must be"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\n[[object]]\nname = \"a\"\n"
       "length_mm = 1\nwidth_mm = 1\nheight_mm = 1\n",
       "there is another one of this name"},
      {"title = \"x\"\n[[robot]]\nname = \"a\"\nrobot = \"r\"\n[[object]]\nname = \"b\"\n"
       "length_mm = 0\nwidth_mm = 1\nheight_mm = 1\n",
       "length_mm: must be above 0"},
      {"title", "cell.toml:"},
  };
  for (const Case& one : kCases) {
    EXPECT_NE(complaints_of(one.text).find(one.says), std::string::npos) << one.says << "\n"
                                                                         << complaints_of(one.text);
  }
}

TEST(CellFile, joints_without_a_board_are_a_list_of_names) {
  const auto with = [](const std::string& without) {
    return "title = \"x\"\n[[robot]]\nname = \"arm\"\nrobot = \"robot-arm-2\"\nwithout = " +
           without + "\n";
  };
  const auto cell = read_cell(with("[\"J3\", \"flange_roll\"]"), "cell.toml");
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->robots[0].without, (std::vector<std::string>{"J3", "flange_roll"}));
  for (const char* wrong : {"\"J3\"", "[3]", "[]", "[\" \"]"}) {
    EXPECT_NE(complaints_of(with(wrong)).find("without"), std::string::npos) << wrong;
  }
}

TEST(CellFile, too_many_robots_are_told) {
  std::string text = "title = \"x\"\n";
  for (int k = 0; k < 17; ++k) {
    text += "[[robot]]\nname = \"r" + std::to_string(k) + "\"\nrobot = \"learm\"\n";
  }
  EXPECT_NE(complaints_of(text).find("at most 16 robots"), std::string::npos);
}

TEST(CellFile, whatever_its_bytes_are_it_is_read_or_complained_about) {
  test::for_random_cases(2000, [](test::Random& random) {
    std::string text(kTwo);
    const std::int64_t edits = random.integer(1, 6);
    for (std::int64_t k = 0; k < edits; ++k) {
      const auto at =
          static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(text.size()) - 1));
      if (random.chance(0.4)) {
        text.erase(at, static_cast<std::size_t>(random.integer(1, 20)));
      } else {
        text[at] = static_cast<char>(random.integer(0, 255));
      }
      if (text.empty()) text = " ";
    }
    const auto cell = read_cell(text, "cell.toml");
    if (cell) {
      EXPECT_FALSE(cell->robots.empty());
      EXPECT_LE(cell->robots.size(), kCellRobotsMax);
    } else {
      EXPECT_FALSE(cell.error().empty());
    }
  });
}

}  // namespace
}  // namespace sinew
