#include "sinew/kinematics/serial_arm.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/trig.h"
#include "sinew/model/tool_state.h"

namespace sinew::kinematics {
namespace {

/// Equal to within what counts as singular.
bool same_joints(const IkBranch& a, const IkBranch& b) {
  for (std::size_t i = 0; i < a.q.size(); ++i) {
    if (std::abs(a.q[i] - b.q[i]) > kSingularSine) return false;
  }
  return true;
}

}  // namespace

PoseFT tool_pose(const SerialGeometry& geometry, std::optional<double> jaw_width) {
  PoseFT X_FT = geometry.X_FT;
  if (!geometry.gripper) return X_FT;
  const JawGripper& jaws = *geometry.gripper;
  X_FT.p = X_FT.p + jaw_reach(jaws, jaw_width.value_or(jaws.width_max)) * X_FT.R.z;
  return X_FT;
}

SerialArm::SerialArm(const SerialGeometry& geometry, std::span<const Joint> joints,
                     const PoseFT& X_FT)
    : chain_(geometry), joints_(joints), X_FT_(X_FT) {
  SerialGeometry with_tool = geometry;
  with_tool.X_FT = X_FT;
  if (const auto six = SixR::match(with_tool, joints)) {
    solver_ = *six;
  } else if (const auto pitch = FiveRPitch::match(with_tool, joints)) {
    solver_ = *pitch;
  } else if (const auto roll = FiveRRoll::match(with_tool, joints)) {
    solver_ = *roll;
  } else if (const auto scara = Scara::match(with_tool, joints)) {
    solver_ = *scara;
  }
}

Expected<IkBranches> SerialArm::inverse(const PoseBT& X_BT, std::span<const double> near,
                                        double tolerance) const {
  if (const auto* six = std::get_if<SixR>(&solver_)) {
    return six->inverse(X_BT * X_FT_.inverse(), near);
  }
  if (const auto* pitch = std::get_if<FiveRPitch>(&solver_)) {
    const auto target = pitch->target(X_BT, tolerance);
    if (!target) return std::unexpected(target.error());
    return pitch->inverse(*target, X_FT_, near);
  }
  if (const auto* roll = std::get_if<FiveRRoll>(&solver_)) {
    return inverse_rolling(*roll, X_BT, near, tolerance);
  }
  if (const Scara* arm = scara()) return arm->inverse(X_BT, near, tolerance);
  return inverse_general(X_BT, near);
}

/// A full pose for an arm whose roll follows from the rest: only branches that give the asked roll.
Expected<IkBranches> SerialArm::inverse_rolling(const FiveRRoll& solver, const PoseBT& X_BT,
                                                std::span<const double> near,
                                                double tolerance) const {
  auto all = solver.inverse({X_BT.p, X_BT.R.z}, near);
  if (!all) return all;
  IkBranches fitting;
  Error refusal{ErrorCode::kRollNotFree, -1, 2 * kPi, tolerance};
  const Rotation R_asked = X_BT.R;
  // With the wrist straight both of its flips are the same joints.
  const auto add = [&](const IkBranch& candidate) {
    const auto same = [&](const IkBranch& other) { return same_joints(other, candidate); };
    if (std::none_of(fitting.begin(), fitting.end(), same)) fitting.push_back(candidate);
  };
  for (IkBranch& branch : *all) {
    const Rotation R = forward(branch.q).R;
    const Vec3 x_asked = transposed_times(R, R_asked.x);
    const double off = std::atan2(x_asked.y, x_asked.x);
    if (std::abs(off) > tolerance && (branch.singular & kWristBit) != 0) {
      // The forearm's roll is free here and turns the tool about its own axis: use it.
      for (const double sign : {1.0, -1.0}) {
        IkBranch turned = branch;
        turned.q[3] += sign * off;
        JointRanges(joints_).settle(turned, near);
        if (angle_between(forward(turned.q).R, R_asked) > tolerance) continue;
        add(turned);
        break;
      }
    } else if (std::abs(off) <= tolerance) {
      add(branch);
    } else {
      refusal.measured = std::min(refusal.measured, std::abs(off));
    }
  }
  if (fitting.empty()) return std::unexpected(refusal);
  return fitting;
}

Expected<IkBranches> SerialArm::inverse_general(const PoseBT& X_BT,
                                                std::span<const double> near) const {
  JointVector start;
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    start.push_back(i < near.size() ? near[i] : (joints_[i].lower + joints_[i].upper) / 2);
  }
  const auto solution = inverse_numeric(chain_, joints_, X_BT * X_FT_.inverse(), start);
  if (!solution) return std::unexpected(solution.error());
  return IkBranches{IkBranch{.q = solution->q, .within_limits = true, .singular = 0}};
}

