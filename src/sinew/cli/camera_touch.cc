#include "sinew/cli/camera_touch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/calibration/touch_points.h"
#include "sinew/cli/camera_marks.h"
#include "sinew/cli/camera_robot.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/quantity.h"
#include "sinew/cli/table.h"
#include "sinew/core/units.h"
#include "sinew/model/cell.h"

namespace sinew::cli {
namespace {

using calibration::TableFrame;
using calibration::TouchedPoint;

/// What one call works with.
struct Touches {
  const CameraRequest& request;
  CalibrationRobot robot;
  vision::TagBoard sheet;
  double jaw_width = 0;
  double limit = 0;  ///< m, of the rms
  std::vector<TouchedMark> marks;
  std::vector<TouchedPoint> points;

  std::string teach(const std::string& point, bool anew) const {
    return fmt::format("sinew teach {} {} --points {}{}", robot.name, point, request.points,
                       anew ? " --replace" : "");
  }
};

std::expected<Touches, Outcome> read_touches(const CameraRequest& request) {
  if (!request.images.empty()) {
    return std::unexpected(
        bad_input("camera touch takes no images; name the robot with --robot "
                  "and the file of touched points with --points"));
  }
  if (!request.robot) {
    return std::unexpected(bad_input(
        "camera touch: --robot is missing; sinew camera touch --robot learm --points points.toml"));
  }
  auto sheet = vision::table_sheet(request.paper);
  if (!sheet) return std::unexpected(wrong_paper(request));
  const auto limit = parse_quantity(request.limit_mm, Measure::kLength, UnitRule::kOptional);
  if (!limit || !(*limit > 0)) {
    return std::unexpected(bad_input("--limit-mm: " + (limit ? "must be above 0" : limit.error())));
  }
  auto robot = calibration_robot(*request.robot, request.cell);
  if (!robot) return std::unexpected(robot.error());
  const auto jaw_width = jaws_at_touch(request, *robot);
  if (!jaw_width) return std::unexpected(jaw_width.error());
  TaughtPoints points;
  if (request.touches.empty() || request.points_given || !request.marks.empty()) {
    auto read = taught_points(request);
    if (!read) return std::unexpected(read.error());
    points = std::move(*read);
  }
  auto marks = touched_marks(request, *robot, *sheet, points);
  if (!marks) return std::unexpected(marks.error());
  Touches touches{
      request, std::move(*robot), std::move(*sheet), *jaw_width, *limit, std::move(*marks), {}};
  for (const TouchedMark& mark : touches.marks) touches.points.push_back({mark.p_BT, mark.p_S});
  return touches;
}

/// The direction from which the tool came to the sheet, and up: where the sheet's face must be.
Vec3 face_side(const Touches& touches) {
  Vec3 side = transposed_times(touches.robot.X_WB.R, Vec3{0, 0, 1});
  const auto* serial = std::get_if<SerialGeometry>(&touches.robot.model.geometry);
  if (serial == nullptr) return side;
  const double share = 1.0 / static_cast<double>(touches.marks.size());
  for (const TouchedMark& mark : touches.marks) {
    const auto at = flange_at(touches.robot.model, mark.q);
    if (at) side = side - share * (at->X_BF.R * serial->X_FT.R).z;
  }
  return side;
}

/// A mark to touch next: the one that leaves the least error at `far`, within reach.
struct NextTouch {
  vision::BoardMark mark;
  JointVector q;
  double error = 0;  ///< m, then, at `far`
};

std::optional<NextTouch> next_touch(const Touches& touches, const TableFrame& frame,
                                    const Vec3& far) {
  std::optional<NextTouch> best;
  for (const vision::BoardMark& mark : marks_of(touches.sheet)) {
    const bool touched = std::ranges::any_of(
        touches.marks, [&](const TouchedMark& other) { return norm(other.p_S - mark.p_B) < 1e-6; });
    if (touched) continue;
    const double error = error_95(with_touch(frame, mark.p_B), far);
    if (best && error >= best->error) continue;
    const auto q = joints_for_tip(touches.robot.model, touches.jaw_width, frame.X_BW * mark.p_B,
                                  -1.0 * frame.X_BW.R.z);
    if (q) best = NextTouch{mark, *q, error};
  }
  return best;
}

/// The corner of the sheet where it is known least.
struct FarCorner {
  Vec3 p_S;
  double error = 0;  ///< m, 95 %
};
FarCorner far_corner(const Touches& touches, const TableFrame& frame) {
  FarCorner worst;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      const Vec3 p_S{x * touches.sheet.width, y * touches.sheet.height, 0};
      const double error = error_95(frame, p_S);
      if (error >= worst.error) worst = {p_S, error};
    }
  }
  return worst;
}

