#include "sinew/io/v4l2_camera.h"

#include <gtest/gtest.h>

#include "support/v4l2_camera.h"

namespace sinew::io {
namespace {

using namespace std::chrono_literals;
using test::TestVideoCamera;

std::string sentence_of(TestVideoCamera& kernel, const VideoWanted& wanted = {}) {
  const V4l2Calls calls = kernel.calls();
  const auto camera = V4l2Camera::open("/dev/video0", wanted, calls);
  return camera ? "fine" : camera.error().sentence;
}

/// The number of the frame that comes next, by its bytes; below zero why none came.
int number_of(const std::expected<VideoFrame, VideoLoss>& frame) {
  if (!frame) return frame.error() == VideoLoss::kGone ? -2 : -1;
  return frame->bytes.at(0);
}

class V4l2CameraTest : public testing::Test {
 protected:
  V4l2Camera open(const VideoWanted& wanted = {}) {
    auto camera = V4l2Camera::open("/dev/video0", wanted, calls_);
    EXPECT_TRUE(camera) << camera.error().sentence;
    return std::move(*camera);
  }
  int next(V4l2Camera& camera, Duration patience = 5s) {
    return number_of(camera.next(kernel_.now, kernel_.now + patience, {}));
  }

  TestVideoCamera kernel_;
  V4l2Calls calls_ = kernel_.calls();
};

TEST_F(V4l2CameraTest, frame_was_exposed_after_it_was_asked_for) {
  V4l2Camera camera = open();
  for (const Duration pause : {0ms, 1ms, 20ms, 40ms, 500ms, 3000ms}) {
    calls_.poll(nullptr, static_cast<int>(pause / 1ms));  // buffers fill up meanwhile
    const Duration asked = kernel_.now;
    const int number = next(camera);
    ASSERT_GT(number, 0);
    EXPECT_GE(kernel_.exposed.at(number), asked);
    EXPECT_LT(kernel_.exposed.at(number), asked + 34ms + 34ms) << "and not much later";
  }
}

TEST_F(V4l2CameraTest, frames_without_a_usable_stamp_are_as_new) {
  kernel_.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  V4l2Camera camera = open();
  for (const Duration pause : {0ms, 20ms, 500ms, 3000ms}) {
    calls_.poll(nullptr, static_cast<int>(pause / 1ms));
    const Duration asked = kernel_.now;
    const int number = next(camera);
    ASSERT_GT(number, 0);
    EXPECT_GE(kernel_.exposed.at(number), asked);
  }
}

TEST_F(V4l2CameraTest, camera_that_exposes_longer_than_it_says_is_waited_for) {
  kernel_.slowness = 4;
  V4l2Camera camera = open();
  ASSERT_TRUE(camera.settle({}));
  for (const int pause : {0, 20, 50, 100, 500, 3000}) {
    calls_.poll(nullptr, pause);
    const Duration asked = kernel_.now;
    const int number = next(camera);
    ASSERT_GT(number, 0);
    EXPECT_GE(kernel_.exposed.at(number), asked);
  }
}

TEST_F(V4l2CameraTest, damaged_short_and_failed_frames_are_passed_over) {
  V4l2Camera camera = open();
  kernel_.is_damaged = [](int number) { return number < 5; };
  kernel_.is_failed = [](int number) { return number >= 5 && number < 10; };
  const auto whole = kernel_.paint;
  kernel_.paint = [whole](int number, const v4l2_pix_format& format) {
    auto bytes = whole(number, format);
    if (number < 15) bytes.resize(number == 14 ? 0 : bytes.size() - 1);
    return bytes;
  };
  EXPECT_EQ(next(camera), 15);
}

TEST_F(V4l2CameraTest, row_padding_is_told_and_may_be_missing_behind_the_last_row) {
  kernel_.padding = 64;
  kernel_.paint = [](int number, const v4l2_pix_format& format) {
    return std::vector<std::uint8_t>(std::size_t{format.bytesperline} * format.height - 64,
                                     static_cast<std::uint8_t>(number));
  };
  V4l2Camera camera = open();
  const auto frame = camera.next(kernel_.now, kernel_.now + 1s, {});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->stride, 2U * 640 + 64);
  EXPECT_EQ(frame->bytes.size(), (2U * 640 + 64) * 480 - 64);
}

TEST_F(V4l2CameraTest, range_of_luma_is_what_the_driver_says) {
  const auto is_full = [&](std::uint32_t quantization, std::uint32_t colorspace,
                           std::uint32_t code) {
    kernel_.quantization = quantization;
    kernel_.colorspace = colorspace;
    kernel_.formats[0].code = code;
    V4l2Camera camera = open();
    return camera.next(kernel_.now, kernel_.now + 1s, {})->is_full_range;
  };
  EXPECT_FALSE(is_full(V4L2_QUANTIZATION_DEFAULT, V4L2_COLORSPACE_SRGB, V4L2_PIX_FMT_YUYV));
  EXPECT_TRUE(is_full(V4L2_QUANTIZATION_DEFAULT, V4L2_COLORSPACE_JPEG, V4L2_PIX_FMT_YUYV));
  EXPECT_TRUE(is_full(V4L2_QUANTIZATION_FULL_RANGE, V4L2_COLORSPACE_SRGB, V4L2_PIX_FMT_YUYV));
  EXPECT_FALSE(is_full(V4L2_QUANTIZATION_LIM_RANGE, V4L2_COLORSPACE_JPEG, V4L2_PIX_FMT_YUYV));
  EXPECT_TRUE(is_full(V4L2_QUANTIZATION_DEFAULT, V4L2_COLORSPACE_SRGB, V4L2_PIX_FMT_GREY));
}

TEST_F(V4l2CameraTest, format_size_and_rate_are_chosen_and_set) {
  kernel_.formats = {{V4L2_PIX_FMT_H264, {{1920, 1080, {{1, 60}}}}},
                     {V4L2_PIX_FMT_YUYV, {{640, 480, {{1, 30}, {1, 15}}}, {1280, 720, {{1, 5}}}}},
                     {V4L2_PIX_FMT_MJPEG, {{1280, 720, {{1, 30}, {1, 15}}}}}};
  EXPECT_EQ(open().mode(), (VideoMode{VideoFormat::kMjpg, 1280, 720, 30}));
  EXPECT_EQ(open({1280, 720, 5}).mode(), (VideoMode{VideoFormat::kYuyv, 1280, 720, 5}));
  EXPECT_EQ(open({640, 480, 15}).mode(), (VideoMode{VideoFormat::kYuyv, 640, 480, 30}));
  EXPECT_EQ(kernel_.interval.denominator, 15U);
  EXPECT_EQ(sentence_of(kernel_, {800, 600, 0}),
            "/dev/video0: no pictures of 800 x 600 pixels; it has 640 x 480, 1280 x 720. "
            "Calibrate it again in one of these sizes");
}

TEST_F(V4l2CameraTest, drivers_that_list_no_sizes_are_asked_for_the_wanted_one) {
  kernel_.lists_sizes = false;
  EXPECT_EQ(open({640, 480, 0}).mode(), (VideoMode{VideoFormat::kYuyv, 640, 480, 30}));
  EXPECT_EQ(open().mode(), (VideoMode{VideoFormat::kYuyv, 640, 480, 30}));
  EXPECT_NE(sentence_of(kernel_, {1280, 720, 0}).find("it has 640 x 480"), std::string::npos);
}

TEST_F(V4l2CameraTest, unplugged_camera_is_gone_at_once_and_leaves_nothing_open) {
  {
    V4l2Camera camera = open();
    EXPECT_GT(next(camera), 0);
    kernel_.on_frame = [&](int number) {
      if (number == 10) kernel_.unplug();
    };
    const Duration asked = kernel_.now;
    int number = 0;
    while ((number = next(camera)) > 0) {
    }
    EXPECT_EQ(number, -2);
    EXPECT_LT(kernel_.now - asked, 1s);
    EXPECT_EQ(next(camera), -2) << "and stays so";
  }
  EXPECT_EQ(kernel_.open_count, 0);
  EXPECT_EQ(kernel_.mapped_count, 0);
}

TEST_F(V4l2CameraTest, silent_camera_is_waited_for_and_one_that_only_fails_is_gone) {
  V4l2Camera camera = open();
  kernel_.is_silent = true;
  const Duration asked = kernel_.now;
  EXPECT_EQ(next(camera, 2s), -1);
  EXPECT_NEAR(to_seconds(kernel_.now - asked), 2, 0.1);
  kernel_.is_silent = false;
  kernel_.is_failed = [](int) { return true; };
  EXPECT_EQ(next(camera), -2);
}

TEST_F(V4l2CameraTest, end_of_the_run_ends_a_wait) {
  V4l2Camera camera = open();
  std::stop_source end;
  end.request_stop();
  EXPECT_EQ(number_of(camera.next(kernel_.now, kernel_.now + 5s, end.get_token())), -1);
  EXPECT_FALSE(camera.settle(end.get_token()));
}

TEST_F(V4l2CameraTest, automatics_choose_and_are_kept) {
  kernel_.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, 100},
                      {V4L2_CID_AUTO_WHITE_BALANCE, 0},
                      {V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4000},
                      {V4L2_CID_FOCUS_AUTO, 0},
                      {V4L2_CID_FOCUS_ABSOLUTE, 0}};
  V4l2Camera camera = open();
  kernel_.on_frame = [&](int number) {  // what the camera itself does
    auto& controls = kernel_.controls;
    const bool is_auto = controls[V4L2_CID_EXPOSURE_AUTO] == V4L2_EXPOSURE_APERTURE_PRIORITY &&
                         controls[V4L2_CID_AUTO_WHITE_BALANCE] == 1 &&
                         controls[V4L2_CID_FOCUS_AUTO] == 1;
    if (!is_auto) return;
    controls[V4L2_CID_EXPOSURE_ABSOLUTE] = 100 + number;
    controls[V4L2_CID_WHITE_BALANCE_TEMPERATURE] = 4000 + number;
    controls[V4L2_CID_FOCUS_ABSOLUTE] = number;
  };
  const Duration begun = kernel_.now;
  const auto chosen = camera.settle({});
  ASSERT_TRUE(chosen);
  EXPECT_LE(kernel_.now - begun, 1s);
  EXPECT_GE(kernel_.now - begun, 600ms) << "20 frames";
  const std::vector<VideoControl> expected{{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
                                           {V4L2_CID_AUTO_WHITE_BALANCE, 0},
                                           {V4L2_CID_FOCUS_AUTO, 0},
                                           {V4L2_CID_EXPOSURE_ABSOLUTE, 120},
                                           {V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4020},
                                           {V4L2_CID_FOCUS_ABSOLUTE, 20}};
  EXPECT_EQ(*chosen, expected);
  for (const VideoControl& control : expected) {
    EXPECT_EQ(kernel_.controls[control.id], control.value);
  }
  next(camera);
  EXPECT_EQ(kernel_.controls[V4L2_CID_FOCUS_ABSOLUTE], 20);
}

