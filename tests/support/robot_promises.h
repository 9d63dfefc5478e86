#pragma once

#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::test {

/// The first promise of model/robot_model.h that `model` breaks, in words; empty where it keeps
/// them all. Written without the reader's code, so that the two can disagree.
std::string broken_promise(const RobotModel& model);

}  // namespace sinew::test
