#include "sinew/runtime/cameras/camera.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sinew/core/error_code.h"
#include "sinew/io/thread_share.h"
#include "sinew/render/silhouette.h"

namespace sinew::runtime {
namespace {

constexpr std::chrono::milliseconds kLookPeriod{100};
constexpr std::chrono::milliseconds kStandPeriod{20};
/// Without a watcher for longer than an arm stands between two moves: things are as they are seen
/// next. Who steps in meanwhile is noticed when the arm moves again.
constexpr std::chrono::seconds kForgets{5};

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

/// Cells that something has to take to count: more than a cube that was pushed.
double least_of(const vision::TableCamera& camera, double edge) {
  constexpr double kCubes = 1.5;
  const vision::CameraModel& model = camera.model;
  const double distance = std::max(0.05, camera.X_WC.p.z);
  const double cell = 1.0 * model.width / vision::grid_of(model.width, model.height).columns;
  const double across = edge * model.fx / (distance * cell);
  return kCubes * across * across;
}

using Stand = std::vector<render::ViewedRobot>;

/// rad or m, of the joint that moved farthest; nothing where other robots are known.
std::optional<double> apart(const Stand& before, const Stand& now) {
  if (before.size() != now.size()) return std::nullopt;
  double far = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (before[i].q.size() != now[i].q.size()) return std::nullopt;
    for (std::size_t j = 0; j < now[i].q.size(); ++j) {
      far = std::max(far, std::abs(now[i].q[j] - before[i].q[j]));
    }
  }
  return far;
}

constexpr double kStandStep = 0.1;  // rad or m, of a joint
constexpr double kFar = 0.8;        // the same

/// The robots all along from stand to stand; nothing where one is not known in all.
std::optional<Stand> all_along(const std::vector<Stand>& stands) {
  constexpr int kStepsMost = 16;
  Stand all = stands.front();
  for (std::size_t n = 1; n < stands.size(); ++n) {
    const Stand& before = stands[n - 1];
    const Stand& now = stands[n];
    const auto far = apart(before, now);
    if (!far) return std::nullopt;
    const int steps = std::min(kStepsMost, static_cast<int>(std::ceil(*far / kStandStep)));
    for (int k = 1; k <= steps; ++k) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        render::ViewedRobot there = now[i];
        for (std::size_t j = 0; j < there.q.size(); ++j) {
          there.q[j] = before[i].q[j] + (now[i].q[j] - before[i].q[j]) * k / steps;
        }
        all.push_back(std::move(there));
      }
    }
  }
  return all;
}

}  // namespace

Camera::Camera(Settings settings, CameraSource source, Watch watch)
    : settings_(std::move(settings)),
      source_(std::move(source)),
      calibration_(settings_.calibration
                       ? std::make_shared<const vision::TableCamera>(*settings_.calibration)
                       : nullptr),
      is_refused_(!settings_.calibration_refused.empty()),
      watch_(std::move(watch)),
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

std::shared_ptr<const vision::TableCamera> Camera::calibration() const {
  const std::scoped_lock lock(mutex_);
  return calibration_;
}

std::string Camera::calibration_refused() const {
  const std::scoped_lock lock(mutex_);
  return is_refused_ ? settings_.calibration_refused : std::string();
}

void Camera::calibrate(const vision::TableCamera& calibration) {
  auto kept = std::make_shared<const vision::TableCamera>(calibration);
  const std::scoped_lock lock(mutex_);
  calibration_ = std::move(kept);
  is_refused_ = false;
}

void Camera::heed(std::shared_ptr<const vision::TableCamera> calibration) {
  if (calibration == heeded_) return;
  heeded_ = std::move(calibration);
  if (heeded_ && watch_.table) X_WT_ = watch_.table(*heeded_);
  // One on an arm leaves its sheet behind, and goes by the arm.
  const bool stays = heeded_ && !watch_.hangs;
  sheet_ = stays ? vision::table_sheet(heeded_->sheet) : std::nullopt;
  if (sheet_ && !tags_) tags_.emplace(std::vector{sheet_->family});
  view_.reset();
  stands_.clear();
  // What a camera on an arm sees changes whenever the arm moves.
  const bool watches = heeded_ && settings_.watch && watch_.robots && !watch_.hangs;
  if (watches) view_.emplace(least_of(*heeded_, settings_.edge));
}

