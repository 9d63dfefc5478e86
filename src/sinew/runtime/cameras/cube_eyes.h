#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sinew/model/cell.h"
#include "sinew/program/language/eyes.h"
#include "sinew/runtime/cameras/camera.h"
#include "sinew/runtime/cameras/cell_baskets.h"

namespace sinew::runtime {

/// Cubes in front of one robot by the calibrated cameras of its cell.
class CubeEyes : public program::Eyes {
 public:
  struct Place {
    Pose<frame::World, frame::Table> X_WT;  ///< the camera's
    Pose<frame::World, frame::Base> X_WB;   ///< the robot's
    std::vector<CellBasket> baskets;        ///< cubes in them are done with
  };

  /// Gets each picture that counts, with its camera.
  using Listener =
      std::function<void(const Camera& camera, const std::shared_ptr<const Camera::Shot>&)>;

  /// @param X_WB     the robot's
  /// @param baskets  outlive this
  CubeEyes(const Pose<frame::World, frame::Base>& X_WB, const CellBaskets& baskets,
           Listener listener)
      : X_WB_(X_WB), baskets_(baskets), listener_(std::move(listener)) {}
  /// One more to look with. @param camera  calibrated; outlives this
  void add(Camera& camera) { cameras_.push_back(&camera); }

  void look(std::string_view camera) override;
  std::optional<Expected<program::Sighting>> seen() override;
  void watch(bool on, bool anew) override;
  std::optional<Error> disturbed() const override {
    return watched_ != nullptr ? watched_->disturbed_since(undisturbed_) : std::nullopt;
  }
  /// What the newest picture of the first camera shows, whenever it was taken; asks for one where
  /// there is none yet. Nothing where it shows nothing.
  std::optional<program::Sighting> newest() const;
  std::vector<std::string> names() const;

 private:
  program::Sighting sighting(const Camera& with, const Camera::Shot& shot) const;

  Pose<frame::World, frame::Base> X_WB_;
  const CellBaskets& baskets_;
  std::vector<Camera*> cameras_;
  Listener listener_;
  std::size_t looks_with_ = 0;
  std::uint64_t wanted_ = 0;  ///< 0: none
  Camera* watched_ = nullptr;
  std::uint64_t undisturbed_ = 0;
};

/// Whether a place lies over a basket, its walls too. m, in W
bool is_in(const CellBasket& basket, const Vec3& p_W);
bool is_in_any(const std::vector<CellBasket>& baskets, const Vec3& p_W);

/// What a picture's cubes are in front of a robot.
/// @param edge  m, of all of them
program::Sighting sighting_of(const vision::Detection& seen, double edge,
                              const CubeEyes::Place& place);

}  // namespace sinew::runtime
