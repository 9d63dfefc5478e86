#include "sinew/runtime/cameras/cube_eyes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"

namespace sinew::runtime {

bool is_in(const CellBasket& basket, const Vec3& p_W) {
  constexpr double kWall = 5e-3;  // m; a cube on the rim is not in it
  const Vec3 p_K = basket.X_WK.inverse() * p_W;
  return std::abs(p_K.x) < basket.size.x / 2 + kWall && std::abs(p_K.y) < basket.size.y / 2 + kWall;
}

bool is_in_any(const std::vector<CellBasket>& baskets, const Vec3& p_W) {
  return std::ranges::any_of(baskets, [&](const CellBasket& one) { return is_in(one, p_W); });
}

program::Sighting sighting_of(const vision::Detection& seen, double edge,
                              const CubeEyes::Place& place) {
  program::Sighting sighting;
  // The calibration's world is its table.
  const auto X_BT = relabel<frame::Base, frame::World>(place.X_WB.inverse() * place.X_WT);
  const double turn = fixed_xyz(X_BT.R).z;
  const auto middle_below = [&](const Vec3& top_W) {
    return X_BT * (top_W - Vec3{0, 0, edge / 2});
  };
  for (const vision::SeenCube& cube : seen.cubes) {
    if (!cube.position) continue;
    const grasping::Cube one{middle_below(cube.position->top_W),
                             std::remainder(cube.position->yaw + turn, kPi / 2), edge,
                             static_cast<int>(cube.color)};
    const bool done = is_in_any(place.baskets, place.X_WB * one.p_BO);
    (done ? sighting.in_baskets : sighting.cubes).push_back(one);
  }
  for (const vision::RefusedShape& shape : seen.refused) {
    if (!shape.position) continue;
    const vision::ThingPosition& thing = *shape.position;
    const grasping::Body body{
        middle_below(thing.top_W), thing.yaw + turn, {thing.half_x, thing.half_y, edge / 2}};
    if (is_in_any(place.baskets, place.X_WB * body.p_BO)) continue;
    sighting.others.push_back({body, shape.height == vision::Height::kLikely});
  }
  return sighting;
}

void CubeEyes::watch(bool on, bool anew) {
  if (on == (watched_ != nullptr)) return;
  if (!on) return std::exchange(watched_, nullptr)->end_watch();
  watched_ = cameras_[looks_with_];
  watched_->begin_watch(anew);
  // Read behind begin_watch(): a look that was under way may have counted before.
  undisturbed_ = watched_->disturbances();
}

program::Sighting CubeEyes::sighting(const Camera& with, const Camera::Shot& shot) const {
  return sighting_of(shot.seen, with.edge(), {shot.X_WT, X_WB_, baskets_.all()});
}

void CubeEyes::look(std::string_view camera) {
  const auto found =
      std::ranges::find_if(cameras_, [&](const Camera* one) { return one->name() == camera; });
  looks_with_ = found != cameras_.end() ? static_cast<std::size_t>(found - cameras_.begin()) : 0;
  wanted_ = cameras_[looks_with_]->ask();
}

std::optional<Expected<program::Sighting>> CubeEyes::seen() {
  const Camera& with = *cameras_[looks_with_];
  const auto shot = with.newest();
  if (wanted_ == 0 || !shot || shot->number < wanted_) return std::nullopt;
  wanted_ = 0;
  if (listener_) listener_(with, shot);
  if (shot->fault) return std::unexpected(*shot->fault);
  return sighting(with, *shot);
}

std::optional<program::Sighting> CubeEyes::newest() const {
  Camera& with = *cameras_.front();
  const auto shot = with.newest();
  if (!shot) with.refresh();
  if (!shot || shot->fault) return std::nullopt;
  return sighting(with, *shot);
}

std::vector<std::string> CubeEyes::names() const {
  std::vector<std::string> names;
  for (const Camera* one : cameras_) names.push_back(one->name());
  return names;
}

}  // namespace sinew::runtime
