#include "sinew/control/position_evidence.h"

#include <algorithm>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/left_out.h"

namespace sinew::control {

Expected<JointInterval> agree(std::size_t joint, std::span<const Evidence> known,
                              const JointPosition& said) {
  JointInterval where{said.lower, said.upper};
  for (const Evidence& one : known) {
    const double lower = one.where.lower - one.slack;
    const double upper = one.where.upper + one.slack;
    if (where.upper < lower || where.lower > upper) {
      const bool counted = one.source == Evidence::Source::kCounters;
      const double middle = (one.where.lower + one.where.upper) / 2;
      const double nearest = said.q < one.where.lower ? one.where.lower : one.where.upper;
      return std::unexpected(
          Error{counted ? ErrorCode::kCountedElsewhere : ErrorCode::kDeclaredElsewhere,
                static_cast<std::int8_t>(joint), said.q, counted ? middle : nearest});
    }
    where = {std::max(where.lower, lower), std::min(where.upper, upper)};
  }
  return where;
}

Expected<FixedVector<JointPosition, kMaxJoints>> as_shown(const RobotModel& robot,
                                                          std::span<const JointPosition> known,
                                                          std::span<const JointPosition> said) {
  constexpr double kTurn = from_deg(3);
  constexpr double kLength = from_mm(1);
  FixedVector<JointPosition, kMaxJoints> shown;
  for (std::size_t j = 0; j < known.size(); ++j) {
    if (is_left_out(robot, j)) {
      shown.push_back({});
      continue;
    }
    const bool lost = known[j].quality == PositionQuality::kLost;
    JointPosition joint = lost && j < said.size() ? said[j] : known[j];
    const double widest = robot.joints[j].slides() ? kLength : kTurn;
    const bool wide =
        joint.quality == PositionQuality::kUncertain && !(joint.upper - joint.lower <= widest);
    if (joint.quality == PositionQuality::kLost || wide) {
      return std::unexpected(Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(j)});
    }
    joint.quality = PositionQuality::kCommanded;
    joint.q = (joint.lower + joint.upper) / 2;
    shown.push_back(joint);
  }
  return shown;
}

double reach_beyond_limits(const Joint& joint) {
  return joint.slides() ? from_mm(2) : from_deg(10);
}

}  // namespace sinew::control
