#include "sinew/planning/paths/tool_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/planning/paths/motion_limits.h"

namespace sinew::planning {
namespace {

using kinematics::IkBranch;
using kinematics::SerialArm;

/// Below this distance (m) from the first axis a five-joint arm's plane is not defined.
constexpr double kAxisDistance = 1e-6;
/// Below these a singularity is named as the one that is near: sines, and parts of the arm's reach.
constexpr double kNearSingular = 0.2;

std::variant<SerialArm, PalletizerGeometry, kinematics::Hexapod> robot_of(
    const RobotModel& model, std::optional<double> jaw_width) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    return SerialArm(*serial, model.joints, kinematics::tool_pose(*serial, jaw_width));
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) return *palletizer;
  return kinematics::Hexapod(std::get<HexapodGeometry>(model.geometry));
}

Rotation pitched(const Vec3& p_BT, double pitch, double roll) {
  return rotation_z(std::atan2(p_BT.y, p_BT.x)) * rotation_y(pitch) * rotation_z(roll);
}

Vec3 approach(const TaskPoint& at) {
  return {at.attitude[0], at.attitude[1], at.attitude[2]};
}

/// Angle between two orientations, exact to first order and good enough for small ones.
double small_angle(const Rotation& A, const Rotation& B) {
  const Vec3 twice = cross(A.x, B.x) + cross(A.y, B.y) + cross(A.z, B.z);
  return 0.5 * norm(twice);
}

PoseBT with_approach(const Vec3& p_BT, const Vec3& z, const Rotation& like) {
  Vec3 x = like.x - dot(like.x, z) * z;
  if (norm(x) < 1e-6) x = like.y - dot(like.y, z) * z;
  x = normalized(x);
  return {{x, cross(z, x), z}, p_BT};
}

}  // namespace

ToolSpace::ToolSpace(const RobotModel& model, std::optional<double> jaw_width)
    : joints_(model.joints),
      shared_velocity_(planning::shared_velocity(model)),
      robot_(robot_of(model, jaw_width)) {
  if (const auto* arm = serial()) {
    if (arm->solver() == SerialArm::Solver::kFiveRPitch) task_ = TaskSpace::kPitchRoll;
    if (arm->solver() == SerialArm::Solver::kFiveRRoll) task_ = TaskSpace::kApproach;
  } else if (const auto* hexapod = std::get_if<HexapodGeometry>(&model.geometry)) {
    X_home_ = relabel<frame::Base, frame::Tool>(hexapod->X_BP_home);
  } else {
    task_ = TaskSpace::kPoint;
    unlimited_ = model.joints;
    for (Joint& joint : unlimited_) {
      const double middle = (joint.lower + joint.upper) / 2;
      joint.lower = middle - 2 * kPi;
      joint.upper = middle + 2 * kPi;
    }
  }
}

const kinematics::Hexapod* ToolSpace::hexapod() const {
  return std::get_if<kinematics::Hexapod>(&robot_);
}
const SerialArm* ToolSpace::serial() const {
  return std::get_if<SerialArm>(&robot_);
}

const kinematics::Scara* ToolSpace::scara() const {
  return serial() != nullptr ? serial()->scara() : nullptr;
}

Expected<PoseBT> ToolSpace::forward(std::span<const double> q, const PoseBT& X_near) const {
  if (const auto* arm = serial()) return arm->forward(q);
  if (const auto* hexapod_robot = hexapod()) {
    const auto found =
        hexapod_robot->forward(JointVector(q), relabel<frame::Base, frame::Platform>(X_near));
    if (!found) return std::unexpected(found.error());
    return relabel<frame::Base, frame::Tool>(found->X_BP);
  }
  return kinematics::forward(std::get<PalletizerGeometry>(robot_), q);
}

