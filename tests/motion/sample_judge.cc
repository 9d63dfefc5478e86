#include "motion/sample_judge.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "sinew/motion/online_profile.h"

namespace sinew::planning {
namespace {

constexpr double kRounding = 1e-9;             // of a limit
constexpr double kPositionRounding = 1e-9;     // rad or m
constexpr double kContinuityRounding = 1e-12;  // rad or m, and of a limit

std::string complaint(std::size_t joint, const char* what, double measured, double limit) {
  std::ostringstream out;
  out << 'J' << joint + 1 << ": " << what << ' ' << std::setprecision(17) << measured
      << ", at most " << limit << ", is " << measured / limit << " of it";
  return out.str();
}

}  // namespace

SampleJudge::SampleJudge(const RobotModel& model, MotionSums& sums)
    : model_(model),
      sums_(sums),
      joints_(model.joints.size()),
      share_(model.device.capability.limits_share) {}

void SampleJudge::begin(const JointMotion& at) {
  last_ = at;
  for (std::size_t j = 0; j < joints_; ++j) {
    lower_[j] = std::min(model_.joints[j].lower, at.q[j]);
    upper_[j] = std::max(model_.joints[j].upper, at.q[j]);
  }
}

bool SampleJudge::rests() const {
  for (std::size_t j = 0; j < joints_; ++j) {
    if (last_.qd[j] != 0 || last_.qdd[j] != 0) return false;
  }
  return true;
}

/// What stood outside may be as far out until it can come to rest inside: then its limits hold.
void SampleJudge::come_back(std::size_t j, const JointMotion& now) {
  const Joint& joint = model_.joints[j];
  const motion::AxisLimits limits{share_ * joint.velocity_max, share_ * joint.acceleration_max,
                                  share_ * joint.jerk_max};
  const motion::ProfileBounds bounds(limits);
  const motion::PositionRange passed =
      motion::OnlineProfile::stop({now.q[j], now.qd[j], now.qdd[j]}, bounds).range();
  if (passed.upper <= joint.upper) upper_[j] = joint.upper;
  if (passed.lower >= joint.lower) lower_[j] = joint.lower;
}

std::string SampleJudge::judge_limits(std::size_t j, const JointMotion& now) {
  const Joint& joint = model_.joints[j];
  if (!std::isfinite(now.q[j]) || !std::isfinite(now.qd[j]) || !std::isfinite(now.qdd[j])) {
    return complaint(j, "no number", now.q[j], joint.upper);
  }
  const double beyond = std::max(now.q[j] - upper_[j], lower_[j] - now.q[j]);
  sums_.beyond = std::max(sums_.beyond, beyond);
  if (beyond > kPositionRounding) {
    return complaint(j, "position", now.q[j], now.q[j] > upper_[j] ? upper_[j] : lower_[j]);
  }
  if (upper_[j] > joint.upper || lower_[j] < joint.lower) come_back(j, now);
  const double velocity = std::abs(now.qd[j]) / (share_ * joint.velocity_max);
  const double acceleration = std::abs(now.qdd[j]) / (share_ * joint.acceleration_max);
  sums_.velocity = std::max(sums_.velocity, velocity);
  sums_.acceleration = std::max(sums_.acceleration, acceleration);
  if (velocity > 1 + kRounding) {
    return complaint(j, "velocity", std::abs(now.qd[j]), share_ * joint.velocity_max);
  }
  if (acceleration > 1 + kRounding) {
    return complaint(j, "acceleration", std::abs(now.qdd[j]), share_ * joint.acceleration_max);
  }
  return {};
}

std::string SampleJudge::judge_change(std::size_t j, const JointMotion& now, double dt) {
  const Joint& joint = model_.joints[j];
  const double jerk = share_ * joint.jerk_max;
  const double noise = kRounding * share_ * joint.acceleration_max;
  const double change = std::abs(now.qdd[j] - last_.qdd[j]);
  if (dt > 0) sums_.jerk = std::max(sums_.jerk, (change - noise) / (jerk * dt));
  if (change > jerk * dt * (1 + kRounding) + noise) {
    return complaint(j, "change of acceleration", change, jerk * dt);
  }
  const double qd = last_.qd[j] + dt * last_.qdd[j];
  const double qd_off = std::abs(now.qd[j] - qd);
  const double qd_room = jerk * dt * dt / 2 * (1 + kRounding) + noise * dt +
                         kContinuityRounding * share_ * joint.velocity_max;
  if (qd_off > qd_room) return complaint(j, "change of velocity", qd_off, qd_room);
  const double q = last_.q[j] + dt * (last_.qd[j] + dt / 2 * last_.qdd[j]);
  const double q_off = std::abs(now.q[j] - q);
  const double q_room = jerk * dt * dt * dt / 6 * (1 + kRounding) + noise * dt * dt +
                        kContinuityRounding * (1 + std::abs(q));
  if (q_off > q_room) return complaint(j, "change of position", q_off, q_room);
  return {};
}

std::string SampleJudge::judge(const JointMotion& now, double dt) {
  ++sums_.samples;
  for (std::size_t j = 0; j < joints_; ++j) {
    std::string wrong = judge_limits(j, now);
    if (wrong.empty()) wrong = judge_change(j, now, dt);
    if (!wrong.empty()) return wrong;
  }
  last_ = now;
  return {};
}

}  // namespace sinew::planning
