#pragma once

#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "sinew/vision/camera_model.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/tag_board.h"

namespace sinew::vision {

/// Where the table is, as the tip of a robot's tool has touched it.
struct TouchedTable {
  std::string robot;  ///< its name in the cell
  Pose<frame::Base, frame::World> X_BW;
  double error = 0;  ///< m, 95 %, at the corner of the sheet where it is largest
};

/// A camera whose lens and pose over a table are known. The world's z = 0 is the table.
struct TableCamera {
  std::string name;
  CameraModel model;
  Pose<frame::World, frame::Camera> X_WC;
  double reprojection = 0;  ///< px, rms, of the views that it was measured with
  double accuracy = 0;      ///< m at the table, 95 %, of views that it was not measured with
  /// Of the sheet that lies in W since then, as table_sheet() has it; empty: none does.
  std::string sheet;
  /// Which camera it is, as camera_identity() names it; empty: not known. It is true for no other.
  std::string identity;
  std::optional<TouchedTable> touched{};  ///< nothing: it is as the cell's file says
};

/// Where what is seen at a pixel meets the plane z = height. m, in W; nothing where it never does
std::optional<Vec3> on_plane(const TableCamera& camera, Pixel p, double height);

/// How far the tags of the camera's sheet seem to be from where they lie, m: the middle of all
/// corners that are seen; nothing where none is. @pre it has a sheet
/// @param tags  of a picture of this camera
std::optional<double> sheet_shift(const TableCamera& camera, const TagBoard& sheet,
                                  const std::vector<SeenTag>& tags);

/// Why a detection has no position as a cube, and how high the object may be.
struct NotPlaced {
  std::string why;
  Height height = Height::kPerhaps;
};

/// Where a cube of edge `edge` (m) is: on the table or on others, its top at the multiple of the
/// edge at which a square of that size fits the picture best. Towers of up to six.
/// @param hidden  as place_on_table() has it
/// @return  why not, where its top would be off that size by more than a quarter on each level, or
///          too much of it is hidden
std::expected<CubePosition, NotPlaced> cube_position(const Picture& picture,
                                                     const TableCamera& camera,
                                                     const SeenCube& cube, double edge,
                                                     const std::vector<bool>& hidden = {});

/// Gives all cubes their positions; those that have another size, or are hidden too much to say
/// where they are, are refused. Doubtful tops whose sides are those of a cube become cubes. Refused
/// shapes that are not flat get one, unless they are the side of a cube or a robot.
/// @param picture  that they were seen in
/// @param edge     m, of all cubes
/// @param hidden   cells of grid_of() in which a robot stands before the table; empty: none does
void place_on_table(Detection& detection, const Picture& picture, const TableCamera& camera,
                    double edge, const std::vector<bool>& hidden = {});

}  // namespace sinew::vision