void Camera::work(const std::stop_token& ending) {
  // A program that waits for a picture could wait longer; who comes into view may not.
  io::let_others_go_first(io::Share::kServing);
  std::uint64_t answered = 0;
  Time next_look{};
  std::unique_lock lock(mutex_);
  while (!ending.stop_requested()) {
    const auto called = [&] { return answered != asked_; };
    const auto woken = [&] { return called() || watches_anew_; };
    if (watchers_ == 0) {
      asked_for_.wait(lock, ending, [&] { return woken() || watchers_ > 0; });
    } else {
      while (!ending.stop_requested() && !woken() && std::chrono::steady_clock::now() < next_look) {
        const Time next_stand = view_ ? std::chrono::steady_clock::now() + kStandPeriod : next_look;
        if (asked_for_.wait_until(lock, ending, std::min(next_look, next_stand), woken)) break;
        lock.unlock();
        note_stand();
        lock.lock();
      }
    }
    if (std::exchange(watches_anew_, false)) {
      if (view_) view_->begin_again();
      stands_.clear();
      next_look = {};
    }
    if (ending.stop_requested()) return;
    const bool is_asked = called();
    const bool glances = watchers_ > 0 && std::chrono::steady_clock::now() >= next_look;
    const std::uint64_t number = asked_;
    auto calibration = calibration_;
    lock.unlock();
    heed(std::move(calibration));
    // First: pictures that are asked for again and again would leave no time for it.
    if (glances) {
      const Time began = std::chrono::steady_clock::now();
      const std::chrono::nanoseconds used = io::processor_time();
      if (const auto why = disturbance(ending)) {
        const std::scoped_lock here(mutex_);
        if (!watches_anew_) {  // else a watch began anew during this look
          ++disturbances_;
          last_disturbance_ = why;
        }
      }
      // Never more than a third of a core, however slow it is; waiting for a picture is none.
      const Time rested = std::chrono::steady_clock::now() + 2 * (io::processor_time() - used);
      next_look = std::max(began + kLookPeriod, rested);
    }
    std::shared_ptr<const Shot> kept;
    if (is_asked) {
      answered = number;
      Shot shot = take(ending);
      shot.number = number;
      kept = std::make_shared<const Shot>(std::move(shot));
      if (kept->picture.width > 0) last_ = kept;
    }
    lock.lock();
    if (kept) newest_ = std::move(kept);
  }
}

/// Also between glances: what robots put down or take away meanwhile is expected.
void Camera::note_stand() {
  if (!view_) return;
  Stand now = robots();
  constexpr std::size_t kStandsMost = 64;  // without a picture they would grow
  const auto far = stands_.empty() ? std::nullopt : apart(stands_.back(), now);
  if (far && *far <= kStandStep) return;
  if (stands_.size() == kStandsMost) stands_.pop_back();
  stands_.push_back(std::move(now));
}

/// Something is in view beside the robots that was not there before, or nothing would be noticed.
std::optional<Error> Camera::disturbance(const std::stop_token& ending) {
  constexpr double kMargin = 0.03;  // m: what is held, and how exact a model is
  constexpr int kFrozen = 5;        // a network camera may send one picture twice
  if (!view_) return std::nullopt;
  note_stand();
  auto picture = watch_.glances ? watch_.glances(ending) : source_(ending);
  if (ending.stop_requested()) return std::nullopt;
  if (!picture) return picture.error();
  glances_alike_ = glance_.rgb == picture->rgb ? glances_alike_ + 1 : 0;
  glance_ = *picture;
  if (glances_alike_ >= kFrozen) return Error{ErrorCode::kCameraFrozen};
  const vision::CameraModel& model = heeded_->model;
  const vision::CellGrid grid = vision::grid_of(model.width, model.height);
  if (vision::grid_of(picture->width, picture->height) != grid) return std::nullopt;
  stands_.push_back(robots());
  // Where a robot went far while the picture was taken it may be anywhere in it.
  const bool is_sure = apart(*std::prev(stands_.end(), 2), stands_.back()).value_or(0) < kFar;
  const auto all = is_sure ? all_along(stands_) : std::nullopt;
  if (is_sure) stands_.erase(stands_.begin(), std::prev(stands_.end()));
  std::optional<vision::Pixel> there;
  if (all) {
    there = view_->look(*picture, render::silhouette(*all, model, heeded_->X_WC, kMargin));
  }
  if (!watch_.glances) {
    Shot shot;
    shot.picture = std::move(*picture);
    last_ = std::make_shared<const Shot>(std::move(shot));
  }
  return there ? std::optional(Error{ErrorCode::kViewDisturbed}) : std::nullopt;
}

void Camera::begin_watch(bool anew) {
  {
    const std::scoped_lock lock(mutex_);
    const bool forgets = std::chrono::steady_clock::now() - unwatched_since_ > kForgets;
    if (watchers_ == 0 && (anew || forgets)) watches_anew_ = true;
    ++watchers_;
  }
  asked_for_.notify_one();
}

