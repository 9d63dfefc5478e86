#include "sinew/render/robot_body.h"

#include <array>
#include <span>

#include "sinew/core/assert.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/tool_state.h"
#include "sinew/render/solids.h"

namespace sinew::render {
namespace {

void add_box(Scene& scene, const Pose<frame::World, frame::Link>& X_WL, const CollisionBox& shape,
             const Material& material) {
  constexpr double kBevel = 0.002;  // m
  scene.solids.push_back(
      {box(shape.half, kBevel), relabel<frame::World, frame::Solid>(X_WL * shape.X_LX), material});
}

}  // namespace

std::vector<Pose<frame::World, frame::Link>> link_poses(const ViewedRobot& robot) {
  SINEW_ASSERT(robot.q.size() == robot.model.joints.size());
  const std::span<const double> q{robot.q.begin(), robot.q.size()};
  std::vector<Pose<frame::World, frame::Link>> X_WL{relabel<frame::World, frame::Link>(robot.X_WB)};
  if (const auto* serial = std::get_if<SerialGeometry>(&robot.model.geometry)) {
    const kinematics::SerialChain chain(*serial);
    std::array<kinematics::PoseBL, kMaxJoints> X_BL;
    chain.frames(q, std::span(X_BL).first(chain.size()));
    for (std::size_t i = 0; i < chain.size(); ++i) X_WL.push_back(robot.X_WB * X_BL[i]);
    const auto X_LT = relabel<frame::Link, frame::Link>(serial->X_FT);
    X_WL.push_back(X_WL.back() * X_LT);
  } else if (const auto* arm = std::get_if<PalletizerGeometry>(&robot.model.geometry)) {
    for (const auto& X_BL : kinematics::palletizer_links(*arm, q)) {
      X_WL.push_back(robot.X_WB * X_BL);
    }
  }
  return X_WL;
}

void add_robot(Scene& scene, const ViewedRobot& robot, const Material& first,
               const Material& second, const Material& finger) {
  const auto X_WL = link_poses(robot);
  const auto* serial = std::get_if<SerialGeometry>(&robot.model.geometry);
  for (const CollisionShape& shape : robot.model.collision.shapes) {
    if (shape.link >= X_WL.size()) continue;
    const auto& X = X_WL[shape.link];
    const Material& material = shape.link % 2 == 0 ? first : second;
    if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
      add_rod(scene, X * capsule->p_LA, X * capsule->p_LB, capsule->radius, material);
    } else if (const auto* block = std::get_if<CollisionBox>(&shape.form)) {
      add_box(scene, X, *block, material);
    } else if (const auto* jaw = std::get_if<JawFinger>(&shape.form);
               jaw != nullptr && serial != nullptr && serial->gripper) {
      add_box(scene, X, finger_box(*jaw, *serial->gripper, robot.jaws, robot.jaws), finger);
    }
  }
}

}  // namespace sinew::render
