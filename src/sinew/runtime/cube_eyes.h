#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

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

  /// Gets each picture that counts.
  using Listener = std::function<void(const std::shared_ptr<const Camera::Shot>&)>;

  /// @param camera  calibrated; outlives this
  CubeEyes(const Place& place, Camera& camera, Listener listener)
      : place_(place), camera_(camera), listener_(std::move(listener)) {}

  void look() override { wanted_ = camera_.ask(); }
  std::optional<Expected<program::Sighting>> seen() override;
  void watch(bool on) override;
  bool disturbed() const override { return watching_ && camera_.disturbances() != undisturbed_; }

 private:
  Place place_;
  Camera& camera_;
  Listener listener_;
  std::uint64_t wanted_ = 0;  ///< 0: none
  bool watching_ = false;
  std::uint64_t undisturbed_ = 0;
};

/// Whether a place lies over a basket, its walls too. m, in W
bool is_in(const CellBasket& basket, const Vec3& p_W);

/// What a picture's cubes are in front of a robot.
/// @param edge  m, of all of them
program::Sighting sighting_of(const vision::Detection& seen, double edge,
                              const CubeEyes::Place& place);

}  // namespace sinew::runtime
