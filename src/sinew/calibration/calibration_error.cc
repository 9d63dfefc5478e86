#include "sinew/calibration/calibration_error.h"

#include <cmath>

#include "sinew/core/number_text.h"
#include "sinew/core/units.h"

namespace sinew::calibration {
namespace {

std::string of_view(const CalibrationError& error) {
  return error.index < 0 ? "" : " of view " + std::to_string(error.index + 1);
}

}  // namespace

std::string sentence(const CalibrationError& error) {
  using enum CalibrationFault;
  const auto count = [](double value) { return number_text(value, 0); };
  const auto mm = [](double value) { return number_text(to_mm(value), 1) + " mm"; };
  const auto deg = [](double value) { return number_text(to_deg(value), 1) + " deg"; };
  const auto percent = [](double value) { return number_text(100 * value, 1) + " %"; };
  const auto px = [](double value) { return number_text(value, 2) + " px"; };
  switch (error.fault) {
    case kPictureSize:
      return "The picture" + of_view(error) +
             " has another size than expected, or a point lies outside of it. Use pictures of one "
             "size from one camera.";
    case kTooFewPoints:
      return "Too few points" + of_view(error) + ": " + count(error.measured) + ", at least " +
             count(error.limit) + " needed. Show more of the board.";
    case kTooFewViews:
      return "Too few views: " + count(error.measured) + ", at least " + count(error.limit) +
             " needed. Take more pictures, each with the board at another angle.";
    case kPointsOnLine:
      return "The points" + of_view(error) + " are nearly on one line: " + mm(error.length) +
             " long, " + mm(error.measured) + " wide, at least " + mm(error.limit) +
             " wide needed. Add a point away from the line.";
    case kViewsParallel:
      return "All views are parallel within " + deg(error.measured) + " (at least " +
             deg(error.limit) +
             " needed), so the focal length cannot be found. Tilt the board by about 30 deg about "
             "its horizontal edge.";
    case kFocalUncertain:
      return "The focal length is uncertain by " + percent(error.measured) + " (limit " +
             percent(error.limit) +
             "). Add views with the board tilted by about 30 deg about its horizontal edge and "
             "about its vertical edge.";
    case kNotConverged:
      if (!std::isfinite(error.measured)) {
        return "The fit" + of_view(error) +
               " found no pose that explains what is seen. Check the dimensions of the board and "
               "that all pictures show this board.";
      }
      return "The fit" + of_view(error) + " did not converge: " + px(error.measured) +
             " remain (limit " + px(error.limit) +
             "). Check the dimensions of the board and that all pictures show this board.";
  }
  return "";
}

}  // namespace sinew::calibration
