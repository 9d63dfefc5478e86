#include "sinew/server/json/model_json.h"

#include <array>

#include "sinew/core/rotation.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/collision_links.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/model/tool_state.h"
#include "sinew/planning/jog/jog_space.h"
#include "sinew/runtime/records/unit_name.h"

namespace sinew::server {
namespace {

using kinematics::PoseBL;
using runtime::with_unit;

Json vector_json(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Json local_pose_json(const Vec3& p, const Rotation& R) {
  return {{"xyz_m", vector_json(p)}, {"quaternion_wxyz", quaternion_wxyz(R)}};
}

Json joints_json(const RobotModel& model) {
  Json joints = Json::array();
  for (const Joint& joint : model.joints) {
    joints.push_back({{"name", joint.name},
                      {"kind", joint.slides() ? "prismatic" : "revolute"},
                      {with_unit("lower", joint), joint.lower},
                      {with_unit("upper", joint), joint.upper},
                      {with_unit("home", joint), joint.home},
                      {with_unit("velocity_max", joint) + "_s", joint.velocity_max},
                      {with_unit("acceleration_max", joint) + "_s2", joint.acceleration_max},
                      {with_unit("jerk_max", joint) + "_s3", joint.jerk_max}});
    if (is_left_out(model, joints.size() - 1)) joints.back()["left_out"] = true;
  }
  return joints;
}

Json geometry_json(const SerialGeometry& chain) {
  Json rows = Json::array();
  for (const DhRow& row : chain.rows) {
    rows.push_back({{"d_m", row.d},
                    {"a_m", row.a},
                    {"alpha_rad", row.alpha},
                    {"theta_offset_rad", row.theta_offset}});
    if (row.kind == JointKind::kPrismatic) rows.back()["slides"] = true;
  }
  Json json{{"dh", rows}, {"tool", local_pose_json(chain.X_FT.p, chain.X_FT.R)}};
  if (chain.gripper) {
    json["gripper"] = {{"width_max_m", chain.gripper->width_max},
                       {"reach_open_m", chain.gripper->reach_open},
                       {"reach_closed_m", chain.gripper->reach_closed}};
  }
  return json;
}

Json geometry_json(const PalletizerGeometry& linkage) {
  return {{"base_height_m", linkage.base_height},
          {"upper_arm_m", linkage.upper_arm},
          {"shoulder_offset_m", linkage.shoulder_offset},
          {"forearm_m", linkage.forearm},
          {"tool_offset_m", linkage.tool_offset},
          {"base_front_rad", linkage.base_front},
          {"radius_min_m", linkage.radius_min}};
}

Json geometry_json(const HexapodGeometry& platform) {
  Json base = Json::array(), top = Json::array();
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    base.push_back(vector_json(platform.p_BA[leg]));
    top.push_back(vector_json(platform.p_PA[leg]));
  }
  return {{"base_anchors_m", base},
          {"platform_anchors_m", top},
          {"platform_radius_m", platform.platform_radius},
          {"home", local_pose_json(platform.X_BP_home.p, platform.X_BP_home.R)}};
}

std::string_view kind_name(const RobotModel& model) {
  constexpr std::array<std::string_view, 3> kNames{"serial", "palletizer", "hexapod"};
  return kNames[model.geometry.index()];
}

/// Every link that has a pose of its own, at home; legs have none.
std::vector<std::optional<PoseBL>> home_links(const RobotModel& model) {
  std::vector<std::optional<PoseBL>> links(link_count(model));
  links[0] = PoseBL{};
  const JointVector home = home_joints(model);
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    const kinematics::SerialChain chain(*serial);
    std::vector<PoseBL> frames(home.size());
    chain.frames({home.data(), home.size()}, frames);
    for (std::size_t i = 0; i < frames.size(); ++i) links[i + 1] = frames[i];
    links.back() = relabel<frame::Base, frame::Link>(
        relabel<frame::Base, frame::Flange>(frames.back()) * serial->X_FT);
  } else if (const auto* linkage = std::get_if<PalletizerGeometry>(&model.geometry)) {
    const auto all = kinematics::palletizer_links(*linkage, {home.data(), home.size()});
    for (std::size_t i = 0; i < all.size(); ++i) links[i + 1] = all[i];
  } else {
    const auto& platform = std::get<HexapodGeometry>(model.geometry);
    links.back() = relabel<frame::Base, frame::Link>(platform.X_BP_home);
  }
  return links;
}

Json links_json(const RobotModel& model) {
  Json links = Json::array();
  const auto poses = home_links(model);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Json link{{"name", link_name(model, i)}};
    if (poses[i]) link["home"] = local_pose_json(poses[i]->p, poses[i]->R);
    links.push_back(std::move(link));
  }
  return links;
}

