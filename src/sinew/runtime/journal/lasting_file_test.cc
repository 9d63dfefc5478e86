#include "sinew/runtime/journal/lasting_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/kinds.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using test::ScratchFolder;
using test::text_of;

/// What sets each robot's first joint in motion; boards on SPI fall by their weight.
std::vector<std::uint8_t> motion_of(const std::string& robot) {
  std::vector<std::uint8_t> bytes;
  const auto add = [&](const auto& frame) {
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  };
  if (robot == "learm") {
    add(lsc::encode(lsc::Move{2000, {{6, 700}, {5, 1500}, {4, 1500}, {3, 1500}, {2, 1500}}}));
  } else if (robot == "bigrobotarm") {
    add(bigrobotarm::byte::encode_request(bigrobotarm::Goto{{3000, 200, 0, 0, 0}}));
    bytes.push_back(bigrobotarm::byte::kTerminator);
  } else if (robot == "maxarm") {
    add(maxarm::encode_request(maxarm::SetAngle{{300, 400, 600}, 2000}));
  } else if (robot == "hexapod") {
    bytes.push_back(icp::kInit);
  }
  return bytes;
}

struct Living {
  explicit Living(const std::string& id, Instant boot = Instant{})
      : robot(test::robot(id)), made(make_machine(robot, {}, boot)), now(boot) {}

  sim::Machine& machine() { return made->get(); }
  void run(Duration time) { machine().advance(now += time); }
  void tell(std::span<const std::uint8_t> bytes) {
    if (made->byte) made->byte->receive(bytes, now);
  }
  void set_in_motion() {
    run(made->spi ? 50ms : 25s);
    tell(motion_of(robot.id));
    for (int i = 0; robot.id == "hexapod" && i < 100; ++i) {
      tell(std::array{icp::encode_step({1, false})});
      run(4167us);
      std::array<std::uint8_t, 8> out{};
      (void)made->byte->take_output(out);
      if (i < 99) tell(motion_of(robot.id));
    }
    if (robot.id != "hexapod") run(made->spi ? 10ms : 300ms);
  }

  const RobotModel& robot;
  std::expected<RobotMachine, std::string> made;
  Instant now;
};

class PowerCut : public ::testing::TestWithParam<const char*> {};

TEST_P(PowerCut, of_a_process_leaves_the_machine_where_a_cut_of_its_supply_does) {
  Living cut(GetParam());
  const double begin = cut.machine().truth().joints[0].q;
  cut.set_in_motion();
  const sim::LastingState state = cut.machine().lasting_state();
  const double volts = cut.machine().truth().supply_volts;
  const double in_motion = cut.machine().truth().joints[0].q;
  EXPECT_GT(std::abs(in_motion - begin), cut.robot.id == "hexapod" ? 1e-6 : 1e-3);
  cut.machine().disturb({.kind = sim::Disturbance::Kind::kSupply, .value = 0});
  cut.run(sim::kPowerOffTime);
  cut.machine().disturb({.kind = sim::Disturbance::Kind::kSupply, .value = volts});
  cut.run(2s);

  Living again(GetParam(), Instant{} - sim::kPowerOffTime);
  ASSERT_TRUE(sim::power_up_from(state, again.machine(), Instant{}));
  again.now = Instant{};
  again.run(2s);
  const sim::Truth expected = cut.machine().truth();
  const sim::Truth truth = again.machine().truth();
  // Its ticks and those of its weight fall otherwise: a servo on its way down shows that.
  const double tolerance = cut.robot.id == "learm" ? 2e-3 : 1e-5;
  for (std::size_t i = 0; i < truth.joints.size(); ++i) {
    EXPECT_NEAR(truth.joints[i].q, expected.joints[i].q, tolerance) << i;
  }
}

TEST_P(PowerCut, another_machines_state_is_refused_and_changes_nothing) {
  Living one(GetParam(), Instant{} - sim::kPowerOffTime);
  const double before = one.machine().truth().joints[0].q;
  sim::LastingState state = one.machine().lasting_state();
  state.bodies.pop_back();
  EXPECT_FALSE(sim::power_up_from(state, one.machine(), Instant{}));
  state = one.machine().lasting_state();
  state.memory.push_back(1);
  EXPECT_FALSE(sim::power_up_from(state, one.machine(), Instant{}));
  EXPECT_EQ(one.machine().truth().joints[0].q, before);
}

