#include "sinew/model/error_sentence.h"

#include "sinew/model/collision_links.h"

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
  if (error.index < 0 || index >= model.joints.size()) return {};
  return model.joints[index].name;
}

std::string sentence_of(const Error& error, const RobotModel& model) {
  const auto index = static_cast<std::size_t>(error.index);
  const bool slides = error.index >= 0 && index < model.joints.size() &&
                      model.joints[index].kind == JointKind::kPrismatic;
  // What is an angle of other joints is a length of this one.
  const bool length = slides && info(error.code).quantity == Quantity::kAngle &&
                      error.code != ErrorCode::kCardanAngle && error.code != ErrorCode::kBallAngle;
  return describe(error, subject_of(error, model),
                  length ? std::optional(Quantity::kLength) : std::nullopt);
}

}  // namespace sinew
