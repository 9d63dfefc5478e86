#pragma once

#include <span>

#include "sinew/calibration/intrinsics.h"
#include "sinew/calibration/view_coverage.h"
#include "sinew/vision/table_camera.h"

namespace sinew::calibration {

/// A camera over a table, measured.
struct TableCalibration {
  vision::TableCamera camera;  ///< without a name; W is the frame of the sheet on the table
  Intrinsics intrinsics;
  Coverage coverage;
  PlanePose table;  ///< of the sheet
};

/// Lens and pose of a camera from pictures of a board, and one of the sheet that marks the table.
///
/// `camera.accuracy` is measured, not estimated: each view in turn is held back; the lens comes
/// from the others, the board's pose from half of the tags in the view that was held back, and the
/// points of its other tags are looked up on the board. 95 % of these errors, as large as they are
/// at the table's distance.
///
/// @param views  of the board, at least 5
/// @param table  of the sheet; the same picture size
/// @error  those of intrinsics() and plane_pose(); of the sheet with index views.size()
Calibrated<TableCalibration> table_calibration(std::span<const BoardView> views,
                                               const BoardView& table);

}  // namespace sinew::calibration
