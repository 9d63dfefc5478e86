#include "sinew/devices/grbl/grbl_device.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace sinew::grbl {
namespace {

using namespace std::chrono_literals;

/// Two axes, 100 steps per unit.
BoardSettings two_axes() {
  BoardSettings settings;
  for (int i = 0; i < 2; ++i) settings.axes.push_back({100, {90, 400}, 180, true, 5});
  return settings;
}

class GrblBoard : public ::testing::Test {
 protected:
  void begin(const BoardSettings& settings) {
    board.emplace(settings, now);
    run(1s);
    heard = take();
  }
  void run(Duration duration) {
    now += duration;
    board->advance(now);
  }
  void say(std::string_view text) {
    for (const char c : text) board->receive(static_cast<std::uint8_t>(c), now);
  }
  /// Lines that have come since.
  std::vector<std::string> take() {
    std::array<std::uint8_t, 4096> bytes{};
    const std::size_t count = board->take_output(bytes);
    std::vector<std::string> lines{""};
    for (std::size_t i = 0; i < count; ++i) {
      if (bytes[i] == '\n') {
        lines.emplace_back();
      } else if (bytes[i] != '\r') {
        lines.back() += static_cast<char>(bytes[i]);
      }
    }
    std::erase(lines, "");
    return lines;
  }
  std::string answer(std::string_view text) {
    say(text);
    const auto lines = take();
    if (lines.empty()) return "";
    // Of a status without the offset, which some have.
    const std::size_t offset = lines.front().find("|WCO:");
    return offset == std::string::npos ? lines.front() : lines.front().substr(0, offset) + ">";
  }

