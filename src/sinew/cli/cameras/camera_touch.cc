#include "sinew/cli/cameras/camera_touch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/calibration/sheet_touches.h"
#include "sinew/cli/cameras/camera_marks.h"
#include "sinew/cli/cameras/camera_robot.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/model/cell.h"

namespace sinew::cli {
namespace {

using calibration::SheetTouches;
using calibration::TouchedSheet;
using calibration::TouchRefusal;

/// What one call works with.
struct Touches {
  const CameraRequest& request;
  CalibrationRobot robot;
  SheetTouches of;

  std::string teach(const std::string& point, bool anew) const {
    return fmt::format("sinew teach {} {} --points {}{}", robot.name, point, request.points,
                       anew ? " --replace" : "");
  }
};

std::optional<Outcome> senseless(const CameraRequest& request) {
  if (!request.images.empty()) {
    return bad_input(
        "camera touch takes no images; name the robot with --robot "
        "and the file of touched points with --points");
  }
  if (!request.robot) {
    return bad_input(
        "camera touch: --robot is missing; sinew camera touch --robot learm --points points.toml");
  }
  if (request.camera && !request.cell) {
    return bad_input(
        "--camera: --cell is missing, the file of the cell whose camera it is; its robots' names "
        "stand there");
  }
  return std::nullopt;
}

std::expected<Touches, Outcome> read_touches(const CameraRequest& request) {
  if (auto why = senseless(request)) return std::unexpected(std::move(*why));
  auto sheet = vision::table_sheet(request.paper);
  if (!sheet) return std::unexpected(wrong_paper(request));
  const auto limit = parse_quantity(request.limit_mm, Measure::kLength, UnitRule::kOptional);
  if (!limit || !(*limit > 0)) {
    return std::unexpected(bad_input("--limit-mm: " + (limit ? "must be above 0" : limit.error())));
  }
  auto robot = calibration_robot(*request.robot, request.cell);
  if (!robot) return std::unexpected(robot.error());
  const auto tool = touch_tool(request, *robot);
  if (!tool) return std::unexpected(tool.error());
  TaughtPoints points;
  if (request.touches.empty() || request.points_given || !request.marks.empty()) {
    auto read = taught_points(request);
    if (!read) return std::unexpected(read.error());
    points = std::move(*read);
  }
  auto marks = touched_marks(request, *robot, *sheet, points);
  if (!marks) return std::unexpected(marks.error());
  SheetTouches of{.model = robot->model,
                  .robot = robot->name,
                  .up = transposed_times(robot->X_WB.R, Vec3{0, 0, 1}),
                  .tool = *tool,
                  .limit = *limit,
                  .sheet = std::move(*sheet),
                  .marks = std::move(*marks)};
  return Touches{request, std::move(*robot), std::move(of)};
}

/// Why the touches say nothing, and the command that mends it.
Outcome refused(const Touches& touches, const TouchRefusal& why) {
  using Kind = TouchRefusal::Kind;
  if (touches.of.marks.empty()) {
    return could_not(fmt::format(
        "no touched mark: {} has no point that is named as a mark of the sheet. Touch 3 or more of "
        "{}, not on one line: bring the tip of the tool there, then {}. Or give points their "
        "marks: --mark POINT=MARK",
        touches.request.points, joined(marks_left(touches.of), ", "),
        touches.teach("cross1", false)));
  }
  std::string text = why.sentence;
  if (why.kind == Kind::kTooFew || why.kind == Kind::kOnLine) {
    const auto left = marks_left(touches.of);
    text += ", then " + touches.teach(left.empty() ? "MARK" : left[0], false);
  } else if (why.again && !touches.of.marks[*why.again].point.empty()) {
    text += ": " + touches.teach(touches.of.marks[*why.again].point, true);
  }
  return could_not(text);
}

void add_advice(const Touches& touches, const TouchedSheet& sheet, Outcome& outcome) {
  const calibration::TableFrame& frame = sheet.frame;
  if (const auto wrong = calibration::wrong_touch(touches.of.points())) {
    const Vec3& off = wrong->off_B;
    outcome.text += "  warning: " + calibration::wrong_touch_sentence(touches.of, *wrong) + "\n";
    outcome.json["wrong"] = {{"mark", touches.of.marks[wrong->point].mark},
                             {"off_mm", {to_mm(off.x), to_mm(off.y), to_mm(off.z)}},
                             {"rms_of_others_mm", to_mm(wrong->rms_others)}};
  }
  if (std::abs(frame.scale - 1) > std::max(0.005, 3 * frame.scale_sigma)) {
    outcome.text += fmt::format(
        "  warning: touched distances are {:.1f} % {} than printed ones. Measure the sheet's ruler "
        "(100 mm)\n",
        100 * std::abs(frame.scale - 1), frame.scale > 1 ? "longer" : "shorter");
    outcome.json["scale"] = frame.scale;
  }
  const auto next = next_touch(touches.of, sheet);
  if (!next) return;
  const std::string joints = joints_argument(touches.robot.model, next->q);
  outcome.text += fmt::format(
      "  better: touch {} too (about {} deg) and teach it: {}; the error becomes {:.1f} mm\n",
      next->mark.name, joints, touches.teach(next->mark.name, false), to_mm(next->error));
  outcome.json["next"] = {{"mark", next->mark.name},
                          {"joints_deg", joints_json(next->q, touches.robot.model)},
                          {"error_mm", to_mm(next->error)}};
}

/// Writes the place of the table into the camera's file.
std::expected<void, Outcome> keep(const Touches& touches, const TouchedSheet& sheet) {
  auto camera = camera_of(touches.request);
  if (!camera) return std::unexpected(camera.error());
  camera->touched = {touches.robot.name, sheet.frame.X_BW, sheet.error};
  const auto written = io::replace_file(*touches.request.camera, camera_text(*camera));
  if (!written) return std::unexpected(could_not("--camera: " + written.error().sentence));
  return {};
}

Outcome found(const Touches& touches, const TouchedSheet& sheet) {
  const calibration::TableFrame& frame = sheet.frame;
  const auto X_WS = touches.robot.X_WB * relabel<frame::Base, frame::Table>(frame.X_BW);
  Table table({"mark", "point", "x, mm", "y, mm", "z, mm", "off, mm"});
  table.left(1);
  Json marks = Json::array();
  for (std::size_t i = 0; i < touches.of.marks.size(); ++i) {
    const calibration::TouchedMark& mark = touches.of.marks[i];
    const std::array p{to_mm(mark.p_BT.x), to_mm(mark.p_BT.y), to_mm(mark.p_BT.z)};
    const double off = to_mm(frame.residuals[i]);
    table.add({mark.mark, mark.point.empty() ? "--touch" : mark.point, fmt::format("{:.1f}", p[0]),
               fmt::format("{:.1f}", p[1]), fmt::format("{:.1f}", p[2]),
               fmt::format("{:.2f}", off)});
    marks.push_back({{"mark", mark.mark}, {"point", mark.point}, {"tip_mm", p}, {"off_mm", off}});
  }
  const auto worst = std::ranges::max_element(frame.residuals);
  const auto worst_at = static_cast<std::size_t>(worst - frame.residuals.begin());
  Outcome outcome;
  outcome.text = table.text();
  outcome.text += fmt::format("  rms {:.2f} mm, worst {:.2f} mm ({})\n", to_mm(frame.rms),
                              to_mm(*worst), touches.of.marks[worst_at].mark);
  outcome.text +=
      fmt::format("  error at the far corner of the sheet: {:.1f} mm (95 %)\n", to_mm(sheet.error));
  outcome.text += "  middle of the sheet in the base of " + touches.robot.name + ":\n" +
                  placed_text(frame.X_BW.p, frame.X_BW.R);
  if (touches.request.camera) {
    outcome.text += "  " + *touches.request.camera + ": [table]\n";
  } else {
    outcome.text +=
        camera_table_title(touches.robot, touches.request.cell) + camera_table_text(X_WS.p, X_WS.R);
  }
  outcome.json = {{"robot", touches.robot.name},
                  {"marks", marks},
                  {"rms_mm", to_mm(frame.rms)},
                  {"worst_mm", to_mm(*worst)},
                  {"worst", touches.of.marks[worst_at].mark},
                  {"error_95_mm", to_mm(sheet.error)},
                  {"sheet_in_base", pose_json(frame.X_BW.p, frame.X_BW.R)},
                  {"sheet_in_cell", pose_json(X_WS.p, X_WS.R)},
                  {"camera_table", camera_table_json(X_WS.p, X_WS.R)}};
  add_advice(touches, sheet, outcome);
  return outcome;
}

}  // namespace

Outcome camera_touch(const CameraRequest& request) {
  const auto touches = read_touches(request);
  if (!touches) return touches.error();
  const auto sheet = calibration::touched_sheet(touches->of);
  if (!sheet) return refused(*touches, sheet.error());
  if (request.camera) {
    if (const auto kept = keep(*touches, *sheet); !kept) return kept.error();
  }
  return found(*touches, *sheet);
}

}  // namespace sinew::cli
