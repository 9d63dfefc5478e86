#include "sinew/planning/jog/platform_walls.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

/// From this part of the condition number's limit on it is looked at where it grows.
constexpr double kConditionNear = 0.7;
/// Turns by walls, at most as many as a velocity has numbers.
constexpr std::size_t kTurnsMax = kTasksMax;

double product(const TaskArray& a, const TaskArray& b) {
  double sum = 0;
  for (std::size_t k = 0; k < kTasksMax; ++k) sum += a[k] * b[k];
  return sum;
}

TaskArray twist(const Vec3& v, const Vec3& w) {
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}

}  // namespace

PlatformWalls::PlatformWalls(const JogSpace& space, std::span<const JogJoint> legs)
    : space_(&space), geometry_(std::get_if<HexapodGeometry>(&space.model().geometry)) {
  time_ = 0;
  for (const JogJoint& leg : legs) {
    const auto& [velocity, acceleration, jerk] = leg.limits();
    time_ = std::max(time_, 2 * (velocity / acceleration + acceleration / jerk));
  }
}

/// What is multiplied with a twist in base, for one in the frame and with its scales.
TaskArray PlatformWalls::in_frame(const TaskArray& twist_B) const {
  Vec3 v{twist_B[0], twist_B[1], twist_B[2]};
  Vec3 w{twist_B[3], twist_B[4], twist_B[5]};
  if (frame_ != JogFrame::kBase) {
    v = transposed_times(R_BT_, v);
    w = transposed_times(R_BT_, w);
  }
  return twist((1 / space_->scale(0)) * v, (1 / space_->scale(3)) * w);
}

void PlatformWalls::add(const TaskArray& twist_B, double bound, std::int8_t leg, bool length) {
  walls_.push_back({in_frame(twist_B), bound, leg, length});
}

void PlatformWalls::look(JogFrame frame, const PoseBT& X_BT, const JointArray& lower,
                         const JointArray& upper) {
  frame_ = frame;
  R_BT_ = X_BT.R;
  walls_.clear();
  const auto J = space_->tool().hexapod()->jacobian(relabel<frame::Base, frame::Platform>(X_BT));
  for (std::size_t i = 0; i < kLegs; ++i) {
    rows_[i] = in_frame(J[i]);
    const auto leg = static_cast<std::int8_t>(i);
    TaskArray back = J[i];
    for (double& number : back) number = -number;
    add(J[i], upper[i], leg, true);
    add(back, -lower[i], leg, true);
  }
  add_joint_angles(X_BT);
  add_condition(X_BT);
}

/// With the leg along the unit vector s and the anchor at r from P, s changes with v + w x r, less
/// what that is along s, per length of the leg.
void PlatformWalls::add_joint_angles(const PoseBT& X_BT) {
  const double cos_least = std::cos(geometry_->cardan_angle_max);
  const double sin_most = std::sin(geometry_->ball_angle_max);
  for (std::size_t i = 0; i < kLegs; ++i) {
    const auto leg = static_cast<std::int8_t>(i);
    const Vec3 r = X_BT.R * geometry_->p_PA[i];
    const Vec3 along = X_BT.p + r - geometry_->p_BA[i];
    const double length = norm(along);
    const Vec3 s = (1 / length) * along;
    const Vec3& motor = geometry_->motor_axis_B[i];
    const double cos_cardan = dot(s, motor);
    const Vec3 fall = (1 / length) * (cos_cardan * s - motor);
    add(twist(fall, cross(r, fall)), (cos_cardan - cos_least) / time_, leg, false);
    const Vec3 skewer = X_BT.R * geometry_->skewer_axis_P[i];
    const double sin_ball = dot(s, skewer);
    const double side = sin_ball < 0 ? -1 : 1;
    const Vec3 rise = (side / length) * (skewer - sin_ball * s);
    add(twist(rise, cross(r, rise) + side * cross(skewer, s)), (sin_most - side * sin_ball) / time_,
        leg, false);
  }
}

