#include "sinew/io/video_modes.h"

#include <gtest/gtest.h>

namespace sinew::io {
namespace {

using enum VideoFormat;

const std::vector<VideoMode> kWebcam{
    {kYuyv, 640, 480, 30},  {kYuyv, 1280, 720, 10},  {kYuyv, 1920, 1080, 5}, {kMjpg, 640, 480, 30},
    {kMjpg, 1280, 720, 30}, {kMjpg, 1920, 1080, 30}, {kGrey, 1280, 720, 60}, {kYuyv, 1600, 400, 60},
};

TEST(VideoModes, largest_size_up_to_1280_x_720_is_taken_where_none_is_wanted) {
  EXPECT_EQ(best_mode(kWebcam, {}), (VideoMode{kMjpg, 1280, 720, 30}));
  const std::vector<VideoMode> large{{kMjpg, 3840, 2160, 30}, {kMjpg, 1920, 1080, 30}};
  EXPECT_EQ(best_mode(large, {}), (VideoMode{kMjpg, 1920, 1080, 30})) << "else the smallest";
}

TEST(VideoModes, wanted_size_is_taken_and_no_other) {
  EXPECT_EQ(best_mode(kWebcam, {1920, 1080, 0}), (VideoMode{kMjpg, 1920, 1080, 30}));
  EXPECT_EQ(best_mode(kWebcam, {800, 600, 0}), std::nullopt);
  EXPECT_EQ(best_mode({}, {}), std::nullopt);
}

TEST(VideoModes, uncompressed_pictures_are_preferred_where_they_come_as_often_as_wanted) {
  EXPECT_EQ(best_mode(kWebcam, {640, 480, 0}), (VideoMode{kYuyv, 640, 480, 30}));
  EXPECT_EQ(best_mode(kWebcam, {1280, 720, 10}), (VideoMode{kYuyv, 1280, 720, 10}));
  EXPECT_EQ(best_mode(kWebcam, {1280, 720, 15}), (VideoMode{kMjpg, 1280, 720, 30}));
}

TEST(VideoModes, grey_is_taken_where_there_is_no_colour) {
  const std::vector<VideoMode> grey{{kGrey, 640, 480, 60}, {kGrey, 640, 480, 90}};
  EXPECT_EQ(best_mode(grey, {}), grey[1]);
}

TEST(VideoModes, sizes_are_listed_once_each) {
  EXPECT_EQ(size_list(kWebcam), "640 x 480, 1280 x 720, 1600 x 400, 1920 x 1080");
  EXPECT_EQ(size_list({}), "");
}

}  // namespace
}  // namespace sinew::io
