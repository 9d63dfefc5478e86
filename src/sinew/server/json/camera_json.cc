#include "sinew/server/json/camera_json.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "sinew/core/base64.h"
#include "sinew/core/rotation.h"
#include "sinew/runtime/cameras/cube_eyes.h"
#include "sinew/server/json/robot_json.h"
#include "sinew/vision/picture_file.h"

namespace sinew::server {
namespace {

Json corners_json(const vision::Quad& quad) {
  Json corners = Json::array();
  for (const vision::Pixel& p : quad) corners.push_back({p.x, p.y});
  return corners;
}

/// @param edge  m
Json cube_json(const vision::SeenCube& cube, const Pose<frame::World, frame::Table>& X_WT,
               double edge, const std::vector<CellBasket>& baskets) {
  Json json{{"color", name(cube.color)},
            {"confidence", cube.confidence},
            {"top_px", corners_json(cube.top)}};
  if (!cube.position) return json;
  // The calibration's world is its table.
  const Vec3 p_W = X_WT * cube.position->top_W;
  json["x_m"] = p_W.x;
  json["y_m"] = p_W.y;
  json["z_m"] = p_W.z;
  json["yaw_rad"] = cube.position->yaw + fixed_xyz(X_WT.R).z;
  json["edge_m"] = edge;
  const auto basket = std::ranges::find_if(
      baskets, [&](const CellBasket& one) { return runtime::is_in(one, p_W); });
  if (basket != baskets.end()) json["in_basket"] = basket->name;
  return json;
}

std::string jpeg(const vision::Picture& picture, int longest) {
  const auto bytes = vision::encode_jpeg(vision::shrunk(picture, longest));
  return base64({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

Json baskets_json(const std::vector<CellBasket>& baskets) {
  Json json = Json::array();
  for (const CellBasket& one : baskets) {
    json.push_back(box_json(one.name, one.X_WK.p, one.X_WK.R, one.size));
  }
  return json;
}

Json camera_description(const runtime::RunningCell& cell, std::size_t camera) {
  const CellCamera& place = cell.cell().cameras[camera];
  const auto X_WT = cell.table_at(camera);
  Json json{{"name", place.name},
            {"device", place.device},
            {"cube_m", place.cube},
            {"table", pose_json(X_WT.p, X_WT.R)}};
  const runtime::Camera* opened = cell.camera(camera);
  if (opened == nullptr) return json;
  if (!opened->calibration_file().empty()) {
    json["calibration"] = {{"file", opened->calibration_file()}};
    const std::string refused = opened->calibration_refused();
    if (!refused.empty()) json["calibration"]["refused"] = refused;
  }
  const auto kept = opened->calibration();
  if (!kept) return json;
  const vision::TableCamera& calibration = *kept;
  const auto X_WC = opened->pose(calibration);
  json["on_arm"] = opened->is_on_arm();
  json["lens"] = {{"width_px", calibration.model.width},  {"height_px", calibration.model.height},
                  {"fx_px", calibration.model.fx},        {"fy_px", calibration.model.fy},
                  {"cx_px", calibration.model.center.x},  {"cy_px", calibration.model.center.y},
                  {"distortion", calibration.model.lens}, {"accuracy_m", calibration.accuracy}};
  if (X_WC) json["lens"]["pose"] = pose_json(X_WC->p, X_WC->R);
  return json;
}

Json shot_json(const runtime::RunningCell& cell, std::size_t camera,
               const runtime::Camera::Shot& shot, std::uint64_t known, int longest) {
  const CellCamera& place = cell.cell().cameras[camera];
  Json cubes = Json::array();
  const std::vector<CellBasket> baskets = cell.baskets().all();
  for (const vision::SeenCube& cube : shot.seen.cubes) {
    cubes.push_back(cube_json(cube, shot.X_WT, place.cube, baskets));
  }
  Json refused = Json::array();
  for (const vision::RefusedShape& shape : shot.seen.refused) {
    refused.push_back({{"why", shape.why}, {"outline_px", corners_json(shape.outline)}});
  }
  Json json{{"camera", place.name},
            {"number", shot.number},
            {"width_px", shot.picture.width},
            {"height_px", shot.picture.height},
            {"cubes", cubes},
            {"refused", refused}};
  const runtime::Camera* opened = cell.camera(camera);
  if (!shot.fault && opened != nullptr && opened->is_on_arm()) {
    const auto X_WC = shot.X_WT * relabel<frame::Table, frame::Camera>(shot.X_TC);
    json["pose"] = pose_json(X_WC.p, X_WC.R);
  }
  if (place.device == kSimulatedCamera) json["trouble"] = name_of(cell.table()->trouble());
  if (!baskets.empty()) json["baskets"] = baskets_json(baskets);
  if (shot.fault) json["fault"] = error_json(*shot.fault, cell.station(0).robot());
  if (shot.picture.width > 0 && shot.number != known) json["picture"] = jpeg(shot.picture, longest);
  return json;
}

std::optional<runtime::SimulatedTable::Trouble> trouble_named(std::string_view name,
                                                              const runtime::SimulatedTable& table,
                                                              std::size_t camera) {
  runtime::SimulatedTable::Trouble trouble;
  trouble.covered = name == "covered";
  trouble.unplugged = name == "unplugged";
  trouble.frozen = name == "frozen";
  if (name == "hand") trouble.hand = table.hand_in_view(camera);
  if (name != "none" && name_of(trouble) != name) return std::nullopt;
  return trouble;
}

std::string_view name_of(const runtime::SimulatedTable::Trouble& trouble) {
  return trouble.unplugged ? "unplugged"
         : trouble.covered ? "covered"
         : trouble.frozen  ? "frozen"
         : trouble.hand    ? "hand"
                           : "none";
}

Json ShownTags::of(std::size_t camera, const runtime::Camera::Shot& shot) {
  Found& found = found_[camera];
  if (found.number == shot.number && !found.tags.is_null()) return found.tags;
  if (!finder_) finder_.emplace(std::vector{vision::TagFamily::k36h11});
  found = {shot.number, Json::array()};
  if (shot.picture.width == 0) return found.tags;
  for (const vision::SeenTag& tag : finder_->find(shot.picture)) {
    found.tags.push_back({{"id", tag.id}, {"corners_px", corners_json(tag.corners)}});
  }
  return found.tags;
}

}  // namespace sinew::server
