#include "sinew/runtime/cameras/v4l2_pictures.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/io/v4l2_camera.h"
#include "sinew/vision/camera_jpeg.h"
#include "sinew/vision/raw_frame.h"

namespace sinew::runtime {
namespace {

constexpr int kBetweenOpensMs = 100;
/// So long new settings take until frames show them.
constexpr Duration kSettingsDelay = std::chrono::milliseconds(150);

std::expected<vision::Picture, std::string> picture_of(const io::VideoFrame& frame) {
  const vision::FrameLayout layout{
      frame.mode.width, frame.mode.height, frame.stride,
      frame.is_full_range ? vision::LumaRange::kFull : vision::LumaRange::kLimited};
  switch (frame.mode.format) {
    case io::VideoFormat::kYuyv:
      return vision::picture_from_yuyv(frame.bytes, layout);
    case io::VideoFormat::kGrey:
      return vision::picture_from_grey(frame.bytes, layout);
    case io::VideoFormat::kMjpg:
      break;
  }
  return vision::decode_camera_jpeg(frame.bytes);
}

/// One camera at this computer, for one thread.
class V4l2Pictures {
 public:
  V4l2Pictures(std::string device, const io::VideoWanted& wanted, const io::V4l2Calls& calls)
      : device_(std::move(device)), wanted_(wanted), calls_(calls) {}

  std::expected<void, std::string> open();
  Expected<vision::Picture> next(const std::stop_token& ending);

 private:
  bool make_ready(Duration until, const std::stop_token& ending);

  std::string device_;
  io::VideoWanted wanted_;
  io::V4l2Calls calls_;
  std::optional<io::V4l2Camera> camera_;
  bool is_settled_ = false;  ///< as opened now
  std::optional<std::vector<io::VideoControl>> kept_;
  Duration settings_shown_{};  ///< when frames show what was kept; CLOCK_MONOTONIC
};

std::expected<void, std::string> V4l2Pictures::open() {
  camera_.reset();
  is_settled_ = false;
  auto camera = io::V4l2Camera::open(device_, wanted_, calls_);
  if (!camera) return std::unexpected(camera.error().sentence);
  camera_ = std::move(*camera);
  return {};
}

/// Opens the camera where it is not, and sets what is to be kept.
bool V4l2Pictures::make_ready(Duration until, const std::stop_token& ending) {
  while (!camera_ && !open()) {
    if (ending.stop_requested() || calls_.now() >= until) return false;
    calls_.poll(nullptr, kBetweenOpensMs);
  }
  if (is_settled_) return true;
  if (kept_) {
    camera_->keep(*kept_);
  } else {
    auto chosen = camera_->settle(ending);
    if (!chosen) {
      if (chosen.error() == io::VideoLoss::kGone) camera_.reset();
      return false;
    }
    kept_ = std::move(*chosen);
  }
  is_settled_ = true;
  settings_shown_ = calls_.now() + kSettingsDelay;
  return true;
}

Expected<vision::Picture> V4l2Pictures::next(const std::stop_token& ending) {
  const Duration begun = calls_.now();
  const Duration until = begun + kPicturePatience;
  while (make_ready(until, ending)) {
    const auto frame = camera_->next(std::max(begun, settings_shown_), until, ending);
    if (!frame) {
      // Also where it is there and silent: some drivers begin again only when they are opened anew.
      if (!ending.stop_requested()) camera_.reset();
      break;
    }
    if (auto picture = picture_of(*frame)) return std::move(*picture);
  }
  return std::unexpected(Error{ErrorCode::kCameraLost, -1, to_seconds(calls_.now() - begun)});
}

}  // namespace

std::expected<CameraSource, std::string> v4l2_pictures(const std::string& device,
                                                       const io::VideoWanted& wanted,
                                                       const io::V4l2Calls& calls) {
  auto camera = std::make_shared<V4l2Pictures>(device, wanted, calls);
  if (auto opened = camera->open(); !opened) return std::unexpected(opened.error());
  return [camera](const std::stop_token& ending) { return camera->next(ending); };
}

}  // namespace sinew::runtime
