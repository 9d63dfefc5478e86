#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>

#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/sim/simwire_server.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

/// The arm behind simwire, with a host that types lines; each pause is in us.
struct Bench {
  explicit Bench(AxisWire wire = AxisWire::kRegisters)
      : arm(test::robot("robot-arm-2"), {wire, SelectKind::kHard, 1, {}}, Instant{}),
        server(arm, test::robot("robot-arm-2").device.settings.get<AxisRegistersDevice>().boards,
               "arm") {
    say(0, "HELLO 1");
    say(0, "DIR " + pin() + " OUT OFF");
    say(0, "SET " + pin() + " 1");
    say(0, "OPEN 0 0 500000 0");
    time_us = 100'000;
  }
  static std::string pin() {
    const auto& device = test::robot("robot-arm-2").device.settings.get<AxisRegistersDevice>();
    return std::to_string(device.boards[0].select_gpio);
  }
  std::string say(std::uint64_t pause_us, const std::string& line) {
    time_us += pause_us;
    const auto reply = server.answer(std::to_string(time_us) + " " + line);
    const auto text = simwire::encode_reply(reply);
    return std::string(simwire::view(text));
  }
  std::string transfer(const std::string& mosi, std::uint64_t setup_us = 200,
                       std::uint64_t pause_us = 10'000) {
    say(pause_us, "SET " + pin() + " 0");
    const std::string miso = say(setup_us, "XFER 0 0 500000 0 " + mosi);
    time_us += mosi.size() / 2 * 16;
    say(0, "SET " + pin() + " 1");
    return miso.substr(5);
  }
  std::map<std::string, std::string> figures(const char* question = "STAT") {
    std::map<std::string, std::string> out;
    std::istringstream words(say(0, question));
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      if (equals != std::string::npos) out[word.substr(0, equals)] = word.substr(equals + 1);
    }
    return out;
  }

  StepperArm arm;
  SimwireServer server;
  std::uint64_t time_us = 0;
};

constexpr const char* kEmergencyStop = "55010005020004000178c80bbcaa";  // frame 5, WRITE, 4, 1 byte

TEST(SimwireFigures, the_state_of_the_handshake_and_the_registers_are_told_at_each_step) {
  Bench bench;
  EXPECT_EQ(bench.figures()["state_1"], "WAIT_SYN");
  EXPECT_EQ(bench.figures()["emergency_stop_1"], "00");
  struct Step {
    const char *mosi, *state;
  };
  for (const Step& step : {Step{"97", "SEND_SYN_ACK"}, Step{"ff", "WAIT_ACK"},
                           Step{"99", "WAIT_HEADER"}, Step{kEmergencyStop, "SEND_VALIDATION"},
                           Step{"ff", "WAIT_DATA"}, Step{"01c3c5c0cc", "SEND_COMMIT"}}) {
    bench.transfer(step.mosi);
    EXPECT_EQ(bench.figures()["state_1"], step.state);
    EXPECT_EQ(bench.figures()["state_2"], "WAIT_SYN") << "nobody selected it";
  }
  EXPECT_EQ(bench.transfer("00000000"), "559a00aa");
  for (const char* question : {"STAT", "DUMP"}) {
    auto figures = bench.figures(question);
    EXPECT_EQ(figures["state_1"], "WAIT_SYN");
    EXPECT_EQ(figures["emergency_stop_1"], "01");
    EXPECT_EQ(figures["emergency_stop_2"], "00");
    EXPECT_EQ(figures["diag_status_1"].size(), 8U) << "four bytes as they stand on the wire";
    EXPECT_EQ(figures["changes_1"], "1");
    EXPECT_EQ(figures["violations_1"], "0");
    EXPECT_EQ(figures["contended_bytes"], "0");
    EXPECT_EQ(figures.contains("believed_deg_1"), std::string(question) == "DUMP");
  }
}

TEST(SimwireFigures, each_thing_that_a_host_does_wrong_is_counted_as_what_it_is) {
  const auto only = [](Bench& bench, const std::string& kind, const std::string& count = "1") {
    auto figures = bench.figures();
    EXPECT_EQ(figures[kind + "_1"], count);
    EXPECT_EQ(figures["violations_1"], count) << kind << " alone";
    EXPECT_EQ(figures["violations_2"], "0");
  };
  Bench early;
  early.transfer("97", 199);
  only(early, "early_clocks");
  Bench hasty;
  hasty.transfer("97");
  hasty.transfer("ff", 200, 9'999 - 16);
  only(hasty, "short_pauses");
  Bench stray;
  stray.transfer("42");
  only(stray, "stray_bytes");
  Bench surplus;
  surplus.transfer("97ffffff");
  only(surplus, "surplus_bytes", "3");
  Bench broken;
  for (const char* mosi : {"97", "ff", "99", "5501", "55"}) broken.transfer(mosi);
  only(broken, "broken_transfers");
  Bench refused;
  for (const char* mosi : {"97", "ff", "99", "54010005020004000178c80bbcaa"}) {
    refused.transfer(mosi);
  }
  only(refused, "refused_headers");
  Bench bad;
  for (const char* mosi : {"97", "ff", "99", kEmergencyStop, "ff", "01c3c5c0cd"})
    bad.transfer(mosi);
  only(bad, "bad_data");
}

TEST(SimwireFigures, a_board_that_lost_its_power_says_off_and_counts_its_boots) {
  Bench bench;
  EXPECT_EQ(bench.figures()["boots_1"], "1");
  bench.arm.disturb({Disturbance::Kind::kSupply, -1, 0});
  bench.time_us += 10'000;
  EXPECT_EQ(bench.figures()["state_1"], "OFF");
  bench.arm.disturb({Disturbance::Kind::kSupply, -1, 24});
  bench.time_us += 10'000;
  EXPECT_EQ(bench.figures()["state_1"], "WAIT_SYN");
  EXPECT_EQ(bench.figures()["boots_1"], "2");
}

TEST(SimwireFigures, boards_on_the_axis_link_tell_their_session_and_their_frames) {
  Bench bench(AxisWire::kLink);
  bench.transfer("00112233445566778899aabbccddeeff");
  auto figures = bench.figures();
  EXPECT_EQ(figures["state_1"], "NO_SESSION");
  EXPECT_EQ(figures["violations_1"], "1");
  EXPECT_EQ(figures["good_frames_1"], "0");
}

}  // namespace
}  // namespace sinew::sim