Expected<IkBranches> SerialArm::inverse_at_pitch(const Vec3& p_BT, double pitch,
                                                 std::span<const double> near) const {
  const bool on_axis = std::hypot(p_BT.x, p_BT.y) < kFreeDirection;
  const double yaw_near = near.empty() ? 0 : near[0];
  const double yaw = on_axis ? yaw_near : std::atan2(p_BT.y, p_BT.x);
  if (const auto* solver = std::get_if<FiveRPitch>(&solver_)) {
    auto answer =
        solver->inverse({.p_BT = p_BT, .pitch = pitch, .roll = 0, .yaw = yaw}, X_FT_, near);
    if (!answer) return answer;
    // A point asks for no roll: the last joint stays where it is.
    const JointRanges ranges(joints_);
    const Joint& roll = joints_[4];
    for (IkBranch& branch : *answer) {
      branch.q[4] = std::clamp(near.size() > 4 ? near[4] : 0.0, roll.lower, roll.upper);
      branch.within_limits = ranges.contains(branch.q);
    }
    return answer;
  }
  const double level = std::sin(pitch);
  return inverse_along(p_BT, {std::cos(yaw) * level, std::sin(yaw) * level, std::cos(pitch)}, near);
}

Expected<IkBranches> SerialArm::inverse_along(const Vec3& p_BT, const Vec3& approach_B,
                                              std::span<const double> near) const {
  const auto* solver = std::get_if<FiveRRoll>(&solver_);
  if (solver == nullptr) return std::unexpected(Error{.code = ErrorCode::kTaskNotSupported});
  return solver->inverse({p_BT, approach_B}, near);
}

Expected<SerialArm::PitchedBranches> SerialArm::inverse_nearest_pitch(
    const Vec3& p_BT, double preferred, std::span<const double> near) const {
  std::optional<Error> nearest;
  const auto try_pitch = [&](double pitch) -> std::optional<PitchedBranches> {
    const auto answer = inverse_at_pitch(p_BT, pitch, near);
    if (answer) {
      const auto inside = [](const IkBranch& branch) { return branch.within_limits; };
      if (std::any_of(answer->begin(), answer->end(), inside)) return {{pitch, *answer}};
    }
    const Error error = answer ? nearest_violation(joints_, *answer) : answer.error();
    // A limit is nearer than a target that no angle reaches.
    const bool first_limit =
        nearest && error.code == ErrorCode::kJointLimit && nearest->code != ErrorCode::kJointLimit;
    if (!nearest || first_limit ||
        (error.code == nearest->code && excess(error) < excess(*nearest))) {
      nearest = error;
    }
    return {};
  };

  constexpr double kStep = kPi / 720;
  constexpr double kRoundingMargin = 1e-5;
  constexpr int kSteps = 720;
  for (int i = 0; i <= kSteps; ++i) {
    for (const double side : {-1.0, 1.0}) {
      auto found = try_pitch(preferred + side * i * kStep);
      if (!found) continue;
      // Between the last step that failed and this one lies the smallest tilt.
      double inside = i * kStep;
      double outside = std::max(0, i - 1) * kStep;
      while (inside - outside > 1e-9) {
        const double middle = (inside + outside) / 2;
        if (const auto better = try_pitch(preferred + side * middle)) {
          found = better;
          inside = middle;
        } else {
          outside = middle;
        }
      }
      // A hair more where there is room: the pitch is still inside when people round it.
      const auto roomy = try_pitch(preferred + side * (inside + kRoundingMargin));
      return inside > 0 && roomy ? *roomy : *found;
    }
  }
  return std::unexpected(*nearest);
}

}  // namespace sinew::kinematics
