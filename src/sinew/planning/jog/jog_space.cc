#include "sinew/planning/jog/jog_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"

namespace sinew::planning {
namespace {

using kinematics::SerialArm;

double length_of(const RobotModel& model, const ToolSpace& tool) {
  if (const SerialArm* arm = tool.serial())
    return arm->chain().reach(model.joints) + norm(arm->tool().p);
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    return palletizer->shoulder_offset + palletizer->upper_arm + palletizer->forearm +
           palletizer->tool_offset;
  }
  return 2 * std::get<HexapodGeometry>(model.geometry).platform_radius;
}

}  // namespace

JogSpace::JogSpace(const RobotModel& model)
    : model_(&model), tool_(model), palletizer_(std::get_if<PalletizerGeometry>(&model.geometry)) {
  linear_ = 1 / length_of(model, tool_);
  angular_ = 0.5;
}

bool JogSpace::has(JogFrame frame) const {
  return frame != JogFrame::kPlatform || tool_.hexapod() != nullptr;
}

std::size_t JogSpace::numbers(JogFrame frame) const {
  if (frame == JogFrame::kJoint) return joints();
  if (tool_.scara() != nullptr) return 4;
  switch (tool_.task()) {
    case TaskSpace::kPitchRoll:
      return 5;
    case TaskSpace::kPoint:
      return 3;
    case TaskSpace::kPose:
    case TaskSpace::kApproach:
      break;
  }
  return 6;
}

Expected<PoseBT> JogSpace::place(const JointArray& q, const PoseBT& X_near) const {
  return tool_.forward({q.data(), joints()}, X_near);
}

PoseBT JogSpace::look_serial(const SerialArm& arm, JogFrame frame, const JointArray& q,
                             TaskJacobian& J) const {
  kinematics::Jacobian flange;
  const auto X_BF = arm.chain().forward({q.data(), joints()}, flange);
  const PoseBT X_BT = X_BF * arm.tool();
  const Vec3 p_FT_B = X_BT.p - X_BF.p;
  const bool in_tool = frame == JogFrame::kTool;
  for (std::size_t j = 0; j < joints(); ++j) {
    Vec3 w = flange.w[j];
    Vec3 v = flange.v[j] + cross(w, p_FT_B);
    if (in_tool) v = transposed_times(X_BT.R, v);
    if (tool_.task() == TaskSpace::kPitchRoll) {
      w = j == 0 ? Vec3{} : Vec3{dot(flange.w[1], w), dot(X_BT.R.z, w), 0};
    } else if (tool_.scara() != nullptr) {
      w = {in_tool && X_BT.R.z.z < 0 ? -w.z : w.z, 0, 0};
    } else {
      if (tool_.task() == TaskSpace::kApproach) w = w - dot(X_BT.R.z, w) * X_BT.R.z;
      if (in_tool) w = transposed_times(X_BT.R, w);
    }
    J.column[j] = {linear_ * v.x,  linear_ * v.y,  linear_ * v.z,
                   angular_ * w.x, angular_ * w.y, angular_ * w.z};
  }
  return X_BT;
}

PoseBT JogSpace::look(JogFrame frame, const JointArray& q, TaskJacobian& J) const {
  J.joints = joints();
  if (const SerialArm* arm = tool_.serial()) return look_serial(*arm, frame, q, J);
  const auto joints_span = std::span<const double>(q.data(), joints());
  const PoseBT X_BT = kinematics::forward(*palletizer_, joints_span);
  const auto columns = kinematics::jacobian(*palletizer_, joints_span);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const Vec3 v = frame == JogFrame::kTool ? transposed_times(X_BT.R, columns[j]) : columns[j];
    J.column[j] = {linear_ * v.x, linear_ * v.y, linear_ * v.z, 0, 0, 0};
  }
  return X_BT;
}

double JogSpace::violation(const JointArray& q, const PoseBT& X_near) const {
  if (palletizer_ != nullptr) {
    const double outward = palletizer_->shoulder_offset + palletizer_->tool_offset -
                           palletizer_->upper_arm * std::cos(q[1]) +
                           palletizer_->forearm * std::cos(q[2]);
    const double near = std::max(0.0, palletizer_->radius_min - outward);
    const double turned_over = std::max(0.0, -std::sin(q[1] - q[2]));
    return near * linear_ + turned_over;
  }
  if (tool_.hexapod() == nullptr) return 0;
  const auto X_BT = place(q, X_near);
  if (!X_BT) return std::numeric_limits<double>::infinity();
  double sum = 0;
  for (const Error& error :
       tool_.hexapod()->check(relabel<frame::Base, frame::Platform>(*X_BT), tool_.joints())) {
    if (error.code == ErrorCode::kLegLength) continue;  // the legs see to this themselves
    sum += std::abs(error.measured / error.limit - 1);
  }
  return sum;
}

double JogSpace::room_to_axis(const PoseBT& X_BT, Vec3& away) const {
  if (palletizer_ == nullptr) return std::numeric_limits<double>::infinity();
  away = -X_BT.R.y;
  return dot(X_BT.p, away) - palletizer_->radius_min;
}

}  // namespace sinew::planning
