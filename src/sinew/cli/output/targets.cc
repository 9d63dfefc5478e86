#include "sinew/cli/output/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_value.h"

namespace sinew::cli {
namespace {

// Far beyond every arm and every turn; more is a slip of the finger, and sines need a bound.
constexpr double kLengthMax = 100;           // m
constexpr double kAngleMax = 100 * 2 * kPi;  // rad

std::expected<std::vector<double>, std::string> parse_bounded(
    const std::string& option, const std::string& text, const std::vector<Measure>& dimensions,
    const std::vector<std::string>& names) {
  auto values = parse_quantities(option, text, dimensions, names);
  if (!values) return values;
  for (std::size_t i = 0; i < values->size(); ++i) {
    const bool length = dimensions[i] == Measure::kLength;
    if (std::abs((*values)[i]) <= (length ? kLengthMax : kAngleMax)) continue;
    return std::unexpected(fmt::format("{}: number {} ({}) is beyond {}", option, i + 1, names[i],
                                       length ? "100 m" : "100 turns"));
  }
  return values;
}

}  // namespace

std::expected<Pose<frame::Base, frame::Tool>, std::string> parse_pose(const std::string& option,
                                                                      const std::string& text) {
  constexpr auto kL = Measure::kLength;
  constexpr auto kA = Measure::kAngle;
  const auto v =
      parse_bounded(option, text, {kL, kL, kL, kA, kA, kA}, {"x", "y", "z", "rx", "ry", "rz"});
  if (!v) return std::unexpected(v.error());
  return Pose<frame::Base, frame::Tool>{rotation_from_fixed_xyz({(*v)[3], (*v)[4], (*v)[5]}),
                                        {(*v)[0], (*v)[1], (*v)[2]}};
}

std::expected<Vec3, std::string> parse_point(const std::string& option, const std::string& text) {
  const auto v = parse_bounded(option, text, std::vector(3, Measure::kLength), {"x", "y", "z"});
  if (!v) return std::unexpected(v.error());
  return Vec3{(*v)[0], (*v)[1], (*v)[2]};
}

std::expected<Vec3, std::string> parse_direction(const std::string& option,
                                                 const std::string& text) {
  const auto v = parse_point(option, text);
  if (!v) return v;
  if (!(norm(*v) > 1e-9)) return std::unexpected(option + ": a direction needs a length");
  return normalized(*v);
}

std::expected<JointVector, std::string> parse_joints(const std::string& option,
                                                     const std::string& text,
                                                     const RobotModel& model) {
  std::vector<Measure> dimensions;
  dimensions.reserve(model.joints.size());
  for (const Joint& joint : model.joints) {
    dimensions.push_back(measure_of(joint));
  }
  const auto v = parse_bounded(option, text, dimensions, joint_names(model));
  if (!v) return std::unexpected(v.error());
  return JointVector(std::span<const double>(*v));
}

std::expected<std::optional<double>, std::string> parse_jaw_width(
    const std::optional<std::string>& text, const SerialGeometry* geometry) {
  if (!text) return std::nullopt;
  if (geometry == nullptr || !geometry->gripper) {
    return std::unexpected("--gripper-mm: this robot has no gripper with jaws");
  }
  const auto width = parse_quantity(*text, Measure::kLength, UnitRule::kOptional);
  if (!width) return std::unexpected("--gripper-mm: " + width.error());
  const double max = geometry->gripper->width_max;
  if (*width < 0 || *width > max) {
    return std::unexpected(fmt::format("--gripper-mm: {} mm is outside 0..{} mm",
                                       number(to_mm(*width)), number(to_mm(max))));
  }
  return *width;
}

}  // namespace sinew::cli