  Instant now{};
  std::optional<GrblDevice> board;
  std::vector<std::string> heard;
};

TEST_F(GrblBoard, greets_and_is_idle) {
  begin(two_axes());
  EXPECT_EQ(heard, std::vector<std::string>{"Grbl 1.1f ['$' for help]"});
  EXPECT_EQ(answer("?"), "<Idle|MPos:0.000,0.000>");
}

TEST_F(GrblBoard, ok_says_that_a_motion_was_taken_not_that_it_was_made) {
  begin(two_axes());
  EXPECT_EQ(answer("G53G93G1X10.000Y5.000F60.000\n"), "ok");
  EXPECT_EQ(answer("?").substr(0, 4), "<Run");
  run(2s);
  EXPECT_EQ(answer("?"), "<Idle|MPos:10.000,5.000>");
}

TEST_F(GrblBoard, ok_waits_for_room_in_the_planner_and_characters_for_theirs) {
  begin(two_axes());
  for (int i = 1; i <= 20; ++i) say("G53G93G1X" + std::to_string(i) + ".000Y0.000F60.000\n");
  // 15 motions, and a line that waits; of the rest 128 characters.
  EXPECT_EQ(take().size(), 15U);
  EXPECT_EQ(board->bytes_lost(), 0U);
  say(std::string(200, 'X'));
  EXPECT_GT(board->bytes_lost(), 0U);
  run(1500ms);
  EXPECT_EQ(take(), std::vector<std::string>{"ok"});
}

TEST_F(GrblBoard, a_reset_behind_a_hold_keeps_the_position) {
  begin(two_axes());
  say("G53G93G1X10.000Y5.000F60.000\n");
  run(500ms);
  say("!");
  run(10ms);
  take();
  EXPECT_EQ(answer("?").substr(0, 7), "<Hold:1");
  run(200ms);
  const std::string held = answer("?");
  EXPECT_EQ(held.substr(0, 7), "<Hold:0");
  // No line is read while it holds.
  EXPECT_EQ(answer("G21G90G94\n"), "");
  EXPECT_EQ(answer("\x18"), "Grbl 1.1f ['$' for help]");
  EXPECT_EQ(answer("?"), "<Idle" + held.substr(7));
}

TEST_F(GrblBoard, resumes_where_it_held) {
  begin(two_axes());
  say("G53G93G1X10.000Y5.000F60.000\n");
  run(500ms);
  say("!");
  run(300ms);
  say("~");
  run(1s);
  take();
  EXPECT_EQ(answer("?"), "<Idle|MPos:10.000,5.000>");
}

TEST_F(GrblBoard, a_probe_ends_where_its_input_closes_and_says_where_that_was) {
  begin(two_axes());
  EXPECT_EQ(answer("G21G91G94G38.3Y10.000F600.000\n"), "") << "answered when it stands";
  run(500ms);
  const double here = board->believed(1);
  EXPECT_GT(here, 1);
  board->set_probe(true);
  EXPECT_EQ(answer("?").substr(0, 4), "<Run");
  run(500ms);
  const auto lines = take();
  ASSERT_EQ(lines.size(), 2U);
  const auto probed = decode_reply(lines[0]);
  ASSERT_TRUE(probed && std::holds_alternative<Probed>(*probed)) << lines[0];
  EXPECT_NEAR(std::get<Probed>(*probed).at[1], here, 0.02) << "a tick at 10 a second, and a step";
  EXPECT_EQ(lines[1], "ok");
  EXPECT_GT(board->believed(1), here) << "it brakes";
  EXPECT_LT(board->believed(1), here + 1);
  EXPECT_TRUE(answer("?").ends_with("|Pn:P>"));
}

TEST_F(GrblBoard, a_probe_that_touches_nothing_ends_where_its_way_does) {
  begin(two_axes());
  say("G21G91G94G38.3X2.000F600.000\n");
  run(1s);
  EXPECT_EQ(take(), (std::vector<std::string>{"[PRB:2.000,0.000:0]", "ok"}));
  EXPECT_EQ(answer("?"), "<Idle|MPos:2.000,0.000>");
}

TEST_F(GrblBoard, a_probe_whose_input_is_closed_does_not_begin) {
  begin(two_axes());
  board->set_probe(true);
  EXPECT_EQ(answer("G21G91G94G38.3X2.000F600.000\n"), "ALARM:4");
  run(1s);
  EXPECT_EQ(board->turned(0), 0);
}

TEST_F(GrblBoard, a_reset_in_a_motion_is_an_alarm_until_it_is_unlocked) {
  begin(two_axes());
  say("G53G93G1X10.000Y5.000F60.000\n");
  run(500ms);
  take();
  say("\x18");
  EXPECT_EQ(take(), (std::vector<std::string>{"ALARM:3", "Grbl 1.1f ['$' for help]"}));
  EXPECT_EQ(answer("G53G93G1X1.000Y1.000F60.000\n"), "error:9");
  EXPECT_EQ(answer("$X\n"), "ok");
  EXPECT_EQ(answer("?").substr(0, 5), "<Idle");
}

TEST_F(GrblBoard, a_jog_ends_where_it_is_cancelled) {
  begin(two_axes());
  EXPECT_EQ(answer("$J=G21G91X10.000F600.000\n"), "ok");
  run(500ms);
  say("\x85");
  run(200ms);
  EXPECT_EQ(answer("?").substr(0, 5), "<Idle");
  EXPECT_GT(board->believed(0), 4);
  EXPECT_LT(board->believed(0), 6);
  // At once, before it has begun, too.
  say("$J=G21G91X10.000F600.000\n\x85");
  take();
  EXPECT_EQ(answer("?").substr(0, 5), "<Idle");
}

TEST_F(GrblBoard, homing_needs_switches_and_ends_at_its_own_place) {
  begin(two_axes());
  EXPECT_EQ(answer("$H\n"), "error:5");
  BoardSettings settings = two_axes();
  settings.homing = true;
  begin(settings);
  EXPECT_EQ(answer("?").substr(0, 6), "<Alarm");
  say("$H\n");
  for (int i = 0; i < 60'000 && board->state() == State::kHome; ++i) {
    // Switches 10 units below where it stands.
    AxisMask closed = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (board->turned(axis) <= -10) closed |= static_cast<AxisMask>(1U << axis);
    }
    board->set_switches(closed);
    run(1ms);
  }
  EXPECT_EQ(take(), std::vector<std::string>{"ok"});
  EXPECT_EQ(answer("?"), "<Idle|MPos:5.000,5.000>");
  EXPECT_NEAR(board->turned(1), -8, 0.02);
}

