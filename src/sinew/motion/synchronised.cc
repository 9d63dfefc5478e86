#include "sinew/motion/synchronised.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/motion/state_to_state.h"
#include "sinew/motion/velocity_change.h"

namespace sinew::motion {

namespace {

constexpr double kRounding = 1e-12;

MotionLimit limit_of(Binding binding) {
  switch (binding) {
    case Binding::kVelocity:
      return MotionLimit::kVelocity;
    case Binding::kAcceleration:
      return MotionLimit::kAcceleration;
    case Binding::kJerk:
      break;
  }
  return MotionLimit::kJerk;
}

/// A second look at what was planned: does it come to its target? What doubles hold of the longest
/// ways is less than what they hold of usual ones.
std::optional<Error> missed(const JointProfile& joint, const AxisState& target,
                            const ProfileBounds& bounds) {
  const double T = joint.duration();
  const double v = bounds.velocity_upper - bounds.velocity_lower;
  const double a = bounds.acceleration_upper - bounds.acceleration_lower;
  const AxisState end = joint.arrival();
  const auto off = [](double x, double wanted, double limit) -> std::optional<Error> {
    const double gap = std::abs(x - wanted);
    if (gap <= limit) return std::nullopt;  // NaN is a miss
    return Error{ErrorCode::kNotConverged, -1, gap, limit};
  };
  if (const auto error = off(end.q, target.q, 1e-8 + 1e-10 * T * (v + a * T))) return error;
  if (const auto error = off(end.qd, target.qd, 1e-8 + 1e-10 * (v + a * T))) return error;
  return off(end.qdd, target.qdd, 1e-8 + 1e-10 * (a + bounds.jerk * T));
}

Error at_joint(Error error, std::size_t joint) {
  error.index = static_cast<std::int8_t>(joint);
  return error;
}

}  // namespace

/// The line along which all joints go, where there is one: each moves by its share of what the
/// leading joint does.
class Line {
 public:
  Line(std::span<const AxisState> start, std::span<const AxisState> target)
      : start_(start), target_(target) {
    for (const auto& component : kComponents) {
      if (!take(component)) return;
    }
    exists_ = true;
  }

  bool exists() const { return exists_; }
  std::size_t leader() const { return leader_; }
  double share(std::size_t i) const { return share_[i]; }

  /// What the leader may do so that all joints keep their bounds; and who is in its way most.
  ProfileBounds bounds(std::span<const ProfileBounds> each) const {
    ProfileBounds result = each[leader_];
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const double share = share_[i];
      if (share == 0) continue;
      const ProfileBounds sided = share > 0 ? each[i] : each[i].mirrored();
      const double k = 1 / std::abs(share);
      result.velocity_lower = std::max(result.velocity_lower, k * sided.velocity_lower);
      result.velocity_upper = std::min(result.velocity_upper, k * sided.velocity_upper);
      result.acceleration_lower = std::max(result.acceleration_lower, k * sided.acceleration_lower);
      result.acceleration_upper = std::min(result.acceleration_upper, k * sided.acceleration_upper);
      result.jerk = std::min(result.jerk, k * sided.jerk);
    }
    return result;
  }

 private:
  using Component = double (*)(const AxisState& start, const AxisState& target);
  static constexpr std::array<Component, 5> kComponents = {
      [](const AxisState& a, const AxisState& b) { return b.q - a.q; },
      [](const AxisState& a, const AxisState&) { return a.qd; },
      [](const AxisState&, const AxisState& b) { return b.qd; },
      [](const AxisState& a, const AxisState&) { return a.qdd; },
      [](const AxisState&, const AxisState& b) { return b.qdd; },
  };

