#include "sinew/runtime/cameras/camera_place.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::runtime {
namespace {

std::optional<Pose<frame::Base, frame::Flange>> flange_of(const RobotModel& model,
                                                          const JointVector& q) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    return kinematics::SerialChain(*serial).forward(q);
  }
  const planning::ToolSpace space(model);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  if (!X_BT) return std::nullopt;
  return relabel<frame::Base, frame::Flange>(*X_BT);
}

}  // namespace

std::expected<std::optional<CameraMount>, std::string> mount_of(const HandEyeFile& file,
                                                                std::size_t robot,
                                                                const RobotModel& model) {
  if (file.robot != model.id) {
    return std::unexpected("it was measured on a " + file.robot + ", not on a " + model.id);
  }
  if (!file.on_arm) return std::nullopt;
  CameraMount mount{robot, relabel<frame::Flange, frame::Camera>(file.X_MC), {}};
  for (std::size_t j = 0; j < model.joints.size(); ++j) mount.zeros.push_back(0);
  for (const auto& [name, offset] : file.joint_zeros) {
    const auto joint = joint_named(model, name);
    if (!joint) return std::unexpected(model.id + " has no joint '" + name + "'");
    mount.zeros[*joint] = offset;
  }
  return mount;
}

std::optional<Pose<frame::World, frame::Camera>> pose_on(const CameraMount& mount,
                                                         render::ViewedRobot robot) {
  for (std::size_t j = 0; j < robot.q.size() && j < mount.zeros.size(); ++j) {
    robot.q[j] += mount.zeros[j];
  }
  const auto X_BF = flange_of(robot.model, robot.q);
  if (!X_BF) return std::nullopt;
  return robot.X_WB * *X_BF * mount.X_FC;
}

void place_beside(const HandEyeFile& file, const std::string& robot, vision::TableCamera& camera) {
  if (camera.touched) return;
  const auto X_BC = relabel<frame::Base, frame::Camera>(file.X_MC);
  camera.touched = {robot, X_BC * camera.X_WC.inverse(), file.table};
}

Pose<frame::World, frame::Table> table_of(const Cell& cell, const CellCamera& camera,
                                          const vision::TableCamera* calibration) {
  if (calibration != nullptr && calibration->touched) {
    const auto robot =
        std::ranges::find(cell.robots, calibration->touched->robot, &CellRobot::name);
    if (robot != cell.robots.end()) {
      return robot->X_WB * relabel<frame::Base, frame::Table>(calibration->touched->X_BW);
    }
  }
  return camera.X_WT;
}

}  // namespace sinew::runtime
