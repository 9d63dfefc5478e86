#include "sinew/runtime/cell_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

class CellSettingsTest : public testing::Test {
 protected:
  static RobotMaking making(const char* name, const char* robot) {
    RobotMaking one{test::robot(robot), {}, {}};
    one.place.name = name;
    one.place.robot = robot;
    return one;
  }
  CellSettings make(double time_scale = 1) {
    RobotMaking left = making("left", "learm");
    left.place.profile = "bus";
    left.found = {{"joint.base.trim_rad", "0.02"}};
    left.place.settings = "found.json";
    return CellSettings(folder_.at("settings/cell.json"), "/home/me/cell.toml", time_scale,
                        {left, making("six", "hexapod"), making("arm", "robot-arm-2")});
  }
  /// "port: sentence"
  static std::string wrong(const CellSettings& settings, std::size_t robot,
                           const RobotSettings& values) {
    const auto made = settings.make(robot, values);
    if (made) return "fine";
    std::string all;
    for (const auto& one : made.error()) all += one.name + ": " + one.sentence + "\n";
    return all;
  }
  static const LscDevice& lsc(const MadeRobot& made) {
    return made.model.device.settings.get<LscDevice>();
  }

  test::ScratchFolder folder_;
};

TEST_F(CellSettingsTest, a_device_belongs_to_one_robot_by_whatever_name) {
  CellSettings settings = make();
  ASSERT_TRUE(settings.load());
  ASSERT_TRUE(settings.save(0, {{"port", "/dev/null"}, {"profile", "bus"}}, 0));
  EXPECT_EQ(wrong(settings, 1, {{"port", "/dev/null"}}), "port: left has this port already\n");
  EXPECT_EQ(wrong(settings, 1, {{"port", "/dev/./null"}}), "port: left has this port already\n");
  EXPECT_EQ(wrong(settings, 1, {{"port", "/dev/zero"}}), "fine");
  EXPECT_EQ(wrong(settings, 0, {{"port", "/dev/null"}, {"profile", "bus"}}), "fine") << "its own";
  EXPECT_EQ(wrong(settings, 1, {{"port", "simulated"}}), "fine");
}

TEST_F(CellSettingsTest, going_back_to_the_cells_own_port_takes_it_from_nobody) {
  RobotMaking left = making("left", "learm");
  left.place.profile = "bus";
  left.place.port = "/dev/null";
  CellSettings settings(folder_.at("settings/cell.json"), "/home/me/cell.toml", 1,
                        {left, making("six", "hexapod")});
  ASSERT_TRUE(settings.load());
  ASSERT_TRUE(settings.save(0, {{"port", "/dev/zero"}, {"profile", "bus"}}, 0));
  ASSERT_TRUE(settings.save(1, {{"port", "/dev/null"}}, settings.revision()));
  EXPECT_EQ(wrong(settings, 0, settings.own(0)), "port: six has this port already\n");
}

TEST_F(CellSettingsTest, where_nothing_is_set_the_cell_is_what_its_file_says) {
  CellSettings settings = make();
  ASSERT_TRUE(settings.load());
  EXPECT_FALSE(settings.is_set(0));
  EXPECT_EQ(
      settings.own(0),
      (RobotSettings{{"port", "simulated"}, {"profile", "bus"}, {"joint.base.trim_rad", "0.02"}}));
  EXPECT_EQ(settings.now(0), settings.own(0));
  const auto made = settings.make(0);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->place.settings, "found.json");
  EXPECT_NEAR(lsc(*made).servos[0].trim / lsc(*made).servos[0].units_per_rad, 0.02, 1e-9);
}

TEST_F(CellSettingsTest, what_is_set_is_there_at_the_next_start_and_gone_when_taken_back) {
  CellSettings settings = make();
  const RobotSettings values{{"port", "/dev/ttyUSB0"},
                             {"profile", "lsc6"},
                             {"joint.base.turn", "other"},
                             {"joint.elbow.trim_rad", "-0.1"}};
  ASSERT_TRUE(settings.make(0, values));
  ASSERT_TRUE(settings.save(0, values, 0));

  CellSettings next = make();
  ASSERT_TRUE(next.load());
  EXPECT_TRUE(next.is_set(0));
  EXPECT_FALSE(next.is_set(1));
  EXPECT_EQ(next.revision(), settings.revision());
  EXPECT_EQ(next.now(0), values);
  const auto made = next.make(0);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->place.port, "/dev/ttyUSB0");
  EXPECT_EQ(made->place.settings, folder_.at("settings/cell.json"));
  const auto file = test::robot("learm");
  const auto& was = file.device.settings.get<LscDevice>().servos[0];
  EXPECT_DOUBLE_EQ(lsc(*made).servos[0].units_per_rad, -was.units_per_rad);
  // What the cell's own settings file had found of the base does not count beside it.
  EXPECT_DOUBLE_EQ(lsc(*made).servos[0].trim, -was.trim);

  ASSERT_TRUE(next.save(0, {}, next.revision()));
  CellSettings last = make();
  ASSERT_TRUE(last.load());
  EXPECT_EQ(last.now(0), last.own(0));
}

TEST_F(CellSettingsTest, two_who_save_at_once_do_not_overwrite_each_other) {
  CellSettings one = make();
  CellSettings other = make();
  ASSERT_TRUE(one.save(0, {{"profile", "lsc6"}}, 0));
  const auto late = other.save(0, {{"profile", "esp32"}}, 0);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ShelfRefusal::Code::kConflict);
  ASSERT_TRUE(other.load());
  EXPECT_EQ(other.now(0).at("profile"), "lsc6");
}

