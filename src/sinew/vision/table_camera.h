#pragma once

#include <optional>
#include <string>

#include "sinew/vision/camera_model.h"
#include "sinew/vision/cube_detection.h"

namespace sinew::vision {

/// A camera whose lens and pose over a table are known. The world's z = 0 is the table.
struct TableCamera {
  std::string name;
  CameraModel model;
  Pose<frame::World, frame::Camera> X_WC;
  double reprojection = 0;  ///< px, rms, of the views that it was measured with
  double accuracy = 0;      ///< m at the table, 95 %, of views that it was not measured with
};

/// Where what is seen at a pixel meets the plane z = height. m, in W; nothing where it never does
std::optional<Vec3> on_plane(const TableCamera& camera, Pixel p, double height);

/// Where a cube of edge `edge` (m) is: its top lies at the first multiple of the edge at which what
/// is seen has that size. Towers of up to six are told apart where the camera is near enough.
/// @return  nothing where its top would be off that size by more than a quarter on each level
std::optional<CubePosition> cube_position(const TableCamera& camera, const SeenCube& cube,
                                          double edge);

/// Gives all cubes their positions; those that have another size are refused.
/// @param edge  m, of all cubes
void place_on_table(Detection& detection, const TableCamera& camera, double edge);

}  // namespace sinew::vision
