#include "sinew/model/joint_lookup.h"

#include <variant>

namespace sinew {
namespace {

constexpr unsigned kAllLegs = (1U << kLegs) - 1;

}  // namespace

std::string misfit_of_joints(const TaughtPoint& point, const RobotModel& model) {
  const auto* q = std::get_if<JointVector>(&point.place);
  const std::uint8_t lengths = prismatic_joints(model);
  if (q == nullptr || (q->size() == model.joints.size() && point.lengths == lengths)) return {};
  if (q->size() == model.joints.size()) {
    return "'" + point.name + "' has degrees where " + model.id + " has mm, or mm for degrees";
  }
  return "'" + point.name + "' has " + std::to_string(q->size()) +
         (point.lengths == kAllLegs ? " legs, " : " joints, ") + model.id + " has " +
         std::to_string(model.joints.size()) +
         (std::holds_alternative<HexapodGeometry>(model.geometry) ? " legs" : " joints");
}

}  // namespace sinew
