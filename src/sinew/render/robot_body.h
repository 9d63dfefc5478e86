#pragma once

#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/render/scene.h"

namespace sinew::render {

/// A robot as it stands in a picture: the collision shapes of its model.
struct ViewedRobot {
  RobotModel model;
  Pose<frame::World, frame::Base> X_WB;
  JointVector q;     ///< rad
  double jaws = 0;   ///< m between the fingers; for a robot that has some
  double held = 0;   ///< m, edge of a cube that its fingers are believed to hold; 0: none
  JointVector qd{};  ///< rad/s, while the picture is taken; empty: it stands
};

/// Links of a robot in the world, as model/collision_links.h counts them. A hexapod has its stand
/// alone: its joints say where its platform is only by an iteration.
/// @pre one angle for each joint, in the middle of the exposure
std::vector<Pose<frame::World, frame::Link>> link_poses(const ViewedRobot& robot);

/// Adds a robot's body: links in turn in two plastics, fingers dark.
void add_robot(Scene& scene, const ViewedRobot& robot, const Material& first,
               const Material& second, const Material& finger);

}  // namespace sinew::render
