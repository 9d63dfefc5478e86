#pragma once

#include <cstdint>
#include <expected>
#include <string>

namespace sinew::calibration {

/// Why a calibration has no result.
enum class CalibrationFault : std::uint8_t {
  kPictureSize,     ///< index: view whose picture has another size, or a pixel outside of it
  kTooFewPoints,    ///< index: view, or -1; measured, limit: points
  kTooFewViews,     ///< measured, limit: views
  kPointsOnLine,    ///< index: view, or -1; measured, limit: m across the line
  kViewsParallel,   ///< measured, limit: rad, the largest angle between two views
  kFocalUncertain,  ///< measured, limit: standard deviation of the focal length over its value
  kNotConverged,    ///< index: view, or -1; measured, limit: px, rms of what remains
};

struct CalibrationError {
  CalibrationFault fault{};
  int index = -1;  ///< of the view, from 0; -1 where the error has none
  double measured = 0;
  double limit = 0;
  double length = 0;  ///< m along the line, of kPointsOnLine

  friend bool operator==(const CalibrationError&, const CalibrationError&) = default;
};

template <class T>
using Calibrated = std::expected<T, CalibrationError>;

/// What is wrong, with value and limit, and what to do.
std::string sentence(const CalibrationError& error);

}  // namespace sinew::calibration