TEST_F(CellSettingsTest, every_fault_is_told_at_its_place) {
  const CellSettings settings = make();
  EXPECT_EQ(wrong(settings, 0, {{"profile", "nonsense"}}),
            "profile: 'nonsense' is none of lsc6, bus, esp32\n");
  EXPECT_EQ(wrong(settings, 2, {{"wire", "nonsense"}}),
            "wire: 'nonsense' is none of registers, link\n");
  const std::string port =
      "port: a port is 'simulated', a device as /dev/ttyUSB0, tcp:HOST:PORT, spidev, or "
      "simwire:unix:PATH or simwire:tcp:HOST:PORT\n";
  for (const char* bad : {"/etc/passwd", "/dev/../etc/passwd", "ttyUSB0", "-", "../x"}) {
    EXPECT_EQ(wrong(settings, 0, {{"port", bad}}), port) << bad;
  }
  EXPECT_NE(wrong(settings, 0, {{"port", ""}}), "fine");
  EXPECT_NE(wrong(settings, 0, {{"port", std::string("/dev/a\0b", 8)}}), "fine");
  EXPECT_NE(wrong(settings, 0, {{"port", "/dev/a\"\n[[robot]]"}}), "fine");
  EXPECT_NE(wrong(settings, 0, {{"port", std::string(2000, 'a')}}), "fine");
  EXPECT_NE(wrong(settings, 0, {{"port", "spidev"}}).find("hangs on a serial port"),
            std::string::npos);
  EXPECT_NE(wrong(settings, 2, {{"port", "/dev/ttyUSB0"}}).find("hangs on SPI"), std::string::npos);
  EXPECT_EQ(wrong(settings, 0, {{"joint.base.trim_rad", "1"}, {"joint.elbow.trim_rad", "two"}}),
            "joint.base.trim_rad: a trim is a number from -15 to 15 degrees\n"
            "joint.elbow.trim_rad: a trim is a number from -15 to 15 degrees\n");
  EXPECT_EQ(wrong(settings, 0, {{"joint.base.turn", "left"}}),
            "joint.base.turn: the sense of rotation is 'other', or not set\n");
  EXPECT_EQ(wrong(settings, 0, {{"joint.base.servo_id", "0"}}),
            "joint.base.servo_id: a servo's number is 1 to 253\n");
  EXPECT_NE(wrong(settings, 0, {{"joint.nose.turn", "other"}}), "fine");
  EXPECT_NE(wrong(settings, 1, {{"joint.leg1.trim_rad", "0.1"}}), "fine");
  // A cell whose time runs faster has no real robot.
  EXPECT_EQ(wrong(make(10), 0, {{"port", "/dev/ttyUSB0"}}),
            "port: a robot on a real port keeps real time\n");
}

TEST_F(CellSettingsTest, servos_may_change_their_numbers_with_each_other_and_not_share_one) {
  const CellSettings settings = make();
  const auto file = test::robot("learm");
  const auto& servos = file.device.settings.get<LscDevice>().servos;
  const std::string base = std::to_string(servos[0].id);
  const std::string shoulder = std::to_string(servos[1].id);
  EXPECT_EQ(
      wrong(settings, 0, {{"joint.base.servo_id", shoulder}, {"joint.shoulder.servo_id", base}}),
      "fine");
  const std::string shared = wrong(settings, 0, {{"joint.base.servo_id", shoulder}});
  EXPECT_NE(shared.find("would be"), std::string::npos) << shared;
}

TEST_F(CellSettingsTest, says_what_can_be_set) {
  const CellSettings settings = make();
  const auto has = [](const std::vector<std::string>& all, const char* name) {
    return std::ranges::find(all, name) != all.end();
  };
  EXPECT_TRUE(has(settings.settable(0), "joint.base.trim_rad"));
  EXPECT_TRUE(has(settings.settable(1), "joint.leg1.turn"));
  EXPECT_TRUE(has(settings.settable(1), "way_factor"));
  EXPECT_FALSE(has(settings.settable(1), "joint.leg1.trim_rad"));
  EXPECT_TRUE(settings.settable(2).empty());
  EXPECT_EQ(settings.wires(2), (std::vector<std::string>{"registers", "link"}));
  EXPECT_TRUE(settings.profiles(2, {{"wire", "link"}}).empty());
  EXPECT_FALSE(settings.profiles(2, {}).empty());
}

TEST_F(CellSettingsTest, a_file_that_is_not_this_cells_is_refused_and_stays) {
  const auto refusal = [&](const std::string& text) {
    std::filesystem::create_directories(folder_.at("settings"));
    folder_.file("settings/cell.json", text);
    CellSettings settings = make();
    const auto loaded = settings.load();
    EXPECT_FALSE(settings.is_set(0));
    EXPECT_EQ(test::text_of(folder_.at("settings/cell.json")), text);
    return loaded ? "fine" : loaded.error();
  };
  const auto file = [](const char* cell, const char* robot, nlohmann::json settings) {
    return nlohmann::json{{"version", 1},
                          {"cell", cell},
                          {"robots", {{"left", {{"robot", robot}, {"settings", settings}}}}}}
        .dump();
  };
  EXPECT_NE(refusal("{"), "fine");
  EXPECT_NE(refusal("[]"), "fine");
  EXPECT_NE(refusal("{\"version\": 2, \"robots\": {}}"), "fine");
  EXPECT_NE(refusal(file("/other.toml", "learm", {})).find("another cell's"), std::string::npos);
  EXPECT_NE(
      refusal(file("/home/me/cell.toml", "maxarm", nlohmann::json::object())).find("another robot"),
      std::string::npos);
  EXPECT_NE(refusal(file("/home/me/cell.toml", "learm", {{"port", 3}})).find("is no text"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew::runtime
