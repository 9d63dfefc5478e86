#include "sinew/cli/cameras/camera_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "sinew/calibration/robot_tip.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/config/camera_file.h"
#include "sinew/config/points_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

using vision::BoardMark;

/// "Cross_1" is cross1.
std::string plain(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (c == '_' || c == '-') continue;
    out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

std::optional<BoardMark> mark_named(const vision::TagBoard& sheet, std::string_view name) {
  const std::vector<BoardMark> marks = marks_of(sheet);
  const auto found = std::ranges::find(marks, plain(name), &BoardMark::name);
  return found == marks.end() ? std::nullopt : std::optional(*found);
}

std::string known_marks(const vision::TagBoard& sheet) {
  std::vector<std::string> names;
  for (const BoardMark& mark : marks_of(sheet)) names.push_back(mark.name);
  return joined(names, ", ");
}

/// A mark by its name, or "X,Y" in mm from the middle of the sheet.
std::expected<BoardMark, Outcome> mark_of(const vision::TagBoard& sheet, const std::string& option,
                                          const std::string& text) {
  if (auto mark = mark_named(sheet, text)) return std::move(*mark);
  if (text.find(',') != std::string::npos) {
    const auto xy =
        parse_quantities(option, text, {Measure::kLength, Measure::kLength}, {"x", "y"});
    if (!xy) return std::unexpected(bad_input(xy.error()));
    const Vec3 p{(*xy)[0], (*xy)[1], 0};
    if (norm(p) < 10) return BoardMark{text, p};
  }
  return std::unexpected(bad_input(fmt::format(
      "{}: there is no mark '{}'; the marks of the sheet are {}, or X,Y in mm from its middle",
      option, printable(text), known_marks(sheet))));
}

struct Assigned {
  std::string left;
  std::string right;
};
/// "LEFT=RIGHT".
std::expected<Assigned, Outcome> assigned(const std::string& option, const std::string& form,
                                          const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size()) {
    return std::unexpected(
        bad_input(option + ": '" + printable(text) + "' is not of the form " + form));
  }
  return Assigned{text.substr(0, equals), text.substr(equals + 1)};
}

std::string source_of(const TouchedMark& mark) {
  return mark.point.empty() ? "--touch" : "point " + mark.point;
}

/// How to touch a mark once more.
std::string again(const TouchedMark& mark, const CameraRequest& request,
                  const CalibrationRobot& robot) {
  if (mark.point.empty()) return "touch " + mark.mark + " again and give its joints to --touch";
  return fmt::format("touch {} again, then sinew teach {} {} --points {} --replace", mark.mark,
                     robot.name, mark.point, request.points);
}

std::optional<Outcome> repeated(std::span<const TouchedMark> marks, const CameraRequest& request,
                                const CalibrationRobot& robot) {
  for (std::size_t i = 0; i < marks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (norm(marks[j].p_S - marks[i].p_S) >= 1e-6) continue;
      return could_not(fmt::format(
          "{} is given twice, by {} and by {}. Leave one of them out, or touch another mark",
          marks[i].mark, source_of(marks[j]), source_of(marks[i])));
    }
  }
  const auto same = calibration::same_place(marks);
  if (!same) return std::nullopt;
  return could_not(same->sentence + ": " + again(marks[*same->again], request, robot));
}

std::expected<void, Outcome> add_taught(const CameraRequest& request, const CalibrationRobot& robot,
                                        const vision::TagBoard& sheet, const TaughtPoints& points,
                                        std::vector<TouchedMark>& marks) {
  std::vector<Assigned> named;
  for (const std::string& text : request.marks) {
    auto mapped = assigned("--mark", "POINT=MARK", text);
    if (!mapped) return std::unexpected(mapped.error());
    if (std::ranges::find(points, mapped->left, &TaughtPoint::name) == points.end()) {
      return std::unexpected(bad_input("--mark: there is no point '" + printable(mapped->left) +
                                       "' in " + request.points));
    }
    named.push_back(std::move(*mapped));
  }
  for (const TaughtPoint& point : points) {
    const auto mapped = std::ranges::find(named, point.name, &Assigned::left);
    auto mark = mark_named(sheet, point.name);
    if (mapped != named.end()) {
      auto other = mark_of(sheet, "--mark", mapped->right);
      if (!other) return std::unexpected(other.error());
      mark = std::move(*other);
    }
    if (!mark) continue;
    const auto q = joints_of(point, request, robot);
    if (!q) return std::unexpected(q.error());
    marks.push_back({mark->name, mark->p_B, point.name, *q, {}});
  }
  return {};
}

}  // namespace

