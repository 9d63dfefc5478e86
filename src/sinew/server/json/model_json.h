#pragma once

#include "sinew/model/robot_model.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// What a robot is drawn and steered from. Links are those of model/collision_links.h; each says
/// where it is with the joints at home, in base B, so that whoever computes it can check itself.
Json model_json(const RobotModel& model);

}  // namespace sinew::server
