#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "cubes/cube_cell.h"
#include "sinew/planning/collision.h"

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

 private:
  void look_at(const planning::PlacedShape& body, bool is_finger,
               const std::vector<sim::CubeState>& cubes);

  CubeCell& cell_;
  planning::CollisionModel collision_;
  Pose<frame::Base, frame::World> X_BT_;                      ///< the table's frame as a world
  std::vector<planning::PlacedBox> fixed_;                    ///< basket and things with a height
  std::vector<std::pair<std::size_t, std::size_t>> touched_;  ///< cube, grasps before
  std::size_t grasps_ = 0;
  std::set<std::string> met_;
  std::size_t outside_ = 0;
};

}  // namespace sinew::cubes
