#include "sinew/planning/jog/jog_stop.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

using motion::AxisState;
using motion::JointProfile;
using motion::PositionRange;
using motion::VelocityRange;

/// Of a limit or a velocity: what is rounding.
constexpr double kRounding = 1e-9;
/// Of the time to rest: pieces of less are none.
constexpr double kNoTime = 1e-12;
/// Tries for a time between a joint's own and that of all.
constexpr int kTries = 5;

/// A velocity to 0 without acceleration: the acceleration goes from `first` to `held`, stays, and
/// goes to 0, each with steady jerk.
struct Shape {
  double first = 0;
  double held = 0;
  std::array<double, 3> time{};  ///< s

  double duration() const { return time[0] + time[1] + time[2]; }
  double jerk(std::size_t part) const {
    if (part == 1 || !(time[part] > 0)) return 0;
    return part == 0 ? (held - first) / time[0] : -held / time[2];
  }
};

/// Velocity that is left when the acceleration is taken back as quickly as the jerk allows.
double natural_velocity(double qd, double qdd, double jerk) {
  return qd + qdd * std::abs(qdd) / (2 * jerk);
}

Shape with_held(double qd, double qdd, double held, double jerk) {
  Shape shape{qdd, held, {std::abs(held - qdd) / jerk, 0, std::abs(held) / jerk}};
  const double gained = (qdd + held) / 2 * shape.time[0] + held / 2 * shape.time[2];
  if (held != 0) shape.time[1] = std::max(0.0, (-qd - gained) / held);
  return shape;
}

/// As soon as the limits allow.
Shape quickest(double qd, double qdd, double acceleration, double jerk) {
  const double sign = natural_velocity(qd, qdd, jerk) > 0 ? -1 : 1;
  // The peak that is not held: its square is jerk times gain, and half of what there is at first.
  const double peak = std::sqrt(std::max(0.0, -sign * jerk * qd + qdd * qdd / 2));
  return with_held(qd, qdd, sign * std::min(peak, acceleration), jerk);
}

/// In `duration`, at full jerk; held acceleration beyond every limit where that is too short.
Shape lasting(double qd, double qdd, double duration, double jerk) {
  // Upwards by construction: what is left to lose is positive.
  const double natural = natural_velocity(qd, qdd, jerk);
  if (natural < 0) {
    Shape shape = lasting(-qd, -qdd, duration, jerk);
    shape.first = -shape.first;
    shape.held = -shape.held;
    return shape;
  }
  const double left = duration - std::abs(qdd) / jerk;
  double held = left > 0 ? -natural / left : std::min(0.0, qdd) - 1;
  // Beyond both 0 and the acceleration at first the gain is a parabola of what is held.
  if (held < std::min(0.0, qdd)) {
    const double b = jerk * duration - qdd;
    const double c = qdd * qdd / 2 + jerk * qd;
    held = (-b + std::sqrt(std::max(0.0, b * b - 4 * c))) / 2;
  }
  Shape shape{qdd, held, {std::abs(held - qdd) / jerk, 0, std::abs(held) / jerk}};
  shape.time[1] = std::max(0.0, duration - shape.time[0] - shape.time[2]);
  return shape;
}

/// Both at once: `share` of one and all of the other.
void add_up(const AxisState& start, const Shape& main, double share, const Shape& own,
            JointProfile& out) {
  out.restart(start);
  std::array<const Shape*, 2> shapes{&main, &own};
  std::array<std::size_t, 2> part{};
  std::array<double, 2> left{main.time[0], own.time[0]};
  const double nothing = kNoTime * std::max(main.duration(), own.duration());
  for (;;) {
    double time = -1;
    for (std::size_t k = 0; k < 2; ++k) {
      while (part[k] < 3 && left[k] <= nothing) {
        if (++part[k] < 3) left[k] = shapes[k]->time[part[k]];
      }
      if (part[k] < 3 && (time < 0 || left[k] < time)) time = left[k];
    }
    if (time < 0) break;
    const double jerk =
        (part[0] < 3 ? share * main.jerk(part[0]) : 0) + (part[1] < 3 ? own.jerk(part[1]) : 0);
    out.append(jerk, time);
    for (double& some : left) some -= time;
  }
  out.finish({out.arrival().q, 0, 0});
}

