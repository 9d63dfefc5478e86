#include "sinew/planning/timing/path_follower.h"

#include <algorithm>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew::planning {
namespace {

std::optional<Error> feed_error(double feed) {
  if (feed >= 0 && feed <= PathFollower::kFeedMax) return {};
  return Error{ErrorCode::kMoveInput, -1, feed, feed < 0 ? 0 : PathFollower::kFeedMax};
}

double feed_that_counts(double feed) {
  return feed < PathFollower::kFeedMin ? 0 : feed;
}

}  // namespace

PathFollower::PathFollower(std::size_t cells_max)
    : timing_(cells_max), law_(timing_.phases_max()), next_(timing_.phases_max()) {}

std::optional<Error> PathFollower::start(const PlannedPath& path,
                                         std::span<const motion::AxisLimits> limits, double feed,
                                         double shared_velocity, double time) {
  if (const auto error = feed_error(feed)) return error;
  path_ = nullptr;
  if (const auto error =
          timing_.prepare(path, limits, kFeedMax, LawUse::kChangeable, shared_velocity)) {
    return error;
  }
  path_ = &path;
  state_ = {};
  law_.clear();
  t_ = 0;
  piece_ = 0;
  paused_ = stopped_ = waits_ = false;
  pace_ = 1;
  const auto untimely = time > 0 ? find_pace(time) : std::nullopt;
  if (untimely) {
    path_ = nullptr;
    return untimely;
  }
  feed_ = feed_that_counts(feed);
  if (feed_ > 0) {
    if (const auto error = try_plan(false)) {
      path_ = nullptr;
      return error;
    }
  }
  step(0);
  return {};
}

const JointMotion& PathFollower::step(double dt) {
  SINEW_ASSERT(path_ != nullptr && dt >= 0);
  t_ += dt;
  state_ = law_.sample(t_);
  if (waits_) replan();
  sample_motion(*path_, state_, law_.jerk(t_), piece_, now_);
  return now_;
}

bool PathFollower::look_ahead(double dt, JointMotion& out) const {
  SINEW_ASSERT(path_ != nullptr && dt >= 0);
  const PathState state = law_.sample(t_ + dt);
  std::size_t piece = piece_;
  sample_motion(*path_, state, law_.jerk(t_ + dt), piece, out);
  return !waits_ && state.v == 0 && state.a == 0 && t_ + dt >= law_.duration();
}

PathProgress PathFollower::progress() const {
  return path_ == nullptr ? PathProgress{} : Trajectory::progress_at(*path_, state_.s);
}

std::optional<Error> PathFollower::try_plan(bool rest) {
  if (!rest) return try_feed(std::max(kFeedMin, feed_ * pace_));
  return begin_next(timing_.stop(law_, t_, next_));
}

std::optional<Error> PathFollower::try_feed(double feed) {
  return begin_next(timing_.plan(state_, feed, next_));
}

/// The law that was planned counts from now on.
std::optional<Error> PathFollower::begin_next(const std::optional<Error>& error) {
  if (error) return error;
  std::swap(law_, next_);
  t_ = 0;
  return {};
}

/// Speeds are scaled and accelerations stay, so that a pause is as short as ever.
std::optional<Error> PathFollower::find_pace(double time) {
  double slow = kFeedMin, quick = 1;
  for (const double pace : {slow, quick}) {
    if (const auto error = timing_.plan({}, pace, next_)) return error;
    const double own = next_.duration();
    const bool fits = pace == slow ? time <= own : time > own - kTimeTolerance;
    if (!fits) return Error{ErrorCode::kSegmentTime, -1, time, own};
  }
  for (double own = next_.duration(); time - own > kTimeTolerance && quick - slow > 1e-12;) {
    const double middle = (slow + quick) / 2;
    if (const auto error = timing_.plan({}, middle, next_)) return error;
    const bool in_time = next_.duration() <= time;
    (in_time ? quick : slow) = middle;
    if (in_time) own = next_.duration();
  }
  pace_ = quick;
  return std::nullopt;
}

/// Next to the end no law may lead on from a rest: a slower one may, and what is nearer is there.
void PathFollower::creep() {
  constexpr double kThere = 1 - 1e-6;
  const double length = path_->joints.length();
  for (double feed = feed_ * pace_ / 2; feed > kFeedMin; feed /= 2) {
    waits_ = try_feed(feed).has_value();
    if (!waits_ && law_.size() > 0) return;
  }
  if (state_.s < kThere * length) return;
  state_.s = length;
  waits_ = try_plan(false).has_value();
}

void PathFollower::replan() {
  const bool rest = paused_ || stopped_ || !(feed_ > 0);
  const bool brakes = std::exchange(waits_, try_plan(rest).has_value());
  const bool stands = state_.v == 0 && state_.a == 0 && (waits_ || law_.size() == 0);
  if (!rest && stands) creep();
  if (waits_ && !brakes) static_cast<void>(try_plan(true));
}

std::optional<Error> PathFollower::set_feed(double feed) {
  if (const auto error = feed_error(feed)) return error;
  feed = feed_that_counts(feed);
  const double before = std::exchange(feed_, feed);
  if (path_ != nullptr && !stopped_ && !paused_ && feed != before) replan();
  return {};
}

void PathFollower::pause() {
  if (path_ == nullptr || paused_ || stopped_) return;
  paused_ = true;
  replan();
}

void PathFollower::resume() {
  if (path_ == nullptr || !paused_ || stopped_) return;
  paused_ = false;
  replan();
}

void PathFollower::stop() {
  if (path_ == nullptr || stopped_) return;
  stopped_ = true;
  if (!paused_ || waits_) replan();
}

bool PathFollower::at_rest() const {
  return path_ == nullptr || (!waits_ && state_.v == 0 && state_.a == 0 && t_ >= law_.duration()) ||
         law_.size() == 0;
}

bool PathFollower::finished() const {
  return path_ != nullptr && at_rest() && state_.s >= path_->joints.length();
}

double PathFollower::time_left() const {
  return std::max(0.0, law_.duration() - t_);
}

}  // namespace sinew::planning
