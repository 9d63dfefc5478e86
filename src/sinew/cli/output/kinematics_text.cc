#include "sinew/cli/output/kinematics_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"
#include "sinew/model/error_sentence.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::cli {
Json pose_json(const Vec3& p, const Rotation& R) {
  const Vec3 rpy = fixed_xyz(R);
  return {{"x_mm", to_mm(p.x)},
          {"y_mm", to_mm(p.y)},
          {"z_mm", to_mm(p.z)},
          {"quaternion_wxyz", quaternion_wxyz(R)},
          {"rotation_fixed_xyz_deg", {to_deg(rpy.x), to_deg(rpy.y), to_deg(rpy.z)}}};
}

std::string pose_text(const Vec3& p, const Rotation& R) {
  const Vec3 rpy = fixed_xyz(R);
  const std::array position{number(to_mm(p.x)), number(to_mm(p.y)), number(to_mm(p.z))};
  const std::array rotation{number(to_deg(rpy.x), 4), number(to_deg(rpy.y), 4),
                            number(to_deg(rpy.z), 4)};
  return fmt::format(
      "  position  x {:>10}   y {:>10}   z {:>10}   mm\n"
      "  rotation rx {:>10}  ry {:>10}  rz {:>10}   deg, about fixed axes x, y, z\n"
      "  for ik:  --pose-mm-deg {},{},{},{},{},{}\n",
      position[0], position[1], position[2], rotation[0], rotation[1], rotation[2], position[0],
      position[1], position[2], rotation[0], rotation[1], rotation[2]);
}

Json error_json(const Error& error, const RobotModel& model) {
  const ErrorInfo& row = info(error.code);
  Json json{{"code", row.name}, {"sentence", error_text(error, model)}};
  const std::string name = subject_of(error, model);
  if (!name.empty()) json[error.other >= 0 ? "links" : "joint"] = name;
  const auto put = [&](const char* unit, double factor) {
    json[fmt::format("measured{}", unit)] = error.measured * factor;
    json[fmt::format("limit{}", unit)] = error.limit * factor;
    json[fmt::format("excess{}", unit)] = excess(error) * factor;
  };
  switch (quantity_of(error, model)) {
    case Quantity::kLength:
      put("_mm", 1e3);
      break;
    case Quantity::kAngle:
      put("_deg", 180 / kPi);
      break;
    case Quantity::kTime:
      put("_s", 1);
      break;
    case Quantity::kVoltage:
      put("_v", 1);
      break;
    case Quantity::kVelocity:
      put("_mm_s", 1e3);
      break;
    case Quantity::kAcceleration:
      put("_mm_s2", 1e3);
      break;
    case Quantity::kAngularVelocity:
      put("_deg_s", 180 / kPi);
      break;
    case Quantity::kAngularAcceleration:
      put("_deg_s2", 180 / kPi);
      break;
    case Quantity::kRatio:
    case Quantity::kCount:
      put("", 1);
      break;
    case Quantity::kNone:
      break;
  }
  return json;
}

std::string error_text(const Error& error, const RobotModel& model) {
  return sentence_of(error, model);
}

Json joints_json(std::span<const double> q, const RobotModel& model) {
  Json json = Json::array();
  for (std::size_t i = 0; i < q.size(); ++i) json.push_back(shown_value(q[i], model.joints[i]));
  return json;
}

std::string joint_text(double q, const Joint& joint) {
  return number(shown_value(q, joint));
}

const char* joints_key(const RobotModel& model) {
  if (prismatic_joints(model) == 0) return "joints_deg";
  if (std::holds_alternative<HexapodGeometry>(model.geometry)) return "legs_mm";
  return all_slide(model) ? "joints_mm" : "joints_deg_mm";
}

bool all_slide(const RobotModel& model) {
  return std::ranges::all_of(model.joints, &Joint::slides);
}

const char* joints_unit(const RobotModel& model) {
  if (prismatic_joints(model) == 0) return "deg";
  return all_slide(model) ? "mm" : "deg or mm";
}

const char* joints_unit_key(const RobotModel& model) {
  if (prismatic_joints(model) == 0) return "deg";
  return all_slide(model) ? "mm" : "deg_mm";
}

std::vector<std::string> joint_names(const RobotModel& model) {
  std::vector<std::string> names;
  names.reserve(model.joints.size());
  for (const Joint& joint : model.joints) names.push_back(joint.name);
  return names;
}

}  // namespace sinew::cli