INSTANTIATE_TEST_SUITE_P(Robots, PowerCut,
                         ::testing::Values("learm", "bigrobotarm", "maxarm", "hexapod",
                                           "robot-arm-2"),
                         [](const auto& robot) {
                           std::string name = robot.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(LastingFile, gives_back_what_was_kept_last) {
  const ScratchFolder folder;
  Living arm("learm");
  for (int round = 0; round < 5; ++round) {
    auto file = LastingFile::open(folder.at("state"), "learm", std::nullopt);
    ASSERT_TRUE(file) << file.error();
    EXPECT_EQ(file->before().has_value(), round > 0);
    if (file->before()) {
      EXPECT_EQ(*file->before(), arm.machine().lasting_state());
    }
    arm.set_in_motion();
    ASSERT_TRUE(file->keep(arm.machine()));
  }
}

TEST(LastingFile, flash_of_a_servo_board_lasts) {
  const ScratchFolder folder;
  Living arm("learm");
  using Kind = lsc::GroupStep::Kind;
  const auto tell = [&](const lsc::Request& request) { arm.tell(lsc::encode(request)); };
  tell(lsc::GroupStep{Kind::kBegin, 7, 0, 0, {}});
  tell(lsc::GroupStep{Kind::kCount, 1, 0, 0, {}});
  tell(lsc::GroupStep{Kind::kBlocks, 1, 0, 0, {}});
  tell(lsc::GroupStep{Kind::kAction, 0, 0, 0, {1000, {{1, 1500}, {6, 1900}}}});
  tell(lsc::GroupStep{Kind::kEnd, 0, 0, 0, {}});
  {
    auto file = LastingFile::open(folder.at("state"), "learm", std::nullopt);
    ASSERT_TRUE(file && file->keep(arm.machine()));
  }
  auto file = LastingFile::open(folder.at("state"), "learm", std::nullopt);
  ASSERT_TRUE(file && file->before());
  Living again("learm", Instant{} - sim::kPowerOffTime);
  ASSERT_TRUE(sim::power_up_from(*file->before(), again.machine(), Instant{}));
  again.now = Instant{};
  again.run(10ms);
  again.tell(lsc::encode(lsc::RunGroup{7, 1}));
  again.run(3s);
  EXPECT_NEAR(again.machine().truth().joints[0].q, 400 * kPi / 2000, 0.01) << "servo 6 at 1900";
}

/// Changes one character of the file.
void damage(const std::string& path, std::size_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(at));
  file.put('#');
}

TEST(LastingFile, a_line_that_was_cut_off_leaves_the_one_before) {
  const ScratchFolder folder;
  Living arm("bigrobotarm");
  sim::LastingState first;
  {
    auto file = LastingFile::open(folder.at("state"), "bigrobotarm", std::nullopt);
    ASSERT_TRUE(file && file->keep(arm.machine()));
    first = arm.machine().lasting_state();
    arm.set_in_motion();
    ASSERT_TRUE(file->keep(arm.machine()));
  }
  // Slots of 64 KiB in turn: the first line is in the second one.
  damage(folder.at("state"), 40);
  {
    auto file = LastingFile::open(folder.at("state"), "bigrobotarm", std::nullopt);
    ASSERT_TRUE(file && file->before());
    EXPECT_EQ(*file->before(), first);
  }
  damage(folder.at("state"), 64 * 1024 + 40);
  const auto file = LastingFile::open(folder.at("state"), "bigrobotarm", std::nullopt);
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().find("damaged"), std::string::npos) << file.error();
}

TEST(LastingFile, what_is_not_this_machines_is_refused) {
  const ScratchFolder folder;
  Living arm("maxarm");
  {
    auto file = LastingFile::open(folder.at("state"), "maxarm", 5);
    ASSERT_TRUE(file && file->keep(arm.machine()));
    const auto second = LastingFile::open(folder.at("state"), "maxarm", 5);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().find("in use"), std::string::npos) << second.error();
  }
  const auto refusal = [&](const std::string& path, const char* robot, std::uint64_t seed) {
    const auto file = LastingFile::open(path, robot, seed);
    return file ? "" : file.error();
  };
  EXPECT_EQ(refusal(folder.at("state"), "maxarm", 5), "");
  EXPECT_NE(refusal(folder.at("state"), "learm", 5).find("of maxarm, not of learm"),
            std::string::npos);
  EXPECT_NE(refusal(folder.at("state"), "maxarm", 6).find("--seed 5, not 6"), std::string::npos);
  EXPECT_NE(refusal(folder.file("text", "hello\n"), "maxarm", 5).find("damaged"),
            std::string::npos);
  EXPECT_NE(refusal(folder.at(), "maxarm", 5), "");
  EXPECT_NE(refusal("/dev/null", "maxarm", 5).find("not a plain file"), std::string::npos);
  EXPECT_EQ(text_of(folder.at("text")), "hello\n");
}

}  // namespace
}  // namespace sinew::runtime