TEST_F(GrblBoard, a_switch_that_is_not_found_is_an_alarm) {
  BoardSettings settings = two_axes();
  settings.homing = true;
  begin(settings);
  say("$H\n");
  run(60s);
  EXPECT_EQ(take(), std::vector<std::string>{"ALARM:9"});
}

TEST_F(GrblBoard, a_switch_that_closes_in_a_motion_is_an_alarm) {
  BoardSettings settings = two_axes();
  settings.homing = true;
  begin(settings);
  say("$X\nG53G93G1X10.000Y5.000F60.000\n");
  run(500ms);
  take();
  board->set_switches(2);
  run(2ms);
  EXPECT_EQ(take(), std::vector<std::string>{"ALARM:1"});
  EXPECT_FALSE(board->moving());
  EXPECT_EQ(answer("?"), "") << "it hears nothing but a reset";
  say("\x18");
  take();
  EXPECT_NE(answer("?").find("Pn:Y"), std::string::npos);
}

TEST_F(GrblBoard, a_line_that_is_too_long_or_unknown_is_refused) {
  begin(two_axes());
  EXPECT_EQ(answer("G53G93G1X1.000Y1.000F60." + std::string(80, '0') + "\n"), "error:14");
  EXPECT_EQ(answer("M3S1000\n"), "error:20");
  EXPECT_EQ(answer("$N0\n"), "error:3");
}

TEST_F(GrblBoard, each_firmware_says_what_it_is) {
  BoardSettings settings = two_axes();
  settings.firmware = Firmware::kGrblHal;
  begin(settings);
  EXPECT_EQ(heard.front().substr(0, 7), "GrblHAL");
  EXPECT_EQ(answer("$I\n"), "[OPT:V,15,1024,2]");
  settings.firmware = Firmware::kFluidNc;
  begin(settings);
  EXPECT_NE(heard.front().find("FluidNC"), std::string::npos);
}

TEST_F(GrblBoard, an_emergency_stop_holds_until_it_is_released) {
  BoardSettings settings = two_axes();
  settings.firmware = Firmware::kGrblHal;
  begin(settings);
  board->set_emergency_stop(true);
  EXPECT_EQ(take(), std::vector<std::string>{"ALARM:10"});
  EXPECT_EQ(answer("$X\n"), "error:9");
  board->set_emergency_stop(false);
  EXPECT_EQ(answer("$X\n"), "ok");
}

TEST_F(GrblBoard, without_power_it_says_nothing_and_counts_from_0_behind_it) {
  begin(two_axes());
  say("G53G93G1X10.000Y5.000F60.000\n");
  run(500ms);
  board->lose_power();
  take();
  EXPECT_EQ(answer("?"), "");
  board->power_up(now);
  run(1s);
  EXPECT_EQ(take().size(), 1U);
  EXPECT_EQ(answer("?"), "<Idle|MPos:0.000,0.000>");
  EXPECT_GT(board->turned(0), 3);
}

TEST_F(GrblBoard, a_tool_offset_shows_in_the_work_coordinates_until_a_reset) {
  BoardSettings settings = two_axes();
  settings.axes.push_back(settings.axes[0]);
  begin(settings);
  EXPECT_EQ(answer("G43.1Z-5.000\n"), "ok");
  say("?");
  EXPECT_EQ(take().front(), "<Idle|MPos:0.000,0.000,0.000|WCO:0.000,0.000,-5.000>");
  say("?");
  EXPECT_EQ(take().front(), "<Idle|MPos:0.000,0.000,0.000>");
  say("\x18?");
  EXPECT_EQ(take().back(), "<Idle|MPos:0.000,0.000,0.000|WCO:0.000,0.000,0.000>");
}

TEST_F(GrblBoard, lists_its_settings) {
  begin(two_axes());
  say("$$\n");
  const auto lines = take();
  EXPECT_EQ(lines.front(), "$1=255.000");
  EXPECT_EQ(lines.back(), "ok");
  EXPECT_NE(std::ranges::find(lines, "$111=5400.000"), lines.end());
}

}  // namespace
}  // namespace sinew::grbl
