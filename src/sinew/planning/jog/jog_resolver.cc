#include "sinew/planning/jog/jog_resolver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/motion/velocity_change.h"

namespace sinew::planning {
namespace {

/// A direction is left out where that costs at least this part of what is asked for.
constexpr double kLostShare = 0.001;
/// How quickly (per rad, scaled) a singular value has to grow along a way for it to lead out.
constexpr double kWayOut = 0.02;
/// Share of a joint's speed that the way out of a singularity takes.
constexpr double kWayOutSpeed = 0.3;
/// Share of its acceleration and jerk.
constexpr double kWayOutPush = 0.3;
/// Singular values from which on nothing has to be slowed down for a singularity yet.
constexpr double kFar = 0.2;
/// Share of the joints' acceleration and jerk that braking before a singularity counts on: the
/// directions themselves turn on the way there, which takes the most of them.
constexpr double kSingularShare = 0.2;
/// rad, over which the change of the Jacobian is tried out.
constexpr double kTry = 1e-5;
/// Below this a singular value is none: which joints belong to it is rounding.
constexpr double kFree = 1e-6;
/// A part of a task that is not worth a look.
constexpr double kNothing = 1e-3;

template <std::size_t N>
double product(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < N; ++k) sum += a[k] * b[k];
  return sum;
}

template <std::size_t N>
void add(std::array<double, N>& a, double share, const std::array<double, N>& b) {
  for (std::size_t k = 0; k < N; ++k) a[k] += share * b[k];
}

}  // namespace

JogResolver::JogResolver(const JogSpace& space, std::span<const JogJoint> joints)
    : space_(&space), joints_(joints), walls_(space, joints) {}

void JogResolver::look_at_caps(const JointArray& q) {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    cap_lower_[j] = -joints_[j].approach_speed(q[j], false, kShare);
    cap_upper_[j] = joints_[j].approach_speed(q[j], true, kShare);
  }
}

void JogResolver::forget() {
  for (TaskSolver& solver : solvers_) solver = TaskSolver();
  holds_ = 0;
  held_ = 0;
  fixed_ = {};
  escape_ = {};
  escapes_ = false;
}

bool JogResolver::look(JogFrame frame, const JointArray& q, const TaskArray& task, PoseBT& X_BT) {
  frame_ = frame;
  q_ = q;
  look_at_caps(q);
  if (space_->tool().hexapod() != nullptr) {
    const auto X = space_->place(q, X_BT);
    if (!X) return false;
    X_BT = *X;
    walls_.look(frame, X_BT, cap_lower_, cap_upper_);
    return true;
  }
  X_BT = space_->look(frame, q, J_);
  Vec3 away;
  room_to_axis_ = space_->room_to_axis(X_BT, away);
  if (room_to_axis_ < kInfinity) {
    if (frame == JogFrame::kTool) away = transposed_times(X_BT.R, away);
    away_ = {away.x, away.y, away.z, 0, 0, 0};
  }
  hold(task);
  return true;
}

/// Singular values fall as the joints go on along their directions; towards 0 they may only go so
/// fast that they can still stop there: behind it the tool would come back.
void JogResolver::look_for_singularities() {
  const bool turns = space_->tool().task() != TaskSpace::kPoint;
  const double share = turns ? kSingularShare : kShare;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double value = solver().singular_value(k);
    if (value >= kFar || value <= kFree) continue;
    JointArray d{};
    add(d, 1 / value, solver().joints_along(k));
    JointArray q = q_;
    add(q, kTry, d);
    TaskJacobian J;
    space_->look(frame_, q, J);
    TaskArray change = J.times(d);
    add(change, -1, J_.times(d));
    const double growth = product(change, solver().direction(k)) / kTry;
    motion::AxisLimits along{kInfinity, kInfinity, kInfinity};
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const double part = std::abs(d[j]);
      along.acceleration = std::min(along.acceleration, joints_[j].limits().acceleration / part);
      along.jerk = std::min(along.jerk, joints_[j].limits().jerk / part);
    }
    const double way = value / std::max(std::abs(growth), kWayOut);
    const JogJoint path(along, {0, way});
    const double most = path.approach_speed(0, true, share);
    if (growth < 0) solvers_[holds_].limit(k, -kInfinity, most);
    if (growth > 0) solvers_[holds_].limit(k, -most, kInfinity);
  }
}

bool JogResolver::in_the_way(const TaskArray& task) const {
  if (space_->tool().hexapod() != nullptr) return walls_.hit(task).any;
  return held_ != 0 || solver().limited(rest_of(task));
}

