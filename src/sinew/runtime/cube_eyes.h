#pragma once

#include <cstdint>
#include <optional>

#include "sinew/model/cell.h"
#include "sinew/program/eyes.h"
#include "sinew/runtime/camera.h"

namespace sinew::runtime {

/// Cubes in front of one robot by a calibrated camera of its cell.
class CubeEyes : public program::Eyes {
 public:
  struct Place {
    Pose<frame::World, frame::Table> X_WT;  ///< the camera's
    Pose<frame::World, frame::Base> X_WB;   ///< the robot's
    std::optional<CellBasket> basket;       ///< cubes in it are not looked at
  };

  /// @param camera  calibrated; outlives this
  CubeEyes(const Place& place, Camera& camera) : place_(place), camera_(camera) {}

  void look() override { wanted_ = camera_.ask(); }
  std::optional<Expected<program::Sighting>> seen() override;

 private:
  Place place_;
  Camera& camera_;
  std::uint64_t wanted_ = 0;  ///< 0: none
};

/// Whether a place lies over a basket, its walls too. m, in W
bool is_in(const CellBasket& basket, const Vec3& p_W);

/// What a picture's cubes are in front of a robot.
/// @param edge  m, of all of them
program::Sighting sighting_of(const vision::Detection& seen, double edge,
                              const CubeEyes::Place& place);

}  // namespace sinew::runtime