TaskPoint ToolSpace::point(const PoseBT& X_BT) const {
  TaskPoint at{X_BT.p, {}};
  const Rotation& R = X_BT.R;
  if (task_ == TaskSpace::kPose) {
    at.attitude = quaternion_wxyz(scara() != nullptr ? scara()->nearest(R) : R);
  } else if (task_ == TaskSpace::kApproach) {
    at.attitude = {R.z.x, R.z.y, R.z.z, 0};
  } else if (task_ == TaskSpace::kPitchRoll) {
    const Rotation R_plane = rotation_z(std::atan2(X_BT.p.y, X_BT.p.x));
    const double pitch = std::atan2(dot(R_plane.x, R.z), R.z.z);
    // The roll that leaves the least angle: the trace of the rest is largest there.
    const Rotation rest = (R_plane * rotation_y(pitch)).transposed() * R;
    at.attitude = {pitch, std::atan2(rest.x.y - rest.y.x, rest.x.x + rest.y.y), 0, 0};
  }
  return at;
}

PoseBT ToolSpace::pose(const TaskPoint& at, const Rotation& like) const {
  switch (task_) {
    case TaskSpace::kPose:
      return {rotation_from_quaternion(at.attitude), at.p_BT};
    case TaskSpace::kPitchRoll:
      return {pitched(at.p_BT, at.attitude[0], at.attitude[1]), at.p_BT};
    case TaskSpace::kApproach:
      return with_approach(at.p_BT, approach(at), like);
    case TaskSpace::kPoint:
      break;
  }
  return {rotation_z(std::atan2(at.p_BT.x, -at.p_BT.y)), at.p_BT};
}

std::expected<TaskPoint, NearestPose> ToolSpace::asked(const PoseBT& X_BT,
                                                       std::span<const double> near) const {
  if (task_ == TaskSpace::kApproach) return asked_with_roll(X_BT, near);
  const TaskPoint nearest = point(X_BT);
  const PoseBT X_nearest = pose(nearest);
  const double off = angle_between(X_nearest.R, X_BT.R);
  if (off <= kTaskTolerance) return nearest;
  const ErrorCode code = task_ == TaskSpace::kPitchRoll ? ErrorCode::kApproachOutOfPlane
                                                        : ErrorCode::kOrientationNotReachable;
  return std::unexpected(NearestPose{X_nearest, nearest, {code, -1, off, kTaskTolerance}});
}

std::expected<TaskPoint, NearestPose> ToolSpace::asked_with_roll(
    const PoseBT& X_BT, std::span<const double> near) const {
  const SerialArm& arm = *serial();
  const TaskPoint asked_for = point(X_BT);
  NearestPose nearest{X_BT, asked_for, {ErrorCode::kRollNotFree, -1, 2 * kPi, kTaskTolerance}};
  const auto branches = arm.inverse_along(X_BT.p, X_BT.R.z, near);
  if (!branches) {
    nearest.error = branches.error();
    return std::unexpected(nearest);
  }
  const bool any_inside = std::any_of(branches->begin(), branches->end(),
                                      [](const IkBranch& branch) { return branch.within_limits; });
  for (const IkBranch& branch : *branches) {
    if (any_inside && !branch.within_limits) continue;
    // With the wrist straight the forearm turns the tool about its own axis: any roll.
    if ((branch.singular & kinematics::kWristBit) != 0) return asked_for;
    const PoseBT X_branch = arm.forward(branch.q);
    const double off = angle_between(X_branch.R, X_BT.R);
    if (off >= nearest.error.measured) continue;
    nearest.error.measured = off;
    nearest.X_BT = X_branch;
  }
  if (nearest.error.measured <= kTaskTolerance) return asked_for;
  return std::unexpected(nearest);
}

Expected<kinematics::IkBranches> ToolSpace::solve(const SerialArm& arm, const TaskPoint& at,
                                                  std::span<const double> near) const {
  if (task_ == TaskSpace::kApproach) return arm.inverse_along(at.p_BT, approach(at), near);
  if (task_ == TaskSpace::kPitchRoll) {
    const double rho = std::hypot(at.p_BT.x, at.p_BT.y);
    if (!(rho > kAxisDistance)) {
      return std::unexpected(Error{ErrorCode::kShoulderSingular, -1, rho, kAxisDistance});
    }
  }
  return arm.inverse(pose(at), near, kTaskTolerance);
}

