#include "sinew/runtime/cameras/camera.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/runtime/cameras/written_pictures.h"
#include "sinew/vision/picture_file.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

/// Dark on the left, bright on the right, and never the same twice.
vision::Picture table(int number, int width = 320) {
  vision::Picture picture = vision::black_picture(width, 240);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = width / 2; x < picture.width; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = 200;
    }
  }
  picture.at(0, 0)[0] = static_cast<std::uint8_t>(number);
  return picture;
}

Camera::Settings settings() {
  Camera::Settings settings;
  settings.name = "top";
  settings.calibration.emplace();
  settings.calibration->model = vision::pinhole(320, 240, 1);
  return settings;
}

std::shared_ptr<const Camera::Shot> shot_of(Camera& camera) {
  const std::uint64_t number = camera.ask();
  while (true) {
    auto shot = camera.newest();
    if (shot && shot->number >= number) return shot;
    std::this_thread::yield();
  }
}

ErrorCode fault_of(Camera& camera) {
  const auto shot = shot_of(camera);
  return shot->fault ? shot->fault->code : ErrorCode{};
}

TEST(Camera, each_picture_that_says_nothing_says_why) {
  std::atomic<int> taken = 0;
  std::atomic<int> width = 320;
  std::atomic<bool> is_lost = false, is_frozen = false, is_covered = false;
  Camera camera(settings(),
                [&](const std::stop_token&) -> Expected<vision::Picture> {
                  if (is_lost) return std::unexpected(Error{ErrorCode::kCameraLost, -1, 5});
                  if (!is_frozen) ++taken;
                  vision::Picture picture = table(taken, width);
                  if (is_covered) {
                    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
                      picture.rgb[i] = static_cast<std::uint8_t>(20 + i * 7919 % 9);
                    }
                  }
                  return picture;
                },
                {});
  EXPECT_EQ(camera.newest(), nullptr) << "none was asked for";
  EXPECT_FALSE(shot_of(camera)->fault);
  EXPECT_EQ(taken, 1);
  width = 640;
  const auto other = shot_of(camera);
  ASSERT_TRUE(other->fault);
  EXPECT_EQ(other->fault->code, ErrorCode::kCameraChanged);
  EXPECT_EQ(other->fault->measured, 640);
  EXPECT_EQ(other->picture.width, 640) << "it can be looked at";
  width = 320;
  EXPECT_FALSE(shot_of(camera)->fault);
  is_frozen = true;
  EXPECT_EQ(fault_of(camera), ErrorCode::kCameraFrozen);
  is_frozen = false;
  is_covered = true;
  EXPECT_EQ(fault_of(camera), ErrorCode::kCameraBlind);
  is_covered = false;
  is_lost = true;
  EXPECT_EQ(fault_of(camera), ErrorCode::kCameraLost);
  is_lost = false;
  EXPECT_FALSE(shot_of(camera)->fault) << "it is there again";
}

TEST(Camera, who_asks_while_one_is_taken_gets_the_next) {
  std::atomic<int> begun = 0;
  std::atomic<bool> go_on = false;
  Camera camera(settings(),
                [&](const std::stop_token&) -> Expected<vision::Picture> {
                  const int number = ++begun;
                  while (number == 1 && !go_on) std::this_thread::yield();
                  if (number == 1) return std::unexpected(Error{ErrorCode::kCameraLost});
                  return table(number);
                },
                {});
  camera.refresh();
  while (begun == 0) std::this_thread::yield();
  camera.refresh();
  const std::uint64_t second = camera.ask();
  go_on = true;
  while (!camera.newest() || camera.newest()->number < second) std::this_thread::yield();
  EXPECT_FALSE(camera.newest()->fault);
  EXPECT_EQ(begun, 2) << "to refresh is not to ask again";
}

/// Who resumes at once begins to watch again between two looks of the camera.
TEST(Camera, a_watch_that_begins_anew_at_once_takes_things_as_they_are) {
  Camera::Settings above = settings();
  above.calibration->X_WC = {rotation_x(kPi), {0, 0, 0.5}};
  std::atomic<int> looks = 0;
  std::atomic<bool> has_box = false;
  const auto glance = [&](const std::stop_token&) -> Expected<vision::Picture> {
    vision::Picture picture = table(++looks);
    for (int y = 60; has_box && y < 180; ++y) std::fill_n(picture.at(200, y), 3 * 100, 20);
    return picture;
  };
  Camera camera(above, glance, {[] { return std::vector<render::ViewedRobot>{}; }, {}, {}, glance});
  const auto wait_for = [](auto holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!holds() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    ASSERT_TRUE(holds());
  };
  const auto look = [&](int more) { wait_for([&, last = looks + more] { return looks > last; }); };
  camera.begin_watch(true);
  look(2);
  EXPECT_EQ(camera.disturbances(), 0U);
  has_box = true;
  wait_for([&] { return camera.disturbances() > 0; });
  for (int i = 0; i < 3; ++i) {
    camera.end_watch();
    camera.begin_watch(true);
    const std::uint64_t before = camera.disturbances();
    look(3);
    EXPECT_EQ(camera.disturbances(), before) << "the box has been looked at";
    has_box = !has_box;
    wait_for([&] { return camera.disturbances() > before; });
  }
  camera.end_watch();
}

TEST(Camera, a_watched_camera_that_sees_nothing_any_more_is_a_disturbance_with_its_name) {
  Camera::Settings above = settings();
  above.calibration->X_WC = {rotation_x(kPi), {0, 0, 0.5}};
  std::atomic<int> number = 0;
  std::atomic<bool> is_frozen = false, is_lost = false;
  const auto glance = [&](const std::stop_token&) -> Expected<vision::Picture> {
    if (is_lost) return std::unexpected(Error{ErrorCode::kCameraLost, -1, 5});
    return table(is_frozen ? number.load() : ++number);
  };
  Camera camera(above, glance, {[] { return std::vector<render::ViewedRobot>{}; }, {}, {}, glance});
  const auto disturbed_by = [&](std::uint64_t before) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (camera.disturbances() == before && std::chrono::steady_clock::now() < end) {
      std::this_thread::yield();
    }
    const auto why = camera.disturbed_since(before);
    return why ? why->code : ErrorCode{};
  };
  camera.begin_watch(true);
  while (number < 3) std::this_thread::yield();
  EXPECT_EQ(camera.disturbed_since(0), std::nullopt);
  is_frozen = true;
  EXPECT_EQ(disturbed_by(0), ErrorCode::kCameraFrozen);
  is_frozen = false;
  const int now = number;
  while (number < now + 3) std::this_thread::yield();
  is_lost = true;
  EXPECT_EQ(disturbed_by(camera.disturbances()), ErrorCode::kCameraLost);
  camera.end_watch();
}

TEST(WrittenPictures, only_a_new_whole_picture_counts) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("table.png");
  const auto write = [&](int number, std::chrono::seconds from_now) {
    const auto png = vision::encode_png(table(number));
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    std::filesystem::last_write_time(path,
                                     std::filesystem::file_time_type::clock::now() + from_now);
  };
  const auto source = written_pictures(path);
  std::stop_source end;
  using std::chrono::seconds;
  write(1, seconds(10));
  const auto first = source(end.get_token());
  ASSERT_TRUE(first);
  EXPECT_EQ(first->width, 320);
  // Written before the look, cut short, or not there: waited for until that is ended.
  std::jthread ender([&] { end.request_stop(); });
  write(3, seconds(-10));
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
  std::filesystem::resize_file(path, 100);
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
  std::filesystem::remove(path);
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
}

}  // namespace
}  // namespace sinew::runtime
