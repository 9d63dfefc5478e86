#include "sinew/runtime/camera.h"

#include <algorithm>
#include <utility>

#include "sinew/io/thread_share.h"

namespace sinew::runtime {
namespace {

/// Whether it is as good as one colour: black, covered, or all white. Noise of a covered lens stays
/// below, any table with something on it far above.
bool is_blind(const vision::Picture& picture) {
  constexpr int kParts = 16;
  constexpr int kApart = 12;  // of 255, between the darkest and the brightest part
  const vision::Picture parts = vision::shrunk(picture, kParts);
  int darkest = 255, brightest = 0;
  for (int y = 0; y < parts.height; ++y) {
    for (int x = 0; x < parts.width; ++x) {
      const int green = parts.at(x, y)[1];
      darkest = std::min(darkest, green);
      brightest = std::max(brightest, green);
    }
  }
  return brightest - darkest < kApart;
}

std::optional<Error> size_change(const vision::Picture& picture, const vision::CameraModel& was) {
  const auto changed = [](int now, int before) {
    return Error{ErrorCode::kCameraChanged, -1, 1.0 * now, 1.0 * before};
  };
  if (picture.width != was.width) return changed(picture.width, was.width);
  if (picture.height != was.height) return changed(picture.height, was.height);
  return std::nullopt;
}

}  // namespace

Camera::Camera(Settings settings, CameraSource source)
    : settings_(std::move(settings)),
      source_(std::move(source)),
      sheet_(settings_.calibration ? vision::table_sheet(settings_.calibration->sheet)
                                   : std::nullopt),
      thread_([this](const std::stop_token& ending) { work(ending); }) {}

std::uint64_t Camera::ask() {
  std::uint64_t number = 0;
  {
    const std::scoped_lock lock(mutex_);
    number = ++asked_;
  }
  asked_for_.notify_one();
  return number;
}

void Camera::refresh() {
  {
    const std::scoped_lock lock(mutex_);
    if (asked_ != (newest_ ? newest_->number : 0)) return;
  }
  ask();
}

std::shared_ptr<const Camera::Shot> Camera::newest() const {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

void Camera::work(const std::stop_token& ending) {
  io::let_others_go_first(io::Share::kThinking);
  if (sheet_) tags_.emplace(std::vector{sheet_->family});
  std::uint64_t answered = 0;
  std::unique_lock lock(mutex_);
  while (asked_for_.wait(lock, ending, [&] { return answered != asked_; })) {
    answered = asked_;
    lock.unlock();
    Shot shot = take(ending);
    shot.number = answered;
    auto kept = std::make_shared<const Shot>(std::move(shot));
    if (kept->picture.width > 0) last_ = kept;
    lock.lock();
    newest_ = std::move(kept);
  }
}

Camera::Shot Camera::take(const std::stop_token& ending) {
  Shot shot;
  auto picture = source_(ending);
  if (!picture) {
    shot.fault = picture.error();
    return shot;
  }
  shot.picture = std::move(*picture);
  shot.fault = fault_of(shot.picture);
  if (shot.fault) return shot;
  shot.seen = vision::detect_cubes(shot.picture);
  const auto& calibration = settings_.calibration;
  if (calibration) vision::place_on_table(shot.seen, shot.picture, *calibration, settings_.edge);
  return shot;
}

std::optional<Error> Camera::fault_of(const vision::Picture& picture) {
  const auto& calibration = settings_.calibration;
  if (calibration) {
    if (const auto changed = size_change(picture, calibration->model)) return changed;
  }
  if (is_blind(picture)) return Error{ErrorCode::kCameraBlind};
  if (last_ && picture.rgb == last_->picture.rgb) return Error{ErrorCode::kCameraFrozen};
  return sheet_ ? moved(picture) : std::nullopt;
}

std::optional<Error> Camera::moved(const vision::Picture& picture) {
  constexpr double kMayBe = 3e-3;  // m; what a cube is grasped with forgives
  const double limit = std::max(kMayBe, 2 * settings_.calibration->accuracy);
  const auto shift = vision::sheet_shift(*settings_.calibration, *sheet_, tags_->find(picture));
  if (!shift) return Error{ErrorCode::kCameraTagsHidden};
  if (*shift > limit) return Error{ErrorCode::kCameraMoved, -1, *shift, limit};
  return std::nullopt;
}

}  // namespace sinew::runtime
