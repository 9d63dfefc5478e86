#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <thread>

#include "cli/process.h"
#include "cli/rendered_table.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/units.h"
#include "sinew/vision/picture_file.h"
#include "support/scratch_folder.h"

/// Programs that look, in a cell with a camera: what it sees comes through an image that another
/// program keeps writing.
namespace sinew::test {
namespace {

constexpr std::string_view kCell = R"(title = "Eyes for a test"
time_scale = 10
[[robot]]
name = "arm"
robot = "learm"
profile = "bus"
[[camera]]
name = "top"
device = "table.png"
calibration = "camera.toml"
cube_mm = 25
x_mm = 170
)";

/// A camera that sees a red cube in the middle of its table, ten times a second.
class Camera {
 public:
  explicit Camera(const ScratchFolder& folder)
      : path_(folder.at("table.png")), thread_([this](const std::stop_token& end) { work(end); }) {}

 private:
  void work(const std::stop_token& end) {
    vision::Picture picture = table(0);
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    while (!end.stop_requested()) {
      ++picture.rgb[0];  // as noise would
      const auto png = vision::encode_png(picture);
      std::ofstream(path_ + ".new", std::ios::binary)
          .write(reinterpret_cast<const char*>(png.data()),
                 static_cast<std::streamsize>(png.size()));
      std::filesystem::rename(path_ + ".new", path_);
      never.wait_for(lock, end, std::chrono::milliseconds(100), [] { return false; });
    }
  }

  std::string path_;
  std::jthread thread_;
};

class Eyes : public testing::Test {
 protected:
  Eyes() {
    folder_.file("camera.toml", camera_text({"test", vision::pinhole(320, 240, from_deg(50)), kX_WC,
                                             0.2, 1e-3, "", ""}));
    serve_ = std::make_unique<Process>(
        Arguments{"serve", folder_.file("cell.toml", std::string(kCell)), "--socket", socket()});
    serve_->wait_for_err("answers on");
  }
  std::string socket() const { return folder_.at("cell.sock"); }
  Ended run(const std::string& rows) const {
    return sinew({"run", folder_.file("p.sinew", rows), "--robot", "arm", "--socket", socket()});
  }

  ScratchFolder folder_;
  std::unique_ptr<Process> serve_;
};

const std::string kReady = "joint base=-60deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg\n";

TEST_F(Eyes, a_cube_that_is_seen_decides_and_is_grasped_until_that_is_no_use) {
  const Camera camera(folder_);
  const Ended seen = run(kReady +
                         "if seen color=blue\n jaws 10mm\nelse\n jaws 20mm\nend\n"
                         "if seen color=red\n wait 0.1s\nelse\n joint base=0deg\nend\n");
  EXPECT_EQ(seen.exit, 0) << seen.err;
  // Nothing is between the simulated jaws.
  const Ended picked = run("pick color=red\n");
  EXPECT_EQ(picked.exit, 1);
  EXPECT_NE(picked.err.find("nothing is held after 3 grasps"), std::string::npos) << picked.err;
  const Ended none = run("pick color=green\n");
  EXPECT_EQ(none.exit, 1);
  EXPECT_NE(none.err.find("no such cube is seen"), std::string::npos) << none.err;
}

TEST_F(Eyes, a_camera_that_gives_no_picture_ends_the_program) {
  const Ended ended = run("look\n");
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("no picture for 5 s"), std::string::npos) << ended.err;
}

TEST_F(Eyes, a_calibration_that_cannot_be_read_is_told_before_anything_runs) {
  folder_.file("camera.toml", "format = 7\n");
  const Ended ended = sinew({"serve", folder_.at("cell.toml"), "--socket", folder_.at("b.sock")});
  EXPECT_EQ(ended.exit, 2);
  EXPECT_NE(ended.err.find("camera.toml"), std::string::npos) << ended.err;
}

}  // namespace
}  // namespace sinew::test
