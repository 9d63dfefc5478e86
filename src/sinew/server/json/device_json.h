#pragma once

#include "sinew/runtime/links/wire_monitor.h"
#include "sinew/server/json/json_rpc.h"

/// What a robot's device has told of itself, and what passes on its wire.
namespace sinew::server {

/// {"wire", "at_s", "warnings", ..}: the last answers with their age and bytes; by wire what
/// docs/api.md says.
Json device_json(const DeviceFacts& facts, const RobotModel& model, Instant now);

Json frame_json(const runtime::WireMonitor::Frame& frame);

}  // namespace sinew::server
