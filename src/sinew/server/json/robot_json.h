#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sinew/planning/paths/tool_space.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/json/json_rpc.h"

/// What the server says of robots: SI and radians, the unit in each number's name.
namespace sinew::server {

/// {"code", "sentence"}; "joint" or "link" or "links" where it is about one; "measured" and "limit"
/// with their unit in the name where it has such.
Json error_json(const Error& error, const RobotModel& model);

/// {"x_m", "y_m", "z_m", "quaternion_wxyz"}
Json pose_json(const Vec3& p, const Rotation& R);
/// A pose_json() with "name", and "length_m", "width_m", "height_m": `size` along x, y and z.
Json box_json(const std::string& name, const Vec3& p, const Rotation& R, const Vec3& size);

/// What is wrong with a text that a client has sent: the first complaint, and all in `complaints`.
RpcError complained(const std::vector<Complaint>& complaints);

/// Instead of its sentence, and beside it: what in the cell is in the way, and where.
void put_in_the_way(Json& json, const runtime::CellRefusal& refusal);

/// What never changes: its joints and limits, where it stands, what it hangs on.
Json description_json(const CellRobot& place, const runtime::Station& station);

/// Each joint's position with its interval, as far as it is known.
Json joints_json(const runtime::StationView& view, const RobotModel& model);
/// How it is now.
/// @param tool    of the same robot, its jaws as they are
/// @param X_near  a hexapod's last pose, and then this one
Json status_json(const runtime::Station& station, const runtime::StationView& view,
                 const planning::ToolSpace& tool, planning::PoseBT& X_near);

Json job_json(const std::string& robot, const runtime::JobView& job, const RobotModel& model);
/// "opening", "running", "paused", "stopping", "done", "stopped", "failed".
std::string_view phase_name(const runtime::JobView& job);

Json truth_json(const sim::Truth& truth, const RobotModel& model);

/// What held motions back for longest, and for which share of their time, as `limited`; nothing
/// where nothing moves.
void put_limited(Json& json, const planning::LimitTimes& limits, const RobotModel& model);
/// A cause that is latched, with its category and what was wrong.
Json latched_json(const control::Latched& latched, const RobotModel& model);
/// A cause of a stop, for machines.
std::string_view cause_name(control::StopCause cause);
/// 0 to 2 after IEC 60204-1; nothing where nothing was moving because of it.
std::optional<int> category_number(control::StopCause cause,
                                   const std::optional<Error>& reason = {});

}  // namespace sinew::server
