#include "firmware/emulation_avr/mega_port.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "cli/process.h"
#include "support/board_image_bytes.h"
#include "support/scratch_folder.h"

// The built program and the image that is flashed, each in its own process time.

namespace sinew::emulation {
namespace {

using test::Arguments;
using test::Ended;
using test::Process;

const std::string kBoard = "bigrobotarm-atmega2560";

class MegaPortTest : public testing::Test {
 protected:
  void SetUp() override {
    setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
    setenv("XDG_RUNTIME_DIR", folder_.at("").c_str(), 1);
  }
  /// @param words  PORT is the board's port; each try has a board of its own
  Ended sinew(Arguments words) {
    words.insert(words.end(), {"--robot", "bigrobotarm", "--wire", "framed", "--json"});
    Ended ended;
    for (int k = 0; k < test::kTriesWhereLate; ++k) {
      port_.emplace();
      Arguments said = words;
      std::ranges::replace(said, "PORT", port_->name());
      ended = Process(said).end();
      if (!ended.was_late()) break;
    }
    return ended;
  }

  test::ScratchFolder folder_;
  std::optional<MegaPort> port_;
};

TEST_F(MegaPortTest, says_which_image_runs_and_whether_an_update_is_due) {
  const std::string built = std::filesystem::path(mega_image()).parent_path();
  const Ended same = sinew({"firmware", "info", "PORT", "--images", built});
  ASSERT_EQ(same.exit, 0) << same.err;
  const auto board = same.json()["boards"][0];
  EXPECT_EQ(board["board"], kBoard);
  EXPECT_EQ(board["update_due"], false) << board.dump();
  const auto other = test::board_image_bytes(kBoard, "9.9.9", 336, 30'000);
  std::filesystem::create_directories(folder_.at("images"));
  folder_.file("images/" + kBoard + ".bin", std::string(other.begin(), other.end()));
  const Ended newer = sinew({"firmware", "info", "PORT", "--images", folder_.at("images")});
  ASSERT_EQ(newer.exit, 0) << newer.err;
  EXPECT_EQ(newer.json()["boards"][0]["update_due"], true);
}

TEST_F(MegaPortTest, a_program_moves_its_motors) {
  const std::string program = folder_.file("p.sinew", "joint base=3deg elbow=-2deg\n");
  const Ended stands = sinew({"doctor", "--port", "PORT"});
  ASSERT_EQ(stands.exit, 0) << stands.err;
  const Ended ran = sinew({"run", program, "--port", "PORT", "--standing-at", "home"});
  ASSERT_EQ(ran.exit, 0) << ran.err << ran.out;
  EXPECT_EQ(port_->steps(0), std::lround(3 * 26000 / 360.0));
  EXPECT_EQ(port_->steps(2), std::lround(2 * 40000 / 360.0));
}

}  // namespace
}  // namespace sinew::emulation
