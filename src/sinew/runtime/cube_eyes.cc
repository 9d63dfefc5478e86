#include "sinew/runtime/cube_eyes.h"

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

program::Sighting sighting_of(const vision::Detection& seen, double edge,
                              const CubeEyes::Place& place) {
  program::Sighting sighting;
  // The calibration's world is its table.
  const auto X_BT = relabel<frame::Base, frame::World>(place.X_WB.inverse() * place.X_WT);
  const double turn = fixed_xyz(X_BT.R).z;
  for (const vision::SeenCube& cube : seen.cubes) {
    if (!cube.position) continue;
    grasping::Cube one;
    one.p_BO = X_BT * (cube.position->top_W - Vec3{0, 0, edge / 2});
    one.yaw = std::remainder(cube.position->yaw + turn, kPi / 2);
    one.edge = edge;
    one.color = static_cast<int>(cube.color);
    if (place.basket && is_in(*place.basket, place.X_WB * one.p_BO)) continue;
    sighting.cubes.push_back(one);
  }
  return sighting;
}

void CubeEyes::watch(bool on) {
  if (on == watching_) return;
  watching_ = on;
  if (!on) return camera_.end_watch();
  undisturbed_ = camera_.disturbances();
  camera_.begin_watch();
}

std::optional<Expected<program::Sighting>> CubeEyes::seen() {
  const auto shot = camera_.newest();
  if (wanted_ == 0 || !shot || shot->number < wanted_) return std::nullopt;
  wanted_ = 0;
  if (listener_) listener_(shot);
  if (shot->fault) return std::unexpected(*shot->fault);
  return sighting_of(shot->seen, camera_.settings().edge, place_);
}

}  // namespace sinew::runtime
