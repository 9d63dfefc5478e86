#include "sinew/runtime/homing_time.h"

#include "sinew/devices/kinds.h"
#include "sinew/model/left_out.h"

namespace sinew::runtime {

program::Homing homing_of(const RobotModel& robot) {
  program::Homing homing;
  const auto search = kind_of(robot.device).search;
  if (search == nullptr) return homing;
  homing.rest.emplace();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const bool left_out = is_left_out(robot, i);
    const ZeroSearch one =
        left_out ? ZeroSearch{0, assumed_place(robot.joints[i])} : search(robot, i);
    homing.times.push_back(one.longest);
    homing.rest->push_back(one.end);
  }
  return homing;
}

}  // namespace sinew::runtime