/// The condition number has no formula for how it changes; tried out in six directions.
void PlatformWalls::add_condition(const PoseBT& X_BT) {
  const auto logarithm = [&](const PoseBT& X) {
    const auto X_BP = relabel<frame::Base, frame::Platform>(X);
    return std::log(space_->tool().hexapod()->dexterity(X_BP).condition);
  };
  const double now = logarithm(X_BT);
  const double most = std::log(geometry_->condition_max);
  if (!std::isfinite(now) || now < most + std::log(kConditionNear)) return;
  constexpr double kStep = 1e-5;  // m, rad
  TaskArray growth{};
  const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (std::size_t k = 0; k < axes.size(); ++k) {
    PoseBT X = X_BT;
    X.p = X.p + kStep * axes[k];
    growth[k] = (logarithm(X) - now) / kStep;
    X = {rotation_from_vector(kStep * axes[k]) * X_BT.R, X_BT.p};
    growth[k + 3] = (logarithm(X) - now) / kStep;
  }
  for (const double number : growth) {
    if (!std::isfinite(number)) return;
  }
  add(growth, (most - now) / time_, -1, false);
}

/// The wall that is broken most first; the ones before stay as they were met.
TaskArray PlatformWalls::turned(const TaskArray& task, Hit* hit) const {
  TaskArray left = task;
  std::array<TaskArray, kTurnsMax> met;
  const double size = std::sqrt(product(task, task));
  for (std::size_t count = 0; count < kTurnsMax; ++count) {
    const Wall* worst = nullptr;
    double depth = 1e-12 * size;
    for (const Wall& wall : walls_) {
      const double length = std::sqrt(product(wall.normal, wall.normal));
      const double beyond = (product(wall.normal, left) - wall.bound) / length;
      if (!(beyond > depth)) continue;
      depth = beyond;
      worst = &wall;
    }
    if (worst == nullptr) return left;
    if (hit != nullptr && !hit->any) *hit = {true, worst->leg, worst->length};
    TaskArray& across = met[count] = worst->normal;
    for (std::size_t k = 0; k < count; ++k) {
      const double along = product(across, met[k]);
      for (std::size_t i = 0; i < kTasksMax; ++i) across[i] -= along * met[k][i];
    }
    const double length = std::sqrt(product(across, across));
    if (!(length > 1e-9 * std::sqrt(product(worst->normal, worst->normal)))) break;
    for (double& number : across) number /= length;
    // How far back along what is free for the wall itself to be met.
    const double slope = product(across, worst->normal);
    const double back = (product(worst->normal, left) - worst->bound) / slope;
    for (std::size_t i = 0; i < kTasksMax; ++i) left[i] -= back * across[i];
  }
  // In a corner of walls that meet: nothing goes.
  for (const Wall& wall : walls_) {
    const double length = std::sqrt(product(wall.normal, wall.normal));
    if (product(wall.normal, left) > wall.bound + 1e-9 * length * size) return {};
  }
  return left;
}

JointArray PlatformWalls::legs_for(const TaskArray& task) const {
  const TaskArray left = turned(task, nullptr);
  JointArray qd{};
  for (std::size_t i = 0; i < kLegs; ++i) qd[i] = product(rows_[i], left);
  return qd;
}

TaskArray PlatformWalls::task_of(const JointArray& qd) const {
  // The same solver with legs and numbers in each other's place; it wants numbers near 1.
  const double scale = space_->scale(0);
  TaskJacobian J{kTasksMax, {}};
  TaskArray rates{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    rates[i] = scale * qd[i];
    for (std::size_t k = 0; k < kTasksMax; ++k) J.column[k][i] = scale * rows_[i][k];
  }
  TaskSolver solver;
  solver.factor(J, 0);
  const JointArray found = solver.solve(rates);
  TaskArray task;
  for (std::size_t k = 0; k < kTasksMax; ++k) task[k] = found[k];
  return task;
}

PlatformWalls::Hit PlatformWalls::hit(const TaskArray& task) const {
  Hit hit;
  turned(task, &hit);
  return hit;
}

}  // namespace sinew::planning
