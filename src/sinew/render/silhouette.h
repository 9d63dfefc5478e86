#pragma once

#include <span>
#include <vector>

#include "sinew/render/robot_body.h"
#include "sinew/vision/camera_model.h"
#include "sinew/vision/view_watch.h"

namespace sinew::render {

/// Which cells of a camera's picture show a robot, or something within `margin` (m) beside it.
/// @param X_WC  of the camera
/// @return  for each cell of vision::grid_of() of its pictures
std::vector<bool> silhouette(std::span<const ViewedRobot> robots, const vision::CameraModel& camera,
                             const Pose<frame::World, frame::Camera>& X_WC, double margin);

}  // namespace sinew::render
