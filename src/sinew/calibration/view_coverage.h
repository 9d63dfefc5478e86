#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "sinew/calibration/intrinsics.h"

namespace sinew::calibration {

/// What views of a board show of a camera: which parts of its picture, from how many sides.
struct Coverage {
  static constexpr std::size_t kColumns = 4;
  static constexpr std::size_t kRows = 3;
  static constexpr std::size_t kViewsEnough = 8;
  static constexpr double kTiltEnough = from_deg(25);
  static constexpr double kScaleEnough = 1.3;

  std::array<std::array<bool, kColumns>, kRows> seen{};  ///< 4 points or more; row 0 is the upper
  double tilt_x = 0;      ///< rad, range of the boards' rotation about the x axis of the picture
  double tilt_y = 0;      ///< rad, about its y axis
  double scale = 1;       ///< largest distance of the board over the smallest
  std::size_t views = 0;  ///< whose board has a pose

  bool all_cells_seen() const;
  bool tilt_x_suffices() const { return tilt_x >= kTiltEnough; }
  bool tilt_y_suffices() const { return tilt_y >= kTiltEnough; }
  bool scale_suffices() const { return scale >= kScaleEnough; }
};

/// Good to about 5 deg and 10 % before the camera is known; a camera makes it exact.
Coverage coverage(std::span<const BoardView> views,
                  const std::optional<vision::CameraModel>& camera = std::nullopt);

/// The next view to take, as an instruction; nothing where the views suffice.
std::optional<std::string> what_to_add(const Coverage& coverage);

}  // namespace sinew::calibration
