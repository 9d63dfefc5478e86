#include "sinew/calibration/sheet_touches.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "sinew/core/units.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::calibration {
namespace {

using Kind = TouchRefusal::Kind;

std::unexpected<TouchRefusal> refused(Kind kind, std::string sentence,
                                      std::optional<std::size_t> again = {}) {
  return std::unexpected(TouchRefusal{kind, std::move(sentence), again});
}

std::string marks_text(const SheetTouches& touches) {
  std::vector<std::string> names;
  for (const TouchedMark& mark : touches.marks) names.push_back(mark.mark);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Marks that are too few, or on a line.
std::unexpected<TouchRefusal> cannot_fit(const SheetTouches& touches,
                                         const CalibrationError& error) {
  const std::string more = fmt::format("Touch more of {}: bring the tip of the tool there",
                                       fmt::join(marks_left(touches), ", "));
  if (error.fault == CalibrationFault::kPointsOnLine) {
    return refused(Kind::kOnLine,
                   fmt::format("{} are nearly on one line: {:.0f} mm long, {:.0f} mm wide, at "
                               "least {:.0f} mm wide needed. {}",
                               marks_text(touches), to_mm(error.length), to_mm(error.measured),
                               to_mm(error.limit), more));
  }
  return refused(Kind::kTooFew,
                 fmt::format("too few marks: {} ({}), at least 3 needed, not on one line. {}",
                             touches.marks.size(), marks_text(touches), more));
}

/// The direction from which the tool came to the sheet, and up: where the sheet's face must be.
Vec3 face_side(const SheetTouches& touches) {
  Vec3 side = touches.up;
  const auto* serial = std::get_if<SerialGeometry>(&touches.model.geometry);
  if (serial == nullptr) return side;
  const kinematics::SerialChain chain(*serial);
  const double share = 1.0 / static_cast<double>(touches.marks.size());
  for (const TouchedMark& mark : touches.marks) {
    side = side - share * (chain.forward(mark.q).R * serial->X_FT.R).z;
  }
  return side;
}

std::string off_text(const Vec3& off_B) {
  return fmt::format("{:.1f} mm (x {:+.1f}, y {:+.1f}, z {:+.1f} in the base)", to_mm(norm(off_B)),
                     to_mm(off_B.x), to_mm(off_B.y), to_mm(off_B.z));
}

/// Why the touches do not fit, as well as the data shows it.
TouchRefusal misfit(const SheetTouches& touches, const TableFrame& frame) {
  TouchRefusal why{Kind::kMisfit,
                   fmt::format("the touches do not fit the sheet: {:.1f} mm rms (limit {:g} mm). ",
                               to_mm(frame.rms), to_mm(touches.limit)),
                   std::nullopt};
  const auto points = touches.points();
  if (const auto pair = exchanged(points)) {
    why.sentence += fmt::format(
        "With {} and {} exchanged they fit: were they touched in the other order? "
        "Then touch both again",
        touches.marks[pair->first].mark, touches.marks[pair->second].mark);
    return why;
  }
  if (const auto wrong = wrong_touch(points)) {
    why.sentence += wrong_touch_sentence(touches, *wrong);
    why.again = wrong->point;
    return why;
  }
  const double scale = frame.scale - 1;
  if (std::abs(scale) > std::max(0.01, 3 * frame.scale_sigma)) {
    why.sentence += fmt::format(
        "Touched distances are {:.1f} % {} than those of {} paper. Measure the sheet's ruler "
        "(100 mm), then check which paper it is and the robot's lengths",
        100 * std::abs(scale), scale > 0 ? "longer" : "shorter", touches.sheet.paper);
    return why;
  }
  why.sentence += fmt::format(
      "{} fits least. Check the tool (jaws closed, length of the pin), that the sheet did not "
      "move, and that the robot's zeros are right (sinew commission {}); then touch the marks "
      "again",
      touches.marks[frame.worst].mark, touches.robot);
  return why;
}

}  // namespace

std::vector<TouchedPoint> SheetTouches::points() const {
  std::vector<TouchedPoint> points;
  for (const TouchedMark& mark : marks) points.push_back({mark.p_BT, mark.p_S});
  return points;
}

double least_touch_sigma(const RobotModel& model, std::span<const TouchedMark> marks,
                         const TouchTool& tool) {
  constexpr double kEyes = 0.2e-3;  // m: lines of 0.3 mm
  double sum = 0;
  for (const TouchedMark& mark : marks) {
    for (std::size_t j = 0; j < mark.q.size(); ++j) {
      JointVector q = mark.q;
      q[j] += model.device.settings->resolution(j);
      const double step = norm(tip_at(model, q, tool) - tip_at(model, mark.q, tool));
      sum += step * step / 12 / 3;  // even over a step; a third of it for each coordinate
    }
  }
  return std::sqrt(kEyes * kEyes + sum / std::max<double>(1, static_cast<double>(marks.size())));
}

std::optional<TouchRefusal> same_place(std::span<const TouchedMark> marks) {
  constexpr double kSamePlace = 0.002;  // m
  for (std::size_t i = 0; i < marks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = norm(marks[j].p_S - marks[i].p_S);
      const double moved = norm(marks[j].p_BT - marks[i].p_BT);
      if (moved > kSamePlace || moved > apart / 2) continue;
      return TouchRefusal{
          Kind::kSamePlace,
          fmt::format("the tool was at the same position for {} and {}: {:.1f} mm apart, and these "
                      "marks are {:.0f} mm apart. Touch the one that is wrong again",
                      marks[j].mark, marks[i].mark, to_mm(moved), to_mm(apart)),
          i};
    }
  }
  return std::nullopt;
}