/// A gripper's fingers as they are with open jaws.
Json shape_json(const CollisionShape& shape, const Geometry& geometry) {
  Json json{{"link", shape.link}};
  if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
    json["form"] = "capsule";
    json["from_m"] = vector_json(capsule->p_LA);
    json["to_m"] = vector_json(capsule->p_LB);
    json["radius_m"] = capsule->radius;
  } else if (const auto* box = std::get_if<CollisionBox>(&shape.form)) {
    json["form"] = "box";
    json["pose"] = local_pose_json(box->X_LX.p, box->X_LX.R);
    json["half_m"] = vector_json(box->half);
  } else if (const auto* finger = std::get_if<JawFinger>(&shape.form)) {
    const JawGripper& gripper = *std::get<SerialGeometry>(geometry).gripper;
    const CollisionBox open = finger_box(*finger, gripper, gripper.width_max, gripper.width_max);
    json["form"] = "finger";
    json["pose"] = local_pose_json(open.X_LX.p, open.X_LX.R);
    json["half_m"] = vector_json(open.half);
  } else if (const auto* leg = std::get_if<LegCapsule>(&shape.form)) {
    json["form"] = "leg";
    json["radius_m"] = leg->radius;
  } else {
    json["form"] = "held";
  }
  return json;
}

std::string_view task_name(const planning::ToolSpace& space) {
  if (space.scara() != nullptr) return "yaw";
  switch (space.task()) {
    case planning::TaskSpace::kPose:
      return "pose";
    case planning::TaskSpace::kPitchRoll:
      return "pitch_roll";
    case planning::TaskSpace::kApproach:
      return "approach";
    case planning::TaskSpace::kPoint:
      break;
  }
  return "point";
}

/// In which frames it can be jogged, and how many numbers a velocity has there.
Json jog_json(const RobotModel& model) {
  Json frames = Json::object();
  if (model.device.capability.motion != MotionKind::kStream) return frames;
  const planning::JogSpace space(model);
  using planning::JogFrame;
  constexpr std::array<std::pair<JogFrame, const char*>, 4> kFrames{
      {{JogFrame::kJoint, "joint"},
       {JogFrame::kBase, "base"},
       {JogFrame::kTool, "tool"},
       {JogFrame::kPlatform, "platform"}}};
  for (const auto& [frame, name] : kFrames) {
    if (space.has(frame)) frames[name] = space.numbers(frame);
  }
  return frames;
}

}  // namespace

Json model_json(const RobotModel& model) {
  Json shapes = Json::array();
  for (const CollisionShape& shape : model.collision.shapes)
    shapes.push_back(shape_json(shape, model.geometry));
  Json json{
      {"robot", model.id},
      {"title", model.title},
      {"kind", kind_name(model)},
      {"task", task_name(planning::ToolSpace(model))},
      {"joints", joints_json(model)},
      {"links", links_json(model)},
      {"geometry", std::visit([](const auto& one) { return geometry_json(one); }, model.geometry)},
      {"shapes", shapes},
      {"margin_m", model.collision.margin},
      {"jog", jog_json(model)},
      {"takes_speed", model.device.capability.takes_speed}};
  if (model.collision.table_height) json["table_height_m"] = *model.collision.table_height;
  return json;
}

}  // namespace sinew::server
