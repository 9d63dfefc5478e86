#pragma once

#include <expected>
#include <string>
#include <vector>

#include "sinew/calibration/sheet_touches.h"
#include "sinew/cli/cameras/camera_robot.h"
#include "sinew/cli/cameras/camera_verb.h"
#include "sinew/model/taught_points.h"
#include "sinew/vision/table_camera.h"
#include "sinew/vision/tag_board.h"

namespace sinew::cli {

using calibration::TouchedMark;

/// The camera of request.camera. @pre it is given
/// @error  a file that cannot be read
std::expected<vision::TableCamera, Outcome> camera_of(const CameraRequest& request);

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

/// What touches: closed jaws and no pin where nothing else is asked for.
std::expected<calibration::TouchTool, Outcome> touch_tool(const CameraRequest& request,
                                                          const CalibrationRobot& robot);

}  // namespace sinew::cli