/// Joints that would be too fast towards their limit, one by one, the worst first: each is held at
/// what it may do, and the others are asked for the rest.
void JogResolver::hold(const TaskArray& task) {
  held_ = 0;
  holds_ = 0;
  fixed_ = {};
  for (;; ++holds_) {
    solvers_[holds_].factor(J_, held_);
    look_for_singularities();
    const JointArray u = solver().solve(rest_of(task));
    std::size_t worst = joints_.size();
    double most = 1e-9;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if ((held_ >> j & 1U) != 0) continue;
      const double beyond = std::max(u[j] - cap_upper_[j], cap_lower_[j] - u[j]);
      if (!(beyond > most * joints_[j].limits().velocity)) continue;
      most = beyond / joints_[j].limits().velocity;
      worst = j;
    }
    if (worst == joints_.size()) return;
    held_ |= 1U << worst;
    fixed_[worst] = u[worst] > 0 ? cap_upper_[worst] : cap_lower_[worst];
  }
}

/// What is left of a task for the joints that are free.
TaskArray JogResolver::rest_of(const TaskArray& task) const {
  TaskArray rest = task;
  if (room_to_axis_ < kInfinity) {
    // As far as it has room in the next second, no faster: it comes to rest there by itself.
    const double least = -std::max(0.0, room_to_axis_) * space_->scale(0);
    const double along = product(rest, away_);
    if (along < least) add(rest, least - along, away_);
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) add(rest, -fixed_[j], J_.column[j]);
  return rest;
}

JointArray JogResolver::joints_for(const TaskArray& task) const {
  if (space_->tool().hexapod() != nullptr) return walls_.legs_for(task);
  JointArray u = solver().solve(rest_of(task));
  add(u, 1, fixed_);
  return u;
}

JointArray JogResolver::drive(const TaskArray& task, double dt) {
  JointArray u = joints_for(task);
  if (space_->tool().hexapod() != nullptr) return u;
  escape(rest_of(task), dt, u);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    u[j] = std::clamp(u[j], cap_lower_[j], cap_upper_[j]);
  }
  return u;
}

TaskArray JogResolver::task_of(const JointArray& qd) const {
  return space_->tool().hexapod() != nullptr ? walls_.task_of(qd) : J_.times(qd);
}

JogObstacle JogResolver::obstacle(const TaskArray& task) const {
  using enum JogObstacle::Kind;
  if (space_->tool().hexapod() != nullptr) {
    const auto hit = walls_.hit(task);
    if (!hit.any) return {};
    return {hit.length ? kJointLimit : kPoseLimit, hit.leg};
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if ((held_ >> j & 1U) != 0) return {kJointLimit, static_cast<std::int8_t>(j)};
  }
  if (room_to_axis_ < kInfinity &&
      product(task, away_) < -std::max(0.0, room_to_axis_) * space_->scale(0)) {
    return {kPoseLimit, -1};
  }
  if (escapes_ || solver().lost_share(rest_of(task)) > kLostShare) return {kSingular, -1};
  return {};
}

/// What of a task lies in directions that fade out, and the joints' directions that belong to them.
TaskArray JogResolver::lost_part(const TaskArray& task, Escape& escape) const {
  const double size = std::sqrt(product(task, task));
  TaskArray lost{};
  bool free = false;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double value = solver().singular_value(k);
    if (value >= TaskSolver::kNearSingular) continue;
    const double along = product(solver().direction(k), task);
    if (!(std::abs(along) > kNothing * size)) continue;
    add(lost, along, solver().direction(k));
    if (value <= kFree) {
      free = true;
    } else if (!escape.directions.full()) {
      escape.directions.push_back({});
      add(escape.directions.back(), 1 / value, solver().joints_along(k));
    }
  }
  if (free) add_free_directions(escape);
  return lost;
}

/// At a singularity itself the Jacobian does not tell any more which direction of the joints
/// belongs to the one that is lost: all along which the tool stands still for the moment.
void JogResolver::add_free_directions(Escape& escape) const {
  while (!escape.directions.full()) {
    JointArray best{};
    double most = 0.1;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if ((held_ >> j & 1U) != 0) continue;
      JointArray d{};
      d[j] = 1;
      for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t k = 0; k < kTasksMax; ++k) {
          const double value = solver().singular_value(k);
          if (value <= kFree) continue;
          const JointArray& G = solver().joints_along(k);
          add(d, -product(d, G) / (value * value), G);
        }
        for (const JointArray& other : escape.directions) add(d, -product(d, other), other);
      }
      const double length = std::sqrt(product(d, d));
      if (length <= most) continue;
      most = length;
      best = {};
      add(best, 1 / length, d);
    }
    if (most <= 0.1) return;
    escape.directions.push_back(best);
  }
}

