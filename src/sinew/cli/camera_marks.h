#pragma once

#include <expected>
#include <string>
#include <vector>

#include "sinew/calibration/touch_points.h"
#include "sinew/cli/camera_robot.h"
#include "sinew/cli/camera_verb.h"
#include "sinew/model/taught_points.h"
#include "sinew/vision/tag_board.h"

namespace sinew::cli {

/// A mark of a sheet that the tool's tip was on.
struct TouchedMark {
  std::string mark;   ///< "cross1", "tag580", or "120,40" of a mark that is not on the sheet
  Vec3 p_S;           ///< m, of the mark on its sheet
  std::string point;  ///< taught point; empty for joints of the command line
  JointVector q;
  Vec3 p_BT;  ///< m, of the tip
};

/// The points of request.points.
/// @error  a file that cannot be read
std::expected<TaughtPoints, Outcome> taught_points(const CameraRequest& request);

/// The joints of a taught point of this robot.
/// @error  a point of another robot, of another number of joints, or without joints
std::expected<JointVector, Outcome> joints_of(const TaughtPoint& point,
                                              const CameraRequest& request,
                                              const CalibrationRobot& robot);

/// Marks by --touch, and by taught points that are named as marks or mapped by --mark. No mark
/// twice.
/// @param points  of the file
/// @error  a text that cannot be read; a mark that is not there; as joints_of(); a mark that was
///         touched twice; two marks at one position of the tool
std::expected<std::vector<TouchedMark>, Outcome> touched_marks(const CameraRequest& request,
                                                               const CalibrationRobot& robot,
                                                               const vision::TagBoard& sheet,
                                                               const TaughtPoints& points);

/// Width between the jaws while they touch, m: closed where nothing else is asked for.
std::expected<double, Outcome> jaws_at_touch(const CameraRequest& request,
                                             const CalibrationRobot& robot);

/// m, standard deviation of a coordinate of a touch at best: steps of the joints' devices, and
/// eyes.
double least_touch_sigma(const CalibrationRobot& robot, std::span<const TouchedMark> marks,
                         double jaw_width);

}  // namespace sinew::cli
