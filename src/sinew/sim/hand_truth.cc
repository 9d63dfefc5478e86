#include "sinew/sim/hand_truth.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/tool_body.h"

namespace sinew::sim {
namespace {

constexpr double kCupRadius = 0.008;  // m, assumed for the MaxArm

JointVector joints_of(const Truth& truth) {
  JointVector q;
  for (const JointTruth& joint : truth.joints) q.push_back(joint.q);
  return q;
}

}  // namespace

FixedVector<Block, 2> blocks_of(const HandTruth& hand) {
  const auto block = [&](const Vec3& p_TX, const Vec3& half) {
    return Block{{hand.X_WT.R, hand.X_WT * p_TX}, half};
  };
  if (const auto* cup = std::get_if<CupTruth>(&hand.grip)) {
    const double half = cup->length / 2;
    return {block({0, 0, -half}, {cup->radius, cup->radius, half})};
  }
  const auto& jaws = std::get<JawTruth>(hand.grip);
  const Vec3& half = jaws.finger_half;
  const double y = jaws.width / 2 + half.y;
  return {block({0, y, -half.z}, half), block({0, -y, -half.z}, half)};
}

double softness(const HandTruth& hand) {
  constexpr double kFingers = 1e-3;
  constexpr double kBellows = 4e-3;  // assumed
  return std::holds_alternative<CupTruth>(hand.grip) ? kBellows : kFingers;
}

HandTruth between(const HandTruth& from, const HandTruth& to, double share) {
  SINEW_ASSERT(from.grip.index() == to.grip.index());
  HandTruth hand = to;
  const Rotation turn = from.X_WT.R.transposed() * to.X_WT.R;
  hand.X_WT.R = from.X_WT.R * rotation_from_vector(share * rotation_vector(turn));
  hand.X_WT.p = from.X_WT.p + share * (to.X_WT.p - from.X_WT.p);
  if (auto* jaws = std::get_if<JawTruth>(&hand.grip)) {
    const double before = std::get<JawTruth>(from.grip).width;
    jaws->width = before + share * (jaws->width - before);
  }
  return hand;
}

std::optional<HandTruth> hand_of(const RobotModel& model, const Truth& truth,
                                 const Pose<frame::World, frame::Base>& X_WB) {
  if (truth.joints.size() != model.joints.size()) return std::nullopt;
  const JointVector q = joints_of(truth);
  const std::span<const double> angles{q.begin(), q.size()};
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    if (!serial->gripper) return std::nullopt;
    const auto X_BF = kinematics::SerialChain(*serial).forward(angles);
    const auto X_WT = X_WB * X_BF * kinematics::tool_pose(*serial, truth.tool);
    return HandTruth{relabel<frame::World, frame::Tip>(X_WT),
                     JawTruth{truth.tool, finger_half(model)}};
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    auto X_WT = X_WB * kinematics::forward(*palletizer, angles);
    const double reach = cup_reach(model);
    X_WT.p = X_WT * Vec3{0, 0, -reach};
    X_WT.R = X_WT.R * rotation_x(kPi);
    return HandTruth{relabel<frame::World, frame::Tip>(X_WT),
                     CupTruth{kCupRadius, std::max(reach, 0.02), truth.suction}};
  }
  return std::nullopt;
}

}  // namespace sinew::sim