  /// The first component that is not 0 gives the line, the others must lie along it.
  bool take(Component component) {
    std::array<double, kAxesMax> value{};
    double largest = 0;
    std::size_t where = 0;
    for (std::size_t i = 0; i < start_.size(); ++i) {
      value[i] = component(start_[i], target_[i]);
      if (std::abs(value[i]) > largest) {
        largest = std::abs(value[i]);
        where = i;
      }
    }
    if (largest == 0) return true;
    if (!found_) {
      found_ = true;
      leader_ = where;
      for (std::size_t i = 0; i < start_.size(); ++i) share_[i] = value[i] / value[where];
      return true;
    }
    for (std::size_t i = 0; i < start_.size(); ++i) {
      if (std::abs(value[i] - share_[i] * value[leader_]) > kRounding * largest) return false;
    }
    return true;
  }

  std::span<const AxisState> start_;
  std::span<const AxisState> target_;
  std::array<double, kAxesMax> share_{};
  std::size_t leader_ = 0;
  bool found_ = false;
  bool exists_ = false;
};

/// Fills a MotionProfile in place: it is too large to be copied about.
class MotionBuilder {
 public:
  MotionBuilder(MotionProfile& out, std::span<const AxisState> start,
                std::span<const ProfileBounds> bounds)
      : out_(out), start_(start), bounds_(bounds) {
    out_.size_ = start.size();
  }

  void plan(std::span<const AxisState> target, const Line& line, Synchronisation how) {
    if (start_.empty()) return;
    if (how == Synchronisation::kStraight) return follow_line(line, target, solve(line, target));
    std::array<std::optional<StateToState>, kAxesMax> joints;
    for (std::size_t i = 0; i < start_.size(); ++i) {
      joints[i].emplace(start_[i], target[i], bounds_[i]);
    }
    find_common_time(joints);
    if (line.exists()) {
      const Leading leading = solve(line, target);
      if (leading.reach.duration <= out_.duration_ * (1 + kRounding)) {
        return follow_line(line, target, leading);
      }
    }
    for (std::size_t i = 0; i < start_.size(); ++i) {
      joints[i]->profile(out_.duration_, out_.joints_[i]);
    }
  }

  void plan(std::span<const double> velocity) {
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const VelocityChange change(start_[i], velocity[i], bounds_[i]);
      change.profile(out_.joints_[i]);
      const double duration = out_.joints_[i].duration();
      if (duration > out_.duration_) {
        out_.duration_ = duration;
        out_.slowest_ = i;
        out_.limited_by_ = limit_of(change.binding());
      }
    }
  }

 private:
  struct Leading {
    StateToState joint;
    StateToState::Reach reach;
  };

  Leading solve(const Line& line, std::span<const AxisState> target) const {
    const std::size_t i = line.leader();
    const StateToState joint(start_[i], target[i], line.bounds(bounds_));
    return {joint, joint.next(0)};
  }

  /// The shortest time that is possible for all. Each round moves on to the next one that a joint
  /// has; a joint has two blocked intervals at most, so it ends.
  void find_common_time(std::span<const std::optional<StateToState>> joints) {
    std::size_t agreed = 0;
    for (std::size_t i = 0; agreed < start_.size(); i = (i + 1) % start_.size()) {
      const StateToState::Reach reach = joints[i]->next(out_.duration_);
      ++agreed;
      if (reach.duration <= out_.duration_) continue;
      out_.duration_ = reach.duration;
      out_.slowest_ = i;
      out_.limited_by_ = reach.binding ? limit_of(*reach.binding) : MotionLimit::kNone;
      agreed = 1;
    }
  }

  void follow_line(const Line& line, std::span<const AxisState> target, const Leading& leading) {
    const std::size_t leader = line.leader();
    out_.straight_ = true;
    out_.duration_ = leading.reach.duration;
    leading.joint.profile(out_.duration_, out_.joints_[leader]);
    const JointProfile& shape = out_.joints_[leader];
    const auto& binding = leading.reach.binding;
    out_.limited_by_ = binding ? limit_of(*binding) : MotionLimit::kNone;
    out_.slowest_ = tightest(line);
    for (std::size_t i = 0; i < start_.size(); ++i) {
      if (i == leader) continue;
      JointProfile& joint = out_.joints_[i];
      joint.restart(start_[i]);
      for (std::size_t k = 0; k < shape.size(); ++k) {
        const ProfilePhase phase = shape.phase(k);
        joint.append(line.share(i) * phase.jerk, phase.duration);
      }
      joint.finish(target[i]);
    }
  }

  /// The joint whose limit holds the line back.
  std::size_t tightest(const Line& line) const {
    const auto limit = [&](std::size_t i) {
      const ProfileBounds& bounds = bounds_[i];
      if (out_.limited_by_ == MotionLimit::kVelocity) return bounds.velocity_upper;
      if (out_.limited_by_ == MotionLimit::kAcceleration) return bounds.acceleration_upper;
      return bounds.jerk;
    };
    std::size_t result = line.leader();
    for (std::size_t i = 0; i < start_.size(); ++i) {
      if (std::abs(line.share(i)) * limit(result) > std::abs(line.share(result)) * limit(i)) {
        result = i;
      }
    }
    return result;
  }

  MotionProfile& out_;
  std::span<const AxisState> start_;
  std::span<const ProfileBounds> bounds_;
};

