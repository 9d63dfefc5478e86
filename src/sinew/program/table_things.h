#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/planning/collision.h"
#include "sinew/program/eyes.h"
#include "sinew/program/table_top.h"

namespace sinew::program {

/// What stands on the table in front of a robot, as a plan keeps clear of it.
struct TableThings {
  /// For the tool on its way up and down, with what it lifts or sets down: upright boxes.
  std::vector<planning::Surrounding> bare{};
  /// For the empty tool on its other ways.
  std::vector<planning::Surrounding> aside{};
  /// For what carries a cube aside: wider, and higher below a cup, as the cube is more than the
  /// robot's own bodies.
  std::vector<planning::Surrounding> carrying{};
};

/// m; bodies of a plan may come nearer to what was seen than the margin of the robot's file, about
/// as near as grasping::kApart: that much smaller each thing is in TableThings.
double things_shrunk_by(const RobotModel& robot);

/// Cubes that are seen, what else is, and the walls of baskets; the nearest to the robot where they
/// are more than a plan takes.
/// @param but      one of seen.cubes that is left out
/// @param carried  m, edge of the cube that is or will be held
/// @param room     m, that ways aside keep more: an arm with a load hangs lower than it was sent
TableThings things_on_table(const RobotModel& robot, const Sighting& seen,
                            std::optional<std::size_t> but, std::span<const Basket> baskets,
                            double carried, double room = 0);

}  // namespace sinew::program
