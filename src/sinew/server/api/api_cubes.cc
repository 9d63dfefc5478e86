// What of the cubes that a camera sees a robot can have, and baskets.
#include <algorithm>
#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/foresight.h"
#include "sinew/server/api/api.h"
#include "sinew/server/json/camera_json.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

constexpr double kFarthest = 100;   // m
constexpr double kEdgeMin = 5e-3;   // m
constexpr double kEdgeMax = 0.2;    // m
constexpr double kRounding = 1e-4;  // m: one region for what differs by less

Json verdict_json(const program::CubeVerdict& verdict, const grasping::Cube& cube,
                  const Pose<frame::World, frame::Base>& X_WB, const RobotModel& robot) {
  const Vec3 p_W = X_WB * (cube.p_BO + Vec3{0, 0, cube.edge / 2});
  Json json{{"color", name(static_cast<vision::ColorName>(cube.color))},
            {"x_m", p_W.x},
            {"y_m", p_W.y},
            {"z_m", p_W.z},
            {"fine", verdict.rows.has_value()}};
  if (verdict.rows) {
    json["tilt_rad"] = verdict.rows->tilt;
    json["duration_s"] = verdict.rows->duration;
    return json;
  }
  const Error& why = verdict.rows.error().error;
  json["error"] = error_json(why, robot);
  if (const auto help = program::help_with_cube(why.code); !help.empty()) json["help"] = help;
  return json;
}

/// As previews look: at what stands in the cell, and at robots that rest there.
program::WayLook look_in(const runtime::RunningCell& cell, std::size_t robot) {
  return [&cell, robot](const planning::CellWay& way) -> std::optional<Error> {
    const auto meeting = cell.space().meets(robot, way);
    return meeting ? std::optional(meeting->error) : std::nullopt;
  };
}

/// Why a robot that takes cubes cannot put them into this basket; nothing where it can.
std::optional<Json> far_from(const runtime::RunningCell& cell, std::size_t robot,
                             const CellBasket& basket) {
  const RobotModel& model = cell.station(robot).robot();
  program::RowPlanner planner(model);
  const program::Step row{0, program::PlaceCubeStep{program::BasketGoal{basket.name, {}}}};
  const auto table = cell.table_top(robot);
  const program::Standing home(home_joints(model), {program::kUsualCube, program::kUsualCube});
  const auto rows = program::rows_to_place(planner, home, row, table.get());
  if (rows) return std::nullopt;
  return Json{{"robot", cell.station(robot).name()},
              {"error", error_json(rows.error().error, model)}};
}

}  // namespace

Api::Answer Api::judge_cubes(const Call& call) {
  const auto camera = camera_of(call);
  if (!camera) return camera.error();
  const std::size_t robot = *call.robot;
  if (!program::can_pick(cell_.station(robot).robot())) {
    return RpcError{RpcCode::kRefused, "this robot's tool takes no cubes", nullptr};
  }
  return Errand{
      verdicts_, as_task([this, robot, i = *camera]() -> Keeper::Result {
        const runtime::Station& station = cell_.station(robot);
        const CellCamera& place = cell_.cell().cameras[i];
        const auto& X_WB = cell_.cell().robots[robot].X_WB;
        program::Standing from = standing(station);
        // Where that is unknown: as from its home.
        if (!from.q) from.q = home_joints(station.robot());
        const auto shot = cell_.camera(i)->newest();
        Json json{{"camera", place.name}, {"number", shot ? shot->number : 0}};
        if (!shot || shot->fault) return json;
        const program::Sighting seen =
            runtime::sighting_of(shot->seen, place.cube, {shot->X_WT, X_WB, cell_.baskets().all()});
        program::RowPlanner planner(station.robot());
        planner.show_to(look_in(cell_, robot));
        Json cubes = Json::array();
        const auto table = cell_.table_top(robot);
        for (const auto& verdict : program::judge_cubes(planner, from, seen, table->baskets)) {
          cubes.push_back(verdict_json(verdict, seen.cubes[verdict.which], X_WB, station.robot()));
        }
        json["cubes"] = std::move(cubes);
        return json;
      })};
}

Api::Answer Api::cube_reach(const Call& call) {
  const std::size_t robot = *call.robot;
  if (!program::can_pick(cell_.station(robot).robot())) {
    return RpcError{RpcCode::kRefused, "this robot's tool takes no cubes", nullptr};
  }
  const auto& cameras = cell_.cell().cameras;
  const double edge =
      call.request.number("edge_m", cameras.empty() ? program::kUsualCube : cameras.front().cube);
  if (!(edge >= kEdgeMin && edge <= kEdgeMax)) return invalid("edge_m has to be 0.005 to 0.2");
  const double foot = cell_.cell().robots[robot].X_WB.p.z;
  const double height = call.request.number("z_m", cameras.empty() ? foot : cell_.table_at(0).p.z);
  if (!(std::abs(height) <= kFarthest)) return invalid("z_m has to be -100 to 100");
  const auto rounded = [](double value) { return std::round(value / kRounding) * kRounding; };
  return reach_.look({robot, rounded(edge), rounded(height)});
}

Api::Answer Api::move_basket(const Call& call) {
  const std::string wanted = call.request.text("basket");
  const auto basket = cell_.baskets().find(wanted);
  if (!basket) {
    std::string names;
    for (const CellBasket& one : cell_.baskets().all()) {
      names += (names.empty() ? "" : ", ") + one.name;
    }
    return invalid(names.empty() ? "this cell has no basket; [basket] in its file names one"
                                 : "no basket of this cell has that name; there are " + names);
  }
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    const runtime::JobView job = cell_.jobs(i).view();
    if (job.over || !job.handles_cubes) continue;
    return RpcError{RpcCode::kBusy,
                    "'" + job.title + "' handles cubes on " + cell_.station(i).name() +
                        ": stop it or wait for its end, then move the basket",
                    {{"code", "under_way"}}};
  }
  CellBasket moved = cell_.baskets().all()[*basket];
  moved.X_WK.p.x = call.request.params["x_m"].get<double>();
  moved.X_WK.p.y = call.request.params["y_m"].get<double>();
  if (!(std::abs(moved.X_WK.p.x) <= kFarthest && std::abs(moved.X_WK.p.y) <= kFarthest)) {
    return invalid("x_m and y_m have to be -100 to 100");
  }
  if (call.request.params.contains("turn_rad")) {
    moved.X_WK.R = rotation_z(call.request.number("turn_rad", 0));
  }
  cell_.move_basket(*basket, moved.X_WK);
  return Errand{moves_, as_task([this, moved]() -> Keeper::Result {
                  if (const auto kept = cell_.baskets().keep(); !kept) {
                    return std::unexpected(
                        RpcError{RpcCode::kFailed,
                                 "the basket counts where it is now, until sinew serve ends; "
                                 "it could not be kept: " +
                                     kept.error().sentence,
                                 {{"code", "disk"}}});
                  }
                  Json warnings = Json::array();
                  for (std::size_t i = 0; i < cell_.size(); ++i) {
                    if (!program::can_pick(cell_.station(i).robot())) continue;
                    if (auto far = far_from(cell_, i, moved)) warnings.push_back(std::move(*far));
                  }
                  return Json{{"basket", baskets_json({moved}).front()}, {"warnings", warnings}};
                })};
}

}  // namespace sinew::server
