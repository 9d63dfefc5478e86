#include "sinew/motion/joint_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::motion {

void JointProfile::restart(const AxisState& start) {
  size_ = 0;
  duration_ = 0;
  end_ = start;
  after_ = AfterEnd::kStay;
  starts_.fill(std::numeric_limits<double>::infinity());
}

void JointProfile::append(double jerk, double duration) {
  if (!(duration > 0)) return;
  append(end_, jerk, duration);
  end_ = advanced(end_, jerk, duration);
}

void JointProfile::finish(const AxisState& end, AfterEnd after) {
  end_ = end;
  after_ = after;
}

ProfilePhase JointProfile::phase(std::size_t i) const {
  SINEW_ASSERT(i < size_);
  const auto& [duration, jerk, q, qd, qdd] = pieces_[i];
  return {starts_[i], duration, jerk, {q, qd, qdd}};
}

AxisState JointProfile::arrival() const {
  if (size_ == 0) return end_;
  const auto& [duration, jerk, q, qd, qdd] = pieces_[size_ - 1];
  return advanced({q, qd, qdd}, jerk, duration);
}

std::size_t JointProfile::piece_at(double t) const {
  // Counting all is quicker than a search whose end no branch predictor can guess.
  std::size_t later = 0;
  for (std::size_t i = 1; i < kPhasesMax; ++i) later += t >= starts_[i] ? 1 : 0;
  return later;
}

AxisState JointProfile::at(double t) const {
  if (t >= duration_) {
    if (after_ == AfterEnd::kStay) return end_;
    return {end_.q + end_.qd * (t - duration_), end_.qd, 0};
  }
  const std::size_t i = piece_at(t);
  const auto& [duration, jerk, q, qd, qdd] = pieces_[i];
  return advanced({q, qd, qdd}, jerk, std::max(0.0, t - starts_[i]));
}

double JointProfile::jerk_at(double t) const {
  return t >= 0 && t < duration_ ? pieces_[piece_at(t)].jerk : 0;
}

PositionRange JointProfile::position_range() const {
  PositionRange result{end_.q, end_.q};
  const auto take = [&](double q) {
    result.lower = std::min(result.lower, q);
    result.upper = std::max(result.upper, q);
  };
  for (std::size_t i = 0; i < size_; ++i) {
    const auto& [duration, jerk, q, qd, qdd] = pieces_[i];
    take(q);
    // It turns where qd + qdd t + jerk t^2 / 2 = 0, in the form that loses no digits.
    const double root = qdd * qdd - 2 * jerk * qd;
    if (root < 0) continue;
    const double w = -(qdd + std::copysign(std::sqrt(root), qdd));
    for (const double t : {w / jerk, 2 * qd / w}) {
      if (t > 0 && t < duration) take(advanced({q, qd, qdd}, jerk, t).q);
    }
  }
  return result;
}

VelocityRange JointProfile::velocity_range() const {
  VelocityRange result{end_.qd, end_.qd};
  const auto take = [&](double qd) {
    result.lower = std::min(result.lower, qd);
    result.upper = std::max(result.upper, qd);
  };
  for (std::size_t i = 0; i < size_; ++i) {
    const auto& [duration, jerk, q, qd, qdd] = pieces_[i];
    take(qd);
    const double t = -qdd / jerk;
    if (t > 0 && t < duration) take(advanced({q, qd, qdd}, jerk, t).qd);
  }
  return result;
}

}  // namespace sinew::motion