/// Along which of these directions (and all between them) the tool comes to move most in the
/// direction that is lost, as the joints go on: the largest eigenvector of a quadratic form, whose
/// eigenvalue it returns. The form is how much of `lost` the change of J along d makes of d.
double JogResolver::way_out(const TaskArray& lost, const Escape& escape, JointArray& d) const {
  const double size = std::sqrt(product(lost, lost));
  using Row = std::array<double, 4>;
  std::array<Row, 4> form{};
  const std::size_t n = escape.directions.size();
  for (std::size_t a = 0; a < n; ++a) {
    JointArray q = q_;
    add(q, kTry, escape.directions[a]);
    TaskJacobian J;
    space_->look(frame_, q, J);
    for (std::size_t b = 0; b < n; ++b) {
      const TaskArray before = J_.times(escape.directions[b]);
      TaskArray change = J.times(escape.directions[b]);
      add(change, -1, before);
      const double grows = product(change, lost) / (kTry * size);
      form[a][b] += grows / 2;
      form[b][a] += grows / 2;
    }
  }
  // Power iteration, with all eigenvalues made positive.
  double shift = 0;
  for (const auto& row : form) {
    for (const double number : row) shift += std::abs(number);
  }
  Row x{};
  for (std::size_t a = 0; a < n; ++a) x[a] = 1 + 0.1 * static_cast<double>(a);
  double value = 0;
  for (int step = 0; step < 40; ++step) {
    Row y{};
    for (std::size_t a = 0; a < n; ++a) y[a] = product(form[a], x) + shift * x[a];
    const double length = std::sqrt(product(y, y));
    if (!(length > 0)) return 0;
    for (double& number : y) number /= length;
    x = y;
    value = length - shift;
    if (n == 1) break;
  }
  d = {};
  for (std::size_t a = 0; a < n; ++a) add(d, x[a], escape.directions[a]);
  return value;
}

void JogResolver::escape(const TaskArray& task, double dt, JointArray& u) {
  const motion::AxisState before = escape_;
  escape_ = {};
  escapes_ = false;
  Escape ways;
  const TaskArray lost = lost_part(task, ways);
  if (ways.directions.empty()) return;
  JointArray d;
  const double growth = way_out(lost, ways, d);
  const double weight = std::clamp(growth / kWayOut - 1, 0.0, 1.0);
  if (weight == 0) return;
  const double size = std::sqrt(product(lost, lost));
  double gain = product(J_.times(d), lost) / size;
  // Without a slope yet, both ways lead out: the one with more room for the joints.
  double room = 0;
  motion::AxisLimits most{kInfinity, kInfinity, kInfinity};
  const auto limits = space_->limits();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if ((held_ >> j & 1U) == 0) room += d[j] * ((limits[j].lower + limits[j].upper) / 2 - q_[j]);
    const auto& [velocity, acceleration, jerk] = joints_[j].limits();
    const double share = std::abs(d[j]);
    most.velocity = std::min(most.velocity, kWayOutSpeed * velocity / share);
    most.acceleration = std::min(most.acceleration, kWayOutPush * acceleration / share);
    most.jerk = std::min(most.jerk, kWayOutPush * jerk / share);
  }
  if (std::abs(gain) > 1e-9 ? gain < 0 : room < 0) {
    gain = -gain;
    for (double& number : d) number = -number;
  }
  double speed = weight * most.velocity;
  if (gain > 0) speed = std::min(speed, weight * size / gain);
  // Gathered so that no joint falls behind: the tool hardly moves only while they keep step.
  const motion::VelocityChange change({0, before.qd, before.qdd}, most.velocity,
                                      motion::ProfileBounds(most));
  change.profile(profile_);
  escape_ = profile_.at(dt);
  if (escape_.qd > speed) escape_ = {0, speed, 0};
  const double along = product(u, d);
  if (along < escape_.qd) {
    add(u, escape_.qd - along, d);
    escapes_ = true;
  } else {
    escape_ = {0, std::min(along, most.velocity), 0};
  }
}

}  // namespace sinew::planning