Expected<JointArray> ToolSpace::nearest_branch(const SerialArm& arm, const TaskPoint& at,
                                               const JointArray& q_near) const {
  const auto branches = solve(arm, at, std::span<const double>(q_near.data(), size()));
  if (!branches) return std::unexpected(branches.error());
  JointArray best{};
  double best_move = std::numeric_limits<double>::infinity();
  for (const IkBranch& branch : *branches) {
    JointArray q{};
    double move = 0;
    // The solver may have turned a joint over to bring it inside its limits; a path cannot.
    for (std::size_t j = 0; j < size(); ++j) {
      const bool slides = arm.chain().slides(j);
      q[j] = slides ? branch.q[j] : wrap_near(branch.q[j], q_near[j]);
      move = std::max(move, std::abs(q[j] - q_near[j]));
    }
    if (move >= best_move) continue;
    best_move = move;
    best = q;
  }
  return best;
}

Expected<JointArray> ToolSpace::inverse_near(const TaskPoint& at, const JointArray& q_near) const {
  if (const auto* arm = serial()) {
    if (arm->solver() != SerialArm::Solver::kNumeric) return nearest_branch(*arm, at, q_near);
    const auto found = kinematics::inverse_numeric(
        arm->chain(), joints_, pose(at) * arm->tool().inverse(),
        std::span<const double>(q_near.data(), size()), {.attempts_max = 1});
    if (!found) return std::unexpected(found.error());
    JointArray q{};
    std::copy(found->q.begin(), found->q.end(), q.begin());
    return q;
  }
  JointArray q{};
  if (const auto* hexapod_robot = hexapod()) {
    const JointVector legs =
        hexapod_robot->inverse(relabel<frame::Base, frame::Platform>(pose(at)));
    std::copy(legs.begin(), legs.end(), q.begin());
    return q;
  }
  const auto found = kinematics::inverse(std::get<PalletizerGeometry>(robot_), unlimited_, at.p_BT);
  if (!found) return std::unexpected(found.error());
  for (std::size_t j = 0; j < size(); ++j) q[j] = wrap_near((*found)[j], q_near[j]);
  return q;
}

FixedVector<JointArray, 8> ToolSpace::branches(const TaskPoint& at,
                                               const JointArray& q_near) const {
  FixedVector<JointArray, 8> inside;
  const auto add = [&](std::span<const double> q) {
    for (std::size_t j = 0; j < size(); ++j) {
      if (!within_limits(joints_[j], q[j])) return;
    }
    JointArray branch{};
    std::copy(q.begin(), q.end(), branch.begin());
    inside.push_back(branch);
  };
  if (const auto* arm = serial()) {
    const std::span<const double> near(q_near.data(), size());
    auto found = solve(*arm, at, near);
    if (!found) return inside;
    sort_by_distance(*found, near);
    for (const IkBranch& branch : *found) add(branch.q);
  } else if (const auto* hexapod_robot = hexapod()) {
    const auto X_BP = relabel<frame::Base, frame::Platform>(pose(at));
    if (hexapod_robot->check(X_BP, joints_).empty()) add(hexapod_robot->inverse(X_BP));
  } else {
    const auto found = kinematics::inverse(std::get<PalletizerGeometry>(robot_), joints_, at.p_BT);
    if (found) add(*found);
  }
  return inside;
}

ToolOffset ToolSpace::offset(const PoseBT& X_BT, const TaskPoint& want) const {
  ToolOffset off{norm(X_BT.p - want.p_BT), 0};
  switch (task_) {
    case TaskSpace::kPose:
      off.angle = small_angle(X_BT.R, rotation_from_quaternion(want.attitude));
      break;
    case TaskSpace::kPitchRoll:
      off.angle = small_angle(X_BT.R, pose(want).R);
      break;
    case TaskSpace::kApproach:
      off.angle = norm(cross(X_BT.R.z, approach(want)));
      break;
    case TaskSpace::kPoint:
      break;
  }
  return off;
}

