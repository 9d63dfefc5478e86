#include "sinew/model/error_sentence.h"

#include "sinew/model/collision_links.h"

namespace sinew {

std::string subject_of(const Error& error, const RobotModel& model) {
  const auto index = static_cast<std::size_t>(error.index);
  if (error.code == ErrorCode::kCollision && error.index >= 0 && error.other >= 0) {
    return std::string(link_name(model, index)) + " and " +
           std::string(link_name(model, static_cast<std::size_t>(error.other)));
  }
  if (error.index < 0 || index >= model.joints.size()) return {};
  return model.joints[index].name;
}

std::string sentence_of(const Error& error, const RobotModel& model) {
  return describe(error, subject_of(error, model));
}

}  // namespace sinew
