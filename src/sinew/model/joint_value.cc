#include "sinew/model/joint_value.h"

#include <cstdint>

#include "sinew/core/error_code.h"

namespace sinew {

Error beyond_limit(const Joint& joint, std::size_t index, double q, double limit) {
  return {joint.slides() ? ErrorCode::kLegLength : ErrorCode::kJointLimit,
          static_cast<std::int8_t>(index), q, limit};
}

Error beyond_limit(const Joint& joint, std::size_t index, double q) {
  return beyond_limit(joint, index, q, q < joint.lower ? joint.lower : joint.upper);
}

}  // namespace sinew
