#pragma once

#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// Adds the schema of `device.status` and of frames of its wire, and what they refer to.
void put_device(Json& all);

}  // namespace sinew::server
