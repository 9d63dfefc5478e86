#include "sinew/render/silhouette.h"

#include <algorithm>
#include <cmath>

#include "sinew/kinematics/serial_arm.h"
#include "sinew/render/solids.h"
#include "sinew/render/tracer.h"

namespace sinew::render {
namespace {

/// What the fingers of a robot hold, larger than it is: it may hang in them anyhow.
void add_held(Scene& scene, const ViewedRobot& robot) {
  const auto* serial = std::get_if<SerialGeometry>(&robot.model.geometry);
  if (serial == nullptr || robot.held <= 0) return;
  const double half = 0.8 * robot.held;
  const auto X_WT = robot.X_WB * kinematics::SerialChain(*serial).forward(robot.q) *
                    kinematics::tool_pose(*serial, robot.jaws);
  scene.solids.push_back(
      {box({half, half, half}, 0), relabel<frame::World, frame::Solid>(X_WT), {}});
}

}  // namespace

std::vector<bool> silhouette(std::span<const ViewedRobot> robots, const vision::CameraModel& camera,
                             const Pose<frame::World, frame::Camera>& X_WC, double margin) {
  const vision::CellGrid grid = vision::grid_of(camera.width, camera.height);
  std::vector<bool> cells(grid.size(), false);
  Scene scene;
  for (const ViewedRobot& robot : robots) {
    add_robot(scene, robot, {}, {}, {});
    add_held(scene, robot);
  }
  if (scene.solids.empty()) return cells;
  constexpr double kMount = 0.03;  // m: nearer is what carries the camera
  const Tracer tracer(scene);
  const double cell = 1.0 * camera.width / grid.columns;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const vision::Pixel p{(column + 0.5) * cell, (row + 0.5) * cell};
      const Vec3 along = X_WC.R * camera.direction(p);
      const auto hit = tracer.nearest({X_WC.p + kMount * along, along});
      if (!hit) continue;
      const int around =
          static_cast<int>(std::ceil(margin * camera.fx / ((kMount + hit->distance) * cell)));
      for (int y = std::max(0, row - around); y <= std::min(grid.rows - 1, row + around); ++y) {
        const int first = std::max(0, column - around);
        const int last = std::min(grid.columns - 1, column + around);
        const auto begin = cells.begin() + static_cast<std::ptrdiff_t>(grid.at(first, y));
        std::fill(begin, begin + (last - first + 1), true);
      }
    }
  }
  return cells;
}

}  // namespace sinew::render
