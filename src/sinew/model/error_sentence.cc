#include "sinew/model/error_sentence.h"

#include "sinew/core/error_code.h"
#include "sinew/model/collision_links.h"
#include "sinew/model/left_out.h"

namespace sinew {

std::string subject_of(const Error& error, const RobotModel& model) {
  const auto index = static_cast<std::size_t>(error.index);
  const bool of_links =
      error.code == ErrorCode::kCollision || error.code == ErrorCode::kJawsContact;
  if (of_links && error.index >= 0 && error.other >= 0) {
    return std::string(link_name(model, index)) + " and " +
           std::string(link_name(model, static_cast<std::size_t>(error.other)));
  }
  const bool in_cell = error.code == ErrorCode::kCellContact || error.code == ErrorCode::kCellTaken;
  if (in_cell && error.index >= 0) return std::string(link_name(model, index));
  if (error.index >= 0 && index == model.joints.size()) return "the jaws";
  if (error.index < 0 || index > model.joints.size()) return {};
  return model.joints[index].name;
}

Quantity quantity_of(const Error& error, const RobotModel& model) {
  const auto index = static_cast<std::size_t>(error.index);
  const Quantity usual = info(error.code).quantity;
  const bool slides =
      error.index >= 0 && index < model.joints.size() && model.joints[index].slides();
  const bool of_leg = error.code == ErrorCode::kCardanAngle || error.code == ErrorCode::kBallAngle;
  if (!slides || of_leg) return usual;
  switch (usual) {
    case Quantity::kAngle:
      return Quantity::kLength;
    case Quantity::kAngularVelocity:
      return Quantity::kVelocity;
    case Quantity::kAngularAcceleration:
      return Quantity::kAcceleration;
    default:
      return usual;
  }
}

std::string sentence_of(const Error& error, const RobotModel& model) {
  const auto index = static_cast<std::size_t>(error.index);
  if (error.code == ErrorCode::kPositionUnknown && error.index >= 0 && is_left_out(model, index)) {
    const std::string name = model.joints[index].name;
    return name + " (J" + std::to_string(index + 1) +
           ") is left out, its position is unknown; use joint moves that do not name " + name;
  }
  return describe(error, subject_of(error, model), quantity_of(error, model));
}

}  // namespace sinew
