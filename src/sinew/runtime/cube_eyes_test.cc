#include "sinew/runtime/cube_eyes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/io/scratch_folder_test_support.h"
#include "sinew/runtime/written_pictures.h"
#include "sinew/vision/picture_file.h"

namespace sinew::runtime {
namespace {

CubeEyes::Place place() {
  CubeEyes::Place place;
  place.camera.model.width = 320;
  place.camera.model.height = 240;
  return place;
}

Expected<program::Sighting> looked(CubeEyes& eyes) {
  eyes.look();
  while (true) {
    if (auto seen = eyes.seen()) return *seen;
    std::this_thread::yield();
  }
}

/// Dark on the left, bright on the right, and never the same twice.
vision::Picture table(int number) {
  vision::Picture picture = vision::black_picture(320, 240);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 160; x < picture.width; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = 200;
    }
  }
  picture.at(0, 0)[0] = static_cast<std::uint8_t>(number);
  return picture;
}

void write(const std::string& path, const vision::Picture& picture, std::chrono::seconds from_now) {
  const auto png = vision::encode_png(picture);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() + from_now);
}

TEST(CubeEyes, each_look_has_its_own_picture_or_says_why_there_is_none) {
  std::atomic<int> taken = 0;
  std::atomic<int> width = 320;
  std::atomic<bool> is_lost = false;
  CubeEyes eyes(place(), [&](const std::stop_token&) -> Expected<vision::Picture> {
    ++taken;
    if (is_lost) return std::unexpected(Error{ErrorCode::kCameraLost, -1, 5});
    return vision::black_picture(width, 240);
  });
  EXPECT_FALSE(eyes.seen()) << "nobody asked";
  EXPECT_TRUE(looked(eyes));
  EXPECT_EQ(taken, 1);
  EXPECT_FALSE(eyes.seen()) << "told once";
  width = 640;
  const auto other = looked(eyes);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kCameraChanged);
  EXPECT_EQ(other.error().measured, 640);
  is_lost = true;
  EXPECT_EQ(looked(eyes).error().code, ErrorCode::kCameraLost);
}

TEST(CubeEyes, a_look_that_is_asked_for_again_is_not_answered_with_the_picture_before) {
  std::atomic<int> begun = 0;
  std::atomic<bool> go_on = false;
  CubeEyes eyes(place(), [&](const std::stop_token&) -> Expected<vision::Picture> {
    const int number = ++begun;
    while (number == 1 && !go_on) std::this_thread::yield();
    if (number == 1) return std::unexpected(Error{ErrorCode::kCameraLost});
    return vision::black_picture(320, 240);
  });
  eyes.look();
  while (begun == 0) std::this_thread::yield();
  eyes.look();
  go_on = true;
  while (true) {
    if (const auto seen = eyes.seen()) {
      EXPECT_TRUE(*seen);
      break;
    }
    std::this_thread::yield();
  }
  EXPECT_EQ(begun, 2);
}

TEST(CubeEyes, places_are_the_robots_own) {
  CubeEyes::Place one = place();
  one.X_BW = {rotation_from_fixed_xyz({0, 0, kPi / 2}), {0.2, 0.05, -0.01}};
  vision::Detection seen;
  vision::SeenCube cube;
  cube.color = vision::ColorName::kBlue;
  cube.position = vision::CubePosition{{0.03, 0.01, 0.025}, from_deg(10), 0.0248, 1};
  seen.cubes = {cube, vision::SeenCube{}};
  const auto sighting = sighting_of(seen, one);
  ASSERT_EQ(sighting.cubes.size(), 1U) << "one has no place";
  EXPECT_NEAR(norm(sighting.cubes[0].p_BO - Vec3{0.19, 0.08, 0.0025}), 0, 1e-12);
  EXPECT_NEAR(sighting.cubes[0].yaw, from_deg(10), 1e-12);
  EXPECT_EQ(sighting.cubes[0].edge, 0.025);
  EXPECT_EQ(sighting.table_z, -0.01);
}

TEST(WrittenPictures, only_a_new_whole_picture_with_something_on_it_counts) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("table.png");
  const auto source = written_pictures(path);
  std::stop_source end;
  using std::chrono::seconds;
  write(path, table(1), seconds(10));
  const auto first = source(end.get_token());
  ASSERT_TRUE(first);
  EXPECT_EQ(first->width, 320);
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraFrozen);
  write(path, table(2), seconds(10));
  EXPECT_TRUE(source(end.get_token()));
  vision::Picture covered = vision::black_picture(320, 240);
  for (std::size_t i = 0; i < covered.rgb.size(); ++i) {
    covered.rgb[i] = static_cast<std::uint8_t>(20 + i * 7919 % 9);
  }
  write(path, covered, seconds(10));
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraBlind);
  // Written before the look, cut short, or not there: waited for until somebody ends it.
  std::jthread ender([&] { end.request_stop(); });
  write(path, table(3), seconds(-10));
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
  std::filesystem::resize_file(path, 100);
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
  std::filesystem::remove(path);
  EXPECT_EQ(source(end.get_token()).error().code, ErrorCode::kCameraLost);
}

}  // namespace
}  // namespace sinew::runtime