// User-provided, so that nothing is filled with zeros first.
MotionProfile::MotionProfile() = default;

void MotionProfile::sample(double t, AxisStates& out) const {
  for (std::size_t i = 0; i < size_; ++i) {
    // Durations of joints differ by rounding; the end is the end for all.
    const JointProfile& joint = joints_[i];
    const AxisState state = joint.at(t >= duration_ ? std::max(t, joint.duration()) : t);
    out.q[i] = state.q;
    out.qd[i] = state.qd;
    out.qdd[i] = state.qdd;
  }
}

Expected<MotionProfile> plan_motion(std::span<const AxisState> start,
                                    std::span<const AxisState> target,
                                    std::span<const ProfileBounds> bounds, Synchronisation how) {
  const std::size_t size = start.size();
  SINEW_ASSERT(size <= kAxesMax && target.size() == size && bounds.size() == size);
  Expected<MotionProfile> result;
  for (std::size_t i = 0; i < size; ++i) {
    auto error = refusal(start[i], bounds[i]);
    if (!error) error = refusal_of_target(target[i], bounds[i]);
    if (error) {
      result = std::unexpected(at_joint(*error, i));
      return result;
    }
  }
  const Line line(start, target);
  if (how == Synchronisation::kStraight && !line.exists()) {
    result = std::unexpected(Error{.code = ErrorCode::kNotStraight});
    return result;
  }
  MotionBuilder(*result, start, bounds).plan(target, line, how);
  for (std::size_t i = 0; i < size; ++i) {
    if (const auto error = missed(result->joint(i), target[i], bounds[i])) {
      result = std::unexpected(at_joint(*error, i));
      return result;
    }
  }
  return result;
}

Expected<MotionProfile> plan_velocity(std::span<const AxisState> start,
                                      std::span<const double> velocity,
                                      std::span<const ProfileBounds> bounds) {
  const std::size_t size = start.size();
  SINEW_ASSERT(size <= kAxesMax && velocity.size() == size && bounds.size() == size);
  Expected<MotionProfile> result;
  for (std::size_t i = 0; i < size; ++i) {
    auto error = refusal(start[i], bounds[i]);
    if (!error) error = refusal_of_target({0, velocity[i], 0}, bounds[i]);
    if (error) {
      result = std::unexpected(at_joint(*error, i));
      return result;
    }
  }
  MotionBuilder(*result, start, bounds).plan(velocity);
  return result;
}

Expected<MotionProfile> plan_stop(std::span<const AxisState> start,
                                  std::span<const ProfileBounds> bounds) {
  constexpr std::array<double, kAxesMax> kRest{};
  SINEW_ASSERT(start.size() <= kAxesMax);
  return plan_velocity(start, std::span(kRest).first(start.size()), bounds);
}

}  // namespace sinew::motion