Error ToolSpace::singularity(std::span<const double> q, const PoseBT& X_BT) const {
  if (const auto* hexapod_robot = hexapod()) {
    const auto X_BP = relabel<frame::Base, frame::Platform>(X_BT);
    return {ErrorCode::kSingular, -1, hexapod_robot->dexterity(X_BP).singular_value_min, 0};
  }
  const auto* arm = serial();
  if (arm == nullptr) {
    const double sine = std::abs(std::sin(q[1] - q[2]));
    const double rho = std::hypot(X_BT.p.x, X_BT.p.y);
    if (sine < kNearSingular) return {ErrorCode::kElbowSingular, -1, sine, kNearSingular};
    return {ErrorCode::kShoulderSingular, -1, rho, 0};
  }
  kinematics::Jacobian J;
  arm->chain().forward(q, J);
  const double reach = arm->chain().reach(joints_);
  const Error general{ErrorCode::kSingular, -1, kinematics::dexterity(J, reach).singular_value_min,
                      0};
  if (arm->solver() == SerialArm::Solver::kNumeric) return general;
  if (const auto* upright = scara()) {
    const double sine = std::abs(upright->elbow_sine(q));
    return sine < kNearSingular ? Error{ErrorCode::kElbowSingular, -1, sine, kNearSingular}
                                : general;
  }
  // Origins of the frames before elbow and wrist: where the closed forms say they are.
  PoseBT X_B{};
  std::array<Vec3, kMaxJoints + 1> origin;
  for (std::size_t i = 0; i < size(); ++i) {
    origin[i] = X_B.p;
    X_B = relabel<frame::Base, frame::Tool>(
        X_B * relabel<frame::Tool, frame::Flange>(arm->chain().link(i, q[i])));
  }
  const bool pitches = task_ == TaskSpace::kPitchRoll;
  const Vec3& elbow = origin[2];
  const Vec3& wrist = pitches ? origin[3] : origin[4];
  // In the arm's plane, across the axes of shoulder and elbow; a lateral offset does not count.
  const auto in_plane = [&](const Vec3& v) { return v - dot(v, J.w[1]) * J.w[1]; };
  const Vec3 upper_arm = in_plane(elbow - origin[1]);
  const Vec3 forearm = in_plane(wrist - elbow);
  const double elbow_sine =
      norm(cross(upper_arm, forearm)) / std::max(norm(upper_arm) * norm(forearm), 1e-12);
  double wrist_sine = 1;
  if (task_ == TaskSpace::kPose) wrist_sine = norm(cross(J.w[3], J.w[5]));
  if (task_ == TaskSpace::kApproach) wrist_sine = norm(cross(J.w[3], X_BT.R.z));
  const double axis = std::abs(dot(pitches ? X_BT.p : wrist, cross(J.w[1], J.w[0])));
  const double least = std::min({elbow_sine, wrist_sine, axis / reach});
  if (least > kNearSingular) return general;
  if (least == wrist_sine) return {ErrorCode::kWristSingular, -1, wrist_sine, kNearSingular};
  if (least == elbow_sine) return {ErrorCode::kElbowSingular, -1, elbow_sine, kNearSingular};
  return {ErrorCode::kShoulderSingular, -1, axis, kNearSingular * reach};
}

double turn_between(TaskSpace task, const TaskPoint& a, const TaskPoint& b) {
  const auto& u = a.attitude;
  const auto& v = b.attitude;
  if (task == TaskSpace::kPitchRoll) {
    return std::hypot(wrap_near(u[0] - v[0], 0), wrap_near(u[1] - v[1], 0));
  }
  double cosine = 0;
  double apart = 0;
  double sum = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    cosine += u[i] * v[i];
    apart += (u[i] - v[i]) * (u[i] - v[i]);
    sum += (u[i] + v[i]) * (u[i] + v[i]);
  }
  // Half the angle from both diagonals of the rhombus: exact for small and for large ones.
  const double half = std::atan2(std::sqrt(apart), std::sqrt(sum));
  if (task == TaskSpace::kApproach) return 2 * half;
  if (task == TaskSpace::kPoint) return 0;
  return cosine < 0 ? 4 * (kPi / 2 - half) : 4 * half;
}

}  // namespace sinew::planning
