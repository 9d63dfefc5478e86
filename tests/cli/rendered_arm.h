#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/config/camera_file.h"
#include "sinew/config/points_file.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/cell.h"
#include "sinew/render/table_scene.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/tag_board.h"
#include "support/property.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

/// A LeArm, a camera and a printed target, for tests of verbs that calibrate.
namespace sinew::test {

using PoseBF = Pose<frame::Base, frame::Flange>;
using PoseBC = Pose<frame::Base, frame::Camera>;
using PoseBS = Pose<frame::Base, frame::Board>;

inline double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(random.uniform(1e-300, 1)));
  return radius * std::cos(random.uniform(0, 2 * kPi));
}

/// Where a servo really goes: LSC boards count 1000 steps over 240 deg, and gears and load add 0.1
/// deg (standard deviation).
inline JointVector really_at(const JointVector& q, Random& random) {
  constexpr double kStep = from_deg(240) / 1000;
  JointVector out;
  for (const double value : q) {
    out.push_back(std::round(value / kStep) * kStep + from_deg(0.1) * normal(random));
  }
  return out;
}

inline vision::CameraModel arm_camera() {
  auto camera = vision::pinhole(640, 480, from_deg(62));
  camera.center = {323, 236};
  camera.lens = {-0.08, 0.02, 3e-4, -2e-4, 0};
  return camera;
}

/// The target as a sheet of paper on its pose, in a room.
inline vision::Picture picture_of_target(const vision::TagBoard& board, const PoseBS& X_BS,
                                         const PoseBC& X_BC, std::uint64_t seed) {
  render::Scene scene;
  scene.solids.push_back({render::Ground{}, {}, {.color = {0.3F, 0.25F, 0.2F}}});
  scene.solids[0].X_WS.p.z = -2e-3;
  render::Material paper{.color = {0.85F, 0.85F, 0.85F}};
  paper.print = {std::make_shared<const vision::Picture>(
                     picture_of(board, board.columns == 1 ? 20'000 : 4000)),
                 board.width, board.height, true};
  const auto X_WS = relabel<frame::World, frame::Solid>(X_BS);
  // A white edge all around, which tags need.
  const double edge = board.columns == 1 ? 0.2 * board.tag : 0;
  scene.solids.push_back({render::box({board.width / 2 + edge, board.height / 2 + edge, 1e-4}),
                          {X_WS.R, X_WS * Vec3{0, 0, -1e-4}},
                          paper});
  scene.lamps.push_back({{0.6, 0.4, 1.2}, 0.1, {0.8F, 0.8F, 0.8F}});
  const auto view =
      render::view_of(scene, arm_camera(), relabel<frame::World, frame::Camera>(X_BC), seed);
  return render::taken(view, {.exposure = render::exposure_for(view, 0.35)}, seed);
}

/// Whether the camera shows the target, of a board the half, from within 50 deg of its normal.
inline bool shows(const PoseBC& X_BC, const vision::TagBoard& board, const PoseBS& X_BS) {
  const auto X_CS = X_BC.inverse() * X_BS;
  if (dot(normalized(X_CS.p), X_CS.R.z) > -std::cos(from_deg(50))) return false;
  const int tags = board.columns * board.rows;
  int seen = 0;
  for (int corner = 0; corner < 4 * tags; ++corner) {
    const Vec3 p_C =
        X_CS * board.corner(board.first + corner / 4, static_cast<std::size_t>(corner % 4));
    const auto pixel = arm_camera().project(p_C);
    seen += pixel && p_C.z > 0.05 && pixel->x > 8 && pixel->y > 8 &&
                    pixel->x < arm_camera().width - 8 && pixel->y < arm_camera().height - 8
                ? 1
                : 0;
  }
  return tags == 1 ? seen == 4 : 2 * seen > 4 * tags;
}

/// Images, points.toml and camera.toml of a calibration in a folder.
struct ArmScene {
  vision::TagBoard board;
  bool on_arm = true;
  Pose<frame::Flange, frame::Camera> X_FC;  ///< of a camera on the arm
  PoseBC X_BC;                              ///< of a fixed one
  PoseBS X_BS;                              ///< of a fixed target
  Pose<frame::Flange, frame::Board> X_FS;   ///< of one on the arm

  PoseBC camera_at(const PoseBF& X_BF) const { return on_arm ? X_BF * X_FC : X_BC; }
  PoseBS target_at(const PoseBF& X_BF) const { return on_arm ? X_BS : X_BF * X_FS; }
};

/// The flange of a robot that has joints, or the tool of a palletizer.
inline PoseBF flange_of(const RobotModel& model, const JointVector& q) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    return kinematics::SerialChain(*serial).forward({q.data(), q.size()});
  }
  return relabel<frame::Base, frame::Flange>(
      kinematics::forward(std::get<PalletizerGeometry>(model.geometry), {q.data(), q.size()}));
}

using DrawJoints = std::function<JointVector(Random&)>;

/// Takes `count` images at joints that show the target; in points.toml stands where the arm was
/// sent, it is where its servos went.
/// @param points  what else is in points.toml; all of them of `id`
/// @return  the images
inline std::vector<std::string> take_images(const ScratchFolder& folder, const ArmScene& scene,
                                            int count, std::uint64_t seed, const DrawJoints& draw,
                                            const std::string& id = "learm",
                                            TaughtPoints points = {}) {
  const RobotModel& model = robot(id);
  Random random(seed);
  std::vector<std::string> images;
  for (int i = 0; i < 200'000 && std::ssize(images) < count; ++i) {
    const JointVector q = draw(random);
    const PoseBF X_BF = flange_of(model, really_at(q, random));
    const PoseBC X_BC = scene.camera_at(X_BF);
    if (!shows(X_BC, scene.board, scene.target_at(X_BF))) continue;
    if (X_BF.p.z < 0.06 || X_BC.p.z < 0.06) continue;
    const std::string name = "view" + std::to_string(images.size() + 1);
    const auto png = vision::encode_png(
        picture_of_target(scene.board, scene.target_at(X_BF), X_BC, seed + images.size()));
    images.push_back(folder.file(name + ".png", std::string(png.begin(), png.end())));
    TaughtPoint point;
    point.name = name;
    point.robot = id;
    point.place = q;
    points.push_back(point);
  }
  folder.file("points.toml", points_text(points));
  folder.file("camera.toml",
              camera_text({"arm", arm_camera(), {Rotation{}, {0, 0, 0.5}}, 0.2, 1e-3, "", ""}));
  return images;
}

/// Joints within the limits of the LeArm, the tool on its front side.
inline JointVector any_joints(Random& random) {
  const auto deg = [&](double lower, double upper) {
    return from_deg(std::round(random.uniform(lower, upper)));
  };
  JointVector q;
  for (const double value : {deg(-60, 60), deg(-60, 60), deg(0, 90), deg(20, 90), deg(-60, 60)}) {
    q.push_back(value);
  }
  return q;
}

}  // namespace sinew::test
