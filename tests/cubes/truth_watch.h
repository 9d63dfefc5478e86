#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cubes/cube_cell.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::cubes {

/// Holds what a simulated arm really does against what it must not touch: cubes that it does not
/// take next, the basket, the table and what else stands on it, and its joints' limits. Looked at
/// every few milliseconds of real time.
class TruthWatch {
 public:
  explicit TruthWatch(CubeCell& cell, std::vector<Thing> clutter);

  /// Now.
  void look();
  /// Contacts with anything but the cube that was taken next, those that the cubes' world reports
  /// included. @param ended  of the run that was watched
  std::vector<std::string> contacts(const Ended& ended) const;
  std::size_t joints_outside() const { return outside_; }
  /// The basket, and things with a height, in base B.
  std::span<const planning::PlacedBox> fixed() const { return fixed_; }

 private:
  /// The arm's own body in a cube.
  struct Touch {
    std::size_t cube = 0;
    std::size_t before = 0;  ///< grasps
    std::string link;
    double depth = 0;  ///< m
  };

  void look_at(const planning::PlacedShape& body, const CollisionShape& shape,
               const std::vector<sim::CubeState>& cubes);
  void meet(std::string_view link, std::string_view what, double apart);

  CubeCell& cell_;
  planning::CollisionModel collision_;
  Pose<frame::Base, frame::World> X_BT_;    ///< the table's frame as a world
  std::vector<planning::PlacedBox> fixed_;  ///< basket and things with a height
  std::vector<Touch> touched_;
  std::size_t grasps_ = 0;
  std::map<std::string, double> met_;  ///< and how deep, m
  std::size_t outside_ = 0;
};

}  // namespace sinew::cubes