std::expected<vision::TableCamera, Outcome> camera_of(const CameraRequest& request) {
  const auto text = io::read_file(*request.camera, std::size_t{1} << 20U);
  if (!text) return std::unexpected(bad_input("--camera: " + text.error().sentence));
  auto camera = read_camera(*text, *request.camera);
  if (!camera) return std::unexpected(complaints_outcome(camera.error()));
  return std::move(*camera);
}

std::expected<TaughtPoints, Outcome> taught_points(const CameraRequest& request) {
  const auto text = io::read_file(request.points);
  if (!text) return std::unexpected(bad_input("--points: " + text.error().sentence));
  auto points = read_points(*text, request.points);
  if (!points) return std::unexpected(complaints_outcome(points.error()));
  return std::move(*points);
}

std::expected<JointVector, Outcome> joints_of(const TaughtPoint& point,
                                              const CameraRequest& request,
                                              const CalibrationRobot& robot) {
  const auto complain = [&](const std::string& what) {
    return std::unexpected(could_not(request.points + ": point " + point.name + " " + what));
  };
  if (point.robot != robot.model.id) {
    return complain(
        fmt::format("is of {}, not of {}. Name that robot with --robot, or teach the "
                    "point of {}: sinew teach {} {} --points OTHER.toml",
                    printable(point.robot), robot.model.id, robot.name, robot.name, point.name));
  }
  const auto* q = std::get_if<JointVector>(&point.place);
  if (q == nullptr) {
    return complain(
        fmt::format("has the tool's position and no joints. Teach it where the robot "
                    "is: sinew teach {} {} --points {} --replace",
                    robot.name, point.name, request.points));
  }
  if (q->size() != robot.model.joints.size()) {
    return complain(fmt::format("has {} joints, {} has {}", q->size(), robot.model.id,
                                robot.model.joints.size()));
  }
  return *q;
}

std::expected<calibration::TouchTool, Outcome> touch_tool(const CameraRequest& request,
                                                          const CalibrationRobot& robot) {
  if (std::holds_alternative<HexapodGeometry>(robot.model.geometry)) {
    return std::unexpected(
        bad_input(robot.model.id + " is a platform: it has no tip to touch marks with"));
  }
  const auto width =
      parse_jaw_width(request.gripper_mm, std::get_if<SerialGeometry>(&robot.model.geometry));
  if (!width) return std::unexpected(bad_input(width.error()));
  const auto pin = parse_quantity(request.pin_mm, Measure::kLength, UnitRule::kOptional);
  constexpr double kPinMost = 0.3;  // m
  if (!pin || !(*pin >= 0 && *pin <= kPinMost)) {
    return std::unexpected(
        bad_input("--pin-mm: " + (pin ? std::string("is 0 to 300 mm") : pin.error())));
  }
  return calibration::TouchTool{width->value_or(0), *pin};
}

std::expected<std::vector<TouchedMark>, Outcome> touched_marks(const CameraRequest& request,
                                                               const CalibrationRobot& robot,
                                                               const vision::TagBoard& sheet,
                                                               const TaughtPoints& points) {
  const auto tool = touch_tool(request, robot);
  if (!tool) return std::unexpected(tool.error());
  std::vector<TouchedMark> marks;
  if (auto added = add_taught(request, robot, sheet, points, marks); !added) {
    return std::unexpected(added.error());
  }
  for (const std::string& text : request.touches) {
    const auto touch = assigned("--touch", "MARK=JOINTS", text);
    if (!touch) return std::unexpected(touch.error());
    const auto mark = mark_of(sheet, "--touch", touch->left);
    if (!mark) return std::unexpected(mark.error());
    const auto q = parse_joints("--touch", touch->right, robot.model);
    if (!q) return std::unexpected(bad_input(q.error()));
    marks.push_back({mark->name, mark->p_B, "", *q, {}});
  }
  for (TouchedMark& mark : marks) mark.p_BT = calibration::tip_at(robot.model, mark.q, *tool);
  if (auto twice = repeated(marks, request, robot)) return std::unexpected(std::move(*twice));
  return marks;
}

}  // namespace sinew::cli