std::expected<TouchedSheet, TouchRefusal> touched_sheet(const SheetTouches& touches) {
  if (auto same = same_place(touches.marks)) return std::unexpected(std::move(*same));
  const double sigma = least_touch_sigma(touches.model, touches.marks, touches.tool);
  const auto points = touches.points();
  auto frame = table_frame(points, sigma);
  if (!frame) return cannot_fit(touches, frame.error());
  // A sheet that is seen in a mirror fits a plane as well, upside down.
  if (dot(frame->X_BW.R.z, face_side(touches)) < 0) {
    return refused(Kind::kMirrored,
                   fmt::format("the marks are in mirrored order: with {} as given, the sheet would "
                               "lie face down. Seen from above, cross1 to cross4 follow each other "
                               "clockwise; touch them again under their own names",
                               marks_text(touches)));
  }
  if (frame->rms > touches.limit) return std::unexpected(misfit(touches, *frame));
  // The robot stands on the table that the sheet lies on, as a rule.
  TableFrame level = levelled(*frame, points, touches.up);
  if (level.rms > touches.limit) level = std::move(*frame);
  TouchedSheet found{std::move(level), {}, 0};
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      const Vec3 p_S{x * touches.sheet.width, y * touches.sheet.height, 0};
      const double error = error_95(found.frame, p_S);
      if (error < found.error) continue;
      found.far_S = p_S;
      found.error = error;
    }
  }
  return found;
}

std::string wrong_touch_sentence(const SheetTouches& touches, const WrongTouch& wrong) {
  return fmt::format("{} is off by {}; the others agree to {:.1f} mm rms. Touch it again",
                     touches.marks[wrong.point].mark, off_text(wrong.off_B),
                     to_mm(wrong.rms_others));
}

std::vector<std::string> marks_left(const SheetTouches& touches) {
  std::vector<std::string> left;
  for (const vision::BoardMark& mark : marks_of(touches.sheet)) {
    if (std::ranges::find(touches.marks, mark.name, &TouchedMark::mark) == touches.marks.end()) {
      left.push_back(mark.name);
    }
  }
  return left;
}

std::optional<NextTouch> next_touch(const SheetTouches& touches, const TouchedSheet& sheet) {
  std::optional<NextTouch> best;
  for (const vision::BoardMark& mark : marks_of(touches.sheet)) {
    const bool touched = std::ranges::any_of(
        touches.marks, [&](const TouchedMark& other) { return norm(other.p_S - mark.p_B) < 1e-6; });
    if (touched) continue;
    const double error = error_95(with_touch(sheet.frame, mark.p_B), sheet.far_S);
    if (best && error >= best->error) continue;
    const auto q = joints_for_tip(touches.model, touches.tool, sheet.frame.X_BW * mark.p_B,
                                  -1.0 * sheet.frame.X_BW.R.z);
    if (q) best = NextTouch{mark, *q, error};
  }
  return best;
}

}  // namespace sinew::calibration