TEST_F(V4l2CameraTest, cameras_without_controls_and_slow_ones_settle_too) {
  kernel_.formats[0].sizes[0].intervals = {{1, 5}};
  V4l2Camera camera = open();
  const Duration begun = kernel_.now;
  const auto chosen = camera.settle({});
  ASSERT_TRUE(chosen);
  EXPECT_TRUE(chosen->empty());
  EXPECT_LE(kernel_.now - begun, 1100ms);
  const Duration asked = kernel_.now;
  const int number = next(camera);
  ASSERT_GT(number, 0);
  EXPECT_GE(kernel_.exposed.at(number), asked);
}

TEST_F(V4l2CameraTest, what_cannot_be_opened_says_what_to_do) {
  const auto opened_with = [&](int error) {
    kernel_.open_error = error;
    std::string sentence = sentence_of(kernel_);
    kernel_.open_error = 0;
    return sentence;
  };
  const std::string busy =
      "/dev/video0: another program is using this camera; close it (fuser -v /dev/video0 shows "
      "which)";
  EXPECT_EQ(opened_with(EBUSY), busy);
  EXPECT_EQ(opened_with(EACCES),
            "/dev/video0: permission denied; the group 'video' may use cameras: sudo adduser "
            "$USER video, then log in again");
  kernel_.unplug();
  EXPECT_EQ(sentence_of(kernel_),
            "/dev/video0: no such file or directory; plug the camera in; v4l2-ctl --list-devices, "
            "or ls /dev/video*, shows the cameras");
  kernel_.plug();
  for (const unsigned long request :
       {static_cast<unsigned long>(VIDIOC_S_FMT), static_cast<unsigned long>(VIDIOC_REQBUFS),
        static_cast<unsigned long>(VIDIOC_STREAMON)}) {
    kernel_.faults = {{request, EBUSY}};
    EXPECT_EQ(sentence_of(kernel_), busy);
  }
  kernel_.faults = {{VIDIOC_STREAMON, ENOSPC}};
  EXPECT_NE(sentence_of(kernel_).find("the USB bus has no room"), std::string::npos);
  kernel_.faults = {{VIDIOC_QBUF, ENODEV}};
  EXPECT_NE(sentence_of(kernel_).find("was unplugged"), std::string::npos);
  EXPECT_EQ(kernel_.open_count, 0);
  EXPECT_EQ(kernel_.mapped_count, 0);
}

TEST_F(V4l2CameraTest, what_is_no_camera_is_refused) {
  kernel_.is_camera = false;
  EXPECT_EQ(sentence_of(kernel_),
            "/dev/video0: is no camera; v4l2-ctl --list-devices, or ls /dev/video*, shows the "
            "cameras");
  kernel_.is_camera = true;
  kernel_.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_NE(sentence_of(kernel_).find("gives no pictures. A camera has several device files"),
            std::string::npos);
  kernel_.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  EXPECT_NE(sentence_of(kernel_).find("in several planes"), std::string::npos);
  kernel_.capabilities = V4L2_CAP_VIDEO_CAPTURE;
  EXPECT_NE(sentence_of(kernel_).find("cannot stream"), std::string::npos);
  kernel_.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  kernel_.formats = {{V4L2_PIX_FMT_H264, {{640, 480, {{1, 30}}}}}};
  EXPECT_NE(sentence_of(kernel_).find("none of the formats MJPG, YUYV and GREY"),
            std::string::npos);
  const auto null = V4l2Camera::open("/dev/null", {});
  ASSERT_FALSE(null);
  EXPECT_EQ(null.error().sentence.find("/dev/null: is no camera"), 0U);
}

}  // namespace
}  // namespace sinew::io
