#include "sinew/runtime/cameras/v4l2_pictures.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/vision/picture_file.h"
#include "support/v4l2_camera.h"
#include "support/video_files.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using test::TestVideoCamera;

/// Rows of YUYV in which the left half is dark and the right half bright.
std::vector<std::uint8_t> halves(int, const v4l2_pix_format& format) {
  std::vector<std::uint8_t> bytes(std::size_t{format.bytesperline} * format.height, 0xEE);
  for (std::size_t y = 0; y < format.height; ++y) {
    for (std::size_t x = 0; x < format.width; ++x) {
      std::uint8_t* at = bytes.data() + y * format.bytesperline + 2 * x;
      at[0] = x < format.width / 2 ? 16 : 235;
      at[1] = 128;
    }
  }
  return bytes;
}

class V4l2PicturesTest : public testing::Test {
 protected:
  CameraSource open(const io::VideoWanted& wanted = {}) {
    auto source = v4l2_pictures("/dev/video0", wanted, kernel_.calls());
    EXPECT_TRUE(source) << source.error();
    return std::move(*source);
  }

  TestVideoCamera kernel_;
};

TEST_F(V4l2PicturesTest, padded_rows_of_yuyv_are_a_straight_picture) {
  kernel_.padding = 24;
  kernel_.paint = halves;
  CameraSource source = open({640, 480, 0});
  const auto picture = source({});
  ASSERT_TRUE(picture);
  ASSERT_EQ(picture->width, 640);
  ASSERT_EQ(picture->height, 480);
  for (int y = 0; y < 480; ++y) {
    ASSERT_EQ(picture->at(319, y)[1], 0);
    ASSERT_EQ(picture->at(320, y)[1], 255);
  }
}

TEST_F(V4l2PicturesTest, mjpeg_frames_are_decoded_and_damaged_ones_passed_over) {
  kernel_.formats = {{V4L2_PIX_FMT_MJPEG, {{64, 48, {{1, 30}}}}}};
  const auto frame =
      test::without_huffman_tables(vision::encode_jpeg(test::plain_picture(64, 48, 200, 200, 200)));
  kernel_.paint = [&](int number, const v4l2_pix_format&) {
    auto bytes = frame;
    if (number % 5 != 0) bytes.resize(bytes.size() - 20);
    return bytes;
  };
  CameraSource source = open();
  for (int i = 0; i < 3; ++i) {
    const auto picture = source({});
    ASSERT_TRUE(picture);
    EXPECT_NEAR(picture->rgb[0], 200, 1);
  }
  kernel_.paint = [&](int, const v4l2_pix_format&) {
    return std::vector<std::uint8_t>(frame.begin(), frame.begin() + 30);
  };
  const auto lost = source({});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kCameraLost);
  EXPECT_NEAR(lost.error().measured, 5, 0.1);
}

TEST_F(V4l2PicturesTest, grey_camera_gives_grey_pictures) {
  kernel_.formats = {{V4L2_PIX_FMT_GREY, {{64, 48, {{1, 30}}}}}};
  CameraSource source = open();
  const auto picture = source({});
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->rgb[0], picture->rgb[2]);
}

TEST_F(V4l2PicturesTest, each_picture_was_exposed_after_it_was_asked_for) {
  kernel_.formats = {{V4L2_PIX_FMT_GREY, {{64, 48, {{1, 30}}}}}};
  CameraSource source = open();
  for (const int pause : {0, 10, 100, 1000}) {
    kernel_.calls().poll(nullptr, pause);
    const Duration asked = kernel_.now;
    const auto picture = source({});
    ASSERT_TRUE(picture);
    EXPECT_GE(kernel_.exposed.at(picture->rgb[0]), asked);
  }
}

TEST_F(V4l2PicturesTest, camera_that_comes_back_is_opened_again_with_what_was_kept) {
  kernel_.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, 77}};
  CameraSource source = open();
  ASSERT_TRUE(source({}));
  kernel_.on_frame = [&](int) { kernel_.unplug(); };
  const Duration asked = kernel_.now;
  const auto lost = source({});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kCameraLost);
  EXPECT_LT(kernel_.now - asked, 1s) << "it is known to be gone";
  kernel_.on_frame = [](int) {};
  const Duration before = kernel_.now;
  EXPECT_FALSE(source({})) << "still away";
  EXPECT_NEAR(to_seconds(kernel_.now - before), 5, 0.2);
  // A camera that was without power is as it was when it was new.
  kernel_.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, 500}};
  kernel_.plug();
  EXPECT_TRUE(source({}));
  EXPECT_EQ(kernel_.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(kernel_.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 77);
  EXPECT_EQ(kernel_.open_count, 1);
  EXPECT_EQ(kernel_.mapped_count, 4);
}

TEST_F(V4l2PicturesTest, silent_camera_is_lost_after_5_s_and_opened_anew) {
  CameraSource source = open();
  ASSERT_TRUE(source({}));
  kernel_.is_silent = true;
  const Duration asked = kernel_.now;
  EXPECT_EQ(source({}).error().code, ErrorCode::kCameraLost);
  EXPECT_NEAR(to_seconds(kernel_.now - asked), 5, 0.1);
  kernel_.is_silent = false;
  const int opened = kernel_.opened;
  EXPECT_TRUE(source({}));
  EXPECT_EQ(kernel_.opened, opened + 1);
}

TEST_F(V4l2PicturesTest, end_of_the_run_is_seen_while_it_settles) {
  CameraSource source = open();
  std::stop_source end;
  kernel_.on_frame = [&](int number) {
    if (number == 3) end.request_stop();
  };
  const Duration asked = kernel_.now;
  EXPECT_FALSE(source(end.get_token()));
  EXPECT_LT(kernel_.now - asked, 200ms);
}

TEST_F(V4l2PicturesTest, wrong_size_is_refused_before_anything_begins) {
  const auto source = v4l2_pictures("/dev/video0", {1920, 1080, 0}, kernel_.calls());
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error(),
            "/dev/video0: no pictures of 1920 x 1080 pixels; it has 640 x 480. Calibrate it again "
            "in one of these sizes");
}

}  // namespace
}  // namespace sinew::runtime