void Camera::end_watch() {
  const std::scoped_lock lock(mutex_);
  --watchers_;
  unwatched_since_ = std::chrono::steady_clock::now();
}

std::uint64_t Camera::disturbances() const {
  const std::scoped_lock lock(mutex_);
  return disturbances_;
}

std::optional<Error> Camera::disturbed_since(std::uint64_t count) const {
  const std::scoped_lock lock(mutex_);
  return disturbances_ > count ? last_disturbance_ : std::nullopt;
}

std::optional<Pose<frame::World, frame::Camera>> Camera::pose(
    const vision::TableCamera& calibration) const {
  if (watch_.hangs) return watch_.hangs();
  const auto X_TC = relabel<frame::Table, frame::Camera>(calibration.X_WC);
  return watch_.table ? watch_.table(calibration) * X_TC
                      : relabel<frame::World, frame::Camera>(X_TC);
}

std::vector<render::ViewedRobot> Camera::robots() const {
  if (!watch_.robots) return {};
  const auto X_TW = relabel<frame::World, frame::World>(X_WT_.inverse());
  auto all = watch_.robots();
  for (render::ViewedRobot& robot : all) robot.X_WB = X_TW * robot.X_WB;
  return all;
}

Expected<vision::Picture> Camera::at_rest(const std::stop_token& ending,
                                          std::optional<vision::TableCamera>& by,
                                          std::vector<render::ViewedRobot>& stood) {
  constexpr std::chrono::seconds kPatience{1};
  constexpr double kStill = 0.5e-3;  // m at the table
  if (!by || !watch_.hangs) {
    stood = robots();
    return source_(ending);
  }
  const auto X_TW = relabel<frame::World, frame::World>(X_WT_.inverse());
  const Time end = std::chrono::steady_clock::now() + kPatience;
  Error why{ErrorCode::kCameraInMotion};
  do {
    stood = robots();
    const auto before = watch_.hangs();
    auto picture = source_(ending);
    const auto after = watch_.hangs();
    if (!picture) return picture;
    if (!before || !after) {
      why = Error{ErrorCode::kPositionUnknown};
      continue;
    }
    by->X_WC = X_TW * *after;
    const double turned = angle_between(before->R, after->R) * std::abs(by->X_WC.p.z);
    const double went = norm(after->p - before->p) + turned;
    if (went < kStill) return picture;
    why = Error{ErrorCode::kCameraInMotion, -1, went};
  } while (!ending.stop_requested() && std::chrono::steady_clock::now() < end);
  return std::unexpected(why);
}

Camera::Shot Camera::take(const std::stop_token& ending) {
  Shot shot;
  std::vector<render::ViewedRobot> before;
  auto by = heeded_ ? std::optional(*heeded_) : std::nullopt;
  auto picture = at_rest(ending, by, before);
  if (!picture) {
    shot.fault = picture.error();
    return shot;
  }
  shot.picture = std::move(*picture);
  shot.fault = fault_of(shot.picture);
  if (shot.fault) return shot;
  shot.seen = vision::detect_cubes(shot.picture);
  if (!by) return shot;
  shot.X_WT = X_WT_;
  shot.X_TC = by->X_WC;
  constexpr double kMargin = 4e-3;  // m: how exact a model is, and what is believed of it
  const auto all = all_along({std::move(before), robots()});
  std::vector<bool> hidden;
  if (all) hidden = render::silhouette(*all, by->model, by->X_WC, kMargin);
  vision::place_on_table(shot.seen, shot.picture, *by, settings_.edge, hidden);
  return shot;
}

std::optional<Error> Camera::fault_of(const vision::Picture& picture) {
  if (heeded_) {
    if (const auto changed = size_change(picture, heeded_->model)) return changed;
  }
  if (is_blind(picture)) return Error{ErrorCode::kCameraBlind};
  if (last_ && picture.rgb == last_->picture.rgb) return Error{ErrorCode::kCameraFrozen};
  return sheet_ ? moved(picture) : std::nullopt;
}

std::optional<Error> Camera::moved(const vision::Picture& picture) {
  constexpr double kMayBe = 3e-3;  // m; what a cube is grasped with forgives
  const double limit = std::max(kMayBe, 2 * heeded_->accuracy);
  const auto shift = vision::sheet_shift(*heeded_, *sheet_, tags_->find(picture));
  if (!shift) return Error{ErrorCode::kCameraTagsHidden};
  if (*shift > limit) return Error{ErrorCode::kCameraMoved, -1, *shift, limit};
  return std::nullopt;
}

}  // namespace sinew::runtime