/// What a joint's way to rest is held against.
struct Bounds {
  motion::AxisLimits limits;
  PositionRange range;
  VelocityRange velocity;
};

bool keeps(const JointProfile& way, const AxisState& start, const Bounds& bounds) {
  const auto& [velocity, acceleration, jerk] = bounds.limits;
  for (std::size_t k = 0; k < way.size(); ++k) {
    const motion::ProfilePhase phase = way.phase(k);
    if (std::abs(phase.jerk) > jerk * (1 + kRounding)) return false;
    if (std::abs(phase.state.qdd) > acceleration * (1 + kRounding)) return false;
  }
  const AxisState end = way.arrival();
  if (std::abs(end.qd) > kRounding * velocity || std::abs(end.qdd) > kRounding * acceleration) {
    return false;
  }
  const VelocityRange speeds = way.velocity_range();
  const PositionRange passed = way.position_range();
  const double slack = kRounding * std::abs(start.qd) + 1e-12 * velocity;
  return speeds.lower >= bounds.velocity.lower - slack &&
         speeds.upper <= bounds.velocity.upper + slack && passed.lower >= bounds.range.lower &&
         passed.upper <= bounds.range.upper;
}

/// Along the slowest one's way, with what acceleration there is beside that lost meanwhile.
bool go_along(const AxisState& start, double share, const Shape& main, double main_jerk,
              const Bounds& bounds, JointProfile& out) {
  const double beside = start.qdd - share * main.first;
  const double jerk = bounds.limits.jerk - std::abs(share) * main_jerk;
  Shape own;
  if (std::abs(beside) > kRounding * bounds.limits.acceleration) {
    if (!(jerk > kRounding * bounds.limits.jerk)) return false;
    own = quickest(0, beside, bounds.limits.acceleration, jerk);
    if (own.duration() > main.duration()) return false;
  }
  add_up(start, main, share, own, out);
  return keeps(out, start, bounds);
}

}  // namespace

void JogStop::plan(std::span<const JogJoint> joints, std::span<const AxisState> states) {
  std::array<Shape, kMaxJoints> quick;
  std::size_t slowest = 0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto& [velocity, acceleration, jerk] = joints[j].limits();
    quick[j] = quickest(states[j].qd, states[j].qdd, acceleration, jerk);
    if (quick[j].duration() > quick[slowest].duration()) slowest = j;
  }
  const Shape& main = quick[slowest];
  duration_ = main.duration();
  const double main_qd = states[slowest].qd;
  const double main_jerk = joints[slowest].limits().jerk;
  add_up(states[slowest], main, 1, {}, joints_[slowest]);
  const VelocityRange main_speeds = joints_[slowest].velocity_range();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const AxisState& start = states[j];
    JointProfile& way = joints_[j];
    if (j == slowest) continue;
    add_up(start, quick[j], 1, {}, way);
    if (quick[j].duration() == 0 || duration_ - quick[j].duration() < kRounding * duration_) {
      continue;
    }
    const Bounds bounds{joints[j].limits(), joints[j].range_from(start), way.velocity_range()};
    const double share = main_qd != 0 ? start.qd / main_qd : 0;
    // No faster than it will be anyway, or in its share of what the slowest one will be.
    const double main_peak = main_qd > 0 ? main_speeds.upper : main_speeds.lower;
    const double peak =
        std::clamp(share * main_peak, -bounds.limits.velocity, bounds.limits.velocity);
    Bounds along = bounds;
    along.velocity.lower = std::min(along.velocity.lower, peak);
    along.velocity.upper = std::max(along.velocity.upper, peak);
    if (share != 0 && go_along(start, share, main, main_jerk, along, way)) continue;
    const double least = quick[j].duration();
    double time = duration_;
    bool found = false;
    for (int tries = 0; tries < kTries && !found; ++tries) {
      add_up(start, lasting(start.qd, start.qdd, time, bounds.limits.jerk), 1, {}, way);
      found = keeps(way, start, bounds);
      time = (least + time) / 2;
    }
    if (!found) add_up(start, quick[j], 1, {}, way);
  }
}

}  // namespace sinew::planning