std::string marks_text(const Touches& touches) {
  std::vector<std::string> names;
  for (const TouchedMark& mark : touches.marks) names.push_back(mark.mark);
  return joined(names, ", ");
}

/// Marks that are too few, or on a line.
Outcome cannot_fit(const Touches& touches, const calibration::CalibrationError& error) {
  std::vector<std::string> left;
  for (const vision::BoardMark& mark : marks_of(touches.sheet)) {
    if (std::ranges::find(touches.marks, mark.name, &TouchedMark::mark) == touches.marks.end()) {
      left.push_back(mark.name);
    }
  }
  const std::string more =
      fmt::format("Touch more of {}: bring the tip of the tool there, then {}", joined(left, ", "),
                  touches.teach(left.empty() ? "MARK" : left[0], false));
  if (error.fault == calibration::CalibrationFault::kPointsOnLine) {
    return could_not(fmt::format(
        "{} are nearly on one line: {:.0f} mm long, {:.0f} mm wide, at least {:.0f} mm wide "
        "needed. {}",
        marks_text(touches), to_mm(error.length), to_mm(error.measured), to_mm(error.limit), more));
  }
  if (touches.marks.empty()) {
    return could_not(fmt::format(
        "no touched mark: {} has no point that is named as a mark of the sheet. {}. Or give points "
        "their marks: --mark POINT=MARK",
        touches.request.points, more));
  }
  return could_not(fmt::format("too few marks: {} ({}), at least 3 needed, not on one line. {}",
                               touches.marks.size(), marks_text(touches), more));
}

std::string off_text(const Vec3& off_B) {
  return fmt::format("{:.1f} mm (x {:+.1f}, y {:+.1f}, z {:+.1f} in the base)", to_mm(norm(off_B)),
                     to_mm(off_B.x), to_mm(off_B.y), to_mm(off_B.z));
}

std::string wrong_text(const Touches& touches, const calibration::WrongTouch& wrong) {
  const TouchedMark& mark = touches.marks[wrong.point];
  return fmt::format("{} is off by {}; the others agree to {:.1f} mm rms. Touch it again{}",
                     mark.mark, off_text(wrong.off_B), to_mm(wrong.rms_others),
                     mark.point.empty() ? "" : ": " + touches.teach(mark.point, true));
}

/// Why the touches do not fit, as well as the data shows it.
std::string misfit_reason(const Touches& touches, const TableFrame& frame) {
  if (const auto pair = exchanged(touches.points)) {
    return fmt::format(
        "With {} and {} exchanged they fit: were they touched in the other order? "
        "Then teach both again",
        touches.marks[pair->first].mark, touches.marks[pair->second].mark);
  }
  if (const auto wrong = wrong_touch(touches.points)) return wrong_text(touches, *wrong);
  const double scale = frame.scale - 1;
  if (std::abs(scale) > std::max(0.01, 3 * frame.scale_sigma)) {
    return fmt::format(
        "Touched distances are {:.1f} % {} than those of {} paper. Measure the "
        "sheet's ruler (100 mm), then check --paper and the robot's lengths",
        100 * std::abs(scale), scale > 0 ? "longer" : "shorter", touches.sheet.paper);
  }
  const TouchedMark& worst = touches.marks[frame.worst];
  return fmt::format(
      "{} fits least. Check the tool (--gripper-mm), that the sheet did not move, "
      "and that the robot's zeros are right (sinew commission {}); then touch the "
      "marks again",
      worst.mark, touches.robot.name);
}

