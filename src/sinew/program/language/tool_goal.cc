#include "sinew/program/language/tool_goal.h"

namespace sinew::program {

using planning::Asked;
using planning::TaskPoint;
using planning::TaskSpace;
using planning::ToolTarget;

ToolTarget with_offset(const ToolGoal& goal, const ToolTarget& target,
                       const planning::ToolSpace& space) {
  if (!goal.offset) return target;
  const GoalOffset& offset = *goal.offset;
  ToolTarget out = target;
  // A palletizer's tool turns with its base: its axes are those that it will have there.
  if (space.task() == TaskSpace::kPoint) out.X_BT = space.pose(space.point(target.X_BT));
  const Rotation R_BT = out.X_BT.R;
  out.X_BT.p = out.X_BT.p + (offset.in_tool ? R_BT * offset.dp : offset.dp);
  if (!(offset.turn == Vec3{})) {
    const Rotation turn = rotation_from_fixed_xyz(offset.turn);
    out.X_BT.R = offset.in_tool ? R_BT * turn : turn * R_BT;
    out.asked = Asked::kPose;
  }
  if (offset.pitch != 0 || offset.roll != 0) {
    TaskPoint point = space.point(out.X_BT);
    point.attitude[0] += offset.pitch;
    point.attitude[1] += offset.roll;
    out = {space.pose(point), Asked::kPose};
  }
  return out;
}

ToolGoal goal_of(const ToolPlace& place) {
  return {{place.p_BT.x, place.p_BT.y, place.p_BT.z}, place.R_BT, place.pitch, place.roll, {}};
}

}  // namespace sinew::program
