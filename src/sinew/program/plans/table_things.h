#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/program/language/eyes.h"
#include "sinew/program/language/table_top.h"

namespace sinew::program {

/// What stands on the table in front of a robot, as a plan keeps clear of it.
struct TableThings {
  /// For vertical motions of the tool, with or without a cube: upright boxes.
  std::vector<planning::Surrounding> bare{};
  /// For lateral motions of the empty tool.
  std::vector<planning::Surrounding> aside{};
  /// For what carries a cube aside: wider, and higher below a cup, as the cube is more than the
  /// robot's own bodies.
  std::vector<planning::Surrounding> carrying{};
};

/// m; bodies of a plan may come nearer to what was seen than the margin of the robot's file, about
/// as near as grasping::kApart: that much smaller each thing is in TableThings.
double things_shrunk_by(const RobotModel& robot);

/// The walls of baskets, cubes and likely obstacles, uncertain obstacles; of each the nearest to
/// the robot first, as many as a plan takes.
/// @param but      one of seen.cubes that is left out
/// @param carried  m, edge of the cube that is or will be held
/// @param room     m, extra clearance of lateral motions: a loaded arm sags
TableThings things_on_table(const RobotModel& robot, const Sighting& seen,
                            std::optional<std::size_t> but, std::span<const Basket> baskets,
                            double carried, double room = 0);

}  // namespace sinew::program