/// @return  nothing where the touches give a pose that can be believed
std::optional<Outcome> refused(const Touches& touches, const TableFrame& frame) {
  // A sheet that is seen in a mirror fits a plane as well, upside down.
  if (dot(frame.X_BW.R.z, face_side(touches)) < 0) {
    return could_not(fmt::format(
        "the marks are in mirrored order: with {} as given, the sheet would lie face down. Seen "
        "from above, cross1 to cross4 follow each other clockwise; teach the points again with "
        "their own marks",
        marks_text(touches)));
  }
  if (frame.rms <= touches.limit) return std::nullopt;
  return could_not(fmt::format("the touches do not fit the sheet: {:.1f} mm rms (limit {} mm). {}",
                               to_mm(frame.rms), number(to_mm(touches.limit)),
                               misfit_reason(touches, frame)));
}

void add_advice(const Touches& touches, const TableFrame& frame, const FarCorner& corner,
                Outcome& outcome) {
  if (const auto wrong = wrong_touch(touches.points)) {
    outcome.text += "  warning: " + wrong_text(touches, *wrong) + "\n";
    const Vec3& off = wrong->off_B;
    outcome.json["wrong"] = {{"mark", touches.marks[wrong->point].mark},
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
  const auto next = next_touch(touches, frame, corner.p_S);
  if (!next) return;
  const std::string joints = joints_argument(touches.robot.model, next->q);
  outcome.text += fmt::format(
      "  better: touch {} too (about {} deg) and teach it: {}; the error becomes {:.1f} mm\n",
      next->mark.name, joints, touches.teach(next->mark.name, false), to_mm(next->error));
  outcome.json["next"] = {{"mark", next->mark.name},
                          {"joints_deg", joints_json(next->q, touches.robot.model)},
                          {"error_mm", to_mm(next->error)}};
}

Outcome found(const Touches& touches, const TableFrame& frame) {
  const auto X_WS = touches.robot.X_WB * relabel<frame::Base, frame::Table>(frame.X_BW);
  const FarCorner corner = far_corner(touches, frame);
  Table table({"mark", "point", "x, mm", "y, mm", "z, mm", "off, mm"});
  table.left(1);
  Json marks = Json::array();
  for (std::size_t i = 0; i < touches.marks.size(); ++i) {
    const TouchedMark& mark = touches.marks[i];
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
                              to_mm(*worst), touches.marks[worst_at].mark);
  outcome.text += fmt::format("  error at the far corner of the sheet: {:.1f} mm (95 %)\n",
                              to_mm(corner.error));
  outcome.text += "  middle of the sheet in the base of " + touches.robot.name + ":\n" +
                  placed_text(frame.X_BW.p, frame.X_BW.R);
  outcome.text +=
      camera_table_title(touches.robot, touches.request.cell) + camera_table_text(X_WS.p, X_WS.R);
  outcome.json = {{"robot", touches.robot.name},
                  {"marks", marks},
                  {"rms_mm", to_mm(frame.rms)},
                  {"worst_mm", to_mm(*worst)},
                  {"worst", touches.marks[worst_at].mark},
                  {"error_95_mm", to_mm(corner.error)},
                  {"sheet_in_base", pose_json(frame.X_BW.p, frame.X_BW.R)},
                  {"sheet_in_cell", pose_json(X_WS.p, X_WS.R)},
                  {"camera_table", camera_table_json(X_WS.p, X_WS.R)}};
  add_advice(touches, frame, corner, outcome);
  return outcome;
}

}  // namespace

Outcome camera_touch(const CameraRequest& request) {
  const auto touches = read_touches(request);
  if (!touches) return touches.error();
  const double sigma = least_touch_sigma(touches->robot, touches->marks, touches->jaw_width);
  const auto frame = calibration::table_frame(touches->points, sigma);
  if (!frame) return cannot_fit(*touches, frame.error());
  if (auto refusal = refused(*touches, *frame)) return std::move(*refusal);
  return found(*touches, *frame);
}

}  // namespace sinew::cli
